//! What was measured of ambient occlusion in a scene, on disk: `KEY.json`, found again by the hash of everything that its
//! numbers follow from, as `compare::kept` does for reflections.

use std::path::{Path, PathBuf};

use chrono::{DateTime, Utc};
use serde::{Deserialize, Serialize};

use super::AoOptions;
use super::configuration::{ORACLE_SEED, configurations, method};
use super::report::AoScene;
use crate::compare::CompareError;
use crate::compare::kept::{Results, circumstances, find_at, keep_at};
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

impl Results for Content {
    fn scene(&self) -> &str {
        &self.scene.scene
    }

    fn measured(&self) -> DateTime<Utc> {
        self.measured
    }
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
        find_at::<Content>(&self.path, console).map(|content| content.scene)
    }

    /// Keeps a scene's results, in the place of what was there.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep(&self, scene: &AoScene, console: &Console) -> Result<(), CompareError> {
        keep_at(&self.path, &Content { measured: Utc::now(), scene: scene.clone() }, console)
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
        "circumstances": circumstances(gpu, scene, view),
        "pictures": pictures.collect::<Result<Vec<_>, _>>()?,
        "seeds": options.seeds,
        "oracle_seed": ORACLE_SEED,
        "poses": options.poses,
    });
    Ok(sha256(&serde_json::to_vec(&all)?))
}
