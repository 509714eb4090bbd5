//! Resolves the node tree of a glTF in f64: which nodes are in the scene, and where. Called when a document is read.

use glam::{DAffine3, DMat4, DQuat, DVec3};
use gltf::json::Root;
use gltf::json::scene::Node;

use super::limits::MOST_DEPTH;
use crate::scene::error::Reason;

/// Name of the extension that hides a node and all nodes below it.
pub const VISIBILITY: &str = "KHR_node_visibility";

/// A node reached from the scene's roots.
#[derive(Debug, Clone)]
pub struct PlacedNode {
    /// Index in the document.
    pub node: usize,
    pub world_from_node: DAffine3,
    /// Index of its parent among the placed nodes, where it comes before its children; `None` for a root.
    pub parent: Option<usize>,
    /// Whether neither this node nor any node above it is hidden.
    pub visible: bool,
}

/// All nodes of the default scene, parents before children. Without a default scene it is the first scene; without any
/// scene it is all nodes from the roots down.
pub fn place(root: &Root) -> Result<Vec<PlacedNode>, Reason> {
    let scene = root.scene.map_or(0, |s| s.value());
    let tops: Vec<usize> = match root.scenes.get(scene) {
        Some(scene) => scene.nodes.iter().map(|n| n.value()).collect(),
        None => parentless(root),
    };
    let mut seen = vec![false; root.nodes.len()];
    let mut out: Vec<PlacedNode> = Vec::new();
    // A node, its parent's index in `out`, and the number of nodes above it.
    let mut stack: Vec<(usize, Option<usize>, usize)> = tops.into_iter().rev().map(|node| (node, None, 0)).collect();
    while let Some((index, parent, above)) = stack.pop() {
        let node = root.nodes.get(index).ok_or_else(|| format!("nodes[{index}] does not exist"))?;
        if std::mem::replace(&mut seen[index], true) {
            return Err(format!("{} is reached twice: a cycle or two parents", label(node, index)));
        }
        if above >= MOST_DEPTH {
            let label = label(node, index);
            return Err(format!("{label} has {above} nodes above it; a tree of at most {MOST_DEPTH} levels is read"));
        }
        let (world_from_parent, parent_visible) =
            parent.map_or((DAffine3::IDENTITY, true), |p| (out[p].world_from_node, out[p].visible));
        let world_from_node = world_from_parent * local(node);
        if !world_from_node.is_finite() {
            return Err(format!("{}: its transform is not finite", label(node, index)));
        }
        let visible = node.extensions.as_ref().and_then(|e| e.others.get(VISIBILITY)?.get("visible")?.as_bool());
        let visible = parent_visible && visible.unwrap_or(true);
        stack.extend(node.children.iter().flatten().rev().map(|child| (child.value(), Some(out.len()), above + 1)));
        out.push(PlacedNode { node: index, world_from_node, parent, visible });
    }
    Ok(out)
}

/// "node `Name`" or "nodes[i]".
pub fn label(node: &Node, index: usize) -> String {
    node.name.as_ref().map_or_else(|| format!("nodes[{index}]"), |name| format!("node `{name}`"))
}

fn parentless(root: &Root) -> Vec<usize> {
    let mut child = vec![false; root.nodes.len()];
    for c in root.nodes.iter().flat_map(|n| n.children.iter().flatten()) {
        if let Some(flag) = child.get_mut(c.value()) {
            *flag = true;
        }
    }
    (0..child.len()).filter(|i| !child[*i]).collect()
}

fn local(node: &Node) -> DAffine3 {
    if let Some(m) = node.matrix {
        return DAffine3::from_mat4(DMat4::from_cols_array(&m.map(f64::from)));
    }
    let rotation = node.rotation.map_or(DQuat::IDENTITY, |q| {
        let [x, y, z, w] = q.0.map(f64::from);
        let q = DQuat::from_xyzw(x, y, z, w);
        if q.length_squared() > 1e-24 { q.normalize() } else { DQuat::IDENTITY }
    });
    let vector = |v: Option<[f32; 3]>, otherwise: DVec3| v.map_or(otherwise, |v| DVec3::from_array(v.map(f64::from)));
    DAffine3::from_scale_rotation_translation(
        vector(node.scale, DVec3::ONE),
        rotation,
        vector(node.translation, DVec3::ZERO),
    )
}
