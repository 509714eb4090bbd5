//! Cases of damaged meshes in files. The loader must mend them or refuse them, and must name the mesh.

use std::sync::Arc;

use glam::{DVec3, Vec3, Vec4};

use crate::render::{RenderError, Settings};
use crate::scene::{Fallback, Scene, View};

use super::bench::Bench;
use super::case::{Bound, Case, Worst};
use super::gltf::{MESH, Square};
use super::measure::{METHODS, farthest_from, most, unequal};
use super::shapes::{look, settings};

pub const CASES: &[Case] = &[
    Case {
        name: "zero-normals",
        hazard: "a normal of length 0 has no direction",
        checks: "pixels that differ from those of an undamaged mesh; it fails if the loader does not name the mesh",
        unit: "pixels",
        bound: Bound::AtMost(0.0),
        run: |bench| mended(bench, |mesh| mesh.normals.fill(Vec3::ZERO)),
    },
    Case {
        name: "nan-normals",
        hazard: "a normal is NaN or infinite",
        checks: "the same as zero-normals",
        unit: "pixels",
        bound: Bound::AtMost(0.0),
        run: |bench| {
            mended(bench, |mesh| {
                for (i, n) in mesh.normals.iter_mut().enumerate() {
                    *n = if i % 2 == 0 { Vec3::NAN } else { Vec3::new(f32::INFINITY, 0.0, 0.0) };
                }
            })
        },
    },
    Case {
        name: "degenerate-triangles",
        hazard: "a triangle without area has no normal",
        checks: "pixels that change when points and lines are added as triangles",
        unit: "pixels",
        bound: Bound::AtMost(0.0),
        run: |bench| mended(bench, |mesh| mesh.indices.extend([0, 0, 0, 3, 3, 4, 0, 1, 2, 7, 6, 7])),
    },
    Case {
        name: "zero-tangents",
        hazard: "a surface with a normal map has tangents of length 0",
        checks: "a mirror with a flat normal map in a white world: distance from white",
        unit: "radiance, where 1 is white",
        bound: Bound::AtMost(2e-3),
        run: zero_tangents,
    },
    Case {
        name: "turned-normal-map",
        hazard: "a normal map turns the normal away from the viewer",
        checks: "the most that a white metal with such a map reflects of a white world",
        unit: "radiance, where 1 is white",
        bound: Bound::AtMost(1.02),
        run: turned_normal_map,
    },
    Case {
        name: "bad-positions",
        hazard: "a position is not finite, or an index is beyond the last vertex",
        checks: "files that are accepted, or refused without the mesh's name",
        unit: "files",
        bound: Bound::AtMost(0.0),
        run: bad_positions,
    },
];

fn view() -> View {
    look(DVec3::new(0.1, 0.5, 0.9), DVec3::ZERO)
}

/// Compares a square that `harm` has damaged with an undamaged one. With roughness 0.3 the noise of every pixel depends
/// on its surface, so equal pixels mean equal surfaces.
fn mended(bench: &mut Bench, harm: impl Fn(&mut Square)) -> Result<Worst, RenderError> {
    let mut harmed = Square::new(0.3);
    harm(&mut harmed);
    let mut worst = Worst::largest();
    let (whole, mended) = match (Square::new(0.3).load(view()), harmed.load(view())) {
        (Ok(whole), Ok(mended)) => (whole, mended),
        (Err(error), _) | (_, Err(error)) => {
            worst.include(f64::INFINITY, format!("refused: {error}"));
            return Ok(worst);
        }
    };
    if !mended.repairs.iter().any(|r| r.contains(MESH)) {
        worst.include(f64::INFINITY, format!("the loader does not name the mesh: {:?}", mended.repairs));
    }
    let (whole, mended) = (Arc::new(whole), Arc::new(mended));
    for method in METHODS {
        let a = bench.render("whole", &whole, method, &settings(33, 17))?;
        let b = bench.render("mended", &mended, method, &settings(33, 17))?;
        for eye in 0..2 {
            worst.include(unequal(&a.linear.eyes[eye], &b.linear.eyes[eye]), method);
        }
    }
    Ok(worst)
}

fn zero_tangents(bench: &mut Bench) -> Result<Worst, RenderError> {
    let tangents = vec![Vec4::ZERO; Square::new(0.0).positions.len()];
    let square = Square { tangents, normal_map: [128, 128, 255, 255].repeat(4), ..Square::new(0.0) };
    let mut worst = Worst::largest();
    match square.load(view()) {
        Err(error) => worst.include(f64::INFINITY, error.to_string()),
        Ok(scene) => {
            if !scene.repairs.iter().any(|r| r.contains(MESH) && r.contains("tangents")) {
                worst.include(f64::INFINITY, format!("the loader does not name the mesh: {:?}", scene.repairs));
            }
            each_method(bench, scene, &mut worst, |rendered| farthest_from(&rendered.linear, 1.0))?;
        }
    }
    Ok(worst)
}

fn turned_normal_map(bench: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    // The normals are backwards, sideways in both directions, and nearly without length. A byte of 127.5 would be 0.
    let maps: [[u8; 4]; 4] = [[128, 128, 0, 255], [255, 128, 128, 255], [0, 128, 127, 255], [127, 128, 127, 255]];
    for roughness in [0.0, 0.1, 0.6] {
        let square = Square { normal_map: maps.concat(), ..Square::new(roughness) };
        match square.load(look(DVec3::new(0.1, 0.02, 0.9), DVec3::ZERO)) {
            Err(error) => worst.include(f64::INFINITY, error.to_string()),
            Ok(scene) => each_method(bench, scene, &mut worst, |rendered| most(&rendered.linear))?,
        }
    }
    Ok(worst)
}

fn each_method(
    bench: &mut Bench,
    scene: Scene,
    worst: &mut Worst,
    measure: impl Fn(&super::CasePicture) -> f64,
) -> Result<(), RenderError> {
    let scene = Arc::new(scene);
    for method in ["sssr", "stereo", "path-traced@64"] {
        let settings = Settings { fallback: Some(Fallback::Environment), ..settings(33, 17) };
        let rendered = bench.render("square", &scene, method, &settings)?;
        worst.include(measure(&rendered), method);
    }
    Ok(())
}

fn bad_positions(_: &mut Bench) -> Result<Worst, RenderError> {
    let mut worst = Worst::largest();
    worst.include(0.0, "all were refused");
    let mut bad = 0.0;
    for (what, harm) in [
        ("NaN", (|s: &mut Square| s.positions[3] = Vec3::NAN) as fn(&mut Square)),
        ("infinity", |s| s.positions[0].y = f32::NEG_INFINITY),
        ("index", |s| s.indices[4] = 4_000_000_000),
    ] {
        let mut square = Square::new(0.3);
        harm(&mut square);
        let refused = square.load(view()).err().is_some_and(|error| error.to_string().contains(MESH));
        if !refused {
            bad += 1.0;
            worst.include(bad, what);
        }
    }
    Ok(worst)
}
