//! VRML 1.0: a walk in order, with a state that separators save and restore.

use nalgebra::Matrix4;

use super::build::{Builder, FaceSet, transform, turn};
use super::nodes::{NodeId, Scene};
use crate::io::Fault;

/// What earlier nodes set for later ones.
#[derive(Clone)]
struct State {
    place: Matrix4<f64>,
    coordinates: Option<NodeId>,
    uvs: Option<NodeId>,
    picture: Option<NodeId>,
    material: Option<NodeId>,
    by_vertex: bool,
    ccw: bool,
}

/// Adds the face sets of a VRML 1.0 scene.
pub(super) fn walk(scene: &Scene, builder: &mut Builder) -> Result<(), Fault> {
    let mut state = State {
        place: Matrix4::identity(),
        coordinates: None,
        uvs: None,
        picture: None,
        material: None,
        by_vertex: false,
        ccw: true,
    };
    scene.roots.iter().try_for_each(|&root| node(scene, root, &mut state, builder))
}

/// Nesting is bounded by the parser: definitions hold only what came before.
fn node(scene: &Scene, id: NodeId, state: &mut State, builder: &mut Builder) -> Result<(), Fault> {
    builder.visit()?;
    let node_ = &scene.nodes[id];
    match node_.kind.as_str() {
        "Separator" | "WWWAnchor" => {
            let mut inner = state.clone();
            return node_.children.iter().try_for_each(|&c| node(scene, c, &mut inner, builder));
        }
        "TransformSeparator" => {
            let place = state.place;
            node_.children.iter().try_for_each(|&c| node(scene, c, state, builder))?;
            state.place = place;
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
        // The first child is the finest.
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
        "Texture2" => state.picture = Some(id),
        "Material" => state.material = Some(id),
        "MaterialBinding" => {
            state.by_vertex = node_.text("value").is_some_and(|v| v.starts_with("PER_VERTEX"));
        }
        "ShapeHints" => state.ccw = node_.text("vertexOrdering") != Some("CLOCKWISE"),
        "Transform" => {
            state.place *= transform(
                node_.vector("translation").unwrap_or_default(),
                node_.vector("rotation").unwrap_or([0.0, 0.0, 1.0, 0.0]),
                node_.vector("scaleFactor").unwrap_or([1.0; 3]),
                node_.vector("scaleOrientation").unwrap_or([0.0, 0.0, 1.0, 0.0]),
                node_.vector("center").unwrap_or_default(),
            );
        }
        "Translation" => {
            let shift = node_.vector::<3>("translation").unwrap_or_default();
            state.place *= Matrix4::new_translation(&shift.into());
        }
        "Rotation" => {
            state.place *= turn(node_.vector("rotation").unwrap_or([0.0, 0.0, 1.0, 0.0]));
        }
        "Scale" => {
            let scale = node_.vector::<3>("scaleFactor").unwrap_or([1.0; 3]);
            state.place *= Matrix4::new_nonuniform_scaling(&scale.into());
        }
        // Row vectors: written transposed.
        "MatrixTransform" => {
            if let Some(rows) = node_.vector::<16>("matrix") {
                state.place *= Matrix4::from_column_slice(&rows);
            }
        }
        "IndexedFaceSet" => face_set(scene, id, state, builder)?,
        other @ ("Cube" | "Cone" | "Cylinder" | "Sphere" | "AsciiText" | "IndexedLineSet"
        | "PointSet" | "WWWInline") => builder.left_out(&format!("a {other}")),
        _ => {}
    }
    Ok(())
}

fn face_set(scene: &Scene, id: NodeId, state: &State, builder: &mut Builder) -> Result<(), Fault> {
    let node = &scene.nodes[id];
    let Some(coordinates) = state.coordinates else {
        return Err(Fault::new("an IndexedFaceSet comes before any Coordinate3"));
    };
    let uv =
        state.uvs.map(|uvs| (scene.nodes[uvs].numbers("point"), node.numbers("textureCoordIndex")));
    // Without an index of its own VRML 1.0 gives no coordinates to the corners.
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
        picture: state.picture.and_then(|p| scene.nodes[p].text("filename")),
    };
    builder.add(&set, &state.place)
}
