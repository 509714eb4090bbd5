//! A hash of everything that determines a picture. On one driver, equal hashes mean equal pictures. Stimuli (as their addresses)
//! and kept references use it.

use sha2::{Digest, Sha256};

use crate::scene::{Eye, Scene, StereoCamera};

use super::method::HitSource;
use super::needs::FrameNeeds;
use super::{Method, Settings, cpu, shaders};

/// SHA-256 (hex) over scene bytes, shaders, method and samples, both eyes' cameras, settings, renderer version and kind
/// of device.
///
/// # Errors
/// A number that JSON does not know.
pub fn identity(
    scene: &Scene,
    camera: &StereoCamera,
    method: &Method,
    settings: &Settings,
    device_kind: &str,
) -> Result<String, serde_json::Error> {
    let eyes = Eye::BOTH.map(|eye| {
        let e = camera.eye(eye);
        let fov = [e.fov.left_rad, e.fov.right_rad, e.fov.up_rad, e.fov.down_rad];
        serde_json::json!({ "position": e.position.to_array(), "rotation": e.world_from_view.to_array(), "fov": fov,
                            "near_m": e.near_m })
    });
    let technique = method.technique();
    // Not with ambient occlusion, which may run shaders of the views.
    let reference = technique.hit_source == HitSource::PathTraced && !technique.resolved && settings.ao.is_off();
    let mut identity = serde_json::json!({
        "scene": scene.content_sha256,
        "shaders": if reference { shaders::digest_of_reference() } else { shaders::digest() },
        "method": method.to_string(),
        // What the method's name means in this build. Its description is left out.
        "technique": method.technique(),
        "samples": method.samples(),
        "eyes": eyes,
        "settings": settings,
        "renderer": env!("CARGO_PKG_VERSION"),
        "device_kind": device_kind,
    });
    // The processor rounds differently from the device, and the digest of the shaders does not cover its code.
    if cpu::traces(method, settings.trace, device_kind) {
        identity["paths_by"] = format!("cpu {}", cpu::VERSION).into();
    }
    let needs = || FrameNeeds::of(scene, method, settings);
    if cpu::is_chosen(settings.trace, device_kind)
        && needs().with_shadows_on_the_cpu(settings.shading_reuse).cpu_shadows
    {
        identity["shadows_by"] = format!("cpu {}", cpu::VERSION).into();
    }
    let digest = Sha256::digest(serde_json::to_vec(&identity)?);
    Ok(digest.iter().map(|b| format!("{b:02x}")).collect())
}
