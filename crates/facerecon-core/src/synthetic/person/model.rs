//! Head and skin of a made-up person.

use super::beard;
use super::identity::{Bump, Identity, proportions};
use super::skin::Skin;
use crate::math::Vec3;
use crate::synthetic::random::Sequence;
use crate::template::{Sculpt, Template, assemble, stored_half};

/// Local deformations that make a face asymmetric.
const BUMPS: usize = 14;

/// A head and what its skin is computed from.
pub(super) struct Model {
    /// About 22,000 vertices; frame of the built-in head, mm.
    pub(super) head: Template,
    /// The same vertices before the deformation by identity and bumps: the skin is defined on them.
    pub(super) rest: Vec<Vec3>,
    pub(super) skin: Skin,
    pub(super) bearded: bool,
}

impl Model {
    /// The person of a seed. The same seed is always the same person.
    pub(super) fn new(seed: u64) -> Self {
        let mut random = Sequence::new(seed);
        let sculpt = Sculpt::new(&proportions(&mut random));
        let mut head = assemble(&sculpt, &stored_half().split());
        let rest = head.mesh.vertices.clone();
        let identity = Identity::new(&mut random);
        let bumps: Vec<Bump> = (0..BUMPS).map(|_| Bump::new(&mut random)).collect();
        for v in &mut head.mesh.vertices {
            *v = identity.apply(v);
            let side: Vec3 = bumps.iter().map(|b| b.at(v)).sum();
            *v += side;
        }
        Self { head, rest, skin: Skin::new(&sculpt, &mut random), bearded: false }
    }

    /// The person of a seed with a full beard.
    pub(super) fn bearded(seed: u64) -> Self {
        let mut model = Self { bearded: true, ..Self::new(seed) };
        beard::grow(&mut model.head.mesh, &model.rest, &model.skin);
        model
    }
}
