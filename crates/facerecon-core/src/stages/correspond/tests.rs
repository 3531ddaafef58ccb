use super::*;
use crate::data::{Dot, Match, Pair, Pattern, PatternKind, Seeds};
use crate::math::Vec2;
use crate::observer::WarningCollector;

const PATTERN: Pattern = Pattern { kind: PatternKind::Dots, columns: 85, rows: 64, rotation: 0.0 };

fn dot(position: Vec2) -> Dot {
    Dot { position, sigma_px: 0.0, amplitude: 0.0, score: 1.0 }
}

/// A pseudo-random number in -0.5..0.5, the same in every run.
fn noise(i: usize, salt: u64) -> f64 {
    let mut h = (i as u64 + 1).wrapping_mul(0x9E37_79B9_7F4A_7C15) ^ salt;
    h = (h ^ (h >> 31)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    h = (h ^ (h >> 29)).wrapping_mul(0x94D0_49BB_1331_11EB);
    ((h ^ (h >> 32)) % 100_000) as f64 / 100_000.0 - 0.5
}

/// A lattice on a bump like a head in front of a wall; some dots are in one photo only. Positions are
/// rounded to pixels, as thinning does.
struct Scene {
    left: Vec<Vec2>,
    right: Vec<Vec2>,
    truth: Vec<Option<usize>>,
    head: Vec<bool>,
    seeds: Seeds,
}

fn scene(rotation: f64, missing: f64) -> Scene {
    let (mut left, mut right, mut truth, mut head) = (vec![], vec![], vec![], vec![]);
    let centre = Vec2::new(380.0, 290.0);
    let disparity = |p: Vec2| {
        let r = (p - centre).component_div(&Vec2::new(150.0, 210.0));
        let r2 = r.norm_squared();
        let nose = 9.0 * (-(p - centre).norm_squared() / 800.0).exp();
        if r2 < 1.0 { (330.0 - 18.0 * r2 + nose, true) } else { (268.3, false) }
    };
    let mut pairs = Vec::new();
    for row in -40_i32..40 {
        for column in -45_i32..45 {
            let i = ((row + 100) * 500 + column + 100) as usize;
            let flat = Vec2::new(f64::from(column), f64::from(row)) * 9.3;
            let (s, c) = f64::sin_cos(rotation);
            let p = centre + Vec2::new(c * flat.x - s * flat.y, s * flat.x + c * flat.y);
            if !(p.x > 5.0 && p.x < 760.0 && p.y > 5.0 && p.y < 570.0) {
                continue;
            }
            let (d, on_head) = disparity(p);
            // the lattice bends with the surface in both photos
            let l = p + Vec2::new(0.4 * (d - 330.0), 0.0);
            let jitter = |salt| Vec2::new(0.3 * noise(i, salt), 0.3 * noise(i, salt + 1));
            // the head occludes the wall, at other positions in each photo
            let hidden = |p: Vec2| {
                !on_head && (p - centre).component_div(&Vec2::new(158.0, 215.0)).norm() < 1.0
            };
            let in_left = noise(i, 10) + 0.5 > missing && !hidden(l);
            let in_right = noise(i, 20) + 0.5 > missing && !hidden(l - Vec2::new(d - 320.0, 0.0));
            let at_right = in_right.then(|| {
                right.push((l - Vec2::new(d, 0.0) + jitter(3)).map(f64::round));
                right.len() - 1
            });
            if in_left {
                left.push((l + jitter(5)).map(f64::round));
                truth.push(at_right);
                head.push(on_head);
                pairs.extend(at_right.map(|r| (left.len() - 1, r)));
            }
        }
    }
    let near = |p: Vec2| {
        let by = |a: &&(usize, usize), b: &&(usize, usize)| {
            (left[a.0] - p).norm().total_cmp(&(left[b.0] - p).norm())
        };
        let &(l, r) = pairs.iter().min_by(by).unwrap();
        // marks by hand are not exact
        Pair { left: left[l] + Vec2::new(1.4, -0.8), right: right[r] + Vec2::new(-0.9, 1.1) }
    };
    let seeds = Seeds {
        head: near(Vec2::new(380.0, 150.0)),
        left_ear: near(Vec2::new(250.0, 300.0)),
        right_ear: near(Vec2::new(500.0, 300.0)),
    };
    Scene { left, right, truth, head, seeds }
}

fn run(scene: &Scene, params: &CorrespondParams) -> Result<Correspondence, CorrespondError> {
    run_observed(scene, params, &())
}

fn run_observed(
    scene: &Scene,
    params: &CorrespondParams,
    observer: &dyn Observer,
) -> Result<Correspondence, CorrespondError> {
    let dots = |v: &[Vec2]| v.iter().copied().map(dot).collect::<Vec<_>>();
    let (left, right) = (dots(&scene.left), dots(&scene.right));
    let input = CorrespondInput {
        left: &left,
        right: &right,
        spacing_px: 9.0,
        plain: None,
        pattern: &PATTERN,
        seeds: Some(scene.seeds),
        rig: None,
    };
    correspond(&input, params, observer)
}

fn by_scan() -> CorrespondParams {
    CorrespondParams { method: CorrespondMethod::Scan, ..CorrespondParams::default() }
}

/// Recall and number of wrong matches among the dots of the head.
fn recall_and_errors(scene: &Scene, found: &Correspondence) -> (f64, usize) {
    let (mut right, mut wrong) = (0, 0);
    for m in &found.matches {
        let i = scene.left.iter().position(|p| *p == m.left).unwrap();
        if !scene.head[i] {
            continue;
        }
        match scene.truth[i] {
            Some(r) if scene.right[r] == m.right => right += 1,
            _ => wrong += 1,
        }
    }
    let all = (0..scene.left.len()).filter(|i| scene.head[*i] && scene.truth[*i].is_some()).count();
    (f64::from(right) / all as f64, wrong)
}

#[test]
fn a_bent_lattice_with_missing_dots_is_matched_dot_by_dot() {
    for rotation in [0.0, 0.05, 0.46] {
        for missing in [0.0, 0.08] {
            let scene = scene(rotation, missing);
            let found = run(&scene, &by_scan()).unwrap();
            let (recall, wrong) = recall_and_errors(&scene, &found);
            assert!(recall > 0.97, "rotation {rotation} missing {missing}: recall {recall}");
            assert_eq!(wrong, 0, "rotation {rotation} missing {missing}");
        }
    }
}

#[test]
fn every_dot_is_in_at_most_one_match_and_on_one_row() {
    let scene = scene(0.0, 0.05);
    let found = run(&scene, &by_scan()).unwrap();
    let key = |p: Vec2| (p.y as i64, p.x as i64);
    for side in [|m: &Match| m.left, |m: &Match| m.right] {
        let mut seen: Vec<_> = found.matches.iter().map(|m| key(side(m))).collect();
        let count = seen.len();
        seen.sort_unstable();
        seen.dedup();
        assert_eq!(seen.len(), count);
    }
    assert!(found.matches.iter().all(|m| (m.left.y - m.right.y).abs() <= 2.0));
    assert!(found.matches.iter().all(|m| (0.0..=1.0).contains(&m.score)));
    let order: Vec<_> = found.matches.iter().map(|m| key(m.left)).collect();
    assert!(order.is_sorted());
}

#[test]
fn seeds_off_a_dot_or_row_are_refused_with_the_distance() {
    let mut off = scene(0.0, 0.0);
    off.seeds.left_ear.right = Vec2::new(2.0, 2.0);
    match run(&off, &by_scan()).unwrap_err() {
        CorrespondError::SeedOffDot { seed: "left_ear", photo: "right", distance_px, .. } => {
            assert!(distance_px > 5.4);
        }
        other => panic!("{other}"),
    }
    let mut high = scene(0.0, 0.0);
    high.seeds.head.right.y += 9.3;
    match run(&high, &by_scan()).unwrap_err() {
        CorrespondError::SeedRows { seed: "head", rows_px, .. } => assert!(rows_px > 5.0),
        other => panic!("{other}"),
    }
}

#[test]
fn seeds_of_impossible_depth_are_reported_once() {
    let mut wrong = scene(0.0, 0.0);
    let target = wrong.seeds.left_ear.right + Vec2::new(140.0, 0.0);
    let distance = |p: &&Vec2| (**p - target).norm();
    let nearest = wrong.right.iter().min_by(|a, b| distance(a).total_cmp(&distance(b)));
    wrong.seeds.left_ear.right = *nearest.unwrap();
    let observer = WarningCollector::new(&());
    // whether enough matches grow from such seeds does not matter here
    let _ = run_observed(&wrong, &by_scan(), &observer);
    let warnings = observer.into_warnings();
    assert!(warnings.len() == 1, "{warnings:?}");
    assert!(warnings[0].contains("marked pairs differ by"), "{warnings:?}");
}

#[test]
fn input_without_enough_dots_is_refused() {
    let full = scene(0.0, 0.0);
    let params = by_scan();
    let none = Scene { right: Vec::new(), ..scene(0.0, 0.0) };
    assert_eq!(run(&none, &params).unwrap_err(), CorrespondError::NoDots { photo: "right" });
    // only the three marked dots exist
    let keep = |p: Pair, dots: &[Vec2], at: fn(Pair) -> Vec2| {
        *dots.iter().min_by(|a, b| (*a - at(p)).norm().total_cmp(&(*b - at(p)).norm())).unwrap()
    };
    let marks = [full.seeds.head, full.seeds.left_ear, full.seeds.right_ear];
    let few = Scene {
        left: marks.iter().map(|p| keep(*p, &full.left, |p| p.left)).collect(),
        right: marks.iter().map(|p| keep(*p, &full.right, |p| p.right)).collect(),
        ..scene(0.0, 0.0)
    };
    let error = run(&few, &params).unwrap_err();
    assert_eq!(
        error,
        CorrespondError::TooFewMatches {
            candidates: "dots",
            got: 3,
            needed: 12,
            left: 3,
            right: 3
        }
    );

    let one = [dot(Vec2::new(1.0, 1.0))];
    let input = CorrespondInput {
        left: &one,
        right: &one,
        spacing_px: 9.0,
        plain: None,
        pattern: &PATTERN,
        seeds: None,
        rig: None,
    };
    assert_eq!(correspond(&input, &params, &()).unwrap_err(), CorrespondError::NoSeeds);
    let odd = CorrespondInput { spacing_px: f64::NAN, seeds: Some(full.seeds), ..input };
    let error = correspond(&odd, &params, &()).unwrap_err();
    assert!(matches!(error, CorrespondError::Pattern { .. }));
}
