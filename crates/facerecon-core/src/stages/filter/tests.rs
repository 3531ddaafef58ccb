use super::*;
use crate::observer::Event;

fn gray(rows: &[&[f32]]) -> Gray {
    Gray::from_fn(rows[0].len(), rows.len(), |x, y| rows[y][x])
}

#[test]
fn eq_2_1_sharpens_exactly() {
    let image = gray(&[&[10.0, 10.0, 10.0], &[10.0, 30.0, 10.0], &[10.0, 10.0, 12.0]]);
    let out = sharpen(&image, &FilterParams::default().kernel).unwrap();
    // 5 * 30 - 0.5 * (7 * 10 + 12)
    assert_eq!(out.at(1, 1), 109.0);
    // the border repeats outward: five neighbours are 10, one is 30, two are 10 again
    assert_eq!(out.at(0, 0), 50.0 - 0.5 * (7.0 * 10.0 + 30.0));
    // a uniform photo does not change, because the kernel sums to 1
    let flat = Gray::filled(5, 4, 77.0);
    assert_eq!(sharpen(&flat, &FilterParams::default().kernel).unwrap(), flat);
    // values are clipped
    let spike = gray(&[&[0.0, 0.0, 0.0], &[0.0, 200.0, 0.0], &[0.0, 0.0, 0.0]]);
    let out = sharpen(&spike, &FilterParams::default().kernel).unwrap();
    assert_eq!((out.at(1, 1), out.at(0, 1)), (255.0, 0.0));
}

#[test]
fn an_uneven_kernel_is_convolved_not_correlated() {
    let image = gray(&[&[0.0, 0.0, 0.0], &[0.0, 8.0, 0.0], &[0.0, 0.0, 0.0]]);
    let mut kernel = vec![0.0; 9];
    kernel[5] = 1.0; // right of the middle: shifts the picture right
    let out = sharpen(&image, &kernel).unwrap();
    assert_eq!((out.at(2, 1), out.at(0, 1)), (8.0, 0.0));
    // a 5x5 kernel reaches two pixels
    let mut kernel = vec![0.0; 25];
    kernel[0] = 1.0;
    let out = sharpen(&Gray::from_fn(5, 5, |x, y| (10 * y + x) as f32), &kernel).unwrap();
    assert_eq!((out.at(1, 1), out.at(2, 2)), (33.0, 44.0));
}

#[test]
fn invalid_kernels_and_photos_are_refused() {
    let image = Gray::filled(4, 4, 1.0);
    for got in [0, 2, 4, 8, 16] {
        assert_eq!(sharpen(&image, &vec![0.1; got]), Err(FilterError::Kernel { got }));
    }
    let error = sharpen(&image, &[f64::INFINITY]).unwrap_err();
    assert_eq!(error, FilterError::KernelEntry { got: f64::INFINITY });
    let params = FilterParams::default();
    let error = filter(&Gray::filled(0, 3, 0.0), &params, &()).unwrap_err();
    assert_eq!(error, FilterError::Empty { width: 0, height: 3 });
    let mut nan = image;
    nan.set(2, 1, f32::NAN);
    assert_eq!(filter(&nan, &params, &()).unwrap_err(), FilterError::NotFinite { x: 2, y: 1 });
}

#[test]
fn a_kernel_that_does_not_sum_to_one_gives_a_warning() {
    struct Warnings(std::cell::RefCell<Vec<String>>);
    impl Observer for Warnings {
        fn event(&self, event: &Event<'_>) {
            if let Event::Warning { message, .. } = event {
                self.0.borrow_mut().push((*message).to_owned());
            }
        }
    }
    let warnings = Warnings(std::cell::RefCell::default());
    let params = FilterParams { kernel: vec![1.5], ..FilterParams::default() };
    filter(&Gray::filled(4, 4, 10.0), &params, &warnings).unwrap();
    assert!(warnings.0.borrow()[0].contains("1.500"), "{:?}", warnings.0.borrow());
    let warnings = Warnings(std::cell::RefCell::default());
    filter(&Gray::filled(4, 4, 10.0), &FilterParams::default(), &warnings).unwrap();
    assert!(warnings.0.borrow().is_empty());
}

#[test]
fn fixed_thresholds_are_strict() {
    let image = gray(&[&[99.0, 100.0, 101.0]]);
    assert_eq!(threshold_fixed(&image, 100.0).data(), [0.0, 0.0, 255.0]);
}

#[test]
fn otsu_separates_two_peaks_in_their_middle() {
    let image = Gray::from_fn(20, 20, |x, _| if x < 15 { 40.0 } else { 200.0 });
    let level = otsu_level(&image);
    assert!((level - 120.0).abs() <= 1.0, "{level}");
    assert_eq!(otsu_level(&Gray::filled(3, 3, 7.0)), 0.5);
}

