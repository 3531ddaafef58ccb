//! `facerecon template`, and the loading of the template for all commands.

use facerecon_core::io;
use facerecon_core::template::{self, LoadedTemplate, Template, presets::PRESETS};

use serde_json::json;

use super::shared::to_json;
use crate::args::{TemplateAction, TemplateArgs};
use crate::failure::Failure;
use crate::output::Terminal;

/// The template named by the arguments: a built-in head, `PRESET=FILE`, or a mesh file with its
/// landmarks beside it.
pub(super) fn load(args: &TemplateArgs, terminal: &Terminal) -> Result<Template, Failure> {
    let name = args.template.as_deref().unwrap_or("head");
    if let Some(head) = template::named(name) {
        return Ok(head);
    }
    let loaded: LoadedTemplate = template::resolve(name, None)?;
    for warning in &loaded.warnings {
        terminal.warning(warning);
    }
    terminal.message(format!(
        "template {}: {} vertices, unit {}, {:.0} mm high",
        loaded.name,
        loaded.template.mesh.vertices.len(),
        loaded.unit,
        loaded.height_mm
    ));
    Ok(loaded.into_template())
}

/// Lists or writes templates.
pub(super) fn template(action: &TemplateAction, terminal: &Terminal) -> Result<(), Failure> {
    match action {
        TemplateAction::List if terminal.json => terminal.result(&to_json(&listed())),
        TemplateAction::List => {
            terminal.result("built-in heads:");
            for head in [template::built_in(), template::head_coarse()] {
                terminal.result(&format!(
                    "  {:<14} {} vertices, {} faces, mm, {} landmarks",
                    head.name,
                    head.mesh.vertices.len(),
                    head.mesh.faces.len(),
                    head.landmarks.len()
                ));
            }
            terminal.result("presets for your own file (--template PRESET=FILE):");
            for preset in &PRESETS {
                let landmarks = preset.landmarks.len();
                terminal.result(&format!(
                    "  {:<14} {}; unit {}, {landmarks} landmarks",
                    preset.name, preset.title, preset.unit
                ));
            }
        }
        TemplateAction::Export { name, output } => {
            let Some(head) = template::named(name) else {
                return Err(Failure::usage(format!(
                    "there is no built-in head {name:?}; expected head or head-coarse"
                )));
            };
            io::write_mesh(output, &head.mesh, None)?;
            let sidecar = template::write_landmarks(output, &head.name, &head.landmarks)?;
            let facts =
                json!({ "vertices": head.mesh.vertices.len(), "faces": head.mesh.faces.len() });
            terminal.wrote(&[output, &sidecar], facts);
        }
    }
    Ok(())
}

/// All templates as JSON.
fn listed() -> serde_json::Value {
    let built_in: Vec<_> = [template::built_in(), template::head_coarse()]
        .iter()
        .map(|head| {
            json!({ "name": head.name, "vertices": head.mesh.vertices.len(),
                "faces": head.mesh.faces.len(), "unit": "mm", "landmarks": head.landmarks.len() })
        })
        .collect();
    let presets: Vec<_> = PRESETS
        .iter()
        .map(|p| {
            json!({ "name": p.name, "title": p.title, "unit": p.unit.to_string(),
                "landmarks": p.landmarks.len() })
        })
        .collect();
    json!({ "built_in": built_in, "presets": presets })
}
