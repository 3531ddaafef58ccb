//! Captures that are hard to reconstruct: made-up persons in the virtual rig, with their truth.

use facerecon_core::camera::Pinhole;
use facerecon_core::data::{Capture, Mesh, Photo, Raster, Rgb};
use facerecon_core::math::{Similarity, Vec3};
use facerecon_core::render::{linear_from_srgb, rasterize, srgb_from_linear};
use facerecon_core::synthetic::simulate::{SimulateParams, Simulated, simulate};
use facerecon_core::synthetic::{Glasses, Person};

/// Linear albedo of the surface of a lens that carries dots, and of the rims, as sRGB codes.
const LENS: [u8; 3] = [150, 150, 155];
const SUN_LENS: [u8; 3] = [60, 60, 62];
const RIM: [u8; 3] = [40, 32, 28];
/// Brightness behind a lens, as a fraction.
const TRANSMISSION: f64 = 0.85;
/// Brightness of the dotted photo relative to the plain one where no light of the projector comes.
const WITHOUT_PROJECTOR: f64 = 0.15;

/// What lies over the eyes in the photos.
enum Lens {
    /// The photos show the eyes and their dots, darker, and this share of a surface with dots.
    Clear(f64),
    /// The lenses keep the pattern from the eyes.
    NoDots,
}

/// The capture of a case, of persons whose numbers follow `seed`. `base` gives the size of the photos
/// and of the pattern. Errors of the simulator as text.
pub fn hard(case: &str, seed: u64, base: &SimulateParams) -> Result<Simulated, String> {
    let rig = SimulateParams { seed, ..base.clone() };
    let take = |person: &Person, rig: &SimulateParams| {
        simulate(&person.subject(), rig, &()).map_err(|e| e.to_string())
    };
    let one = || Person::new(seed);
    let beside = |x: f64, y: f64, z: f64| {
        let both = one().with_neighbour(&Person::new(seed + 100), Vec3::new(x, y, z));
        // the simulator centres the bounding box of both
        take(&both, &SimulateParams { shift_x_mm: 0.5 * x, shift_y_mm: -0.5 * y, ..rig.clone() })
    };
    // the same angles for every distance and size
    let wide = |yaw_deg: f64| SimulateParams {
        baseline_mm: 350.0,
        distance_mm: 1000.0,
        focal_px: rig.focal_px / 1.3,
        toe_in_deg: 9.9,
        yaw_deg,
        ..rig.clone()
    };
    match case {
        "scatter" => {
            let soft = SimulateParams { blur_px: 1.5, dot_softness: 0.15, ..rig.clone() };
            take(&one(), &soft)
        }
        "scatter_strong" => {
            let soft = SimulateParams { blur_px: 2.0, dot_softness: 0.25, ..rig.clone() };
            take(&one(), &soft)
        }
        "beard" => take(&Person::bearded(seed), &rig),
        "beard_dark" => {
            let low = SimulateParams { ambient_light: 0.2, soft_light: 0.15, ..rig.clone() };
            take(&Person::bearded(seed), &low)
        }
        "wide_left" => take(&one(), &wide(-15.0)),
        "wide_right" => take(&one(), &wide(15.0)),
        "two_right" => beside(165.0, -30.0, -150.0),
        "two_left" => beside(-165.0, 20.0, -150.0),
        "two_beside" => beside(175.0, 0.0, 0.0),
        "two_small" => beside(-140.0, 30.0, -450.0),
        "glasses_clear" => with_glasses(&one(), &Lens::Clear(0.05), LENS, &rig),
        "glasses_dark" => with_glasses(&one(), &Lens::NoDots, LENS, &rig),
        "glasses_dots" => with_glasses(&one(), &Lens::Clear(0.5), LENS, &rig),
        "glasses_sun" => with_glasses(&one(), &Lens::Clear(1.0), SUN_LENS, &rig),
        "turned_right" => take(&one(), &SimulateParams { yaw_deg: 25.0, ..rig.clone() }),
        "turned_left" => take(&one(), &SimulateParams { yaw_deg: -25.0, ..rig.clone() }),
        "blur_right" => Ok(blurred_right(take(&one(), &rig)?, 1.5)),
        "blur_right_strong" => Ok(blurred_right(take(&one(), &rig)?, 2.5)),
        "over" => take(&one(), &SimulateParams { exposure: 1.6, ..rig.clone() }),
        "over_strong" => take(&one(), &SimulateParams { exposure: 2.5, ..rig.clone() }),
        other => Err(format!("no case {other:?}")),
    }
}