#[test]
fn the_local_threshold_equals_a_direct_sum_over_its_window() {
    let image = Gray::from_fn(23, 17, |x, y| ((x * 37 + y * 91 + x * y) % 256) as f32);
    let (window, deviations, contrast) = (7, 0.5, 12.0);
    let fast = threshold_local(&image, window, deviations, contrast);
    for y in 0..17_usize {
        for x in 0..23_usize {
            let mut values = Vec::new();
            for v in y.saturating_sub(3)..(y + 4).min(17) {
                for u in x.saturating_sub(3)..(x + 4).min(23) {
                    values.push(f64::from(image.at(u, v)));
                }
            }
            let n = values.len() as f64;
            let mean = values.iter().sum::<f64>() / n;
            let deviation = (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / n).sqrt();
            let level = mean + (deviations * deviation).max(contrast);
            let white = f64::from(image.at(x, y)) > level;
            assert_eq!(fast.at(x, y), if white { 255.0 } else { 0.0 }, "{x} {y}");
        }
    }
}

#[test]
fn dots_in_light_and_shadow_are_found_by_the_local_threshold_only() {
    // dots of the same contrast on a ramp: no single level separates them all
    let image = Gray::from_fn(120, 60, |x, y| {
        let dot = (x % 10 < 3) && (y % 10 < 3);
        let light = 10.0 + x as f32 * 1.2;
        if dot { light * 1.6 + 25.0 } else { light }
    });
    let count = |threshold| {
        let params = FilterParams { threshold, smooth_px: 0.0, ..FilterParams::default() };
        let binary = filter(&image, &params, &()).unwrap().binary;
        let dots = (0..12).flat_map(|i| (0..6).map(move |j| (i, j)));
        dots.filter(|&(i, j)| {
            let mut dot = (0..9).map(|k| binary.at(10 * i + k % 3, 10 * j + k / 3));
            let middle = dot.any(|v| v > 0.0);
            let beside = binary.at(10 * i + 6, 10 * j + 6) > 0.0;
            middle && !beside
        })
        .count()
    };
    assert_eq!(count(Threshold::Local), 72);
    assert!(count(Threshold::Fixed) < 72);
}

#[test]
fn global_equalisation_flattens_the_histogram() {
    let image = Gray::from_fn(64, 64, |x, y| (100 + (x + y) / 8) as f32);
    let out = equalize_global(&image);
    let (low, high) =
        out.data().iter().fold((255.0_f32, 0.0_f32), |(l, h), v| (l.min(*v), h.max(*v)));
    assert!(low < 10.0 && high > 245.0, "{low} {high}");
    // the middle of the level's part of all pixels
    let below = image.data().iter().filter(|v| **v < 108.0).count() as f32;
    let at = image.data().iter().filter(|v| **v == 108.0).count() as f32;
    let expected = 255.0 * (below + at / 2.0) / 4096.0;
    let i = image.data().iter().position(|v| *v == 108.0).unwrap();
    assert!((out.data()[i] - expected).abs() < 1e-3);
}

#[test]
fn clahe_with_one_tile_and_no_limit_is_global_and_tiles_adapt_to_their_brightness() {
    let image =
        Gray::from_fn(64, 48, |x, y| ((x * 3 + y * 5) % 90 + if x < 32 { 10 } else { 120 }) as f32);
    let whole = equalize_clahe(&image, 1, 1000.0);
    assert_eq!(whole, equalize_global(&image));
    let spread = |out: &Gray, from: usize| {
        let values = (0..48).flat_map(|y| (from..from + 16).map(move |x| (x, y)));
        let values: Vec<f32> = values.map(|(x, y)| out.at(x, y)).collect();
        values.iter().fold(0.0_f32, |a, v| a.max(*v))
            - values.iter().fold(255.0_f32, |a, v| a.min(*v))
    };
    let tiled = equalize_clahe(&image, 4, 1000.0);
    assert!(spread(&tiled, 0) > 200.0 && spread(&tiled, 48) > 200.0);
    assert!(spread(&whole, 0) < 140.0);
    // a low limit keeps the contrast low
    assert!(spread(&equalize_clahe(&image, 4, 1.5), 0) < 0.7 * spread(&tiled, 0));
}

#[test]
fn the_blur_preserves_a_plane_and_the_sum() {
    let plane = Gray::from_fn(31, 31, |x, y| 2.0 * x as f32 + 3.0 * y as f32);
    let out = plane.blurred_f64(1.3);
    assert!((out.at(15, 15) - plane.at(15, 15)).abs() < 1e-3);
    let mut spike = Gray::filled(31, 31, 0.0);
    spike.set(15, 15, 100.0);
    let out = spike.blurred_f64(1.3);
    assert!((out.data().iter().sum::<f32>() - 100.0).abs() < 1e-2);
    // the peak of a Gaussian of deviation 1.3
    assert!((out.at(15, 15) - 100.0 / (std::f32::consts::TAU * 1.69)).abs() < 0.1);
    assert_eq!(spike.blurred_f64(0.0), spike);
}
