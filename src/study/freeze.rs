//! The pre-registration: writes one folder that fixes a study, and checks a session against it. `study freeze` and `run
//! --frozen` call it.

use std::collections::BTreeMap;
use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use cyclopean_analysis::files::{self, MOST_DATA, WriteError};
use serde::{Deserialize, Serialize};

use super::plan::Plan;
use super::power;
use super::schema;
use super::session::program;
use super::store::{Store, StoreError, file_sha256};
use super::validate::Study;

/// A study cannot be frozen, or differs from its frozen form.
#[derive(Debug, thiserror::Error)]
pub enum FreezeError {
    #[error("{} exists; a frozen study is never overwritten, give a new folder", .0.display())]
    Exists(PathBuf),
    #[error(transparent)]
    Store(#[from] StoreError),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("cannot use frozen study at {}: {source}", path.display())]
    Io {
        path: PathBuf,
        #[source]
        source: io::Error,
    },
    #[error("frozen study {}: {what}", folder.display())]
    Differs { folder: PathBuf, what: String },
}

/// Gives a standard error of 0.011 at a power of one half, and a smaller one elsewhere.
const SIMULATED_STUDIES: u32 = 2000;

#[derive(Debug, Serialize, Deserialize)]
struct Manifest {
    format: u32,
    /// File name → SHA-256 (hex).
    files: BTreeMap<String, String>,
}

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct FrozenStimulus {
    request: super::stimulus::StimulusRequest,
    key: String,
    files: BTreeMap<String, String>,
}

/// Writes the folder; returns the SHA-256 of its manifest.
///
/// # Errors
/// The folder exists, a stimulus is missing, or the disk is full; no folder is left then.
pub fn freeze(study: &Study, store: &Store, folder: &Path) -> Result<String, FreezeError> {
    if folder.exists() {
        return Err(FreezeError::Exists(folder.to_owned()));
    }
    let io = |source| FreezeError::Io { path: folder.to_owned(), source };
    let stimuli = stimuli(study, store)?;
    let d = &study.definition;
    let orders: Vec<_> = (0..u64::from(d.participants))
        .map(|row| {
            let plan = Plan::draw(d, row);
            serde_json::json!({"order": plan.order, "presentations": plan.presentations})
        })
        .collect();
    // For a study without simulated observers, the file says so instead.
    let power = match power::estimate(d, SIMULATED_STUDIES) {
        Ok(power) => serde_json::to_value(power).unwrap_or_default(),
        Err(error) => serde_json::json!({"unknown": error.to_string()}),
    };
    let contents: Vec<(&str, Vec<u8>)> = vec![
        ("study.json", study.text.clone().into_bytes()),
        ("schema.json", pretty(&schema::generate())),
        ("stimuli.json", pretty(&stimuli)),
        ("orders.json", pretty(&orders)),
        ("analysis.json", pretty(&d.analysis)),
        ("power.json", pretty(&power)),
        ("program.json", pretty(&frozen_program().map_err(io)?)),
    ];
    let name = folder.file_name().map(|n| n.to_string_lossy().into_owned()).unwrap_or_default();
    let part = folder.with_file_name(format!(".{name}.{}.part", std::process::id()));
    fs::create_dir_all(&part).map_err(io)?;
    let written = (|| {
        let mut sums = BTreeMap::new();
        for (name, bytes) in &contents {
            files::write_bytes(&part.join(name), bytes)?;
            sums.insert((*name).to_owned(), super::sha256_hex(bytes));
        }
        let manifest = pretty(&Manifest { format: 1, files: sums });
        files::write_bytes(&part.join("manifest.json"), &manifest)?;
        fs::rename(&part, folder).map_err(io)?;
        let parent = folder.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
        files::sync_directory(parent).map_err(io)?;
        Ok(super::sha256_hex(&manifest))
    })();
    if written.is_err() {
        let _ = fs::remove_dir_all(&part);
    }
    written
}

/// Refuses when the folder was changed, or when study, stimuli or program differ from the frozen ones; returns the
/// manifest's SHA-256.
///
/// # Errors
/// What differs, and how.
pub fn verify(folder: &Path, study: &Study, store: &Store) -> Result<String, FreezeError> {
    let read = |name: &str| {
        let path = folder.join(name);
        files::read(&path, MOST_DATA).map_err(|source| FreezeError::Io { path, source })
    };
    let differs = |what: String| FreezeError::Differs { folder: folder.to_owned(), what };
    let text = read("manifest.json")?;
    let manifest: Manifest =
        serde_json::from_slice(&text).map_err(|e| differs(format!("manifest.json is damaged: {e}")))?;
    for (name, expected) in &manifest.files {
        if super::sha256_hex(&read(name)?) != *expected {
            return Err(differs(format!("{name} was changed after it was frozen")));
        }
    }
    if manifest.files.get("study.json") != Some(&study.sha256) {
        return Err(differs(format!("{} is not the frozen study", study.path.display())));
    }
    let frozen: Vec<FrozenStimulus> =
        serde_json::from_slice(&read("stimuli.json")?).map_err(|e| differs(format!("stimuli.json is damaged: {e}")))?;
    for (was, is) in frozen.iter().zip(&stimuli(study, store)?) {
        if was != is {
            return Err(differs(format!("stimulus {} in the store is another", is.request.label())));
        }
    }
    let built = frozen_program().map_err(|source| FreezeError::Io { path: folder.to_owned(), source })?;
    let built = pretty(&built);
    if manifest.files.get("program.json") != Some(&super::sha256_hex(&built)) {
        let what = "it was frozen by another build of the program; use that build, or freeze again";
        return Err(differs(what.to_owned()));
    }
    Ok(super::sha256_hex(&text))
}

/// Version, commit, and the SHA-256 of the running program itself.
fn frozen_program() -> io::Result<serde_json::Value> {
    let executable_sha256 = file_sha256(&std::env::current_exe()?)?;
    Ok(serde_json::json!({"program": program(), "executable_sha256": executable_sha256}))
}

fn stimuli(study: &Study, store: &Store) -> Result<Vec<FrozenStimulus>, StoreError> {
    let find = |request: &super::stimulus::StimulusRequest| {
        let stored = store.find(request)?;
        Ok(FrozenStimulus { request: request.clone(), key: stored.side_car.key, files: stored.side_car.files })
    };
    Plan::all_stimuli(&study.definition).iter().map(find).collect()
}

fn pretty(value: &impl Serialize) -> Vec<u8> {
    // Plain structs and finite numbers always have a JSON text.
    let mut bytes = serde_json::to_vec_pretty(value).unwrap_or_default();
    bytes.push(b'\n');
    bytes
}
