//! `facerecon compare`.

use facerecon_core::evaluate::{BothDirections, CompareParams, Comparison, MeshRegion};
use facerecon_core::io;

use super::shared::to_json;
use crate::args::CompareArgs;
use crate::failure::Failure;
use crate::output::Terminal;

/// Measures distances between two meshes, before and after alignment.
pub(super) fn compare(args: &CompareArgs, terminal: &Terminal) -> Result<(), Failure> {
    let a = io::read_mesh(&args.a)?;
    let b = io::read_mesh(&args.b)?;
    let found = facerecon_core::evaluate::compare(
        &MeshRegion::whole(&a.mesh),
        &MeshRegion::whole(&b.mesh),
        &CompareParams::default(),
        &(),
    )?;
    if terminal.json {
        terminal.result(&to_json(&serde_json::json!(found)));
    } else {
        terminal.result(&table(&found));
    }
    Ok(())
}

/// The comparison as a table, mm.
fn table(found: &Comparison) -> String {
    let mut text =
        String::from("distances, mm             median    mean     p90     p99     max\n");
    let mut rows = |name: &str, both: &BothDirections| {
        for (way, d) in [("A to B", &both.first_to_second), ("B to A", &both.second_to_first)] {
            let label = format!("{name}, {way}");
            text.push_str(&format!(
                "{label:<24} {:>7.3} {:>7.3} {:>7.3} {:>7.3} {:>7.2}\n",
                d.median_mm, d.mean_mm, d.p90_mm, d.p99_mm, d.max_mm
            ));
        }
    };
    rows("before alignment", &found.before);
    if let Some(after) = &found.after {
        rows("after alignment", after);
        text.push_str(&format!(
            "alignment: rotation {:.2} degrees, scale {:.4}\n",
            found.rotation_deg, found.scale
        ));
    }
    text
}
