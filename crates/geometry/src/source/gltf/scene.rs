//! Nodes of a glTF file: which mesh stands where.

use super::{index, list};
use crate::source::read_error::ReadErrorKind;
use glam::{DAffine3, DMat4, DQuat, DVec3};
use serde_json::Value;

/// A mesh in the scene, at its first node.
pub(super) struct Placed {
    pub(super) mesh: usize,
    pub(super) place: DAffine3,
    /// Number of nodes with the mesh.
    pub(super) nodes: usize,
}

/// Meshes of the scene in the order of the nodes; all meshes, as they are, if no node of the scene has one.
pub(super) fn meshes(document: &Value, notes: &mut Vec<String>) -> Result<Vec<Placed>, ReadErrorKind> {
    let nodes = list(document, "nodes");
    let is_child = |n: usize| nodes.iter().any(|node| list(node, "children").iter().any(|c| index(c) == Some(n)));
    let scenes = list(document, "scenes");
    let scene = scenes.get(index(&document["scene"]).unwrap_or(0));
    let roots: Vec<usize> = match scene {
        Some(scene) => list(scene, "nodes").iter().filter_map(index).collect(),
        None if nodes.len() > 10_000 => (0..nodes.len()).collect(),
        None => (0..nodes.len()).filter(|n| !is_child(*n)).collect(),
    };
    let mut placed: Vec<Placed> = Vec::new();
    let mut visited = vec![false; nodes.len()];
    let mut open: Vec<(usize, DAffine3)> = roots.into_iter().rev().map(|n| (n, DAffine3::IDENTITY)).collect();
    let mut instanced = false;
    while let Some((n, parent)) = open.pop() {
        let bad = |reason: &str| ReadErrorKind::Malformed(format!("node {n}: {reason}"));
        let node = nodes.get(n).ok_or_else(|| bad("there is none"))?;
        // A node with two parents, or that is its own ancestor, breaks the rules; its first place counts.
        if std::mem::replace(&mut visited[n], true) {
            continue;
        }
        let place = parent * transform(node);
        if let Some(mesh) = index(&node["mesh"]) {
            if mesh >= list(document, "meshes").len() {
                return Err(bad(&format!("mesh {mesh} does not exist")));
            }
            // The vertices of a skinned mesh are placed by its joints alone.
            let place = if node["skin"].is_null() { place } else { DAffine3::IDENTITY };
            let is_usable = place.is_finite() && place.matrix3.determinant() != 0.0;
            let place = if is_usable { place } else { DAffine3::IDENTITY };
            instanced |= !node["extensions"]["EXT_mesh_gpu_instancing"].is_null();
            match placed.iter_mut().find(|known| known.mesh == mesh) {
                Some(known) => known.nodes += 1,
                None => placed.push(Placed { mesh, place, nodes: 1 }),
            }
        }
        open.extend(list(node, "children").iter().rev().filter_map(|c| Some((index(c)?, place))));
    }
    let repeated: usize = placed.iter().map(|p| p.nodes - 1).sum();
    if repeated > 0 || instanced {
        let text = "the scene shows a mesh several times; the surface has it once, and the other instances follow";
        notes.push(text.to_owned());
    }
    let all = list(document, "meshes").len();
    if placed.is_empty() {
        return Ok((0..all).map(|mesh| Placed { mesh, place: DAffine3::IDENTITY, nodes: 0 }).collect());
    }
    if placed.len() < all {
        notes.push(format!("{} of {all} meshes are not in the scene and stay as they are", all - placed.len()));
    }
    Ok(placed)
}

/// Transformation of a node from its parent.
fn transform(node: &Value) -> DAffine3 {
    let numbers = |name: &str| -> Vec<f64> { list(node, name).iter().filter_map(Value::as_f64).collect() };
    if let Ok(matrix) = <[f64; 16]>::try_from(numbers("matrix")) {
        return DAffine3::from_mat4(DMat4::from_cols_array(&matrix));
    }
    let vector = |name: &str, default: DVec3| <[f64; 3]>::try_from(numbers(name)).map_or(default, DVec3::from);
    let rotation = <[f64; 4]>::try_from(numbers("rotation")).map_or(DQuat::IDENTITY, DQuat::from_array);
    let rotation = if rotation.length_squared() > 0.0 { rotation.normalize() } else { DQuat::IDENTITY };
    DAffine3::from_scale_rotation_translation(vector("scale", DVec3::ONE), rotation, vector("translation", DVec3::ZERO))
}

/// Number of morph targets of all meshes.
pub(super) fn morph_targets(document: &Value) -> usize {
    let of_mesh = |mesh: &Value| list(mesh, "primitives").iter().map(|p| list(p, "targets").len()).max().unwrap_or(0);
    list(document, "meshes").iter().map(of_mesh).sum()
}
