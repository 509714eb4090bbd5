//! Makes a [`Scene`] from a document and its manifest: resolves and checks views, lights, environment and motion.
//! Called last by the loader.

use std::sync::LazyLock;

use glam::{DMat3, DQuat, DVec3, Vec3};

use super::document::Document;
use super::files::Reader;
use super::framing;
use super::material;
use crate::scene::environment::sky;
use crate::scene::error::{Reason, SceneError};
use crate::scene::manifest::{
    EnvironmentSpec, HeadKeySpec, HeadPathSpec, Manifest, MapSpec, MotionSpec, PathSpec, SkySpec, ViewSpec,
};
use crate::scene::motion::{FRAME_S, Motion, Path};
use crate::scene::{Environment, Equirect, Fallback, HeadKey, HeadPath, Light, Scene, View};

/// Default thickness of open meshes over the distance of the nearest content. It corresponds to two pixels of an image
/// with 1080 lines.
const THICKNESS_OVER_NEAREST: f64 = 1.0 / 200.0;

/// A glTF without a manifest. It gets the default sky, whose sun is added only where the file has no light, and a
/// default view where it has no camera.
pub fn bare(name: String, document: Document, reader: Reader) -> Result<Scene, SceneError> {
    let sky_spec = SkySpec::default();
    let lit = !document.lights.is_empty() || document.materials.iter().any(|m| m.emissive != Vec3::ZERO);
    let mut scene = scene(name, document, default_sky(), reader);
    if !lit {
        scene.lights.extend(sky::sun(&sky_spec));
    }
    Ok(scene)
}

/// The default sky's environment. It is prefiltered once per process, because most scenes without lights of their own
/// share it.
fn default_sky() -> Environment {
    static SKY: LazyLock<Environment> =
        LazyLock::new(|| Environment::from_radiance(sky::radiance(&SkySpec::default())));
    SKY.clone()
}

/// A glTF with its manifest, and with the lights of [`super::lights::of_manifest`]. `map` is the decoded environment
/// file.
pub fn with_manifest(
    manifest: &Manifest,
    (mut document, mut placed): (Document, Vec<Light>),
    map: Option<Equirect>,
    reader: Reader,
) -> Result<Scene, Reason> {
    let exposure = manifest.exposure;
    if !(exposure.is_finite() && exposure > 0.0) {
        return Err(format!("exposure is {exposure}; it must be a number above 0"));
    }
    material::shape_those_of_file(&mut document.materials, &manifest.materials)?;
    let environment = match &manifest.environment {
        Some(EnvironmentSpec::Constant(radiance)) => {
            check_color("environment.constant", *radiance)?;
            Environment::constant(*radiance)
        }
        Some(EnvironmentSpec::Map(spec)) => Environment::from_radiance(placed_map(spec, map)?),
        Some(EnvironmentSpec::Sky(spec)) => {
            placed.extend(sky::sun(spec));
            Environment::from_radiance(sky::radiance(spec))
        }
        None => default_sky(),
    };
    let mut views = Vec::new();
    for spec in &manifest.views {
        if views.iter().any(|v: &View| v.name == spec.name) {
            return Err(format!("view `{}` is there twice", spec.name));
        }
        views.push(view(spec).map_err(|reason| format!("view `{}`: {reason}", spec.name))?);
    }
    let (nodes, node_of) = (std::mem::take(&mut document.nodes), std::mem::take(&mut document.node_of));
    let mut scene = scene(manifest.name.clone(), document, environment, reader);
    scene.lights.extend(placed);
    if !views.is_empty() {
        let own = std::mem::take(&mut scene.views);
        let fresh = own.into_iter().filter(|v| v.name != "default" && views.iter().all(|w| w.name != v.name));
        let fresh: Vec<View> = fresh.collect();
        scene.views = views;
        scene.views.extend(fresh);
    }
    for spec in &manifest.paths {
        if scene.paths.iter().any(|p| p.name == spec.name) {
            return Err(format!("path `{}` is there twice", spec.name));
        }
        scene.paths.push(head_path(spec).map_err(|reason| format!("path `{}`: {reason}", spec.name))?);
    }
    scene.fallback = manifest.fallback;
    scene.exposure = exposure;
    if let Some(thickness) = manifest.open_mesh_thickness_m {
        if !(thickness.is_finite() && thickness >= 0.0) {
            return Err(format!("open_mesh_thickness_m is {thickness}; it must be 0 or more"));
        }
        scene.open_mesh_thickness_m = thickness;
    }
    for spec in &manifest.motion {
        let motion = motion(spec, &scene, (&nodes, &node_of))
            .map_err(|reason| format!("motion of `{}`: {reason}", spec.node))?;
        scene.motions.push(motion);
    }
    scene.set_time(0.0, FRAME_S);
    Ok(scene)
}

