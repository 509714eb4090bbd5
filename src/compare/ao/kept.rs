//! What was measured of ambient occlusion in a scene, on disk: `KEY.json`, found again by the hash of everything that its
//! numbers follow from, as `compare::kept` does for reflections.

use std::path::{Path, PathBuf};

use chrono::{DateTime, SecondsFormat, Utc};
use cyclopean_analysis::files;
use serde::{Deserialize, Serialize};

use super::AoOptions;
use super::report::AoScene;
use super::run::{ORACLE_SEED, configurations, method};
use crate::compare::CompareError;
use crate::compare::kept::{MOST_KEPT, PROGRAM, decode, encode};
use crate::compare::sha256;
use crate::console::Console;
use crate::gpu::Gpu;
use crate::render::{Ao, AoSettings, Settings, fast_ray_queries, identity};
use crate::scene::{Scene, View};

/// Of the files' layout, and of what the numbers in them mean: another one is measured again.
const VERSION: u32 = 1;

/// Where the results of one scene with these options are kept, whether they are there or not.
pub struct Kept {
    path: PathBuf,
}

/// What is kept of a scene.
#[derive(Serialize, Deserialize)]
struct Content {
    /// When the measurement ended.
    measured: DateTime<Utc>,
    scene: AoScene,
}

impl Kept {
    /// # Errors
    /// A folder that cannot be made.
    pub fn new(
        folder: &Path,
        gpu: &Gpu,
        (scene, view): (&Scene, &View),
        options: &AoOptions,
    ) -> Result<Kept, CompareError> {
        crate::compare::make_folder(folder)?;
        Ok(Kept { path: folder.join(format!("{}.json", key(gpu, (scene, view), options)?)) })
    }

    /// The scene's results, if they are there and whole. Where they come from is said.
    pub fn find(&self, console: &Console) -> Option<AoScene> {
        if !self.path.exists() {
            return None;
        }
        let found = files::read(&self.path, MOST_KEPT).map_err(|e| format!("it cannot be read ({e})"));
        match found.and_then(|bytes| decode::<Content>(&bytes)) {
            Ok(Content { measured, scene }) => {
                let when = measured.to_rfc3339_opts(SecondsFormat::Secs, true);
                console.note(format!("{}: kept from {}, measured {when}", scene.scene, self.path.display()));
                Some(scene)
            }
            Err(reason) => {
                console.note(format!("{}: {reason}; the scene is measured again", self.path.display()));
                None
            }
        }
    }

    /// Keeps a scene's results, in the place of what was there.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep(&self, scene: &AoScene, console: &Console) -> Result<(), CompareError> {
        let bytes = encode(&Content { measured: Utc::now(), scene: scene.clone() })?;
        // JSON knows no infinity: such a number would come back as another one, or not at all.
        if let Err(reason) = decode::<Content>(&bytes) {
            console.note(format!("{}: its results cannot be kept: {reason}", scene.scene));
            return Ok(());
        }
        Ok(files::write_bytes(&self.path, &bytes)?)
    }
}

/// SHA-256 (hex) of everything that a scene's numbers follow from.
fn key(gpu: &Gpu, (scene, view): (&Scene, &View), options: &AoOptions) -> Result<String, CompareError> {
    let camera = view.stereo_camera(options.settings.aspect());
    let method = method().on(fast_ray_queries(gpu, options.settings.trace));
    let rays = AoSettings { method: Ao::RayTraced, ..options.settings.ao };
    let pictures = configurations(options.settings.ao).into_iter().chain([rays]).map(|ao| {
        let settings = Settings { ao, ..options.settings.clone() };
        identity(scene, &camera, &method, &settings, gpu.info().kind)
    });
    let all = serde_json::json!({
        "version": VERSION,
        "effect": "ao",
        "program": PROGRAM,
        "device": gpu.info(),
        "ray_queries": gpu.has_ray_query(),
        "validation": gpu.has_validation(),
        "scene": scene.name,
        "scene_sha256": scene.content_sha256,
        "view": view.name,
        "pictures": pictures.collect::<Result<Vec<_>, _>>()?,
        "seeds": options.seeds,
        "oracle_seed": ORACLE_SEED,
        "poses": options.poses,
    });
    Ok(sha256(&serde_json::to_vec(&all)?))
}
