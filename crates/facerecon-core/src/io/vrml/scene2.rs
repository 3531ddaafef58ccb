//! VRML 2.0 (VRML97): groups, transforms and shapes.

use nalgebra::Matrix4;

use super::build::{Builder, FaceSet, transform};
use super::nodes::{Node, NodeId, Scene};
use crate::io::error::Fault;

/// Adds the face sets of a VRML 2.0 scene.
pub(super) fn walk(scene: &Scene, builder: &mut Builder) -> Result<(), Fault> {
    scene.roots.iter().try_for_each(|&root| node(scene, root, &Matrix4::identity(), builder))
}

/// The parser bounds the nesting: a node contains only nodes before it.
fn node(
    scene: &Scene,
    id: NodeId,
    world_from_node: &Matrix4<f64>,
    builder: &mut Builder,
) -> Result<(), Fault> {
    builder.visit()?;
    let found = &scene.nodes[id];
    let all = |ids: &[NodeId], world_from_node: &Matrix4<f64>, builder: &mut Builder| {
        ids.iter().try_for_each(|&c| node(scene, c, world_from_node, builder))
    };
    match found.kind.as_str() {
        "Transform" => {
            let own = transform(
                found.vector("translation").unwrap_or_default(),
                found.vector("rotation").unwrap_or([0.0, 0.0, 1.0, 0.0]),
                found.vector("scale").unwrap_or([1.0; 3]),
                found.vector("scaleOrientation").unwrap_or([0.0, 0.0, 1.0, 0.0]),
                found.vector("center").unwrap_or_default(),
            );
            all(found.nodes("children"), &(world_from_node * own), builder)
        }
        "Group" | "Anchor" | "Billboard" => all(found.nodes("children"), world_from_node, builder),
        "Collision" => all(found.nodes("children"), world_from_node, builder),
        "Switch" => {
            let which = found.vector::<1>("whichChoice").map_or(-1.0, |[w]| w);
            let choice = found.nodes("choice");
            let chosen = (which >= 0.0).then(|| choice.get(which as usize)).flatten();
            chosen.map_or(Ok(()), |&c| node(scene, c, world_from_node, builder))
        }
        // The first level is the most detailed.
        "LOD" => all(found.nodes("level").get(..1).unwrap_or_default(), world_from_node, builder),
        "Shape" => shape(scene, found, world_from_node, builder),
        "Inline" => {
            builder.ignored("an inlined file");
            Ok(())
        }
        _ => Ok(()),
    }
}

fn shape(
    scene: &Scene,
    shape: &Node,
    world_from_node: &Matrix4<f64>,
    builder: &mut Builder,
) -> Result<(), Fault> {
    let first =
        |node: &Node, field: &str| node.nodes(field).first().map(|&id| (id, &scene.nodes[id]));
    let Some((_, geometry)) = first(shape, "geometry") else { return Ok(()) };
    if geometry.kind != "IndexedFaceSet" {
        builder.ignored(&format!("a {}", geometry.kind));
        return Ok(());
    }
    let Some((id, coordinates)) = first(geometry, "coord") else { return Ok(()) };
    let appearance = first(shape, "appearance").map(|(_, a)| a);
    let texture = appearance.and_then(|a| first(a, "texture")).map(|(_, t)| t);
    if appearance.is_some_and(|a| !a.nodes("textureTransform").is_empty()) {
        builder.ignored("a texture transform");
    }
    let uvs = first(geometry, "texCoord").map(|(_, n)| n.numbers("point"));
    let colors = first(geometry, "color").map(|(_, n)| n.numbers("color"));
    if colors.is_some() && !geometry.switch("colorPerVertex", true) {
        builder.ignored("a colour for each face");
    }
    let set = FaceSet {
        coordinates: (id, coordinates.numbers("point")),
        index: geometry.numbers("coordIndex"),
        uv: uvs.filter(|p| !p.is_empty()).map(|p| (p, geometry.numbers("texCoordIndex"))),
        colors: colors
            .filter(|_| geometry.switch("colorPerVertex", true))
            .map(|c| (c, geometry.numbers("colorIndex"))),
        ccw: geometry.switch("ccw", true),
        image: texture.filter(|t| t.kind == "ImageTexture").and_then(|t| t.text("url")),
    };
    builder.add(&set, world_from_node)
}