/// Hashes what the manifest says, independent of its layout. Where the geometry came from is left out, because the
/// geometry's bytes are hashed themselves: a built-in scene and its export are the same scene.
pub fn hash_manifest(reader: &mut Reader, manifest: &Manifest) {
    let manifest = Manifest { geometry: None, ..manifest.clone() };
    // Serialising plain data into memory cannot fail.
    reader.hash(&serde_json::to_vec(&manifest).unwrap_or_default());
}

fn scene(name: String, document: Document, environment: Environment, reader: Reader) -> Scene {
    let mut views = document.views;
    if views.is_empty() {
        views.push(framing::default_view(&document.primitives, &document.instances));
    }
    let nearest = framing::nearest(&views[0], &document.primitives, &document.instances);
    Scene {
        name,
        primitives: document.primitives,
        instances: document.instances,
        materials: document.materials,
        textures: document.textures,
        lights: document.lights,
        environment,
        views,
        paths: Vec::new(),
        fallback: Fallback::default(),
        exposure: 1.0,
        open_mesh_thickness_m: (nearest * THICKNESS_OVER_NEAREST) as f32,
        motions: Vec::new(),
        content_sha256: reader.finish(),
        extensions: document.extensions,
        repairs: document.repairs,
    }
}

fn view(spec: &ViewSpec) -> Result<View, Reason> {
    let position = DVec3::from_array(spec.position);
    let numbers = [spec.vertical_fov_deg, spec.ipd_m, spec.cant_deg, spec.near_m];
    if !position.is_finite() || numbers.iter().any(|x| !x.is_finite()) {
        return Err("a number is not finite".to_owned());
    }
    if !(1.0..=170.0).contains(&spec.vertical_fov_deg) {
        return Err(format!("vertical_fov_deg is {}; it must be 1 to 170", spec.vertical_fov_deg));
    }
    if spec.near_m <= 0.0 {
        return Err(format!("near_m is {}; it must be above 0", spec.near_m));
    }
    let world_from_view = direction(position, spec.target, spec.orientation)?;
    Ok(View {
        name: spec.name.clone(),
        position,
        world_from_view,
        vertical_fov_rad: spec.vertical_fov_deg.to_radians(),
        ipd_m: spec.ipd_m,
        cant_rad: spec.cant_deg.to_radians(),
        near_m: spec.near_m,
    })
}

/// The rotation from view to world, from `target` or `orientation`, of which exactly one must be given.
fn direction(position: DVec3, target: Option<[f64; 3]>, orientation: Option<[f64; 4]>) -> Result<DQuat, Reason> {
    match (target, orientation) {
        (Some(target), None) => look_at(position, DVec3::from_array(target)),
        (None, Some(q)) => {
            let q = DQuat::from_array(q);
            if !(q.is_finite() && q.length_squared() > 1e-12) {
                return Err("orientation is not a quaternion".to_owned());
            }
            Ok(q.normalize())
        }
        _ => Err("give `target` or `orientation`, one of the two".to_owned()),
    }
}

