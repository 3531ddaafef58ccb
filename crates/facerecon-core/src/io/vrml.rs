//! VRML 1.0 and 2.0 (VRML97): the indexed face sets of a scene as one mesh, transforms applied.

mod build;
mod lexer;
mod nodes;
mod scene1;
mod scene2;

use std::path::Path;

use super::error::Fault;
use super::image::read_rgb;
use super::loaded_mesh::LoadedMesh;
use super::source::{decode_text, find_beside};
use build::Builder;
use nodes::Scene;

/// Characters of the first line that an error message shows.
const MAX_SHOWN: usize = 40;

/// Reads the bytes of a VRML file; `folder` has its texture. Inlined files, prototypes, scripts and
/// geometry other than indexed face sets are ignored.
///
/// # Errors
/// [`Fault`] with the line.
pub(super) fn decode(bytes: &[u8], folder: &Path) -> Result<LoadedMesh, Fault> {
    let text = decode_text(bytes);
    let first = text.lines().next().unwrap_or_default();
    let version_1 = first.contains("V1.");
    if !first.starts_with("#VRML") || !(version_1 || first.contains("V2.")) {
        let shown: String = first.chars().take(MAX_SHOWN).collect();
        return Err(Fault::at(
            1,
            format!(
                "the file begins with {shown:?}; expected is \"#VRML V1.0 ascii\" or \"#VRML V2.0 utf8\""
            ),
        ));
    }
    let scene = Scene::parse(&text)?;
    let mut builder = Builder::default();
    if version_1 {
        scene1::walk(&scene, &mut builder)?;
    } else {
        scene2::walk(&scene, &mut builder)?;
    }
    let (mut loaded, images) = builder.finish();
    let Some((image, _)) = images.first().filter(|_| loaded.mesh.has_uv()) else {
        return Ok(loaded);
    };
    if images.len() > 1 {
        loaded
            .warnings
            .push(format!("the scene has {} textures; only {image} is read", images.len()));
    }
    match find_beside(folder, image).map(|path| read_rgb(&path)) {
        Some(Ok(rgb)) => loaded.texture = Some(rgb),
        Some(Err(e)) => loaded.warnings.push(format!("the texture is not read: {e}")),
        None => loaded.warnings.push(format!("the texture {image} does not exist")),
    }
    Ok(loaded)
}

#[cfg(test)]
mod tests;
