//! What a scene holds, what was repaired, and what one should know before a study uses it. `scene info`, `scene check`
//! and the reproduction of the paper report it.

use serde::Serialize;

use super::{Alpha, ExtensionUse, Scene};

/// Table 1 of the paper counts the materials below this roughness as reflective.
pub const REFLECTIVE_BELOW: f32 = 0.8;

/// Counts, shares and sentences about a scene.
#[derive(Debug, Clone, Serialize)]
pub struct Survey {
    pub name: String,
    pub content_sha256: String,
    /// Of all instances together.
    pub triangles: usize,
    /// Draw calls: the number of placed primitives.
    pub instances: usize,
    pub primitives: usize,
    pub materials: usize,
    /// Materials with a roughness below 0.8.
    pub reflective_materials: usize,
    /// Smallest, largest and mean roughness factor of the reflective materials.
    pub roughness: Option<[f32; 3]>,
    pub textures: usize,
    pub lights: usize,
    pub views: Vec<String>,
    /// Instances that move.
    pub moving: usize,
    /// Share of the triangles that belong to closed meshes. Only those get a layer of back faces.
    pub closed_share: f64,
    /// Size of vertices and indices, uncompressed.
    pub geometry_mib: f64,
    /// Size of the texels, uncompressed and without mip levels.
    pub texture_mib: f64,
    /// The glTF extensions that the file names: read, approximated or ignored.
    pub extensions: Vec<ExtensionUse>,
    pub repairs: Vec<String>,
    pub warnings: Vec<String>,
}

/// Surveys a scene.
pub fn survey(scene: &Scene) -> Survey {
    let rough: Vec<f32> = scene.materials.iter().map(|m| m.roughness).filter(|r| *r < REFLECTIVE_BELOW).collect();
    let roughness = (!rough.is_empty()).then(|| {
        let (low, high) = rough.iter().fold((1.0f32, 0.0f32), |(low, high), r| (low.min(*r), high.max(*r)));
        [low, high, rough.iter().sum::<f32>() / rough.len() as f32]
    });
    let triangles = scene.triangle_count();
    let closed: usize = scene
        .instances
        .iter()
        .map(|i| &scene.primitives[i.primitive])
        .filter(|p| p.closed)
        .map(|p| p.indices.len() / 3)
        .sum();
    // Position 12, normal 12, tangent 16, two UV sets 16, colour 16 bytes.
    let vertices: usize = scene.primitives.iter().map(|p| p.positions.len() * 72 + p.indices.len() * 4).sum();
    // An image that is used both as colour and as data is allocated once.
    let mut images: Vec<_> = scene.textures.iter().map(|t| (t.rgba8.as_ptr(), t.rgba8.len())).collect();
    images.sort_unstable();
    images.dedup();
    const MIB: f64 = 1024.0 * 1024.0;
    Survey {
        name: scene.name.clone(),
        content_sha256: scene.content_sha256.clone(),
        triangles,
        instances: scene.instances.len(),
        primitives: scene.primitives.len(),
        materials: scene.materials.len(),
        reflective_materials: rough.len(),
        roughness,
        textures: scene.textures.len(),
        lights: scene.lights.len(),
        views: scene.views.iter().map(|v| v.name.clone()).collect(),
        moving: scene.motions.iter().map(|m| m.instances.len()).sum(),
        closed_share: if triangles == 0 { 0.0 } else { closed as f64 / triangles as f64 },
        geometry_mib: vertices as f64 / MIB,
        texture_mib: images.iter().map(|(_, n)| *n).sum::<usize>() as f64 / MIB,
        extensions: scene.extensions.clone(),
        repairs: scene.repairs.clone(),
        warnings: warnings(scene, closed, triangles, rough.len()),
    }
}

fn warnings(scene: &Scene, closed: usize, triangles: usize, reflective: usize) -> Vec<String> {
    let mut said = Vec::new();
    if triangles == 0 {
        said.push("there is no triangle: only the environment will be seen".to_owned());
    } else if closed * 2 < triangles {
        said.push(format!(
            "only {} % of the triangles are in closed meshes; open ones count as {:.4} m thick behind their front",
            closed * 100 / triangles,
            scene.open_mesh_thickness_m
        ));
    }
    if reflective == 0 {
        said.push("no material is below roughness 0.8: no reflection ray will be traced".to_owned());
    }
    if triangles > 1_000_000 {
        said.push(format!("{triangles} triangles: drawing them dominates on a software device"));
    }
    let masked = scene.materials.iter().filter(|m| matches!(m.alpha, Alpha::Mask { .. })).count();
    if masked > 0 {
        said.push(format!("{masked} materials are cut out by alpha"));
    }
    let clear = scene.materials.iter().filter(|m| m.transmission > 0.0).count();
    if clear > 0 {
        said.push(format!(
            "{clear} materials transmit light; they are drawn as surfaces, and the light of lamps passes through"
        ));
    }
    if scene.views.iter().any(|v| v.ipd_m == 0.0) {
        said.push("a view has both eyes in one place".to_owned());
    }
    said
}
