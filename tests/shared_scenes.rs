//! Loads real scenes and environments, which lie in `shared/scenes` beside the repository, and checks what the renderer
//! needs of every scene. The tests are skipped, with a message, where that folder is absent. Needs no GPU.

use std::path::{Path, PathBuf};

use cyclopean::scene::{self, Scene};

fn shared() -> Option<PathBuf> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/scenes");
    if !folder.is_dir() {
        println!("skipped: {} is absent", folder.display());
        return None;
    }
    Some(folder)
}

/// Checks what the renderer needs of every loaded scene.
fn check(scene: &Scene) {
    assert!(!scene.views.is_empty() && !scene.instances.is_empty());
    for p in &scene.primitives {
        let n = p.positions.len();
        assert!([p.normals.len(), p.tangents.len(), p.uv0.len(), p.uv1.len(), p.colors.len()].iter().all(|m| *m == n));
        assert!(p.indices.len() % 3 == 0 && p.indices.iter().all(|i| (*i as usize) < n));
        assert!(p.material < scene.materials.len());
        assert!(p.normals.iter().all(|v| (v.length() - 1.0).abs() < 1e-4), "{}", p.name);
        assert!(
            p.tangents.iter().all(|t| (t.truncate().length() - 1.0).abs() < 1e-4 && t.w.abs() == 1.0),
            "{}",
            p.name
        );
    }
    for i in &scene.instances {
        assert!(i.primitive < scene.primitives.len() && i.world_from_object.matrix3.determinant() >= 0.0);
    }
    let finite = |m: &scene::Equirect| m.texels.iter().flatten().all(|c| c.is_finite() && *c >= 0.0);
    assert!(finite(&scene.environment.radiance) && finite(&scene.environment.irradiance));
    assert!(scene.environment.specular.len() == 8 && scene.environment.specular.iter().all(finite));
}

#[test]
fn every_shared_scene_loads() {
    let Some(folder) = shared() else { return };
    for (file, triangles) in [
        ("pica-mini-diorama/scene.gltf", 70_000),
        ("mitsuba-living-room/scene.gltf", 140_000),
        ("mitsuba-living-room-2/scene.gltf", 400_000),
        ("mitsuba-staircase/scene.gltf", 260_000),
        ("chess-board/chess-board.glb", 1_000),
        ("roughness-scale/scene.gltf", 100),
    ] {
        let path = folder.join(file);
        let started = std::time::Instant::now();
        let scene = scene::load(&path.to_string_lossy()).unwrap_or_else(|error| panic!("{error}"));
        println!(
            "{file}: {} triangles, {} instances, {} materials, {} textures, {:?}, {} repairs, {:?}",
            scene.triangle_count(),
            scene.instances.len(),
            scene.materials.len(),
            scene.textures.len(),
            started.elapsed(),
            scene.repairs.len(),
            scene.views[0],
        );
        check(&scene);
        assert!(scene.triangle_count() >= triangles, "{file}: {}", scene.triangle_count());
    }
}

#[test]
fn environment_files_light_a_scene() {
    let Some(folder) = shared() else { return };
    let work = tempfile::tempdir().expect("a folder");
    for (file, rotation) in
        [("hdri/spree_bank_1k.hdr", 90.0), ("hdri/pmndrs_night.hdr", 0.0), ("mitsuba-living-room/env_sky19.hdr", 0.0)]
    {
        let map = folder.join(file).canonicalize().expect("a path");
        let manifest = serde_json::json!({
            "name": "lit", "geometry": { "builtin": { "name": "pica", "detail": 0.01 } },
            "environment": { "map": { "file": map, "rotation_deg": rotation, "clamp": 50.0 } },
        });
        let path = work.path().join("lit.json");
        std::fs::write(&path, manifest.to_string()).expect("written");
        let started = std::time::Instant::now();
        let scene = scene::load(&path.to_string_lossy()).unwrap_or_else(|error| panic!("{error}"));
        println!("{file}: {:?}, {} wide", started.elapsed(), scene.environment.radiance.width);
        check(&scene);
        let texels = &scene.environment.radiance.texels;
        assert!(scene.environment.radiance.width <= 2048 && texels.iter().flatten().all(|c| *c <= 50.0));
        assert!(texels.iter().flatten().any(|c| *c > 0.1), "{file} is dark");
    }
}
