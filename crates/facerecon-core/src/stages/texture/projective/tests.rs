use std::cell::RefCell;

use nalgebra::Rotation3;

use super::super::{
    FILLED, SEEN_LEFT, SEEN_RIGHT, Texture, TextureError, TextureInput, TextureMethod,
    TextureParams, TexturePhoto, texture,
};
use crate::camera::{Pinhole, resect};
use crate::data::{Gray, Mesh, Rgb};
use crate::math::{Mat3, Similarity, Vec2, Vec3};
use crate::observer::{Event, Observer};
use crate::render::{NO_FACE, rasterize};

const SIZE: (usize, usize) = (480, 400);

fn camera() -> Pinhole {
    Pinhole::ideal(1700.0, Vec2::new(239.5, 199.5))
}

/// The built-in head 1.3 m in front of a camera `x` mm to the side.
fn pose(x: f64) -> Similarity {
    let turn = Mat3::from_diagonal(&Vec3::new(1.0, -1.0, -1.0));
    Similarity::rigid(turn, Vec3::new(-x, 10.0, 1300.0))
}

/// Skin with a smooth pattern in space, without shading.
fn skin(p: &Vec3) -> [f64; 3] {
    let wave = |a: f64, b: f64| (p.x / a + 1.3 * (p.y / b).sin()).sin() * (p.y / a + p.x / b).cos();
    [
        150.0 + 35.0 * wave(14.0, 22.0),
        110.0 + 25.0 * wave(11.0, 31.0),
        90.0 + 20.0 * wave(17.0, 19.0),
    ]
}

fn photo(mesh: &Mesh, pose: &Similarity, gain: f64) -> Rgb {
    let seen = rasterize(mesh, &camera(), pose, SIZE).unwrap();
    Rgb::from_fn(SIZE.0, SIZE.1, |x, y| {
        let face = seen.face.at(x, y);
        if face == NO_FACE {
            return [10, 10, 30];
        }
        let corners = mesh.corners(face as usize);
        let w = seen.barycentric.at(x, y);
        let p = crate::math::interpolate(corners, w.map(f64::from));
        skin(&p).map(|v| {
            let linear = crate::render::linear_from_srgb(v.round() as u8) * gain;
            crate::render::srgb_from_linear(linear).round() as u8
        })
    })
}

fn params() -> TextureParams {
    TextureParams { method: TextureMethod::Projective, size: 1024, ..TextureParams::default() }
}

/// Collects the warnings of the stage.
#[derive(Default)]
struct Warnings(RefCell<Vec<String>>);

impl Observer for Warnings {
    fn event(&self, event: &Event<'_>) {
        if let Event::Warning { stage: "texture", message } = event {
            self.0.borrow_mut().push((*message).to_owned());
        }
    }
}

fn given<'a>(image: &'a Rgb, patterned: Option<&'a Gray>, pose: Similarity) -> TexturePhoto<'a> {
    TexturePhoto { image, camera: Some((camera(), pose)), patterned, dots: &[] }
}

