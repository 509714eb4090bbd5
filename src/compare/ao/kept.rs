//! Keeps what was measured of ambient occlusion in a scene in a file `KEY.json`, and finds it again. KEY is a hash of
//! everything that the numbers follow from. `compare::kept` does the same for reflections. `run` calls it.

use std::path::{Path, PathBuf};

use chrono::{DateTime, Utc};
use serde::{Deserialize, Serialize};

use super::AoOptions;
use super::configuration::{ORACLE_SEED, configurations, method};
use super::report::AoScene;
use crate::compare::CompareError;
use crate::compare::kept::{SceneResults, circumstances, find_at, keep_at};
use crate::compare::sha256;
use crate::console::Console;
use crate::gpu::Gpu;
use crate::render::{Ao, AoSettings, Settings, fast_ray_queries, identity};
use crate::scene::{Scene, View};

/// The version of the layout of the files and of the meaning of their numbers. It is part of the key, so results of
/// another version are measured again.
const VERSION: u32 = 1;

/// The place where the results of one scene with these options are kept. They may not be there yet.
pub struct KeptAoScene {
    path: PathBuf,
}

/// What is kept of a scene.
#[derive(Serialize, Deserialize)]
struct KeptContent {
    /// When the measurement ended.
    measured: DateTime<Utc>,
    scene: AoScene,
}

impl SceneResults for KeptContent {
    fn scene(&self) -> &str {
        &self.scene.scene
    }

    fn measured(&self) -> DateTime<Utc> {
        self.measured
    }
}

impl KeptAoScene {
    /// Finds the place, and makes the folder if it is missing.
    ///
    /// # Errors
    /// A folder that cannot be made, or a number that JSON cannot hold.
    pub fn new(
        folder: &Path,
        gpu: &Gpu,
        (scene, view): (&Scene, &View),
        options: &AoOptions,
    ) -> Result<KeptAoScene, CompareError> {
        crate::compare::make_folder(folder)?;
        Ok(KeptAoScene { path: folder.join(format!("{}.json", key(gpu, (scene, view), options)?)) })
    }

    /// The scene's results, if they are there and undamaged. A note says where they come from.
    pub fn find(&self, console: &Console) -> Option<AoScene> {
        find_at::<KeptContent>(&self.path, console).map(|content| content.scene)
    }

    /// Keeps a scene's results and replaces what was there.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep(&self, scene: &AoScene, console: &Console) -> Result<(), CompareError> {
        keep_at(&self.path, &KeptContent { measured: Utc::now(), scene: scene.clone() }, console)
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
