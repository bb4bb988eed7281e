//! Nodes: what is shown where.

use std::collections::HashSet;

use ::gltf::json;
use ::gltf::json::{Index, Node};
use glam::{DAffine3, DMat4, DQuat, DVec3};

use super::buffers::Document;
use crate::model::SceneError;

/// Deeper nesting than this is a mistake or an attack.
const MAX_DEPTH: usize = 1000;

/// A node with its transform to the world.
pub(super) struct Placement<'a> {
    pub node: &'a Node,
    pub index: usize,
    /// For messages.
    pub name: String,
    pub world: DAffine3,
}

impl Placement<'_> {
    /// The node's own name, unless it is empty.
    pub fn given_name(&self) -> Option<String> {
        self.node.name.clone().filter(|name| !name.is_empty())
    }
}

/// All nodes of the scene, parents before children, siblings in order.
pub(super) fn placements<'a>(document: &Document<'a>) -> Result<Vec<Placement<'a>>, SceneError> {
    let nodes = &document.root.nodes;
    let mut reached = vec![false; nodes.len()];
    let mut placements = Vec::new();
    let mut pending: Vec<_> =
        roots(document)?.into_iter().rev().map(|root| (root.value(), DAffine3::IDENTITY, 0)).collect();
    while let Some((index, parent, depth)) = pending.pop() {
        let placement = placement(document, index, parent)?;
        let fail = |message: &str| Err(document.fail(format!("node '{}'", placement.name), message));
        if std::mem::replace(&mut reached[index], true) {
            return fail("it is reached twice: it has two parents or is its own ancestor; export the file again");
        }
        if depth > MAX_DEPTH {
            return fail("it is nested more than 1000 levels deep; flatten the hierarchy");
        }
        let children = placement.node.children.iter().flatten().rev();
        pending.extend(children.map(|child| (child.value(), placement.world, depth + 1)));
        placements.push(placement);
    }
    Ok(placements)
}

fn placement<'a>(document: &Document<'a>, index: usize, parent: DAffine3) -> Result<Placement<'a>, SceneError> {
    let Some(node) = document.root.nodes.get(index) else {
        return Err(document.fail(format!("node {index}"), "it does not exist; export the file again"));
    };
    let name = node.name.clone().unwrap_or_else(|| index.to_string());
    let local = transform(node).map_err(|message| document.fail(format!("node '{name}'"), message))?;
    let world = parent * local;
    if !world.is_finite() {
        return Err(document.fail(format!("node '{name}'"), "its transform is not finite; reset it"));
    }
    Ok(Placement { node, index, name, world })
}

/// The nodes of the default scene, else of the first, else all that are nobody's child.
fn roots(document: &Document) -> Result<Vec<Index<Node>>, SceneError> {
    let root = document.root;
    let scene = root.scene.map_or(0, |scene| scene.value());
    match root.scenes.get(scene) {
        Some(scene) => Ok(scene.nodes.clone()),
        None if root.scene.is_some() => {
            Err(document.fail(format!("scene {scene}"), "it does not exist; export the file again"))
        }
        None => {
            let children: HashSet<_> = root.nodes.iter().flat_map(|node| node.children.iter().flatten()).collect();
            let all = (0..root.nodes.len() as u32).map(Index::new);
            Ok(all.filter(|node| !children.contains(node)).collect())
        }
    }
}

fn transform(node: &json::Node) -> Result<DAffine3, String> {
    let local = match node.matrix {
        Some(matrix) => from_matrix(matrix)?,
        None => from_parts(node)?,
    };
    if local.is_finite() { Ok(local) } else { Err("its transform is not finite; reset it".into()) }
}

fn from_matrix(columns: [f32; 16]) -> Result<DAffine3, String> {
    let matrix = DMat4::from_cols_array(&columns.map(f64::from));
    if matrix.row(3).abs_diff_eq(glam::DVec4::W, 1e-5) {
        Ok(DAffine3::from_mat4(matrix))
    } else {
        Err(format!("the last row of its matrix is {} and not 0, 0, 0, 1; apply the transform first", matrix.row(3)))
    }
}

fn from_parts(node: &json::Node) -> Result<DAffine3, String> {
    let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
    let translation = node.translation.map_or(DVec3::ZERO, vector);
    let scale = node.scale.map_or(DVec3::ONE, vector);
    let [x, y, z, w] = node.rotation.unwrap_or_default().0.map(f64::from);
    let rotation = DQuat::from_xyzw(x, y, z, w);
    if rotation.length() > 0.0 && rotation.is_finite() {
        Ok(DAffine3::from_scale_rotation_translation(scale, rotation.normalize(), translation))
    } else {
        Err(format!("its rotation {rotation} is no quaternion; reset it"))
    }
}
