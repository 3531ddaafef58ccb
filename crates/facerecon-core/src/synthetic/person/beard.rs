//! A full beard: hair that stands out from the lower face.

use super::skin::Skin;
use crate::data::Mesh;
use crate::math::Vec3;
use crate::template::smoothstep;

/// Mean thickness of the beard, and its variation, mm.
const THICKNESS_MM: f64 = 7.0;
const VARIATION: f64 = 0.5;
/// Size of the locks that make it rough, mm.
const LOCK_MM: f64 = 5.0;
/// Skin that shows through where the beard is thickest, as a fraction.
const SKIN_SHOWS: f64 = 0.06;
/// The lips are free of hair for this distance outside their borders, mm.
const FREE_MM: (f64, f64) = (0.5, 4.0);

/// How much of the skin at a point of the head before its deformation is under the beard, 0 to 1.
fn cover(skin: &Skin, p: &Vec3) -> f64 {
    let region = smoothstep(-24.0, -34.0, p.y)
        * smoothstep(5.0, 25.0, p.z)
        * smoothstep(-122.0, -104.0, p.y);
    if region <= 0.0 {
        return 0.0;
    }
    let mouth = skin.mouth();
    let x = p.x.abs();
    let (up, low) = mouth.borders(x.min(mouth.half_width()));
    let above_or_below = (p.y - up).max(low - p.y).max(0.0);
    let outside = above_or_below.hypot((x - mouth.half_width()).max(0.0));
    region * smoothstep(FREE_MM.0, FREE_MM.1, outside)
}

/// Linear RGB of a point with the beard over `bare` skin.
pub(super) fn over(skin: &Skin, p: &Vec3, bare: [f32; 3]) -> [f32; 3] {
    let lock = skin.noise_at(p, LOCK_MM);
    let strand = skin.noise_at(&Vec3::new(p.x * 3.0, p.y * 0.5, p.z * 3.0), 1.0);
    let tone = (1.0 + 0.35 * lock + 0.35 * strand).max(0.2);
    let share = (1.0 - SKIN_SHOWS) * cover(skin, p);
    let hair = skin.hair();
    [0, 1, 2].map(|k| bare[k] + ((hair[k] * tone - f64::from(bare[k])) * share) as f32)
}

/// Moves the vertices of the lower face out to the surface of the beard; `rest` are the vertices
/// before the deformation of the head.
pub(super) fn grow(mesh: &mut Mesh, rest: &[Vec3], skin: &Skin) {
    let normals = mesh.vertex_normals();
    for ((vertex, rest), normal) in mesh.vertices.iter_mut().zip(rest).zip(normals) {
        let rough = 1.0 + VARIATION * skin.noise_at(rest, LOCK_MM);
        *vertex += normal * (THICKNESS_MM * rough * cover(skin, rest));
    }
}
