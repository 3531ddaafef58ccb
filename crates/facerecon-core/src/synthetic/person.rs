//! Made-up persons: heads that differ from the generic one in identity and asymmetry, with skin.

mod albedo;
mod beard;
mod glasses;
mod identity;
mod join;
mod model;
mod skin;
#[cfg(test)]
mod tests;

pub use glasses::Glasses;

use crate::data::Rgb;
use crate::math::Vec3;
use crate::render::srgb_from_linear;
use crate::synthetic::simulate::Subject;
use crate::template::Template;
use model::Model;

/// Side of the skin texture, texels.
const SKIN_PX: usize = 1024;
/// The face begins this far in front of the ears, mm.
const IN_FRONT_OF_EARS_MM: f64 = 22.0;
/// The face ends this far below the chin and above the forehead, mm.
const BELOW_CHIN_MM: f64 = 4.0;
const ABOVE_FOREHEAD_MM: f64 = 6.0;

/// A made-up person for the virtual rig.
///
/// ```
/// use facerecon_core::synthetic::Person;
/// let person = Person::new(3);
/// assert_eq!(person.face.len(), person.head.mesh.vertices.len());
/// assert_eq!(person.skin.size(), (1024, 1024));
/// let subject = person.subject(); // for `simulate`
/// assert!(subject.texture.is_some());
/// ```
#[derive(Clone, Debug)]
pub struct Person {
    /// About 22,000 vertices with the 18 landmarks; frame of the built-in head, mm.
    pub head: Template,
    /// Albedo of skin, brows, eyes and hair, sRGB, in the texture layout of the head.
    pub skin: Rgb,
    /// Whether each vertex belongs to the face (in front of the ears, from hairline to chin).
    pub face: Vec<bool>,
}

impl Person {
    /// The person of a seed. The same seed is always the same person.
    pub fn new(seed: u64) -> Self {
        Self::of(Model::new(seed))
    }

    /// The person of a seed with a full beard, some 7 mm thick. The landmark of the chin is on it.
    pub fn bearded(seed: u64) -> Self {
        Self::of(Model::bearded(seed))
    }

    fn of(model: Model) -> Self {
        let skin = albedo::albedo(&model, SKIN_PX)
            .map(|c| c.map(|v| srgb_from_linear(f64::from(v)).round() as u8));
        Self { face: face_region(&model.head), skin, head: model.head }
    }

    /// The person in front of the cameras of [`simulate`](crate::synthetic::simulate::simulate).
    pub fn subject(&self) -> Subject<'_> {
        Subject {
            mesh: &self.head.mesh,
            texture: Some(&self.skin),
            landmarks: Some(&self.head.landmarks),
            face: Some(&self.face),
        }
    }
}

fn face_region(head: &Template) -> Vec<bool> {
    let at = |name: &str| head.landmarks.get(name).map(|&i| head.mesh.vertices[i]);
    let (Some(ear), Some(chin), Some(forehead)) =
        (at("ear_left_upper"), at("chin"), at("forehead"))
    else {
        return vec![true; head.mesh.vertices.len()];
    };
    let inside = |v: &Vec3| {
        v.z > ear.z + IN_FRONT_OF_EARS_MM
            && v.y > chin.y - BELOW_CHIN_MM
            && v.y < forehead.y + ABOVE_FOREHEAD_MM
    };
    head.mesh.vertices.iter().map(inside).collect()
}
