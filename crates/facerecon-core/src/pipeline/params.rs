//! All parameters in one struct; the two profiles; TOML and single settings.

use crate::settings::{self, SettingsError};
use crate::stages::cameras::CamerasParams;
use crate::stages::check::CheckParams;
use crate::stages::correspond::{CorrespondMethod, CorrespondParams};
use crate::stages::deform::{DeformMethod, DeformParams};
use crate::stages::detect::{DetectMethod, DetectParams};
use crate::stages::filter::FilterParams;
use crate::stages::landmarks::{LandmarkMethod, LandmarksParams};
use crate::stages::outline::OutlineParams;
use crate::stages::rectify::RectifyParams;
use crate::stages::refine::{RefineMethod, RefineParams};
use crate::stages::register::{RegisterMethod, RegisterParams};
use crate::stages::smooth::{SmoothMethod, SmoothParams};
use crate::stages::surface::SurfaceParams;
use crate::stages::texture::{TextureMethod, TextureParams};
use crate::stages::triangulate::TriangulateParams;

crate::settings::choices! {
    /// A set of methods that belong together.
    pub enum Profile {
        /// Nothing to mark by hand, metric, as accurate as the photographs allow.
        Precise = "precise",
        /// The thesis FaceBuilder, stage by stage; needs the three marked pairs.
        Facebuilder = "facebuilder",
    }
}

crate::settings::settings! {
    /// All parameters of a reconstruction. The defaults are those of the profile `precise`.
    pub struct Params {
        /// The profile the other values start from.
        profile: Profile = Profile::Precise;
        /// Level rows.
        rectify: RectifyParams = RectifyParams::default();
        /// Rules for the photographs; a broken one is a warning.
        check: CheckParams = CheckParams::default();
        /// The thesis's preprocessing; used where detect.method = "thin".
        filter: FilterParams = FilterParams::default();
        /// Finding the dots.
        detect: DetectParams =
            DetectParams { method: DetectMethod::Gaussian, ..DetectParams::default() };
        /// Which dot is which.
        correspond: CorrespondParams =
            CorrespondParams { method: CorrespondMethod::Lattice, ..CorrespondParams::default() };
        /// Cameras that nobody has calibrated.
        cameras: CamerasParams = CamerasParams::default();
        /// Measuring disparity by image matching.
        refine: RefineParams = RefineParams::default();
        /// The subject's outline in the plain photos.
        outline: OutlineParams = OutlineParams::default();
        /// Disparity to points.
        triangulate: TriangulateParams = TriangulateParams::default();
        /// Finding the landmarks of the face.
        landmarks: LandmarksParams = LandmarksParams::default();
        /// Bringing the points to the generic head.
        register: RegisterParams =
            RegisterParams { method: RegisterMethod::Robust, ..RegisterParams::default() };
        /// Bending the generic head.
        deform: DeformParams =
            DeformParams { method: DeformMethod::Nicp, ..DeformParams::default() };
        /// The measured surface itself as the mesh, instead of the bent head.
        surface: SurfaceParams = SurfaceParams::default();
        /// Smoothing the mesh.
        smooth: SmoothParams =
            SmoothParams { method: SmoothMethod::None, ..SmoothParams::default() };
        /// Colouring the mesh.
        texture: TextureParams = TextureParams {
            method: TextureMethod::Projective,
            size: 2048,
            ..TextureParams::default()
        };
    }
}

impl Params {
    /// The parameters of a profile.
    pub fn of(profile: Profile) -> Self {
        match profile {
            Profile::Precise => Self::default(),
            Profile::Facebuilder => Self {
                profile,
                detect: DetectParams { method: DetectMethod::Thin, ..DetectParams::default() },
                correspond: CorrespondParams {
                    method: CorrespondMethod::Scan,
                    ..CorrespondParams::default()
                },
                cameras: CamerasParams { estimate: false, ..CamerasParams::default() },
                refine: RefineParams { method: RefineMethod::None, ..RefineParams::default() },
                outline: OutlineParams { find: false, ..OutlineParams::default() },
                landmarks: LandmarksParams {
                    method: LandmarkMethod::None,
                    ..LandmarksParams::default()
                },
                register: RegisterParams {
                    method: RegisterMethod::Besl,
                    ..RegisterParams::default()
                },
                deform: DeformParams {
                    method: DeformMethod::GaussianRbf,
                    ..DeformParams::default()
                },
                smooth: SmoothParams { method: SmoothMethod::Laplacian, ..SmoothParams::default() },
                texture: TextureParams {
                    method: TextureMethod::Scanline,
                    ..TextureParams::default()
                },
                ..Self::default()
            },
        }
    }

    /// The parameters of a profile by name.
    ///
    /// # Errors
    /// [`SettingsError::Malformed`] naming the profiles there are.
    pub fn profile(name: &str) -> Result<Self, SettingsError> {
        match name {
            "precise" => Ok(Self::of(Profile::Precise)),
            "facebuilder" => Ok(Self::of(Profile::Facebuilder)),
            _ => Err(SettingsError::Malformed(format!(
                "there is no profile {name:?}; take \"precise\" or \"facebuilder\""
            ))),
        }
    }