/// Blurs the right photo of the dotted pair, standard deviation in pixels.
fn blurred_right(mut made: Simulated, sigma_px: f64) -> Simulated {
    let sharp = &made.capture.right.rgb;
    let channel = |k: usize| sharp.map(|c| linear_from_srgb(c[k]) as f32).blurred(sigma_px);
    let linear = [channel(0), channel(1), channel(2)];
    made.capture.right = Photo::from_rgb(Raster::from_fn(sharp.width(), sharp.height(), |x, y| {
        [0, 1, 2].map(|k| srgb_from_linear(f64::from(linear[k].at(x, y))).round() as u8)
    }));
    made
}

/// A person with glasses. The truth is the person's without them.
fn with_glasses(
    person: &Person,
    lens: &Lens,
    color: [u8; 3],
    rig: &SimulateParams,
) -> Result<Simulated, String> {
    let take = |person: &Person| simulate(&person.subject(), rig, &()).map_err(|e| e.to_string());
    let glasses = Glasses::for_head(&person.head).ok_or("a head without landmarks")?;
    let rims = person.with_part(&glasses.frame, RIM);
    let bare = take(person)?;
    let through = take(&rims)?;
    let opaque = take(&rims.with_part(&glasses.lenses, color))?;
    let masks = lens_masks(&glasses.lenses, &opaque)?;
    let capture = mixed(&through.capture, &opaque.capture, &masks, lens)?;
    Ok(Simulated { capture, truth: bare.truth })
}

/// Where each camera sees the lenses.
fn lens_masks(lenses: &Mesh, made: &Simulated) -> Result<[Raster<bool>; 2], String> {
    let rig = made.truth.rig;
    let mesh = lenses.transformed(&made.truth.camera_from_model);
    let size = made.capture.left.size();
    let mask = |camera: &Pinhole, pose: &Similarity| {
        let seen = rasterize(&mesh, camera, pose, size).map_err(|e| e.to_string())?;
        Ok::<_, String>(seen.depth_mm.map(|z| z.is_finite()))
    };
    Ok([mask(&rig.left, &Similarity::identity())?, mask(&rig.right, &rig.right_from_left)?])
}

/// The photos with the lenses between camera and eyes.
fn mixed(
    through: &Capture,
    opaque: &Capture,
    masks: &[Raster<bool>; 2],
    lens: &Lens,
) -> Result<Capture, String> {
    let (Some(plain), Some(plain_opaque)) = (&through.plain, &opaque.plain) else {
        return Err("no plain pair".into());
    };
    let linear = |c: [u8; 3]| c.map(linear_from_srgb);
    let mix = |bare: &Rgb, own: &Rgb, unlit: Option<&Rgb>, mask: &Raster<bool>| {
        Photo::from_rgb(Raster::from_fn(bare.width(), bare.height(), |x, y| {
            if !mask.at(x, y) {
                return bare.at(x, y);
            }
            let (share, behind) = match (lens, unlit) {
                (Lens::Clear(share), _) => (*share, linear(bare.at(x, y))),
                (Lens::NoDots, None) => (0.0, linear(bare.at(x, y))),
                (Lens::NoDots, Some(u)) => (0.0, linear(u.at(x, y)).map(|v| v * WITHOUT_PROJECTOR)),
            };
            let own = linear(own.at(x, y));
            [0, 1, 2].map(|k| {
                let light = (1.0 - share) * TRANSMISSION * behind[k] + share * own[k];
                srgb_from_linear(light).round() as u8
            })
        }))
    };
    let [pl, pr] = [&plain[0].rgb, &plain[1].rgb];
    let mut capture = through.clone();
    capture.left = mix(&through.left.rgb, &opaque.left.rgb, Some(pl), &masks[0]);
    capture.right = mix(&through.right.rgb, &opaque.right.rgb, Some(pr), &masks[1]);
    capture.plain = Some([
        mix(pl, &plain_opaque[0].rgb, None, &masks[0]),
        mix(pr, &plain_opaque[1].rgb, None, &masks[1]),
    ]);
    Ok(capture)
}
