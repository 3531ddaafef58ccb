//! Whether a result can be trusted: good, usable or doubtful, with reasons.
//!
//! Each rule compares one figure with limits that captures of known truth keep and that wrong
//! results break. The level is that of the worst reason; a result without a reason is good.

mod figures;
mod limits;
mod norms;
mod outcome;

use crate::pipeline::Reconstruction;
use figures::figures_of;
use limits::{
    ASYMMETRY_MM, BLUR_DIFFERENCE, DOTS_BEFORE_EYES, LANDMARK_OFFSET_MM, LANDMARKS_MEASURED,
    LARGE_SD, Limits, MATCHED_SHARE, MEASURED_SHARE, NOSE_PROTRUSION_MAX_MM, NOSE_PROTRUSION_MM,
    NOSE_RELIEF, NOSE_RELIEF_MAX, PROPORTION_SD, PROPORTIONS_OFF, REGION_SHARE,
    REGISTRATION_GROWTH, REGISTRATION_RMS_MM, REGISTRATION_SHARE, RESIDUAL_MM, ROLL_DEG,
    ROW_OFFSET_PX, SMALL_SD, TURN_DEG,
};
pub use outcome::{FaceVerdict, Reason, VerdictFigures, VerdictLevel};

/// The verdict on a result whose photos have these `faults`; its own field `verdict` is not read.
pub(super) fn verdict_of(found: &Reconstruction, faults: Vec<String>) -> FaceVerdict {
    judge(figures_of(found), faults, found.registration.is_some(), found.metric)
}

/// Applies the rules to the figures.
fn judge(
    figures: VerdictFigures,
    faults: Vec<String>,
    registered: bool,
    metric: bool,
) -> FaceVerdict {
    let mut rules = Rules::default();
    faults.into_iter().for_each(|text| rules.add(VerdictLevel::Doubtful, text));
    if !registered {
        rules.add(
            VerdictLevel::Doubtful,
            "the measured surface could not be registered to a head".into(),
        );
    }
    if !metric {
        rules.add(
            VerdictLevel::Usable,
            "the cameras are not calibrated: sizes were not checked".into(),
        );
    }
    shape_rules(&figures, &mut rules);
    photo_rules(&figures, &mut rules);
    size_rules(&figures, &mut rules);
    pose_rules(&figures, &mut rules);
    let mut reasons = rules.reasons;
    reasons.sort_by_key(|r| std::cmp::Reverse(r.level as u8));
    let level = reasons.first().map_or(VerdictLevel::Good, |r| r.level);
    FaceVerdict { level, reasons, figures }
}

/// The rules on the face.
fn shape_rules(figures: &VerdictFigures, rules: &mut Rules) {
    rules.at_least(&MEASURED_SHARE, figures.measured_share, |share, limit| {
        format!(
            "{:.0} % of the face was measured (at least {:.0} % expected)",
            100.0 * share,
            100.0 * limit
        )
    });
    let regions = ["eyes", "nose", "mouth", "chin"];
    for (region, share) in figures.measured_region.iter().filter(|r| regions.contains(r.0)) {
        rules.at_least(&REGION_SHARE, Some(*share), |share, limit| {
            format!(
                "{region}: {:.0} % was measured (at least {:.0} % expected), the rest is the \
                 template's",
                100.0 * share,
                100.0 * limit
            )
        });
    }
    for (name, mm) in &figures.landmarks_off_mm {
        let text = format!(
            "the landmark {name} is {mm:.1} mm from its vertex: the mesh does not follow it"
        );
        rules.add(VerdictLevel::Usable, text);
    }
    // ears are thin and often covered by hair: their residual is reported, but not judged
    for (region, residual) in figures.residual_mm.iter().filter(|r| *r.0 != "ears") {
        rules.at_most(&RESIDUAL_MM, Some(*residual), |mm, limit| {
            format!(
                "{region}: the mesh lies {mm:.1} mm from the points (at most {limit:.1} expected)"
            )
        });
    }
    let measured = figures.landmarks_measured();
    rules.at_least(&LANDMARKS_MEASURED, Some(measured as f64), |_, limit| {
        format!(
            "{measured} of 18 landmarks were found or marked (at least {:.0} expected): the others \
             are known from the template alone",
            limit.ceil()
        )
    });
    rules.at_most(&LANDMARK_OFFSET_MM, figures.landmark_offset_mm, |mm, limit| {
        format!(
            "the measured landmarks are {mm:.1} mm from the vertices of their names (at most \
             {limit:.1} expected)"
        )
    });
    rules.at_most(&ASYMMETRY_MM, figures.asymmetry_mm, |mm, limit| {
        format!(
            "the face differs from its mirror image by {mm:.1} mm (at most {limit:.1} expected): \
             the head may be turned against the face, or this is no face"
        )
    });
    let protrusion = |mm: f64, limit: f64| {
        format!("the nose protrudes by {mm:.0} mm ({limit:.0} mm is the limit): is this a face?")
    };
    rules.at_least(&NOSE_PROTRUSION_MM, figures.nose_protrusion_mm, protrusion);
    rules.at_most(&NOSE_PROTRUSION_MAX_MM, figures.nose_protrusion_mm, protrusion);
    let relief = |share: f64, limit: f64| {
        format!(
            "the nose protrudes by {share:.2} of the distance of the outer eye corners ({limit:.2} \
             is the limit): is the focal length right?"
        )
    };
    rules.at_least(&NOSE_RELIEF, figures.nose_relief, relief);
    rules.at_most(&NOSE_RELIEF_MAX, figures.nose_relief, relief);
}

