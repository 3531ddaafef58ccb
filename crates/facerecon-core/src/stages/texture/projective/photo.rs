//! A photo with all that is needed to take colours from it.

use super::super::error::TextureError;
use super::posed_camera::PosedCamera;
use super::subject::SubjectMask;
use super::visibility::Visibility;
use crate::data::{Mesh, Raster, Rgb};
use crate::math::{Vec2, Vec3};
use crate::render::{linear_from_srgb, srgb_from_linear};

/// Channel values above this are saturated, grey levels.
const SATURATED: f32 = 254.0;
/// Below saturation the weight rises to 1 over this many grey levels, so that no edge shows.
const SATURATION_RAMP: f32 = 10.0;
/// Weight factor of a saturated pixel: it is used only where no other photo sees the texel.
const SATURATED_WEIGHT: f32 = 0.02;

/// A photo, its camera, and what it sees.
pub(super) struct Photo<'a> {
    pub camera: PosedCamera,
    /// The camera's centre, mesh frame.
    pub centre: Vec3,
    pub visibility: Visibility,
    image: &'a Rgb,
    /// Where it shows the subject; `None` where that is not known.
    subject: Option<SubjectMask>,
    /// Linear light of each channel's values.
    pub tones: [[f32; 256]; 3],
}

impl<'a> Photo<'a> {
    /// `measured`: points known to lie on the subject, mesh frame.
    pub fn new(
        mesh: &Mesh,
        camera: &PosedCamera,
        image: &'a Rgb,
        edge_px: f64,
        measured: &[Vec3],
    ) -> Result<Self, TextureError> {
        let visibility = Visibility::new(mesh, camera, image.size(), edge_px)?;
        let subject = SubjectMask::new(image, camera, &visibility, measured);
        let tone = std::array::from_fn(|v| linear_from_srgb(v as u8) as f32);
        let (camera, centre) = (*camera, camera.centre());
        Ok(Self { camera, centre, visibility, image, subject, tones: [tone; 3] })
    }

    /// The photo in linear light.
    pub fn linear(&self) -> Raster<[f32; 3]> {
        self.mapped(&self.tones)
    }

    /// The photo's sRGB values, 0 to 255, in its corrected exposure.
    pub fn encoded(&self) -> Raster<[f32; 3]> {
        self.mapped(&self.tones.map(|t| t.map(|v| srgb_from_linear(f64::from(v)) as f32)))
    }

    /// The photo with each channel's values replaced by those of a table.
    fn mapped(&self, table: &[[f32; 256]; 3]) -> Raster<[f32; 3]> {
        let (w, h) = self.image.size();
        Raster::par_from_fn(w, h, |x, y| {
            let p = self.image.at(x, y);
            std::array::from_fn(|c| table[c][p[c] as usize])
        })
    }

    /// 1 where no channel of the nearest pixel is saturated, down to [`SATURATED_WEIGHT`]; 0
    /// outside.
    pub fn unsaturated(&self, pixel: Vec2) -> f32 {
        let nearest = self.image.get(pixel.x.round() as isize, pixel.y.round() as isize);
        nearest.map_or(0.0, |p| {
            let top = p.into_iter().max().unwrap_or(0);
            ((SATURATED - f32::from(top)) / SATURATION_RAMP).clamp(SATURATED_WEIGHT, 1.0)
        })
    }

    /// Degree to which a pixel shows the subject, 0 to 1.
    pub fn shows_subject(&self, pixel: Vec2) -> f32 {
        self.subject.as_ref().map_or(1.0, |s| s.at(pixel))
    }
}
