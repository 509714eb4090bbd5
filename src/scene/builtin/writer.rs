//! Writes shapes into the binary buffer of a built-in scene's glTF. Called by the scene's builder.

use glam::Vec3;
use serde_json::{Value, json};

use super::finish::Finish;
use super::shape::Shape;

/// Collects the buffer's bytes together with the buffer views and accessors that describe them.
#[derive(Default)]
pub(super) struct Writer {
    pub(super) bytes: Vec<u8>,
    pub(super) views: Vec<Value>,
    pub(super) accessors: Vec<Value>,
}

impl Writer {
    /// Appends a shape's attributes and indices, and returns the glTF primitive that refers to them.
    pub(super) fn primitive(&mut self, shape: &Shape, material: usize, finish: &Finish) -> Value {
        let flat3 = |v: &[Vec3]| v.iter().flat_map(|v| v.to_array()).collect::<Vec<f32>>();
        let positions = self.floats(&flat3(&shape.positions), "VEC3");
        let (low, high) = shape
            .positions
            .iter()
            .fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), p| (low.min(*p), high.max(*p)));
        self.accessors[positions]["min"] = json!(low.to_array());
        self.accessors[positions]["max"] = json!(high.to_array());
        let mut attributes = json!({
            "POSITION": positions,
            "NORMAL": self.floats(&flat3(&shape.normals), "VEC3"),
            "TEXCOORD_0": self.floats(&shape.uvs.iter().flat_map(|v| v.to_array()).collect::<Vec<f32>>(), "VEC2"),
        });
        if finish.normal_map.is_some() {
            attributes["TANGENT"] = self.floats(&super::texture::tangents(shape), "VEC4").into();
        }
        let start = self.bytes.len();
        self.bytes.extend(shape.indices.iter().flat_map(|i| i.to_le_bytes()));
        self.views
            .push(json!({ "buffer": 0, "byteOffset": start, "byteLength": self.bytes.len() - start, "target": 34963 }));
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1, "componentType": 5125, "count": shape.indices.len(), "type": "SCALAR",
        }));
        json!({ "attributes": attributes, "indices": self.accessors.len() - 1, "material": material })
    }

    fn floats(&mut self, values: &[f32], kind: &str) -> usize {
        let width = match kind {
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        let start = self.bytes.len();
        self.bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
        self.views
            .push(json!({ "buffer": 0, "byteOffset": start, "byteLength": self.bytes.len() - start, "target": 34962 }));
        self.accessors.push(json!({
            "bufferView": self.views.len() - 1, "componentType": 5126, "count": values.len() / width, "type": kind,
        }));
        self.accessors.len() - 1
    }
}
