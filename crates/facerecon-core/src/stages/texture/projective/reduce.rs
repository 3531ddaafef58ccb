//! Photos far finer than the texture are halved: what lies between texels would only alias, and a
//! photo of twelve megapixels takes a gigabyte in octaves.

use super::super::TexturePhoto;
use super::photo::Sight;
use crate::data::{Gray, Mesh, Rgb};
use crate::math::{Vec2, median};

/// A photo with more pixels than this along a texel is halved.
const FINE: f64 = 1.5;

/// A photo at the size it is used in, with its camera.
pub(super) struct Reduced {
    image: Rgb,
    patterned: Option<Gray>,
}

impl Reduced {
    /// The photo as often halved as the texture of `size` texels allows, `view` with it; `None`
    /// where it is used as it is.
    pub fn new(
        mesh: &Mesh,
        photo: &TexturePhoto<'_>,
        view: &mut Sight,
        size: usize,
    ) -> Option<Self> {
        let mut reduced: Option<Self> = None;
        while pixels_per_texel(mesh, view, size)? > FINE {
            let (image, patterned) = match &reduced {
                None => (photo.image.halved(), photo.patterned.map(Gray::halved)),
                Some(last) => (last.image.halved(), last.patterned.as_ref().map(Gray::halved)),
            };
            if image.data().is_empty() {
                break;
            }
            reduced = Some(Self { image, patterned });
            *view = view.halved();
        }
        reduced
    }

    /// The photo in its new size.
    pub fn lend<'a>(&'a self, photo: &TexturePhoto<'a>) -> TexturePhoto<'a> {
        TexturePhoto { image: &self.image, patterned: self.patterned.as_ref(), ..*photo }
    }
}

/// How many pixels lie along a texel, in the median of the faces that look at the camera.
fn pixels_per_texel(mesh: &Mesh, view: &Sight, size: usize) -> Option<f64> {
    let pixels: Vec<Option<Vec2>> =
        mesh.vertices.iter().map(|v| view.camera.project(&view.place(v))).collect();
    let area = |[a, b, c]: [Vec2; 3]| (b - a).perp(&(c - a));
    let ratio = |(face, uv): (&[u32; 3], &[u32; 3])| {
        let [a, b, c] = face.map(|v| pixels[v as usize]);
        let texels = area(uv.map(|k| Vec2::from(mesh.uvs[k as usize]))).abs();
        // counterclockwise seen from outside, and y goes down in the photo
        let facing = -area([a?, b?, c?]);
        (facing > 0.0 && texels > 0.0).then(|| (facing / texels).sqrt() / size as f64)
    };
    let ratios: Vec<f64> = mesh.faces.iter().zip(&mesh.face_uvs).filter_map(ratio).collect();
    median(&ratios).filter(|r| r.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera::Pinhole;
    use crate::math::{Mat3, Vec3};

    /// A square of 100 mm facing a camera 1 m away, over the whole texture.
    fn square() -> (Mesh, Sight) {
        let corner = |x: f64, y: f64| Vec3::new(x, y, 0.0);
        let mesh = Mesh {
            vertices: vec![
                corner(-50.0, -50.0),
                corner(50.0, -50.0),
                corner(50.0, 50.0),
                corner(-50.0, 50.0),
            ],
            faces: vec![[0, 1, 2], [0, 2, 3]],
            uvs: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
            face_uvs: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        };
        // y up in the mesh, down in the camera
        let matrix = Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0));
        let camera = Pinhole::ideal(4000.0, Vec2::new(199.5, 199.5));
        (mesh, Sight { camera, matrix, shift: Vec3::new(0.0, 0.0, 1000.0) })
    }

    #[test]
    fn a_photo_finer_than_the_texture_is_halved_and_its_camera_with_it() {
        let (mesh, mut view) = square();
        let given = view;
        let image = Rgb::from_fn(400, 400, |x, y| [(x / 2) as u8, (y / 2) as u8, 7]);
        let photo = TexturePhoto { image: &image, camera: None, patterned: None, dots: &[] };
        // 400 pixels along the square: 4 a texel of 100
        assert!(Reduced::new(&mesh, &photo, &mut view, 400).is_none());
        let reduced = Reduced::new(&mesh, &photo, &mut view, 100).unwrap();
        let small = reduced.lend(&photo).image;
        assert_eq!(small.size(), (100, 100));
        // each corner lies where it lay in the picture
        for v in &mesh.vertices {
            let [old, new] = [given, view].map(|s| s.camera.project(&s.place(v)).unwrap());
            assert!(((new.add_scalar(0.5)) * 4.0 - old.add_scalar(0.5)).norm() < 1e-9);
        }
        assert_eq!(small.at(50, 20), [101, 41, 7]);
    }

    #[test]
    fn a_camera_without_calibration_is_halved_as_well() {
        let (mesh, calibrated) = square();
        // the same projection as one matrix
        let k = Mat3::new(4000.0, 0.0, 199.5, 0.0, 4000.0, 199.5, 0.0, 0.0, 1.0);
        let camera = Pinhole::ideal(1.0, Vec2::zeros());
        let general = Sight { camera, matrix: k * calibrated.matrix, shift: k * calibrated.shift };
        for v in &mesh.vertices {
            let [a, b] = [calibrated.halved(), general.halved()]
                .map(|s| s.camera.project(&s.place(v)).unwrap());
            assert!((a - b).norm() < 1e-9, "{a} {b}");
        }
    }
}