/// The rules on what hides or blurs the face in the photos.
fn photo_rules(figures: &VerdictFigures, rules: &mut Rules) {
    let less_sharp = if figures.blur_difference > 0.0 { "right" } else { "left" };
    let other = if figures.blur_difference > 0.0 { "left" } else { "right" };
    rules.at_most(&BLUR_DIFFERENCE, Some(figures.blur_difference.abs()), |blur, limit| {
        format!(
            "the {less_sharp} photo is less sharp than the {other} one by {blur:.2} distances between \
             dots (at most {limit:.2} expected): details are lost; focus both cameras on the face"
        )
    });
    let before = figures.dots_before_eyes;
    rules.at_most(&DOTS_BEFORE_EYES, Some(before as f64), |_, _| {
        format!(
            "{before} dots in front of the eye sockets were left out (glasses?): the eyes are the \
             template's"
        )
    });
}

/// The rules on the size of the face.
fn size_rules(figures: &VerdictFigures, rules: &mut Rules) {
    rules.at_most(&LARGE_SD, figures.size_sd, |sd, limit| {
        format!(
            "the face is {sd:.1} standard deviations larger than those of adults (at most \
             {limit:.1} expected): does the calibration belong to these photos?"
        )
    });
    rules.at_least(&SMALL_SD, figures.size_sd, |sd, limit| {
        format!(
            "the face is {:.1} standard deviations smaller than those of adults (at most {:.1} \
             expected): unless the subject is a child, the calibration is wrong",
            -sd, -limit
        )
    });
    let beyond = |limit: f64| {
        let off = figures.proportions_sd.iter().filter(|(_, sd)| sd.abs() > limit);
        off.map(|(name, sd)| format!("{} {sd:+.1}", name.replace('_', " "))).collect::<Vec<_>>()
    };
    let (grave, slight) = (beyond(PROPORTION_SD.doubtful), beyond(PROPORTION_SD.usable));
    let (level, names) = if grave.len() >= PROPORTIONS_OFF {
        (VerdictLevel::Doubtful, grave)
    } else {
        (VerdictLevel::Usable, slight)
    };
    if !names.is_empty() {
        rules.add(
            level,
            format!(
                "sizes outside those of adults and children, in standard deviations: {}; check the \
                 calibration and the landmarks",
                names.join(", ")
            ),
        );
    }
}

