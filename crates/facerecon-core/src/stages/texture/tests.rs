use super::*;
use crate::data::{Mesh, Rgb};
use crate::math::{Vec2, Vec3};

/// A half cylinder facing +z, unrolled on the texture map between u 0.1 .. 0.9, v 0.2 .. 0.8.
fn half_cylinder() -> Mesh {
    let n = 31u32;
    let mut mesh = Mesh::default();
    for i in 0..n * n {
        let (s, t) = (f64::from(i % n) / 30.0, f64::from(i / n) / 30.0);
        let angle = (s - 0.5) * std::f64::consts::PI * 0.9;
        mesh.vertices.push(Vec3::new(angle.sin() * 70.0, 100.0 - 200.0 * t, angle.cos() * 70.0));
        mesh.uvs.push([0.1 + 0.8 * s, 0.8 - 0.6 * t]);
    }
    for y in 0..n - 1 {
        for x in 0..n - 1 {
            let i = y * n + x;
            mesh.faces.push([i, i + n, i + 1]);
            mesh.faces.push([i + 1, i + n, i + n + 1]);
        }
    }
    mesh.face_uvs = mesh.faces.clone();
    mesh
}

/// Seen from the front at 1.5 px per mm, shifted by `shift` px; an oval of it, as of a face.
fn dots(mesh: &Mesh, shift: f64) -> Vec<TextureDot> {
    (0..mesh.vertices.len())
        .filter(|i| (i % 31).abs_diff(15).pow(2) + (i / 31).abs_diff(15).pow(2) <= 225)
        .map(|i| (i, mesh.vertices[i]))
        .map(|(vertex, point)| {
            let pixel = Vec2::new(150.0 + shift + 1.5 * point.x, 170.0 - 1.5 * point.y);
            TextureDot { vertex, point, pixel }
        })
        .collect()
}

/// A photo whose red is x / 2 and whose green is y / 2; blue identifies the photo.
fn photo(shift: usize, blue: u8) -> Rgb {
    Rgb::from_fn(330, 340, |x, y| [(x.saturating_sub(shift) / 2) as u8, (y / 2) as u8, blue])
}

fn made(params: &TextureParams) -> Texture {
    let mesh = half_cylinder();
    let (left, right) = (photo(0, 50), photo(12, 90));
    let (a, b) = (dots(&mesh, 0.0), dots(&mesh, 12.0));
    let photos = [
        TexturePhoto { image: &left, camera: None, patterned: None, dots: &a },
        TexturePhoto { image: &right, camera: None, patterned: None, dots: &b },
    ];
    let input = TextureInput { mesh: &mesh, photos: &photos, template_texture: None };
    texture(&input, params, &()).unwrap()
}

#[test]
fn every_line_of_the_region_is_filled_for_both_boundaries() {
    for boundary in [Boundary::Hexagon, Boundary::Rectangle] {
        for (segments, size) in [(1, 256), (10, 256), (10, 1500)] {
            let params = TextureParams { boundary, segments, size, ..TextureParams::default() };
            let out = made(&params);
            assert_eq!(out.image.size(), (size, size));
            let row = |v: f64| ((1.0 - v) * size as f64 - 0.5).round() as usize;
            for y in row(0.8) + 1..row(0.2) {
                let seen = out.coverage.row(y).iter().filter(|c| **c != FILLED).count();
                let least = if segments == 1 { size / 3 } else { 1 };
                assert!(seen >= least, "{boundary} {segments}: row {y} of {size} has {seen}");
            }
            assert!(out.coverage.row(row(0.8) - 3).iter().all(|c| *c == FILLED));
        }
    }
}

#[test]
fn the_hexagon_is_half_as_wide_at_its_ends() {
    let params =
        TextureParams { size: 400, segments: 1, source: Source::Left, ..TextureParams::default() };
    let out = made(&params);
    let width = |y: usize| out.coverage.row(y).iter().filter(|c| **c == SEEN_LEFT).count() as f64;
    let widths: Vec<f64> = (80..=319).map(width).filter(|w| *w > 0.0).collect();
    assert!((widths[0] / 320.0 - 0.5).abs() < 0.03, "{}", widths[0]);
    let widest = widths.iter().copied().fold(0.0, f64::max);
    assert!((widest / 320.0 - 1.0).abs() < 0.03, "{widest}");
}

