//! The two built-in heads.

use super::assemble::{Template, assemble};
use super::half_head::HalfHead;
use super::sculpt::{Proportions, Sculpt};

const FINE: &[u8] = include_bytes!("../../assets/head.bin");
const COARSE: &[u8] = include_bytes!("../../assets/head-coarse.bin");

/// The generic head: a neutral adult of average proportions, about 6,000 vertices, exactly
/// symmetric, one surface whose only border is at the neck. Model frame, mm, origin between the
/// ears.
///
/// ```
/// let head = facerecon_core::template::head();
/// assert_eq!(head.landmarks.len(), 18);
/// assert!(head.mesh.validate().is_ok());
/// ```
pub fn head() -> Template {
    generic("head", FINE)
}

/// The same head with about 830 vertices and the same landmark names.
pub fn head_coarse() -> Template {
    generic("head-coarse", COARSE)
}

/// The default template of a reconstruction: the generic head with its coarse mesh.
pub fn built_in() -> Template {
    Template { coarse: Some(head_coarse().mesh), ..head() }
}

/// A built-in head by name: `head` or `head-coarse`.
pub fn named(name: &str) -> Option<Template> {
    match name {
        "head" => Some(built_in()),
        "head-coarse" => Some(head_coarse()),
        _ => None,
    }
}

/// The stored part of the fine head.
pub(crate) fn stored_half() -> HalfHead {
    HalfHead::decode(FINE)
}

fn generic(name: &str, stored: &[u8]) -> Template {
    let sculpt = Sculpt::new(&Proportions::default());
    Template { name: name.into(), ..assemble(&sculpt, &HalfHead::decode(stored)) }
}
