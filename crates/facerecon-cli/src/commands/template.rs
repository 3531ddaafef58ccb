//! `facerecon template`, and how all commands choose the generic head.

use facerecon_core::io;
use facerecon_core::template::{self, LoadedTemplate, Template, presets::PRESETS};

use serde_json::json;

use super::to_json;
use crate::args::{TemplateAction, TemplateArgs};
use crate::failure::Failure;
use crate::output::Terminal;

/// The generic head that the arguments name: the built-in one, `PRESET=FILE`, or a file with its
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
    terminal.say(format!(
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
            terminal.result("built in:");
            for head in [template::built_in(), template::head_coarse()] {
                terminal.result(&format!(
                    "  {:<14} {} vertices, {} faces, mm, {} landmarks",
                    head.name,
                    head.mesh.vertices.len(),
                    head.mesh.faces.len(),
                    head.landmarks.len()
                ));
            }
            terminal.result("known, from your own file (--template PRESET=FILE):");
            for preset in &PRESETS {
                let marks = preset.landmarks.len();
                terminal.result(&format!(
                    "  {:<14} {}; unit {}, {marks} landmarks",
                    preset.name, preset.title, preset.unit
                ));
            }
        }
        TemplateAction::Export { name, output } => {
            let Some(head) = template::named(name) else {
                return Err(Failure::usage(format!(
                    "there is no built-in head {name:?}; take head or head-coarse"
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
