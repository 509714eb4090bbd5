//! A square as a glTF in memory, which a case may damage. It goes through the loader, because these are hazards of
//! files. The cases of `meshes` call it.

use glam::{DQuat, Vec3, Vec4};
use serde_json::{Value, json};

use crate::scene::{self, Scene, SceneError, View};

use super::shapes::{constant_environment, plane};

/// A 4×4 grid in the xz plane that faces +Y, like [`plane`], from which a file is made.
pub struct Square {
    pub positions: Vec<Vec3>,
    pub normals: Vec<Vec3>,
    /// The file has no tangents if this is empty.
    pub tangents: Vec<Vec4>,
    pub indices: Vec<u32>,
    /// RGBA texels of a 2×2 normal map. The file has no normal map if this is empty.
    pub normal_map: Vec<u8>,
    pub roughness: f32,
}

/// The name of the mesh in the file. The loader's messages must contain it.
pub const MESH: &str = "Square";

impl Square {
    pub fn new(roughness: f32) -> Square {
        let p = plane(4);
        let (tangents, normal_map) = (Vec::new(), Vec::new());
        Square { positions: p.positions, normals: p.normals, tangents, indices: p.indices, normal_map, roughness }
    }

    /// Loads the file with the scene loader: a white metal in a white world, seen by `view`.
    ///
    /// # Errors
    /// The loader refuses the file.
    pub fn load(&self, view: View) -> Result<Scene, SceneError> {
        let loaded = scene::load_bytes("square", &self.glb())?;
        Ok(Scene { environment: constant_environment(1.0), lights: Vec::new(), views: vec![view], ..loaded })
    }

    fn glb(&self) -> Vec<u8> {
        let mut file = File { views: Vec::new(), accessors: Vec::new(), bytes: Vec::new() };
        let vec3 = |v: &[Vec3]| v.iter().flat_map(|v| v.to_array()).collect::<Vec<f32>>();
        let position = file.floats(&vec3(&self.positions), "VEC3", 3);
        file.accessors[position]["min"] = json!([-1, -1, -1]);
        file.accessors[position]["max"] = json!([1, 1, 1]);
        let uv: Vec<f32> = plane(4).uv0.iter().flat_map(|v| v.to_array()).collect();
        let mut attributes = json!({
            "POSITION": position,
            "NORMAL": file.floats(&vec3(&self.normals), "VEC3", 3),
            "TEXCOORD_0": file.floats(&uv, "VEC2", 2),
        });
        if !self.tangents.is_empty() {
            let tangents: Vec<f32> = self.tangents.iter().flat_map(|v| v.to_array()).collect();
            attributes["TANGENT"] = file.floats(&tangents, "VEC4", 4).into();
        }
        let words: Vec<u8> = self.indices.iter().flat_map(|i| i.to_le_bytes()).collect();
        let indices = file.accessor(&words, 5125, self.indices.len(), "SCALAR");
        let mut material =
            json!({ "pbrMetallicRoughness": { "metallicFactor": 1, "roughnessFactor": self.roughness } });
        let mut images = json!([]);
        if !self.normal_map.is_empty() {
            let view = file.view(&png(&self.normal_map));
            images = json!([{ "bufferView": view, "mimeType": "image/png" }]);
            material["normalTexture"] = json!({ "index": 0 });
        }
        let root = json!({
            "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
            "nodes": [{ "mesh": 0, "rotation": DQuat::IDENTITY.to_array() }],
            "meshes": [{ "name": MESH, "primitives": [{ "attributes": attributes, "indices": indices, "material": 0 }] }],
            "materials": [material], "images": images,
            "textures": if self.normal_map.is_empty() { json!([]) } else { json!([{ "source": 0 }]) },
            "accessors": file.accessors, "bufferViews": file.views, "buffers": [{ "byteLength": file.bytes.len() }],
        });
        container(&root, &file.bytes)
    }
}

struct File {
    views: Vec<Value>,
    accessors: Vec<Value>,
    bytes: Vec<u8>,
}

impl File {
    fn view(&mut self, bytes: &[u8]) -> usize {
        self.views.push(json!({ "buffer": 0, "byteOffset": self.bytes.len(), "byteLength": bytes.len() }));
        self.bytes.extend(bytes);
        self.bytes.resize(self.bytes.len().next_multiple_of(4), 0);
        self.views.len() - 1
    }

    fn accessor(&mut self, bytes: &[u8], component: u32, count: usize, kind: &str) -> usize {
        let view = self.view(bytes);
        self.accessors.push(json!({ "bufferView": view, "componentType": component, "count": count, "type": kind }));
        self.accessors.len() - 1
    }

    fn floats(&mut self, values: &[f32], kind: &str, width: usize) -> usize {
        let bytes: Vec<u8> = values.iter().flat_map(|v| v.to_le_bytes()).collect();
        self.accessor(&bytes, 5126, values.len() / width, kind)
    }
}

/// A 2×2 picture as a PNG.
fn png(rgba: &[u8]) -> Vec<u8> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let kind = image::ExtendedColorType::Rgba8;
    image::write_buffer_with_format(&mut bytes, rgba, 2, 2, kind, image::ImageFormat::Png)
        .expect("four texels fit in memory");
    bytes.into_inner()
}

/// A binary glTF (glTF 2.0, §4): the header, the JSON chunk and the binary chunk.
fn container(root: &Value, binary: &[u8]) -> Vec<u8> {
    let mut text = root.to_string().into_bytes();
    text.resize(text.len().next_multiple_of(4), b' ');
    let mut out = b"glTF".to_vec();
    out.extend(2u32.to_le_bytes());
    out.extend(((12 + 8 + text.len() + 8 + binary.len()) as u32).to_le_bytes());
    for (kind, chunk) in [(0x4E4F_534Au32, text.as_slice()), (0x004E_4942, binary)] {
        out.extend((chunk.len() as u32).to_le_bytes());
        out.extend(kind.to_le_bytes());
        out.extend(chunk);
    }
    out
}