fn head_path(spec: &HeadPathSpec) -> Result<HeadPath, Reason> {
    let key = |(i, key): (usize, &HeadKeySpec)| {
        let position = DVec3::from_array(key.position);
        let direction = direction(position, key.target, key.orientation);
        let world_from_view = direction.map_err(|reason| format!("key {}: {reason}", i + 1))?;
        Ok(HeadKey { time_s: key.time_s, position, world_from_view, cut: key.cut })
    };
    let keys = spec.keys.iter().enumerate().map(key).collect::<Result<Vec<_>, Reason>>()?;
    HeadPath::new(&spec.name, spec.rate_hz, keys).map_err(|e| e.to_string())
}

/// The rotation from view to world of a head at `from` that is upright and looks at `to`.
fn look_at(from: DVec3, to: DVec3) -> Result<DQuat, Reason> {
    let back = (from - to).try_normalize().filter(|b| b.is_finite()).ok_or("target and position are the same point")?;
    let right = DVec3::Y.cross(back).try_normalize().unwrap_or(DVec3::X);
    Ok(DQuat::from_mat3(&DMat3::from_cols(right, back.cross(right), back)).normalize())
}

fn placed_map(spec: &MapSpec, map: Option<Equirect>) -> Result<Equirect, Reason> {
    if !(spec.intensity.is_finite() && spec.intensity >= 0.0 && spec.rotation_deg.is_finite()) {
        return Err(format!("environment: intensity {} or rotation {} is no use", spec.intensity, spec.rotation_deg));
    }
    let mut map = map.ok_or("environment: the map was not read")?;
    if spec.rotation_deg != 0.0 {
        map = map.rotated(spec.rotation_deg.to_radians());
    }
    let most = spec.clamp.unwrap_or(f32::INFINITY);
    map.texels.iter_mut().flatten().for_each(|c| *c = (*c * spec.intensity).min(most));
    Ok(map)
}

/// The motion of a manifest's entry: it moves the instances of all nodes of that name and of all nodes below them.
fn motion(
    spec: &MotionSpec,
    scene: &Scene,
    (nodes, node_of): (&[(String, Option<usize>)], &[usize]),
) -> Result<Motion, Reason> {
    let mut moves = vec![false; nodes.len()];
    for (place, (name, parent)) in nodes.iter().enumerate() {
        moves[place] = *name == spec.node || parent.is_some_and(|parent| moves[parent]);
    }
    let instances: Vec<usize> = (0..node_of.len()).filter(|i| moves[node_of[*i]]).collect();
    if instances.is_empty() {
        return Err("no node of that name carries a mesh".to_owned());
    }
    let turning = |axis: [f64; 3], period_s: f64| -> Result<DVec3, Reason> {
        period(period_s)?;
        finite(axis)?.try_normalize().ok_or_else(|| "axis has no length".to_owned())
    };
    let path = match spec.path {
        PathSpec::Orbit { center, axis, period_s } => {
            Path::Orbit { center: finite(center)?, axis: turning(axis, period_s)?, period_s }
        }
        PathSpec::Spin { axis, period_s } => {
            let (low, high) = framing::bounds(&scene.primitives, instances.iter().map(|i| &scene.instances[*i]));
            Path::Orbit { center: (low + high) / 2.0, axis: turning(axis, period_s)?, period_s }
        }
        PathSpec::Translate { offset_m, period_s } => {
            period(period_s)?;
            Path::Sway { offset_m: finite(offset_m)?, period_s }
        }
    };
    let rest = instances.iter().map(|i| scene.instances[*i].world_from_object).collect();
    Ok(Motion { instances, rest, path })
}

fn period(period_s: f64) -> Result<(), Reason> {
    if period_s.is_finite() && period_s != 0.0 { Ok(()) } else { Err(format!("period_s is {period_s}")) }
}

pub(super) fn finite(p: [f64; 3]) -> Result<DVec3, Reason> {
    let p = DVec3::from_array(p);
    if p.is_finite() { Ok(p) } else { Err("a coordinate is not finite".to_owned()) }
}

pub(super) fn check_color(what: &str, c: [f32; 3]) -> Result<(), Reason> {
    if c.iter().all(|x| x.is_finite() && *x >= 0.0) {
        Ok(())
    } else {
        Err(format!("{what} is {c:?}; each must be ≥ 0"))
    }
}
