//! The content-addressed store of stimuli: a request is looked up, checked, and rendered if needed.
//!
//! ```text
//! objects/KK/KEY/{sbs.png, stereo.exr, stimulus.json, timing.json}    KK: first two digits of KEY
//! objects/KK/KEY/sbs_NNNNN.png                                        frame NNNNN of a moving stimulus, from 1
//! requests/HASH.json                                                  request → KEY; HASH: of the request's JSON
//! ```
//! Every file but `timing.json` is the same whoever renders it, so folders made by several shards can be copied
//! together.

use std::collections::BTreeMap;
use std::fs;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use cyclopean_analysis::files::{self, MOST_TEXT, WriteError};
use cyclopean_analysis::parts;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};

use super::stimulus::{StimulusInfo, StimulusRenderer, StimulusRequest, frame_file};

/// The side-car beside a stimulus's images.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SideCar {
    pub format: u32,
    pub key: String,
    pub request: StimulusRequest,
    pub info: StimulusInfo,
    /// File name → SHA-256 (hex).
    pub files: BTreeMap<String, String>,
}

/// The file `timing.json`: it differs from one rendering to the next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RenderTiming {
    pub seconds: f64,
}

#[derive(Debug, Serialize, Deserialize)]
struct Alias {
    request: StimulusRequest,
    key: String,
}

/// A stimulus in the store whose files were checked against their sums.
#[derive(Debug, Clone, PartialEq)]
pub struct StoredStimulus {
    pub folder: PathBuf,
    pub side_car: SideCar,
}

impl StoredStimulus {
    /// Its pictures in the order of their display: one of a still, one for each frame of a moving stimulus.
    pub fn frame_paths(&self) -> Vec<PathBuf> {
        let frames = self.side_car.info.film.map_or(1, |film| film.frames);
        (0..frames).map(|frame| self.folder.join(frame_file(frame))).collect()
    }
}

/// A stimulus cannot be used as it is.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    #[error("stimulus {label} is not in the store {}", store.display())]
    Missing { label: String, store: PathBuf },
    #[error("stimulus file {} is damaged ({what}); `cyclopean prepare` renders it again", path.display())]
    Damaged { path: PathBuf, what: String },
    #[error("cannot read or write the store at {}: {source}", path.display())]
    Io {
        path: PathBuf,
        #[source]
        source: io::Error,
    },
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error("the renderer wrote no {file} for {label}")]
    NoFile { file: String, label: String },
    #[error("{label}: {error:#}")]
    Render { label: String, error: anyhow::Error },
}

/// See the module's documentation.
#[derive(Debug, Clone)]
pub struct Store {
    root: PathBuf,
}

impl Store {
    pub fn new(root: impl Into<PathBuf>) -> Store {
        Store { root: root.into() }
    }

    pub fn root(&self) -> &Path {
        &self.root
    }

    fn folder(&self, key: &str) -> PathBuf {
        self.root.join("objects").join(key.get(..2).unwrap_or("__")).join(key)
    }

    fn alias_path(&self, request: &StimulusRequest) -> PathBuf {
        // A struct of plain values always has a JSON text.
        let text = serde_json::to_vec(request).unwrap_or_default();
        self.root.join("requests").join(format!("{}.json", super::sha256_hex(&text)))
    }

    /// Finds a stimulus by its request, and checks every byte of it.
    ///
    /// # Errors
    /// It is missing or damaged.
    pub fn find(&self, request: &StimulusRequest) -> Result<StoredStimulus, StoreError> {
        let missing = || StoreError::Missing { label: request.label(), store: self.root.clone() };
        let path = self.alias_path(request);
        let alias: Alias = match files::read(&path, MOST_TEXT) {
            Ok(bytes) => serde_json::from_slice(&bytes)
                .map_err(|e| StoreError::Damaged { path: path.clone(), what: e.to_string() })?,
            Err(e) if e.kind() == io::ErrorKind::NotFound => return Err(missing()),
            Err(source) => return Err(StoreError::Io { path, source }),
        };
        if alias.request != *request {
            return Err(StoreError::Damaged { path, what: "it belongs to another request".to_owned() });
        }
        let stored = self.check(&alias.key)?.ok_or_else(missing)?;
        Ok(stored)
    }

    /// The entry of a key; none when there is no entry.
    ///
    /// # Errors
    /// The entry exists and is damaged.
    pub fn check(&self, key: &str) -> Result<Option<StoredStimulus>, StoreError> {
        let folder = self.folder(key);
        let path = folder.join("stimulus.json");
        // The folder is looked for first: an entry that appears afterwards appears whole.
        let is_there = folder.exists();
        let bytes = match files::read(&path, MOST_TEXT) {
            Ok(bytes) => bytes,
            Err(e) if e.kind() == io::ErrorKind::NotFound && !is_there => return Ok(None),
            Err(e) if e.kind() == io::ErrorKind::NotFound => {
                return Err(StoreError::Damaged { path, what: "it is missing".to_owned() });
            }
            Err(source) => return Err(StoreError::Io { path, source }),
        };
        let side_car: SideCar = serde_json::from_slice(&bytes)
            .map_err(|e| StoreError::Damaged { path: path.clone(), what: e.to_string() })?;
        // This is checked before the names are made, because a few digits can promise billions of frames.
        let frames = side_car.info.film.map_or(1, |film| film.frames as usize);
        if side_car.key != key
            || frames > side_car.files.len()
            || side_car.info.files().iter().any(|f| !side_car.files.contains_key(f))
        {
            return Err(StoreError::Damaged { path, what: "it describes another stimulus".to_owned() });
        }
        for (name, expected) in &side_car.files {
            let path = folder.join(name);
            let found =
                file_sha256(&path).map_err(|e| StoreError::Damaged { path: path.clone(), what: e.to_string() })?;
            if found != *expected {
                return Err(StoreError::Damaged { path, what: format!("SHA-256 {found}, expected {expected}") });
            }
        }
        Ok(Some(StoredStimulus { folder, side_car }))
    }