#[test]
fn colours_are_at_the_texels_of_their_vertices() {
    let params =
        TextureParams { size: 512, boundary: Boundary::Rectangle, ..TextureParams::default() };
    let out = made(&params);
    let mesh = half_cylinder();
    let mut residuals = Vec::new();
    for TextureDot { vertex: i, pixel: position, .. } in dots(&mesh, 0.0) {
        let [u, v] = mesh.uvs[i];
        let (x, y) = ((u * 512.0) as usize, ((1.0 - v) * 512.0) as usize);
        if out.coverage.at(x, y) == FILLED {
            continue;
        }
        let [r, g, blue] = out.image.at(x, y);
        residuals.push((Vec2::new(f64::from(r), f64::from(g)) * 2.0 - position).norm());
        let expected = if u < 0.49 { 50 } else { 90 };
        assert!(blue == expected || (u - 0.5).abs() < 0.02, "halves come from their photos");
    }
    assert!(residuals.len() > 500);
    let median = crate::math::median(&residuals).unwrap();
    assert!(median < 3.0, "{median} px");
}

#[test]
fn one_segment_is_the_even_stretching_of_the_thesis() {
    let params = TextureParams {
        size: 400,
        boundary: Boundary::Rectangle,
        segments: 1,
        source: Source::Left,
        ..TextureParams::default()
    };
    let out = made(&params);
    // u 0.1 .. 0.9 takes the photo's 46.3 .. 253.7 evenly
    let half = 1.5 * 70.0 * (0.45 * std::f64::consts::PI).sin();
    for x in [60usize, 150, 200, 330] {
        let t = (x as f64 + 0.5 - 40.0) / 320.0;
        let expected = (150.0 - half + 2.0 * half * t) / 2.0;
        assert!((f64::from(out.image.at(x, 200)[0]) - expected).abs() < 1.5);
    }
}

#[test]
fn one_wrong_dot_does_not_move_the_boundary() {
    let mesh = half_cylinder();
    let left = photo(0, 50);
    let good = dots(&mesh, 0.0);
    let mut spoiled = good.clone();
    spoiled[300].pixel = Vec2::new(325.0, 5.0);
    let params = TextureParams { size: 256, source: Source::Left, ..TextureParams::default() };
    let make = |dots: &[TextureDot]| {
        let photos = [TexturePhoto { image: &left, camera: None, patterned: None, dots }];
        let input = TextureInput { mesh: &mesh, photos: &photos, template_texture: None };
        texture(&input, &params, &()).unwrap()
    };
    let (a, b) = (make(&good), make(&spoiled));
    let different = a.image.data().iter().zip(b.image.data()).filter(|(a, b)| a != b).count();
    assert!(different * 50 < 256 * 256, "{different} texels differ");
}

#[test]
fn missing_input_is_named() {
    let mesh = half_cylinder();
    let left = photo(0, 50);
    let all = dots(&mesh, 0.0);
    let refuse = |mesh: &Mesh, dots: &[TextureDot], source: Source| {
        let photos = [TexturePhoto { image: &left, camera: None, patterned: None, dots }];
        let input = TextureInput { mesh, photos: &photos, template_texture: None };
        let params = TextureParams { size: 64, source, ..TextureParams::default() };
        texture(&input, &params, &()).unwrap_err()
    };
    let error = refuse(&mesh, &all, Source::Halves);
    assert_eq!(error, TextureError::Photos { got: 1, needed: 2 });
    let error = refuse(&mesh, &all[..4], Source::Left);
    assert_eq!(error, TextureError::TooFewDots { got: 4, needed: 8 });
    let bare = Mesh { uvs: Vec::new(), face_uvs: Vec::new(), ..mesh.clone() };
    assert_eq!(refuse(&bare, &all, Source::Left), TextureError::NoUv);
    let mut flat = mesh.clone();
    flat.uvs.iter_mut().for_each(|uv| *uv = [0.5, 0.5]);
    assert!(matches!(refuse(&flat, &all, Source::Left), TextureError::Boundary { .. }));
    let error = refuse(&mesh, &[TextureDot { vertex: 99_999, ..all[0] }], Source::Left);
    assert!(matches!(error, TextureError::Dot { vertex: 99_999, .. }));
    let photos = [TexturePhoto { image: &left, camera: None, patterned: None, dots: &all }];
    let input = TextureInput { mesh: &mesh, photos: &photos, template_texture: None };
    let error = texture(&input, &TextureParams { size: 0, ..TextureParams::default() }, &());
    assert!(matches!(error, Err(TextureError::Settings(_))));
}