/// The rules on registration, pose and photos.
fn pose_rules(figures: &VerdictFigures, rules: &mut Rules) {
    rules.at_most(&REGISTRATION_RMS_MM, figures.registration_rms_mm, |mm, limit| {
        format!("the points are {mm:.1} mm from the template (at most {limit:.1} expected)")
    });
    rules.at_most(&REGISTRATION_GROWTH, figures.registration_growth, |ratio, _| {
        format!("the registration raised the distance of the points to {ratio:.2} times its start")
    });
    rules.at_least(&MATCHED_SHARE, figures.matched_share, |share, limit| {
        format!(
            "{:.1} % of the dots were matched (at least {:.0} % expected): do the photos belong \
             together, in this order, and to the calibration?",
            100.0 * share,
            100.0 * limit
        )
    });
    rules.at_least(&REGISTRATION_SHARE, figures.registration_share, |share, limit| {
        format!(
            "{:.0} % of the matches belong to the head (at least {:.0} % expected)",
            100.0 * share,
            100.0 * limit
        )
    });
    rules.at_most(&ROLL_DEG, figures.roll_deg, |deg, limit| {
        format!(
            "the head is rolled by {deg:.0} degrees in the photo (at most {limit:.0} expected): \
             upside down or sideways?"
        )
    });
    rules.at_most(&TURN_DEG, figures.turn_deg, |deg, limit| {
        format!(
            "the face is turned {deg:.0} degrees away from the camera (at most {limit:.0} expected)"
        )
    });
    rules.at_most(&ROW_OFFSET_PX, Some(figures.row_offset_px.abs()), |px, limit| {
        format!(
            "the rows of the photos differ by {px:.1} px (at most {limit:.1} expected): does the \
             calibration belong to these photos?"
        )
    });
}

/// Collects reasons.
#[derive(Default)]
struct Rules {
    reasons: Vec<Reason>,
}

impl Rules {
    fn add(&mut self, level: VerdictLevel, text: String) {
        self.reasons.push(Reason { level, text });
    }

    /// A figure that should not be below the limits; NaN breaks them.
    fn at_least(
        &mut self,
        limits: &Limits,
        figure: Option<f64>,
        text: impl Fn(f64, f64) -> String,
    ) {
        let Some(value) = figure else { return };
        if !(value >= limits.doubtful) {
            self.add(VerdictLevel::Doubtful, text(value, limits.usable));
        } else if value < limits.usable {
            self.add(VerdictLevel::Usable, text(value, limits.usable));
        }
    }

