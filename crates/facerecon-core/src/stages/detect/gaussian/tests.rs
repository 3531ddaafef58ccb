use super::*;

/// A deterministic noise value of about unit variance.
fn noise(i: usize) -> f64 {
    let mut v = (i as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ 0xD1B5_4A32_D192_ED03;
    let mut sum = 0.0;
    for _ in 0..4 {
        v = (v ^ (v >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        v ^= v >> 27;
        sum += (v >> 11) as f64 / (1_u64 << 53) as f64 - 0.5;
    }
    sum * 3.0_f64.sqrt()
}

struct Scene {
    spacing: f64,
    sigma: f64,
    angle: f64,
    amplitude: f64,
    ramp: f64,
    noise: f64,
}

/// A lattice of Gaussian dots on a ramp, and the truth.
fn draw(scene: &Scene) -> (Gray, Vec<Vec2>) {
    let (width, height) = (240, 200);
    let (u, v) = (
        Vec2::new(scene.angle.cos(), scene.angle.sin()) * scene.spacing,
        Vec2::new(-scene.angle.sin(), scene.angle.cos()) * scene.spacing,
    );
    let mut truth = Vec::new();
    for j in -60..60 {
        for i in -60..60 {
            let p = Vec2::new(120.3, 99.6) + u * f64::from(i) + v * f64::from(j);
            let margin = 4.0 * scene.sigma;
            if p.x > margin
                && p.y > margin
                && p.x < width as f64 - 1.0 - margin
                && p.y < height as f64 - 1.0 - margin
            {
                truth.push(p);
            }
        }
    }
    let mut image = Gray::from_fn(width, height, |x, y| {
        (20.0 + scene.ramp * x as f64 + scene.noise * noise(y * width + x)) as f32
    });
    let reach = (5.0 * scene.sigma).ceil() as isize;
    for p in &truth {
        let (cx, cy) = (p.x.round() as isize, p.y.round() as isize);
        for y in (cy - reach).max(0)..=(cy + reach).min(height as isize - 1) {
            for x in (cx - reach).max(0)..=(cx + reach).min(width as isize - 1) {
                let r2 = (Vec2::new(x as f64, y as f64) - p).norm_squared();
                let add = scene.amplitude * (-0.5 * r2 / scene.sigma.powi(2)).exp();
                let (x, y) = (x as usize, y as usize);
                image.set(x, y, image.at(x, y) + add as f32);
            }
        }
    }
    (image.map(|v| v.clamp(0.0, 255.0).round()), truth)
}

/// Fraction of the true dots found, median error (pixels), number of false dots.
fn score(dots: &[Dot], truth: &[Vec2]) -> (f64, f64, usize) {
    let nearest =
        |p: &Vec2, of: &[Vec2]| of.iter().map(|q| (p - q).norm()).fold(f64::INFINITY, f64::min);
    let found: Vec<Vec2> = dots.iter().map(|d| d.position).collect();
    let errors: Vec<f64> = truth.iter().map(|t| nearest(t, &found)).filter(|e| *e < 1.0).collect();
    let wrong = found.iter().filter(|f| nearest(f, truth) > 1.0).count();
    (errors.len() as f64 / truth.len() as f64, median(&errors).unwrap_or(9.0), wrong)
}

#[test]
fn dots_are_found_to_a_few_hundredths_of_a_pixel_at_any_scale_and_angle() {
    for (spacing, sigma, angle) in
        [(9.6, 1.4, 0.0), (6.0, 0.95, 0.1), (14.0, 2.2, 0.35), (24.0, 3.6, -0.2)]
    {
        let scene = Scene { spacing, sigma, angle, amplitude: 90.0, ramp: 0.25, noise: 2.0 };
        let (image, truth) = draw(&scene);
        let (dots, found) = gaussian(&image, &GaussianParams::default());
        assert!((found / spacing - 1.0).abs() < 0.03, "spacing {found} of {spacing}");
        let (recall, error, wrong) = score(&dots, &truth);
        assert!(recall > 0.995 && error < 0.04 && wrong < 6, "{spacing}: {recall} {error} {wrong}");
    }
}

#[test]
fn low_contrast_steep_ramps_and_saturated_dots_are_found() {
    let base =
        Scene { spacing: 9.6, sigma: 1.4, angle: 0.0, amplitude: 20.0, ramp: 0.0, noise: 2.0 };
    let (image, truth) = draw(&base);
    let (recall, error, _) = score(&gaussian(&image, &GaussianParams::default()).0, &truth);
    assert!(recall > 0.98 && error < 0.15, "low contrast: {recall} {error}");

    let (image, truth) = draw(&Scene { amplitude: 450.0, noise: 1.0, ..base });
    assert!(image.data().iter().filter(|v| **v >= 255.0).count() > 4 * truth.len());
    let (recall, error, _) = score(&gaussian(&image, &GaussianParams::default()).0, &truth);
    assert!(recall > 0.98 && error < 0.05, "saturated: {recall} {error}");
}

#[test]
fn an_image_without_dots_gives_none_and_no_panic() {
    for size in [(0, 0), (1, 1), (3, 2), (64, 48)] {
        let flat = Gray::filled(size.0, size.1, 90.0);
        assert!(gaussian(&flat, &GaussianParams::default()).0.is_empty());
    }
    let broken = Gray::filled(64, 48, f32::NAN);
    assert!(gaussian(&broken, &GaussianParams::default()).0.is_empty());
}