fn made(mesh: &Mesh, photos: &[TexturePhoto<'_>]) -> Texture {
    texture(&TextureInput { mesh, photos, template_texture: None }, &params(), &()).unwrap()
}

/// RMS difference in grey levels between the texture and the skin, over visible texels on the
/// front.
fn rms_error(mesh: &Mesh, made: &Texture) -> f64 {
    let size = made.image.width() as f64;
    let (mut sum, mut count) = (0.0, 0.0);
    for (face, uv) in mesh.faces.iter().zip(&mesh.face_uvs) {
        let uv: Vec<_> = uv.iter().map(|&i| mesh.uvs[i as usize]).collect();
        let (u, v) =
            ((uv[0][0] + uv[1][0] + uv[2][0]) / 3.0, (uv[0][1] + uv[1][1] + uv[2][1]) / 3.0);
        let (x, y) = ((u * size - 0.5).round() as usize, ((1.0 - v) * size - 0.5).round() as usize);
        let code = made.coverage.at(x, y);
        let p: Vec3 = face.iter().map(|&i| mesh.vertices[i as usize]).sum::<Vec3>() / 3.0;
        if code & FILLED != 0 || code == 0 || p.z < 60.0 {
            continue;
        }
        let got = made.image.at(x, y);
        for (g, s) in got.iter().zip(skin(&p)) {
            sum += (f64::from(*g) - s).powi(2);
            count += 1.0;
        }
    }
    assert!(count > 2000.0, "{count}");
    (sum / count).sqrt()
}

#[test]
fn two_photos_give_the_skin_and_exposures_are_matched() {
    let mesh = crate::template::head().mesh;
    let (a, b) = (pose(-70.0), pose(70.0));
    // the right photo is darker
    let (left, right) = (photo(&mesh, &a, 1.0), photo(&mesh, &b, 0.8));
    let made = made(&mesh, &[given(&left, None, a), given(&right, None, b)]);
    assert!(made.head_motion.is_none(), "{:?}", made.head_motion);
    let rms = rms_error(&mesh, &made);
    assert!(rms < 4.0, "{rms}"); // 36 dB; texels lie between pixels
    let codes = made.coverage.data();
    assert!(codes.iter().any(|c| c & SEEN_LEFT != 0) && codes.iter().any(|c| c & SEEN_RIGHT != 0));
    // nothing is black, and none of the blue wall is on the skin
    let blue = made.image.data().iter().filter(|p| p[2] > p[0]).count();
    assert!(blue * 200 < made.image.data().len(), "{blue}");
    assert!(made.image.data().iter().all(|p| p[0] > 20));
}

#[test]
fn hidden_texels_do_not_take_the_colour_of_what_hides_them() {
    // a red card in front of the left half of the face, part of the mesh
    let mut mesh = crate::template::head().mesh;
    let n = mesh.vertices.len() as u32;
    for (x, y) in [(10.0, -40.0), (60.0, -40.0), (60.0, 60.0), (10.0, 60.0)] {
        mesh.vertices.push(Vec3::new(x, y, 180.0));
        mesh.uvs.push([0.001, 0.001]);
    }
    let m = mesh.uvs.len() as u32 - 4;
    for t in [[0, 1, 2], [0, 2, 3]] {
        mesh.faces.push(t.map(|i| n + i));
        mesh.face_uvs.push(t.map(|i| m + i));
    }
    let at = pose(0.0);
    let mut image = photo(&mesh, &at, 1.0);
    let seen = rasterize(&mesh, &camera(), &at, SIZE).unwrap();
    let card = mesh.faces.len() as u32 - 2;
    for y in 0..SIZE.1 {
        for x in 0..SIZE.0 {
            if seen.face.at(x, y) != NO_FACE && seen.face.at(x, y) >= card {
                image.set(x, y, [250, 0, 0]);
            }
        }
    }
    let made = made(&mesh, &[given(&image, None, at)]);
    let red = made.image.data().iter().filter(|p| p[0] > 200 && p[1] < 60).count();
    assert_eq!(red, 0);
}

#[test]
fn a_head_that_moved_is_followed() {
    let mesh = crate::template::head().mesh;
    let (a, b) = (pose(-70.0), pose(70.0));
    let turn = Rotation3::from_euler_angles(0.01, -0.03, 0.015).into_inner();
    let moved = Similarity::rigid(turn, Vec3::new(3.0, -2.0, 4.0));
    // skin is fixed to the head: draw the head where it was, seen from where it is now
    let (left, right) =
        (photo(&mesh, &a.compose(&moved), 1.0), photo(&mesh, &b.compose(&moved), 1.0));
    let then = [photo(&mesh, &a, 1.0).to_gray(), photo(&mesh, &b, 1.0).to_gray()];
    let photos = [given(&left, Some(&then[0]), a), given(&right, Some(&then[1]), b)];
    let warnings = Warnings::default();
    let input = TextureInput { mesh: &mesh, photos: &photos, template_texture: None };
    let made = texture(&input, &params(), &warnings).unwrap();
    let found = made.head_motion.unwrap();
    assert_eq!(*warnings.0.borrow(), [found.to_string()], "one warning, as an event");
    for p in mesh.vertices.iter().filter(|p| p.z > 60.0) {
        let off = (found.moved_from_mesh.apply(p) - moved.apply(p)).norm();
        assert!(off < 0.5, "{off} mm");
    }
    assert!(rms_error(&mesh, &made) < 6.0, "{}", rms_error(&mesh, &made));
}

#[test]
fn the_same_bytes_for_any_number_of_threads() {
    let mesh = crate::template::head_coarse().mesh;
    let at = pose(0.0);
    let image = photo(&mesh, &at, 1.0);
    let photos = [given(&image, None, at)];
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    assert_eq!(one.install(|| made(&mesh, &photos)), made(&mesh, &photos));
}

#[test]
fn a_camera_is_found_from_dots_or_required() {
    let mesh = crate::template::head().mesh;
    let at = pose(30.0);
    let points: Vec<Vec3> =
        mesh.vertices.iter().filter(|v| v.z > 40.0).step_by(9).copied().collect();
    let mut pixels: Vec<Vec2> =
        points.iter().map(|p| camera().project(&at.apply(p)).unwrap()).collect();
    for (i, q) in pixels.iter_mut().enumerate() {
        let t = i as f64;
        *q += Vec2::new((t * 12.9).sin(), (t * 7.7).cos()) * 0.2;
        if i % 15 == 0 {
            *q += Vec2::new(40.0, -25.0); // wrong matches
        }
    }
    let (found, rms) = resect(&points, &pixels).unwrap();
    assert!(rms < 0.5, "{rms}");
    for p in &points {
        let q = found.matrix * p + found.shift;
        let off =
            (Vec2::new(q.x / q.z, q.y / q.z) - camera().project(&at.apply(p)).unwrap()).norm();
        assert!(off < 0.5, "{off}");
    }
    assert!(resect(&points[..8], &pixels[..8]).is_none());

    let image = photo(&mesh, &at, 1.0);
    let without = TexturePhoto { image: &image, camera: None, patterned: None, dots: &[] };
    let photos = [without];
    let input = TextureInput { mesh: &mesh, photos: &photos, template_texture: None };
    let error = texture(&input, &params(), &()).unwrap_err();
    assert!(matches!(error, TextureError::NoCamera { photo: 0, dots: 0, .. }), "{error}");
}

#[test]
fn further_photos_without_a_camera_are_left_out_with_a_warning() {
    let mesh = crate::template::head_coarse().mesh;
    let (a, b) = (pose(-70.0), pose(70.0));
    let images = [photo(&mesh, &a, 1.0), photo(&mesh, &b, 1.0)];
    let pair = [given(&images[0], None, a), given(&images[1], None, b)];
    let further = TexturePhoto { image: &images[0], camera: None, patterned: None, dots: &[] };
    let warnings = Warnings::default();
    let all = [pair[0], pair[1], further];
    let input = TextureInput { mesh: &mesh, photos: &all, template_texture: None };
    let with = texture(&input, &params(), &warnings).unwrap();
    assert_eq!(with.image, made(&mesh, &pair).image);
    let warnings = warnings.0.borrow();
    assert_eq!(warnings.len(), 1);
    assert!(warnings[0].starts_with("1 further photo"), "{}", warnings[0]);
}