    /// A figure that should not be above the limits; NaN breaks them.
    fn at_most(&mut self, limits: &Limits, figure: Option<f64>, text: impl Fn(f64, f64) -> String) {
        let Some(value) = figure else { return };
        if !(value <= limits.doubtful) {
            self.add(VerdictLevel::Doubtful, text(value, limits.usable));
        } else if value > limits.usable {
            self.add(VerdictLevel::Usable, text(value, limits.usable));
        }
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    /// The figures of a good result.
    fn good() -> VerdictFigures {
        VerdictFigures {
            measured_share: Some(0.92),
            residual_mm: [("nose", 0.2), ("eyes", 0.3)].into(),
            landmarks_found: 16,
            landmarks_marked: 0,
            landmark_offset_mm: Some(0.8),
            asymmetry_mm: Some(0.9),
            nose_protrusion_mm: Some(37.0),
            nose_relief: Some(0.41),
            size_sd: Some(0.2),
            measured_region: [("mouth", 0.98), ("forehead", 0.1)].into(),
            landmarks_off_mm: BTreeMap::new(),
            matched_share: Some(0.4),
            proportions_sd: [("biocular_width", 0.4), ("nose_width", 0.0)].into(),
            registration_rms_mm: Some(4.4),
            registration_growth: Some(0.5),
            registration_share: Some(0.95),
            roll_deg: Some(7.0),
            turn_deg: Some(9.0),
            match_score: Some(0.9),
            row_offset_px: 0.1,
            blur_difference: 0.0,
            dots_before_eyes: 0,
        }
    }

    fn level(figures: VerdictFigures) -> VerdictLevel {
        judge(figures, Vec::new(), true, true).level
    }

    #[test]
    fn a_result_without_a_reason_is_good() {
        let verdict = judge(good(), Vec::new(), true, true);
        assert_eq!((verdict.level, verdict.reasons.len()), (VerdictLevel::Good, 0));
        let text = verdict.to_string();
        assert!(
            text.contains("good") && text.contains("92 %") && text.contains("16 of 18"),
            "{text}"
        );
    }

    #[test]
    fn one_grave_figure_makes_a_result_doubtful() {
        type Change = fn(&mut VerdictFigures);
        let cases: [(Change, &str); 18] = [
            (|f| f.blur_difference = 0.5, "right photo is less sharp than the left one by 0.50"),
            (|f| f.blur_difference = -0.5, "left photo is less sharp"),
            (|f| f.nose_relief = Some(0.7), "focal length"),
            (|f| f.size_sd = Some(2.5), "larger"),
            (|f| f.size_sd = Some(-3.0), "child"),
            (|f| _ = f.measured_region.insert("mouth", 0.2), "mouth: 20 %"),
            (|f| f.matched_share = Some(0.02), "2.0 % of the dots"),
            (|f| f.measured_share = Some(0.2), "20 %"),
            (|f| _ = f.residual_mm.insert("nose", 3.0), "nose"),
            (|f| f.landmark_offset_mm = Some(9.0), "9.0 mm"),
            (|f| f.asymmetry_mm = Some(2.6), "mirror"),
            (|f| f.nose_protrusion_mm = Some(3.0), "nose"),
            (|f| f.registration_rms_mm = Some(9.6), "9.6 mm"),
            (|f| f.registration_share = Some(0.51), "51 %"),
            (|f| f.roll_deg = Some(175.0), "upside"),
            (|f| f.row_offset_px = -12.0, "calibration"),
            (|f| f.asymmetry_mm = Some(f64::NAN), "mirror"),
            (
                |f| f.proportions_sd = [("biocular_width", 8.0), ("nose_width", 5.0)].into(),
                "biocular width +8.0",
            ),
        ];
        for (change, words) in cases {
            let mut figures = good();
            change(&mut figures);
            let verdict = judge(figures, Vec::new(), true, true);
            assert_eq!(verdict.level, VerdictLevel::Doubtful, "{words}");
            assert!(verdict.to_string().contains(words), "{verdict}");
        }
    }

    #[test]
    fn slight_deviations_leave_a_result_usable() {
        let slight = VerdictFigures { landmarks_found: 10, ..good() };
        assert_eq!(level(slight), VerdictLevel::Usable);
        let off = VerdictFigures { landmarks_off_mm: [("chin", 7.25)].into(), ..good() };
        let verdict = judge(off, Vec::new(), true, true);
        assert_eq!(verdict.level, VerdictLevel::Usable);
        assert!(verdict.to_string().contains("chin is 7.2 mm"), "{verdict}");
        let glasses = VerdictFigures { dots_before_eyes: 90, ..good() };
        let verdict = judge(glasses, Vec::new(), true, true);
        assert_eq!(verdict.level, VerdictLevel::Usable);
        assert!(verdict.to_string().contains("90 dots in front of the eye"), "{verdict}");
        assert_eq!(level(VerdictFigures { blur_difference: 0.2, ..good() }), VerdictLevel::Usable);
        let small = VerdictFigures { size_sd: Some(-2.0), ..good() };
        assert_eq!(level(small), VerdictLevel::Usable);
        let one = VerdictFigures { proportions_sd: [("mouth_width", 6.0)].into(), ..good() };
        assert_eq!(level(one), VerdictLevel::Usable);
        assert_eq!(judge(good(), Vec::new(), true, false).level, VerdictLevel::Usable);
        assert_eq!(judge(good(), Vec::new(), false, true).level, VerdictLevel::Doubtful);
    }

    #[test]
    fn a_fault_of_the_photos_makes_a_result_doubtful() {
        let verdict = judge(good(), vec!["the same picture".into()], true, true);
        assert_eq!(verdict.level, VerdictLevel::Doubtful);
        assert!(verdict.to_string().contains("the same picture"));
    }

    #[test]
    fn the_gravest_reason_comes_first() {
        let mixed = VerdictFigures { measured_share: Some(0.6), roll_deg: Some(90.0), ..good() };
        let levels: Vec<_> =
            judge(mixed, Vec::new(), true, true).reasons.iter().map(|r| r.level).collect();
        assert_eq!(levels, [VerdictLevel::Doubtful, VerdictLevel::Usable]);
    }
}
