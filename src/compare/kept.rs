//! Keeps what was measured of a scene in files, and finds it again. KEY is a hash of everything that the numbers follow
//! from. [`super::scene`] calls it.
//!
//! ```text
//! KEY.json            the digest of the scene's part of a report, and that part
//! KEY_FALLBACK.png    a sheet, where sheets were asked for; its digest is in KEY.json
//! ```
//! A damaged file counts as missing, and a note says so.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use chrono::{DateTime, SecondsFormat, Utc};
use cyclopean_analysis::files;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::plan::{Options, base_name};
use super::reference;
use super::report::SceneReport;
use super::run::fallback_name;
use super::subject::Subject;
use super::{CompareError, Sheet, sha256};
use crate::console::Console;
use crate::gpu::Gpu;
use crate::render::{Settings, fast_ray_queries, identity};
use crate::scene::{Scene, View};

/// The version of the layout of the files and of the meaning of their numbers. It is part of the key, so results of
/// another version are measured again.
const VERSION: u32 = 1;

/// The most bytes of a file that is read. The rounds of a hundred thousand seeds fit into it.
const MOST_KEPT: u64 = 4 << 30;

/// The version and the commit of the program that measures.
pub const PROGRAM: [&str; 2] = [
    env!("CARGO_PKG_VERSION"),
    match option_env!("CYCLOPEAN_COMMIT") {
        Some(commit) => commit,
        None => "unknown",
    },
];

/// The place where the results of one scene with these options are kept. They may not be there yet.
pub struct KeptScene {
    folder: PathBuf,
    key: String,
}

/// The results of one scene that a file holds.
pub(super) trait SceneResults: Serialize + DeserializeOwned {
    /// The scene's name.
    fn scene(&self) -> &str;
    /// When the measurement ended.
    fn measured(&self) -> DateTime<Utc>;
}

/// Reads the results in a file, if it is there and undamaged. A note says where they come from, or why they are not
/// used.
pub(super) fn find_at<C: SceneResults>(path: &Path, console: &Console) -> Option<C> {
    if !path.exists() {
        return None;
    }
    let found = files::read(path, MOST_KEPT).map_err(|e| format!("it cannot be read ({e})"));
    match found.and_then(|bytes| decode::<C>(&bytes)) {
        Ok(content) => {
            let when = content.measured().to_rfc3339_opts(SecondsFormat::Secs, true);
            console.note(format!("{}: kept from {}, measured {when}", content.scene(), path.display()));
            Some(content)
        }
        Err(reason) => {
            console.note(format!("{}: {reason}; the scene is measured again", path.display()));
            None
        }
    }
}

/// Writes results to a file and replaces what was there. Results that could not be read back are not kept, and a note
/// says so.
///
/// # Errors
/// A file that cannot be written.
pub(super) fn keep_at<C: SceneResults>(path: &Path, content: &C, console: &Console) -> Result<(), CompareError> {
    let bytes = encode(content)?;
    // JSON has no infinity. A file with such a number could not be read back, or would hold another number.
    if let Err(reason) = decode::<C>(&bytes) {
        console.note(format!("{}: its results cannot be kept: {reason}", content.scene()));
        return Ok(());
    }
    Ok(files::write_bytes(path, &bytes)?)
}

/// What all numbers of a scene follow from, whatever is compared: the program, the device, the scene and the view.
pub(super) fn circumstances(gpu: &Gpu, scene: &Scene, view: &View) -> serde_json::Value {
    serde_json::json!({
        "program": PROGRAM,
        // Times depend on the device and its driver, and on whether validation runs.
        "device": gpu.info(),
        "ray_queries": gpu.has_ray_query(),
        "validation": gpu.has_validation(),
        "scene": scene.name,
        "scene_sha256": scene.content_sha256,
        "view": view.name,
    })
}

/// A file: the SHA-256 (hex) of its content as compact JSON, and the content.
#[derive(Serialize, Deserialize)]
struct File<C> {
    sha256: String,
    content: C,
}

/// What is kept of a scene.
#[derive(Serialize, Deserialize)]
pub struct KeptContent {
    /// When the measurement ended.
    measured: DateTime<Utc>,
    pub scene: SceneReport,
    /// The SHA-256 (hex) of each sheet, by fallback. It is empty where no sheets were drawn.
    sheets: BTreeMap<String, String>,
}

