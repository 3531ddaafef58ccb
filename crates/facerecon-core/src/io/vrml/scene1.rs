//! VRML 1.0: nodes in order, with a state that separators save and restore.

use nalgebra::Matrix4;

use super::build::{Builder, FaceSet, rotation, transform};
use super::nodes::{NodeId, Scene};
use crate::io::error::Fault;

/// What earlier nodes set for later ones.
#[derive(Clone)]
struct State {
    world_from_node: Matrix4<f64>,
    coordinates: Option<NodeId>,
    uvs: Option<NodeId>,
    image: Option<NodeId>,
    material: Option<NodeId>,
    by_vertex: bool,
    ccw: bool,
}

/// Adds the face sets of a VRML 1.0 scene.
pub(super) fn walk(scene: &Scene, builder: &mut Builder) -> Result<(), Fault> {
    let mut state = State {
        world_from_node: Matrix4::identity(),
        coordinates: None,
        uvs: None,
        image: None,
        material: None,
        by_vertex: false,
        ccw: true,
    };
    scene.roots.iter().try_for_each(|&root| node(scene, root, &mut state, builder))
}

/// The parser bounds the nesting: a node contains only nodes before it.
fn node(scene: &Scene, id: NodeId, state: &mut State, builder: &mut Builder) -> Result<(), Fault> {
    builder.visit()?;
    let node_ = &scene.nodes[id];
    match node_.kind.as_str() {
        "Separator" | "WWWAnchor" => {
            let mut inner = state.clone();
            return node_.children.iter().try_for_each(|&c| node(scene, c, &mut inner, builder));
        }
        "TransformSeparator" => {
            let saved = state.world_from_node;
            node_.children.iter().try_for_each(|&c| node(scene, c, state, builder))?;
            state.world_from_node = saved;
        }
        "Group" => {
            return node_.children.iter().try_for_each(|&c| node(scene, c, state, builder));
        }
        "Switch" => {
            let which = node_.vector::<1>("whichChild").map_or(-1.0, |[w]| w);
            for (i, &child) in node_.children.iter().enumerate() {
                if which == -3.0 || which == i as f64 {
                    node(scene, child, state, builder)?;
                }
            }
        }
        // The first child is the most detailed.
        "LOD" => {
            let mut inner = state.clone();
            return node_
                .children
                .iter()
                .take(1)
                .try_for_each(|&c| node(scene, c, &mut inner, builder));
        }
        "Coordinate3" => state.coordinates = Some(id),
        "TextureCoordinate2" => state.uvs = Some(id),
        "Texture2" => state.image = Some(id),
        "Material" => state.material = Some(id),
        "MaterialBinding" => {
            state.by_vertex = node_.text("value").is_some_and(|v| v.starts_with("PER_VERTEX"));
        }
        "ShapeHints" => state.ccw = node_.text("vertexOrdering") != Some("CLOCKWISE"),
        "Transform" => {
            state.world_from_node *= transform(
                node_.vector("translation").unwrap_or_default(),
                node_.vector("rotation").unwrap_or([0.0, 0.0, 1.0, 0.0]),
                node_.vector("scaleFactor").unwrap_or([1.0; 3]),
                node_.vector("scaleOrientation").unwrap_or([0.0, 0.0, 1.0, 0.0]),
                node_.vector("center").unwrap_or_default(),
            );
        }
        "Translation" => {
            let shift = node_.vector::<3>("translation").unwrap_or_default();
            state.world_from_node *= Matrix4::new_translation(&shift.into());
        }
        "Rotation" => {
            state.world_from_node *=
                rotation(node_.vector("rotation").unwrap_or([0.0, 0.0, 1.0, 0.0]));
        }
        "Scale" => {
            let scale = node_.vector::<3>("scaleFactor").unwrap_or([1.0; 3]);
            state.world_from_node *= Matrix4::new_nonuniform_scaling(&scale.into());
        }
        // Row vectors: written transposed.
        "MatrixTransform" => {
            if let Some(rows) = node_.vector::<16>("matrix") {
                state.world_from_node *= Matrix4::from_column_slice(&rows);
            }
        }
        "IndexedFaceSet" => face_set(scene, id, state, builder)?,
        other @ ("Cube" | "Cone" | "Cylinder" | "Sphere" | "AsciiText" | "IndexedLineSet"
        | "PointSet" | "WWWInline") => builder.ignored(&format!("a {other}")),
        _ => {}
    }
    Ok(())
}

fn face_set(scene: &Scene, id: NodeId, state: &State, builder: &mut Builder) -> Result<(), Fault> {
    let node = &scene.nodes[id];
    let Some(coordinates) = state.coordinates else {
        return Err(Fault::new("an IndexedFaceSet has no Coordinate3 before it"));
    };
    let uv =
        state.uvs.map(|uvs| (scene.nodes[uvs].numbers("point"), node.numbers("textureCoordIndex")));
    // In VRML 1.0 texture coordinates need an index of their own.
    let uv = uv.filter(|(points, index)| !points.is_empty() && !index.is_empty());
    let colors = state
        .material
        .filter(|_| state.by_vertex)
        .map(|m| (scene.nodes[m].numbers("diffuseColor"), node.numbers("materialIndex")));
    let set = FaceSet {
        coordinates: (coordinates, scene.nodes[coordinates].numbers("point")),
        index: node.numbers("coordIndex"),
        uv,
        colors: colors.filter(|(colors, _)| colors.len() > 3),
        ccw: state.ccw,
        image: state.image.and_then(|p| scene.nodes[p].text("filename")),
    };
    builder.add(&set, &state.world_from_node)
}
