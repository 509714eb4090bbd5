//! `EXT_mesh_gpu_instancing`: the places of a node's mesh that is drawn many times. Called for each node of a document.

use std::collections::BTreeMap;

use glam::{DAffine3, DQuat, DVec3};
use gltf::json::Index;
use gltf::json::accessor::Accessor;
use gltf::json::scene::Node;
use serde::Deserialize;

use super::accessor::Buffers;
use crate::scene::error::Reason;

pub const NAME: &str = "EXT_mesh_gpu_instancing";

/// The most instances that are read. More would not be drawn in reasonable time, because each is a draw call of its
/// own.
pub const MOST_INSTANCES: usize = 1 << 16;

/// The extension's object in a node. Attributes with other names than the extension's do not say anything about places.
#[derive(Debug, Deserialize)]
struct InstancingExtension {
    attributes: BTreeMap<String, serde_json::Value>,
}

/// The place of each instance within the node; `None` when the node does not have the extension. `left` is how many
/// instances may still be added.
pub fn places(buffers: &Buffers, node: &Node, left: usize) -> Result<Option<Vec<DAffine3>>, Reason> {
    let Some(value) = node.extensions.as_ref().and_then(|e| e.others.get(NAME)) else { return Ok(None) };
    read(buffers, value, left).map(Some).map_err(|reason| format!("{NAME}: {reason}"))
}

fn read(buffers: &Buffers, value: &serde_json::Value, left: usize) -> Result<Vec<DAffine3>, Reason> {
    let places = InstancingExtension::deserialize(value).map_err(|error| error.to_string())?;
    let numbers = |name: &str, width: usize| -> Result<Option<Vec<f32>>, Reason> {
        let Some(index) = places.attributes.get(name) else { return Ok(None) };
        let index = index.as_u64().and_then(|i| u32::try_from(i).ok());
        let index = index.ok_or_else(|| format!("{name} is not the number of an accessor"))?;
        Ok(Some(buffers.numbers(Index::<Accessor>::new(index), &[width])?.values))
    };
    let (translations, rotations, scales) = (numbers("TRANSLATION", 3)?, numbers("ROTATION", 4)?, numbers("SCALE", 3)?);
    let counts = [(&translations, 3), (&rotations, 4), (&scales, 3)];
    let mut counts = counts.into_iter().filter_map(|(values, width)| Some(values.as_ref()?.len() / width));
    let count = counts.next().ok_or("it has neither TRANSLATION nor ROTATION nor SCALE")?;
    if counts.any(|other| other != count) {
        return Err("its attributes have different counts".to_owned());
    }
    if count > left {
        return Err(format!("{count} instances; at most {MOST_INSTANCES} are drawn in all"));
    }
    let vector = |values: &Option<Vec<f32>>, i: usize, otherwise: DVec3| {
        values.as_ref().map_or(otherwise, |v| DVec3::new(v[3 * i].into(), v[3 * i + 1].into(), v[3 * i + 2].into()))
    };
    let place = |i: usize| {
        let turn = rotations.as_ref().map(|q| DQuat::from_array([0, 1, 2, 3].map(|k| q[4 * i + k].into())));
        let turn =
            turn.filter(|q| q.is_finite() && q.length_squared() > 1e-24).map_or(DQuat::IDENTITY, DQuat::normalize);
        let (size, shift) = (vector(&scales, i, DVec3::ONE), vector(&translations, i, DVec3::ZERO));
        let place = DAffine3::from_scale_rotation_translation(size, turn, shift);
        if place.is_finite() { Ok(place) } else { Err(format!("instance {i} has no finite place")) }
    };
    (0..count).map(place).collect()
}
