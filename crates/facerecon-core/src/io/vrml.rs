//! VRML 1.0 and 2.0 (VRML97): the indexed face sets of a scene as one mesh, transforms applied.

mod build;
mod lexer;
mod nodes;
mod scene1;
mod scene2;

use std::path::Path;

use super::obj::find_beside;
use super::source::decode_text;
use super::{Fault, LoadedMesh, read_rgb};
use build::Builder;
use nodes::Scene;

/// Reads the bytes of a VRML file; `folder` is where its texture lies. Inlined files, prototypes,
/// scripts and other geometry than indexed face sets are left out.
///
/// # Errors
/// [`Fault`] with the line.
pub fn decode(bytes: &[u8], folder: &Path) -> Result<LoadedMesh, Fault> {
    let text = decode_text(bytes);
    let first = text.lines().next().unwrap_or_default();
    let old = first.contains("V1.");
    if !first.starts_with("#VRML") || !(old || first.contains("V2.")) {
        let shown: String = first.chars().take(40).collect();
        return Err(Fault::at(
            1,
            format!(
                "this begins with {shown:?}; \"#VRML V1.0 ascii\" or \"#VRML V2.0 utf8\" is wanted"
            ),
        ));
    }
    let scene = Scene::parse(&text)?;
    let mut builder = Builder::default();
    if old {
        scene1::walk(&scene, &mut builder)?;
    } else {
        scene2::walk(&scene, &mut builder)?;
    }
    let (mut loaded, pictures) = builder.finish();
    let Some((picture, _)) = pictures.first().filter(|_| loaded.mesh.has_uv()) else {
        return Ok(loaded);
    };
    if pictures.len() > 1 {
        loaded
            .warnings
            .push(format!("the scene has {} textures; only {picture} is read", pictures.len()));
    }
    match find_beside(folder, picture).map(|path| read_rgb(&path)) {
        Some(Ok(rgb)) => loaded.texture = Some(rgb),
        Some(Err(e)) => loaded.warnings.push(format!("the texture is left out: {e}")),
        None => loaded.warnings.push(format!("the texture {picture} is not there")),
    }
    Ok(loaded)
}

#[cfg(test)]
mod tests;