impl SceneResults for KeptContent {
    fn scene(&self) -> &str {
        &self.scene.scene
    }

    fn measured(&self) -> DateTime<Utc> {
        self.measured
    }
}

impl KeptContent {
    /// The results of a measurement that has just ended, without sheets.
    pub fn new(scene: SceneReport) -> KeptContent {
        KeptContent { measured: Utc::now(), scene, sheets: BTreeMap::new() }
    }
}

impl KeptScene {
    /// The place in this folder, which is made if it is missing.
    ///
    /// # Errors
    /// A folder that cannot be made, or a number that JSON cannot hold.
    pub fn new(folder: &Path, gpu: &Gpu, subject: &Subject, options: &Options) -> Result<KeptScene, CompareError> {
        super::make_folder(folder)?;
        Ok(KeptScene { folder: folder.to_owned(), key: key(gpu, subject, options)? })
    }

    /// The scene's results, if they are there and undamaged. A note says where they come from.
    pub fn find(&self, options: &Options, console: &Console) -> Option<KeptContent> {
        let mut content: KeptContent = find_at(&self.path(), console)?;
        // The cache folder may be another one than when this was written.
        let reference = &mut content.scene.reference;
        reference.files = options.cache.join(&reference.key);
        Some(content)
    }

    /// Keeps a scene's results and replaces what was there.
    ///
    /// # Errors
    /// A file that cannot be written.
    pub fn keep(&self, content: &KeptContent, console: &Console) -> Result<(), CompareError> {
        keep_at(&self.path(), content, console)
    }

    /// The sheets that were kept with the results, if there are any and all are undamaged.
    pub fn find_sheets(&self, content: &KeptContent, console: &Console) -> Option<Vec<Sheet>> {
        let read = |(fallback, digest): (&String, &String)| {
            let path = self.sheet_path(fallback);
            let png = files::read(&path, MOST_KEPT).map_err(|e| format!("it cannot be read ({e})"));
            match png {
                Ok(png) if sha256(&png) == *digest => Ok(Sheet { fallback: fallback.clone(), png }),
                Ok(_) => Err(format!("{}: it does not match its digest", path.display())),
                Err(reason) => Err(format!("{}: {reason}", path.display())),
            }
        };
        let sheets: Result<Vec<Sheet>, String> = content.sheets.iter().map(read).collect();
        sheets
            .map_err(|reason| console.note(format!("{reason}; the sheets are drawn again")))
            .ok()
            .filter(|sheets| !sheets.is_empty())
    }

    /// Keeps sheets beside the results, and their digests in the file of the results.
    ///
    /// # Errors
    /// As [`KeptScene::keep`].
    pub fn keep_sheets(&self, content: KeptContent, sheets: &[Sheet], console: &Console) -> Result<(), CompareError> {
        for sheet in sheets {
            files::write_bytes(&self.sheet_path(&sheet.fallback), &sheet.png)?;
        }
        let sheets = sheets.iter().map(|sheet| (sheet.fallback.clone(), sha256(&sheet.png))).collect();
        self.keep(&KeptContent { sheets, ..content }, console)
    }

    fn path(&self) -> PathBuf {
        self.folder.join(format!("{}.json", self.key))
    }

    fn sheet_path(&self, fallback: &str) -> PathBuf {
        self.folder.join(format!("{}_{fallback}.png", self.key))
    }
}

/// The SHA-256 (hex) of everything that a scene's numbers follow from: the program, the device, the scene and its view,
/// the reference, and every configuration in order.
fn key(gpu: &Gpu, subject: &Subject, options: &Options) -> Result<String, CompareError> {
    let Subject { scene, view, camera } = subject;
    let fast = fast_ray_queries(gpu, options.settings.trace);
    let configurations = options.configurations(scene).into_iter().map(|c| {
        let settings = Settings { fallback: Some(c.fallback), ..options.settings.clone() };
        let picture = identity(scene, camera, &c.method.on(fast), &settings, gpu.info().kind)?;
        Ok(serde_json::json!({ "name": c.name, "method": c.method.to_string(), "spp": c.method.samples(),
                               "fallback": fallback_name(c.fallback), "picture": picture }))
    });
    let mut all = serde_json::json!({
        "version": VERSION,
        "circumstances": circumstances(gpu, scene, view),
        "exposure": scene.exposure,
        "reference": reference::follows_from(scene, camera, options, gpu.info().kind)?,
        "baseline": base_name(&options.methods[0]),
        "configurations": configurations.collect::<Result<Vec<_>, serde_json::Error>>()?,
        "seeds": options.seeds,
        "pixels_per_degree": options.pixels_per_degree,
    });
    // Without networks nothing is added, so that results from before there were networks keep their key.
    for network in options.networks.iter() {
        all[network.measure()] = network.sha256().into();
    }
    Ok(sha256(&serde_json::to_vec(&all)?))
}

