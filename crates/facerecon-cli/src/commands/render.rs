//! `facerecon render`.

use facerecon_core::data::Mesh;
use facerecon_core::io;
use facerecon_core::math::percentile;
use facerecon_core::render::{Frame, Heat, Mode, Scene, View, contact_sheet};
use facerecon_core::spatial::SurfaceIndex;

use serde_json::json;

use super::shared::require_png_name;
use crate::args::RenderArgs;
use crate::failure::Failure;
use crate::output::Terminal;

/// Renders a mesh from named views, side by side.
pub(super) fn render(args: &RenderArgs, terminal: &Terminal) -> Result<(), Failure> {
    let views = args
        .view
        .iter()
        .map(|name| View::named(name).ok_or_else(|| unknown("--view", name, View::NAMED)))
        .collect::<Result<Vec<_>, _>>()?;
    let mode = Mode::named(&args.mode).ok_or_else(|| unknown("--mode", &args.mode, Mode::NAMED))?;
    require_png_name(&args.output)?;
    let loaded = io::read_mesh(&args.mesh)?;
    let distances = match (&args.against, mode) {
        (Some(other), _) => Some(distances_to(&loaded.mesh, &io::read_mesh(other)?.mesh)),
        (None, Mode::Heat) => {
            return Err(Failure::usage(
                "--mode heat needs --against MESH, the mesh to measure distances to",
            ));
        }
        (None, _) => None,
    };
    let scene = Scene {
        texture: loaded.texture.as_ref(),
        heat: distances.as_deref().map(|values| Heat { values, limit: None, unit: "mm" }),
        frame: frame_of(&loaded.mesh),
        ..Scene::new(&loaded.mesh)
    };
    let sheet = contact_sheet(&scene, &views, mode, (args.size, args.size))?;
    io::image::write_png(&args.output, &sheet)?;
    let mut facts = json!({ "width": sheet.width(), "height": sheet.height() });
    if mode == Mode::Uncertainty {
        let mesh = &loaded.mesh;
        let sigmas: Vec<f64> =
            mesh.sigmas.iter().zip(&mesh.measured).filter(|m| *m.1).map(|m| *m.0).collect();
        let share = sigmas.len() as f64 / mesh.vertices.len().max(1) as f64;
        let at = |q| percentile(&sigmas, q).unwrap_or(f64::NAN);
        terminal.message(format!(
            "{:.0} % of the vertices were measured (grey: not); their standard deviation is {:.2} mm \
             (median), {:.2} mm (95th percentile)",
            100.0 * share,
            at(0.5),
            at(0.95)
        ));
        facts["measured_share"] = json!(share);
        facts["sigma_median_mm"] = json!(percentile(&sigmas, 0.5));
        facts["sigma_p95_mm"] = json!(percentile(&sigmas, 0.95));
    }
    terminal.wrote(&[&args.output], facts);
    Ok(())
}

fn unknown<T>(flag: &str, name: &str, choices: &[(&str, T)]) -> Failure {
    let names: Vec<_> = choices.iter().map(|c| c.0).collect();
    Failure::usage(format!("{flag} {name}: unknown; expected one of {}", names.join(", ")))
}

/// Distance of every vertex to the surface of another mesh, mm; NaN where there is none.
fn distances_to(mesh: &Mesh, other: &Mesh) -> Vec<f64> {
    let index = SurfaceIndex::new(other);
    let distance = |v| index.as_ref().and_then(|i| i.closest(v)).map_or(f64::NAN, |c| c.distance);
    mesh.vertices.iter().map(distance).collect()
}

/// The frame of a mesh: camera when it lies farther along +z than its own size.
fn frame_of(mesh: &Mesh) -> Frame {
    match mesh.bounds() {
        Some((low, high)) if low.z > (high - low).norm() => Frame::Camera,
        _ => Frame::Model,
    }
}