    /// Seconds that rendering an entry took; none when it is not known.
    pub fn seconds(&self, key: &str) -> Option<f64> {
        let bytes = files::read(&self.folder(key).join("timing.json"), MOST_TEXT).ok()?;
        serde_json::from_slice::<RenderTiming>(&bytes).ok().map(|t| t.seconds)
    }

    /// Renders into a folder beside the entry's place and moves it there as a whole. Then the request points to it.
    ///
    /// # Errors
    /// The renderer failed or the disk is full; the store is then as before.
    pub fn render(
        &self,
        renderer: &mut dyn StimulusRenderer,
        request: &StimulusRequest,
        key: &str,
    ) -> Result<(), StoreError> {
        let folder = self.folder(key);
        let parent = folder.parent().unwrap_or(&self.root);
        fs::create_dir_all(parent).map_err(|source| StoreError::Io { path: parent.to_owned(), source })?;
        // An entry that exists is damaged, or another process was faster; whole ones have the same bytes.
        let is_whole = || self.check(key).is_ok_and(|entry| entry.is_some());
        files::write_folder(&folder, is_whole, |part| self.fill(renderer, request, key, part))
    }

    /// Removes what killed programs left half-written; see [`parts::sweep`].
    ///
    /// # Errors
    /// A folder that cannot be read.
    pub fn sweep(&self) -> Result<(), StoreError> {
        let sweep = |path: PathBuf| parts::sweep(&path).map_err(|source| StoreError::Io { path, source });
        sweep(self.root.join("requests"))?;
        let objects = self.root.join("objects");
        let entries = match fs::read_dir(&objects) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(()),
            entries => entries.map_err(|source| StoreError::Io { path: objects.clone(), source })?,
        };
        for entry in entries {
            let folder = entry.map_err(|source| StoreError::Io { path: objects.clone(), source })?.path();
            if folder.is_dir() {
                sweep(folder)?;
            }
        }
        Ok(())
    }

    fn fill(
        &self,
        renderer: &mut dyn StimulusRenderer,
        request: &StimulusRequest,
        key: &str,
        part: &Path,
    ) -> Result<(), StoreError> {
        let label = || request.label();
        let started = std::time::Instant::now();
        let info = renderer.render(request, part).map_err(|error| StoreError::Render { label: label(), error })?;
        let seconds = started.elapsed().as_secs_f64();
        let mut files = BTreeMap::new();
        for file in info.files() {
            let path = part.join(&file);
            let sum = file_sha256(&path).map_err(|_| StoreError::NoFile { file: file.clone(), label: label() })?;
            files::open(&path)
                .and_then(|f| f.sync_all())
                .map_err(|source| StoreError::Io { path: path.clone(), source })?;
            files.insert(file, sum);
        }
        let side_car = SideCar { format: 1, key: key.to_owned(), request: request.clone(), info, files };
        files::write_bytes(&part.join("timing.json"), &to_json(&RenderTiming { seconds }))?;
        files::write_bytes(&part.join("stimulus.json"), &to_json(&side_car))?;
        Ok(())
    }

    /// Makes a request point to an entry; writes only if something changes.
    ///
    /// # Errors
    /// The disk is full or read-only.
    pub fn point(&self, request: &StimulusRequest, key: &str) -> Result<(), StoreError> {
        let path = self.alias_path(request);
        let bytes = to_json(&Alias { request: request.clone(), key: key.to_owned() });
        if files::read(&path, MOST_TEXT).is_ok_and(|old| old == bytes) {
            return Ok(());
        }
        let parent = self.root.join("requests");
        fs::create_dir_all(&parent).map_err(|source| StoreError::Io { path: parent, source })?;
        Ok(files::write_bytes(&path, &bytes)?)
    }
}

fn to_json(value: &impl Serialize) -> Vec<u8> {
    // Structs of plain values and finite numbers always have a JSON text.
    let mut bytes = serde_json::to_vec_pretty(value).unwrap_or_default();
    bytes.push(b'\n');
    bytes
}

/// SHA-256 (hex) of a file, in bounded memory.
///
/// # Errors
/// It cannot be read.
pub fn file_sha256(path: &Path) -> io::Result<String> {
    let mut file = files::open(path)?;
    let mut hash = Sha256::new();
    let mut buffer = vec![0; 1 << 18];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(super::hex(&hash.finalize())),
            n => hash.update(&buffer[..n]),
        }
    }
}
