//! The targets for scenes: manifests, and glTF and GLB files with packed meshes and pictures. A scene that is loaded
//! must be fit to be drawn: every index is valid, and every number that reaches a shader is finite.

use std::path::Path;

use cyclopean::scene::manifest::{EnvironmentSpec, Manifest};
use cyclopean::scene::{self, Scene, SceneError, survey};

/// A glTF with a triangle, for manifests to refer to. Its buffer is in a data URI.
const TRIANGLE: &str = include_str!("triangle.gltf");

/// Reads the bytes as a side-car, which can have every part of a manifest except `geometry`.
pub fn manifest(bytes: &[u8]) {
    super::file("t.cyclopean.json", bytes);
    let path = super::file("t.gltf", TRIANGLE.as_bytes());
    // Prefiltering the light of a sky or a map takes some tenths of a second, whatever its numbers are. One in 1,024
    // such manifests is loaded as it is, and the others without their environment.
    if let Ok(mut manifest) = serde_json::from_slice::<Manifest>(bytes)
        && matches!(manifest.environment, Some(EnvironmentSpec::Sky(_) | EnvironmentSpec::Map(_)))
        && !super::one_of(1024, bytes)
    {
        manifest.environment = None;
        super::file("t.cyclopean.json", &serde_json::to_vec(&manifest).expect("plain data"));
    }
    loaded(scene::load(&path.to_string_lossy()));
}

pub fn gltf(bytes: &[u8]) {
    let path = super::file("u.gltf", bytes);
    loaded(scene::load(&path.to_string_lossy()));
}

pub fn glb(bytes: &[u8]) {
    let path = super::file("u.glb", bytes);
    loaded(scene::load(&path.to_string_lossy()));
}

fn loaded(scene: Result<Scene, SceneError>) {
    match scene {
        Ok(scene) => check(scene),
        Err(error) => super::said(&error),
    }
}

fn check(mut scene: Scene) {
    for primitive in &scene.primitives {
        let vertices = primitive.positions.len();
        let lists = [primitive.normals.len(), primitive.tangents.len(), primitive.colors.len()];
        assert_eq!(lists, [vertices; 3], "not one normal, tangent and colour for each vertex");
        assert_eq!(
            [primitive.uv0.len(), primitive.uv1.len()],
            [vertices; 2],
            "not two texture coordinates for each vertex"
        );
        assert!(primitive.indices.len().is_multiple_of(3), "the indices are not triples");
        assert!(primitive.indices.iter().all(|i| (*i as usize) < vertices), "an index has no vertex");
        assert!(primitive.positions.iter().all(|p| p.is_finite()), "a position is not finite");
        assert!(primitive.normals.iter().all(|n| (n.length() - 1.0).abs() < 1e-3), "a normal is not of unit length");
        assert!(
            primitive.tangents.iter().all(|t| (t.truncate().length() - 1.0).abs() < 1e-3),
            "a tangent is not of unit length"
        );
        assert!(primitive.material < scene.materials.len(), "a material does not exist");
    }
    for instance in &scene.instances {
        assert!(instance.primitive < scene.primitives.len(), "a primitive does not exist");
        assert!(instance.world_from_object.is_finite(), "a placement is not finite");
    }
    for material in &scene.materials {
        assert!(material.base_color.is_finite() && material.emissive.is_finite(), "a colour is not finite");
        let textures = [
            &material.base_color_texture,
            &material.metallic_roughness_texture,
            &material.normal_texture,
            &material.emissive_texture,
        ];
        assert!(textures.into_iter().flatten().all(|t| t.texture < scene.textures.len()), "a texture does not exist");
    }
    for texture in &scene.textures {
        let texels = u64::from(texture.width) * u64::from(texture.height);
        assert!(texels > 0 && texture.rgba8.len() as u64 == texels * 4, "not four bytes for each texel");
    }
    assert!(!scene.views.is_empty(), "the scene has no view");
    for view in scene.views.clone() {
        assert!(view.position.is_finite() && view.world_from_view.is_finite(), "a view is not finite");
        for name in ["still", "sway", "cut"] {
            let path = scene.path(name, &view).expect("every scene has this path");
            assert!(path.view(&view, path.frames() - 1).position.is_finite());
        }
    }
    for path in &scene.paths {
        let (first, last) = (path.view(&scene.views[0], 0), path.view(&scene.views[0], path.frames() - 1));
        assert!(first.position.is_finite() && last.position.is_finite(), "a path is not finite");
    }
    let report = survey::survey(&scene);
    serde_json::to_string(&report).expect("a survey is plain data");
    scene.set_time(1.25, 1.0 / 90.0);
    assert!(Path::new(&scene.content_sha256).components().count() == 1, "the scene's address is not a single name");
}
