//! Photos far finer than the texture are halved: detail between texels would only alias, and the
//! octaves of a photo of twelve megapixels take a gigabyte.

use super::super::input::TexturePhoto;
use super::posed_camera::PosedCamera;
use crate::data::{Gray, Mesh, Rgb};
use crate::math::{Vec2, median};

/// A photo with more pixels than this along a texel is halved; it keeps more than 0.75.
const MAX_PIXELS_PER_TEXEL: f64 = 1.5;

/// A photo at the size at which it is used.
pub(super) struct Reduced {
    image: Rgb,
    patterned: Option<Gray>,
}

impl Reduced {
    /// Halves the photo and its camera as often as a texture of `size` texels allows; `None` where
    /// the photo is used as it is.
    pub fn new(
        mesh: &Mesh,
        photo: &TexturePhoto<'_>,
        camera: &mut PosedCamera,
        size: usize,
    ) -> Option<Self> {
        let mut reduced: Option<Self> = None;
        while pixels_per_texel(mesh, camera, size)? > MAX_PIXELS_PER_TEXEL {
            let (image, patterned) = match &reduced {
                None => (photo.image.halved(), photo.patterned.map(Gray::halved)),
                Some(last) => (last.image.halved(), last.patterned.as_ref().map(Gray::halved)),
            };
            if image.data().is_empty() {
                break;
            }
            reduced = Some(Self { image, patterned });
            *camera = camera.halved();
        }
        reduced
    }

    /// The photo at its new size.
    pub fn photo<'a>(&'a self, photo: &TexturePhoto<'a>) -> TexturePhoto<'a> {
        TexturePhoto { image: &self.image, patterned: self.patterned.as_ref(), ..*photo }
    }
}

/// Median number of pixels along a texel, over the faces that face the camera.
fn pixels_per_texel(mesh: &Mesh, camera: &PosedCamera, size: usize) -> Option<f64> {
    let pixels: Vec<Option<Vec2>> =
        mesh.vertices.iter().map(|v| Some(camera.project(v)?.0)).collect();
    let area = |[a, b, c]: [Vec2; 3]| (b - a).perp(&(c - a));
    let ratio = |(face, uv): (&[u32; 3], &[u32; 3])| {
        let [a, b, c] = face.map(|v| pixels[v as usize]);
        let texels = area(uv.map(|k| Vec2::from(mesh.uvs[k as usize]))).abs();
        // faces are counterclockwise seen from outside, and y is down in the photo
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
    fn square() -> (Mesh, PosedCamera) {
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
        // y is up in the mesh and down in the camera
        let matrix = Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0));
        let pinhole = Pinhole::ideal(4000.0, Vec2::new(199.5, 199.5));
        (mesh, PosedCamera { pinhole, matrix, shift: Vec3::new(0.0, 0.0, 1000.0) })
    }

    #[test]
    fn a_photo_finer_than_the_texture_is_halved_and_its_camera_with_it() {
        let (mesh, mut camera) = square();
        let given = camera;
        let image = Rgb::from_fn(400, 400, |x, y| [(x / 2) as u8, (y / 2) as u8, 7]);
        let photo = TexturePhoto { image: &image, camera: None, patterned: None, dots: &[] };
        // 400 pixels along the square: 4 a texel of 100
        assert!(Reduced::new(&mesh, &photo, &mut camera, 400).is_none());
        let reduced = Reduced::new(&mesh, &photo, &mut camera, 100).unwrap();
        let small = reduced.photo(&photo).image;
        assert_eq!(small.size(), (100, 100));
        // each corner keeps its position in the image
        for v in &mesh.vertices {
            let [old, new] = [given, camera].map(|c| c.project(v).unwrap().0);
            assert!(((new.add_scalar(0.5)) * 4.0 - old.add_scalar(0.5)).norm() < 1e-9);
        }
        assert_eq!(small.at(50, 20), [101, 41, 7]);
    }

    #[test]
    fn a_camera_without_calibration_is_halved_as_well() {
        let (mesh, calibrated) = square();
        // the same projection as one matrix
        let k = Mat3::new(4000.0, 0.0, 199.5, 0.0, 4000.0, 199.5, 0.0, 0.0, 1.0);
        let pinhole = Pinhole::ideal(1.0, Vec2::zeros());
        let resected =
            PosedCamera { pinhole, matrix: k * calibrated.matrix, shift: k * calibrated.shift };
        for v in &mesh.vertices {
            let [a, b] = [calibrated.halved(), resected.halved()].map(|c| c.project(v).unwrap().0);
            assert!((a - b).norm() < 1e-9, "{a} {b}");
        }
    }
}
