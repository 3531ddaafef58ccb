//! The built-in head and presets for known templates. Floor 2.
//!
//! The head is our own: a function (`sculpt`) from a chart of half the head to space, built from
//! anthropometric proportions. Stored are only the mesh's places in the chart, its texture
//! coordinates and its triangles (`assets/`), made by `make`; positions are computed on loading.

mod asset;
mod head;
#[cfg(test)]
mod layout;
mod load;
#[cfg(test)]
mod make;
#[cfg(test)]
mod mesher;
pub mod presets;
mod sculpt;
mod skin;
mod subject;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod unwrap;

pub use head::Template;
pub use load::{
    LoadedTemplate, TemplateError, landmarks_toml, load_template, resolve, sidecar_path,
    write_landmarks,
};
pub use subject::Subject;

use asset::HalfHead;
use sculpt::{Proportions, Sculpt};

const FINE: &[u8] = include_bytes!("../assets/head.bin");
const COARSE: &[u8] = include_bytes!("../assets/head-coarse.bin");

/// The generic head: a neutral adult of average proportions, about 6,000 vertices, exactly
/// symmetric, one surface with the neck as its only border. Model frame, mm, origin between the
/// ears.
pub fn head() -> Template {
    let half = HalfHead::decode(FINE);
    Template { name: "head".into(), ..head::assemble(&Sculpt::new(&Proportions::default()), &half) }
}

/// The same head with about 830 vertices and the same landmark names.
pub fn head_coarse() -> Template {
    let half = HalfHead::decode(COARSE);
    let made = head::assemble(&Sculpt::new(&Proportions::default()), &half);
    Template { name: "head-coarse".into(), ..made }
}

/// The built-in template of a run: the generic head with its coarse mesh.
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

/// A made-up person for the virtual rig: like the built-in head, but with an identity and an
/// asymmetry of its own and with skin, four times as fine. The same seed is the same person.
pub fn subject(seed: u64) -> Subject {
    subject::subject(seed, &HalfHead::decode(FINE))
}