/// The bytes of a file with this content.
///
/// # Errors
/// A value that JSON cannot hold.
fn encode<C: Serialize>(content: &C) -> Result<Vec<u8>, serde_json::Error> {
    let sha256 = sha256(&serde_json::to_vec(content)?);
    serde_json::to_vec_pretty(&File { sha256, content })
}

/// The content of a file that [`encode`] made.
///
/// # Errors
/// Why the bytes are not such a file, as a clause for a message.
fn decode<C: Serialize + DeserializeOwned>(bytes: &[u8]) -> Result<C, String> {
    let file: File<C> = serde_json::from_slice(bytes).map_err(|e| format!("it is not JSON of this program ({e})"))?;
    // The digest is of the compact form, whatever the layout of the file is.
    let written = serde_json::to_vec(&file.content).map_err(|e| e.to_string())?;
    if sha256(&written) != file.sha256 {
        return Err("it does not match its digest".to_owned());
    }
    Ok(file.content)
}

#[cfg(test)]
mod tests {
    use super::super::report::EqualTime;
    use super::super::sample::{ratio, row, scene};
    use super::*;

    fn content() -> KeptContent {
        let stereo = row("stereo", 1, 0.1 + 0.2, &[("mse", 1.0 / 3.0), ("ssim", 1e-300)]);
        let mut scene = scene("room", vec![row("sssr", 1, 1.0, &[("mse", 5e-324)]), stereo.clone()]);
        scene.exposure = 0.1;
        scene.results[1].systematic_over = Some(BTreeMap::from([(2, 0.5), (20, 0.25)]));
        scene.equal_sample.push(ratio(&stereo, "mse", 0.7));
        KeptContent::new(scene)
    }

    fn equal_time(ratio: f64) -> EqualTime {
        EqualTime {
            method: "stereo".to_owned(),
            spp: 1,
            fallback: "black".to_owned(),
            ms: 1.0,
            mse: 1.0,
            baseline_mse: 1.0,
            ratio,
            relmse: None,
            baseline_relmse: None,
            relmse_ratio: None,
            tonemapped_mse: None,
            baseline_tonemapped_mse: None,
            tonemapped_mse_ratio: None,
            extrapolated: false,
        }
    }

    fn json(content: &KeptContent) -> Vec<u8> {
        serde_json::to_vec(content).expect("JSON")
    }

    #[test]
    fn what_is_written_is_read_and_nothing_else() {
        let content = content();
        let bytes = encode(&content).expect("JSON");
        let read = decode::<KeptContent>(&bytes).expect("read back");
        assert_eq!(json(&read), json(&content));
        // A digit that was changed is noticed, wherever it is.
        let digits = (0..bytes.len()).filter(|i| bytes[*i].is_ascii_digit());
        for at in digits {
            let mut wrong = bytes.clone();
            wrong[at] = if wrong[at] == b'7' { b'3' } else { b'7' };
            let taken = decode::<KeptContent>(&wrong).is_ok_and(|read| json(&read) != json(&content));
            assert!(!taken, "byte {at} of {}", String::from_utf8_lossy(&bytes));
        }
        for end in [0, 1, bytes.len() / 2, bytes.len() - 1] {
            assert!(decode::<KeptContent>(&bytes[..end]).is_err(), "{end} bytes");
        }
    }

    #[test]
    fn a_number_that_json_does_not_know_is_not_kept() {
        let mut content = content();
        content.scene.equal_time.push(equal_time(0.5));
        assert!(decode::<KeptContent>(&encode(&content).expect("JSON")).is_ok());
        content.scene.equal_time.push(equal_time(f64::INFINITY));
        assert!(decode::<KeptContent>(&encode(&content).expect("JSON")).is_err());
    }
}