    /// Parameters from, in this order: the profile (`profile`, else the one the TOML text names,
    /// else `precise`), a TOML text, and single settings `(dotted name, value as text)`.
    ///
    /// # Errors
    /// [`SettingsError`] for text that is not TOML, unknown names, and values out of range.
    pub fn load(
        profile: Option<&str>,
        toml_text: Option<&str>,
        sets: &[(String, String)],
    ) -> Result<Self, SettingsError> {
        let malformed = |e: &dyn std::fmt::Display| SettingsError::Malformed(e.to_string());
        let mut given = match toml_text {
            Some(text) => text.parse::<toml::Table>().map_err(|e| malformed(&e))?,
            None => toml::Table::new(),
        };
        for (name, value) in sets {
            settings::set::<Self>(&mut given, name, value)?;
        }
        drop_fixed(&mut given)?;
        settings::resolve_keys::<Self>(&mut given)?;
        if let Some(name) = profile {
            given.insert("profile".into(), toml::Value::String(name.to_owned()));
        }
        let base = match given.get("profile").and_then(toml::Value::as_str) {
            Some(name) => Self::profile(name)?,
            None => Self::default(),
        };
        let mut table = toml::Table::try_from(&base).map_err(|e| malformed(&e))?;
        merge(&mut table, given);
        settings::from_table(table)
    }

    /// The whole commented TOML.
    ///
    /// # Errors
    /// [`SettingsError::Malformed`] when a value cannot be written as TOML.
    pub fn to_toml(&self) -> Result<String, SettingsError> {
        settings::commented_toml(self)
    }
}

/// Former parameters that are constants now, with their value. Earlier files may state it.
const FIXED: [(&str, f64); 4] = [
    ("correspond.stripes.average_rows", 2.0),
    ("correspond.stripes.skip_cost", 2.0),
    ("correspond.lattice.row_slack", 0.25),
    ("correspond.lattice.max_step", 0.35),
];

/// Removes former parameters that state the value that is fixed now.
///
/// # Errors
/// [`SettingsError::Malformed`] for another value, which would have no effect.
fn drop_fixed(table: &mut toml::Table) -> Result<(), SettingsError> {
    for (name, fixed) in FIXED {
        let Some(value) = take(table, name) else { continue };
        let number = value.as_float().or_else(|| value.as_integer().map(|i| i as f64));
        if number != Some(fixed) {
            return Err(SettingsError::Malformed(format!(
                "{name} is {value}, but is fixed at {fixed} now; remove it from the parameters"
            )));
        }
    }
    Ok(())
}

/// Removes the value of a dotted name.
fn take(table: &mut toml::Table, name: &str) -> Option<toml::Value> {
    match name.split_once('.') {
        Some((group, rest)) => take(table.get_mut(group)?.as_table_mut()?, rest),
        None => table.remove(name),
    }
}

fn merge(base: &mut toml::Table, over: toml::Table) {
    for (name, value) in over {
        match (base.get_mut(&name), value) {
            (Some(toml::Value::Table(inner)), toml::Value::Table(value)) => merge(inner, value),
            (_, value) => {
                base.insert(name, value);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Value;

    #[test]
    fn both_profiles_survive_their_own_toml() {
        for name in ["precise", "facebuilder"] {
            let params = Params::profile(name).unwrap();
            params.check("", None).unwrap();
            let text = params.to_toml().unwrap();
            assert_eq!(Params::load(None, Some(&text), &[]).unwrap(), params, "{text}");
        }
    }

    #[test]
    fn a_file_changes_the_profile_and_a_setting_changes_the_file() {
        let text = "profile = \"facebuilder\"\n[smooth]\nsteps = 3\nlambda = 0.25";
        let sets = [("smooth.steps".to_owned(), "7".to_owned())];
        let params = Params::load(None, Some(text), &sets).unwrap();
        assert_eq!(params.detect.method, DetectMethod::Thin);
        assert_eq!((params.smooth.steps, params.smooth.lambda), (7, 0.25));
    }

    #[test]
    fn a_former_parameter_is_read_with_its_fixed_value_only() {
        let load = |text: &str| Params::load(None, Some(text), &[]);
        let stated =
            "[correspond.stripes]\naverage_rows = 2\n[correspond.lattice]\nmax_step = 0.35";
        assert_eq!(load(stated).unwrap(), Params::default());
        let other = load("[correspond.stripes]\nskip_cost = 3.5").unwrap_err().to_string();
        assert!(other.contains("skip_cost is 3.5, but is fixed at 2 now"), "{other}");
    }

    #[test]
    fn the_thesis_knows_neither_found_landmarks_nor_outlines() {
        let thesis = Params::of(Profile::Facebuilder);
        assert_eq!(thesis.landmarks.method, LandmarkMethod::None);
        assert!(!thesis.outline.find && Params::default().outline.find);
    }

    #[test]
    fn wrong_names_values_and_profiles_are_refused() {
        let set = |name: &str, value: &str| {
            Params::load(None, None, &[(name.to_owned(), value.to_owned())])
                .unwrap_err()
                .to_string()
        };
        assert!(set("smoth.steps", "3").contains("smooth"));
        assert!(set("smooth.lambda", "3").contains("smooth.lambda is 3"));
        assert!(
            set("smooth.lambda", "much").contains("lambda"),
            "{}",
            set("smooth.lambda", "much")
        );
        assert!(set("detect.method", "magic").contains("magic"));
        assert!(Params::load(Some("best"), None, &[]).is_err());
        assert!(Params::load(None, Some("not toml"), &[]).is_err());
        assert!(Params::load(None, Some("surprise = 1"), &[]).is_err());
    }
}
