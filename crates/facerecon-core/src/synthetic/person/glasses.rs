//! Glasses for a made-up person.

use std::f64::consts::TAU;

use crate::data::Mesh;
use crate::math::Vec3;
use crate::template::Template;

/// The lenses stand this far in front of the outer corners of the eyes, mm.
const LENS_IN_FRONT_MM: f64 = 24.0;
/// Half width and half height of a lens, mm.
const LENS_MM: [f64; 2] = [25.0, 19.0];
/// Distance of the middle of a lens from the middle of the face, mm.
const LENS_OUT_MM: f64 = 33.0;
/// Exponent of the outline of a lens: 2 is an ellipse, more is closer to a rectangle.
const OUTLINE_POWER: f64 = 2.6;
/// Radius of the curved front of a lens, mm.
const FRONT_RADIUS_MM: f64 = 120.0;
/// Radius of the rims and arms, mm.
const RIM_MM: f64 = 1.5;
/// Points around a lens, and around a rim.
const AROUND: usize = 72;
const SECTION: usize = 8;
/// Height of the bridge and of the arms above the middle of the lenses, mm.
const BRIDGE_UP_MM: f64 = 7.0;

/// Rims with arms, and lenses, in the frame of the head, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Glasses {
    /// Rims, bridge and arms.
    pub frame: Mesh,
    /// The fronts of both lenses.
    pub lenses: Mesh,
}

impl Glasses {
    /// Glasses that fit a head; `None` if it lacks landmarks of eyes or ears.
    pub fn for_head(head: &Template) -> Option<Self> {
        let at = |name: &str| head.landmarks.get(name).map(|&i| head.mesh.vertices[i]);
        let eyes = [at("eye_left_outer")?, at("eye_right_outer")?];
        let ears = [at("ear_left_upper")?, at("ear_right_upper")?];
        let middle = (eyes[0] + eyes[1]) / 2.0 + Vec3::new(0.0, -4.0, LENS_IN_FRONT_MM);
        let (mut frame, mut lenses) = (Mesh::default(), Mesh::default());
        for (side, ear) in [-1.0, 1.0].into_iter().zip(ears) {
            let centre = middle + Vec3::new(side * LENS_OUT_MM, 0.0, 0.0);
            let rim: Vec<Vec3> = (0..AROUND).map(|k| centre + outline(k)).collect();
            add_lens(&mut lenses, centre, &rim);
            add_tube(&mut frame, &rim, true);
            let hinge = centre + Vec3::new(side * (LENS_MM[0] + RIM_MM), BRIDGE_UP_MM, 0.0);
            let bend = Vec3::new(ear.x + side * 3.0, hinge.y, hinge.z - 8.0);
            add_tube(&mut frame, &[hinge, bend, ear + Vec3::new(side * 3.0, 2.0, 0.0)], false);
        }
        let inner = LENS_OUT_MM - LENS_MM[0];
        let bridge = [-1.0, 0.0, 1.0]
            .map(|t: f64| middle + Vec3::new(t * inner, BRIDGE_UP_MM, 4.0 * (1.0 - t * t)));
        add_tube(&mut frame, &bridge, false);
        Some(Self { frame, lenses })
    }
}

/// Point `k` of the outline of a lens about its middle.
fn outline(k: usize) -> Vec3 {
    let (sin, cos) = (TAU * k as f64 / AROUND as f64).sin_cos();
    let part = |t: f64| t.abs().powf(2.0 / OUTLINE_POWER) * t.signum();
    let (x, y) = (LENS_MM[0] * part(cos), LENS_MM[1] * part(sin));
    Vec3::new(x, y, -(x * x + y * y) / (2.0 * FRONT_RADIUS_MM))
}

/// A curved disk.
fn add_lens(mesh: &mut Mesh, centre: Vec3, rim: &[Vec3]) {
    let first = mesh.vertices.len() as u32;
    mesh.vertices.push(centre);
    mesh.vertices.extend(rim);
    let n = rim.len() as u32;
    mesh.faces.extend((0..n).map(|k| [first, first + 1 + k, first + 1 + (k + 1) % n]));
}

/// A tube along a line.
fn add_tube(mesh: &mut Mesh, line: &[Vec3], closed: bool) {
    let (n, first) = (line.len(), mesh.vertices.len() as u32);
    for (k, p) in line.iter().enumerate() {
        let (before, after) = if closed {
            (line[(k + n - 1) % n], line[(k + 1) % n])
        } else {
            (line[k.saturating_sub(1)], line[(k + 1).min(n - 1)])
        };
        let along = (after - before).try_normalize(1e-9).unwrap_or_else(Vec3::x);
        let side = along.cross(&Vec3::z()).try_normalize(1e-3).unwrap_or_else(Vec3::y);
        let up = side.cross(&along);
        for s in 0..SECTION {
            let (sin, cos) = (TAU * s as f64 / SECTION as f64).sin_cos();
            mesh.vertices.push(p + (side * cos + up * sin) * RIM_MM);
        }
    }
    let section = SECTION as u32;
    for k in 0..(if closed { n } else { n - 1 }) as u32 {
        let (here, there) = (first + k * section, first + (k + 1) % n as u32 * section);
        for s in 0..section {
            let next = (s + 1) % section;
            mesh.faces.push([here + s, there + s, here + next]);
            mesh.faces.push([here + next, there + s, there + next]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::template::built_in;

    #[test]
    fn glasses_stand_in_front_of_the_eyes_with_their_fronts_to_the_viewer() {
        let head = built_in();
        let glasses = Glasses::for_head(&head).unwrap();
        assert!(glasses.frame.validate().is_ok() && glasses.lenses.validate().is_ok());
        let eye = head.mesh.vertices[head.landmarks["eye_left_outer"]];
        let behind = glasses.lenses.vertices.iter().filter(|v| v.z < eye.z + 10.0).count();
        assert_eq!(behind, 0);
        assert!(glasses.lenses.vertex_normals().iter().all(|n| n.z > 0.9));
        // The rims are closed tubes: their normals point away from their lines.
        let volume: f64 = (0..glasses.frame.faces.len())
            .map(|f| {
                let [a, b, c] = glasses.frame.corners(f);
                a.dot(&b.cross(&c)) / 6.0
            })
            .sum();
        assert!(volume > 0.0, "{volume}");
        let bare = Template { landmarks: Default::default(), ..head };
        assert_eq!(Glasses::for_head(&bare), None);
    }
}
