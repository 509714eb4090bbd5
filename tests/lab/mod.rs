//! A laboratory for tests of studies: a renderer of stimuli that needs no graphics device, and the program in a fresh
//! folder.

use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use cyclopean::study::prepare::{self, Shard};
use cyclopean::study::sha256_hex;
use cyclopean::study::stimulus::{StimulusInfo, StimulusRenderer, StimulusRequest, frame_file};
use cyclopean::study::store::Store;
use cyclopean::study::validate;
use cyclopean_analysis::journal::record::Film;

pub use crate::program::stderr;

/// Renders small real pictures whose colours follow from the request.
#[derive(Default)]
pub struct Painter {
    /// Part of every identity. Another version changes all of them, as a new shader would.
    pub version: u32,
    /// The number of stimuli that were rendered.
    pub rendered: usize,
    /// The number of the stimulus at which rendering fails.
    pub fails_at: Option<usize>,
}

impl StimulusRenderer for Painter {
    fn identity(&self, request: &StimulusRequest) -> anyhow::Result<String> {
        Ok(sha256_hex(format!("painter {} {}", self.version, serde_json::to_string(request)?).as_bytes()))
    }

    fn render(&mut self, request: &StimulusRequest, into: &Path) -> anyhow::Result<StimulusInfo> {
        anyhow::ensure!(self.fails_at != Some(self.rendered), "the device is gone");
        self.rendered += 1;
        let key = self.identity(request)?;
        let byte = |i: usize| u8::from_str_radix(&key[2 * i..2 * i + 2], 16).unwrap_or(0);
        let sbs =
            image::RgbImage::from_fn(32, 16, |x, y| image::Rgb([byte(0), byte((x % 32) as usize), byte(y as usize)]));
        sbs.save(into.join("sbs.png"))?;
        let film = film(request, 30.0);
        for frame in 1..film.map_or(1, |film| film.frames) {
            let mut other = sbs.clone();
            other.put_pixel(0, 0, image::Rgb([frame as u8, 0, 0]));
            other.save(into.join(frame_file(frame)))?;
        }
        let pixel = |x: usize, _y: usize| (f32::from(byte(x % 32)), 0.5_f32, 0.25_f32);
        exr::prelude::write_rgb_file(into.join("stereo.exr"), 16, 16, pixel)?;
        Ok(StimulusInfo {
            scene_sha256: Some(sha256_hex(request.scene.as_bytes())),
            shaders_sha256: None,
            renderer: format!("painter {}", self.version),
            samples: request.samples.unwrap_or(1),
            standard_error: None,
            horizontal_fov_deg: request.horizontal_fov_deg,
            inconsistency: Some(if request.method == "sssr" { 0.2 } else { 0.0 }),
            film,
        })
    }
}

/// The frames of a stimulus along a path, which lasts at most one second.
pub fn film(request: &StimulusRequest, rate_hz: f64) -> Option<Film> {
    request.path.as_ref()?;
    let seconds = request.seconds.expect("a moving stimulus says how long it is shown").min(1.0);
    Some(Film { rate_hz, frames: (seconds * rate_hz).ceil() as u32 })
}

/// A folder with a study file and its stimuli prepared.
pub struct Lab {
    pub dir: tempfile::TempDir,
}

impl Lab {
    /// Makes a laboratory with this study file.
    pub fn new(study: &serde_json::Value) -> Lab {
        Lab::within(&std::env::temp_dir(), study)
    }

    /// The same on a file system in memory where there is one, because thousands of syncs take no time there.
    pub fn in_memory(study: &serde_json::Value) -> Lab {
        let (memory, temporary) = (Path::new("/dev/shm"), std::env::temp_dir());
        Lab::within(if memory.is_dir() { memory } else { &temporary }, study)
    }

    fn within(folder: &Path, study: &serde_json::Value) -> Lab {
        let lab = Lab { dir: tempfile::tempdir_in(folder).expect("a temporary folder") };
        std::fs::write(lab.study(), serde_json::to_string_pretty(study).expect("JSON")).expect("the study file");
        lab.prepare(&mut Painter::default());
        lab
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.dir.path().join(name)
    }

    pub fn study(&self) -> PathBuf {
        self.path("study.json")
    }

    pub fn store(&self) -> Store {
        Store::new(self.path("store"))
    }

    pub fn sessions(&self) -> PathBuf {
        self.path("sessions")
    }

    pub fn load(&self) -> validate::Study {
        validate::load(&self.study()).expect("a study")
    }

    pub fn prepare(&self, painter: &mut Painter) -> prepare::Report {
        let study = self.load();
        prepare::prepare(&study.definition, &self.store(), painter, Shard::WHOLE, &mut |_, _| Ok(()))
            .expect("prepared stimuli")
    }

    /// A command of the program in this folder.
    pub fn command(&self, args: &[&str]) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cyclopean"));
        command.args(args).current_dir(self.dir.path());
        command
    }

    pub fn program(&self, args: &[&str]) -> Output {
        self.command(args).output().expect("the program starts")
    }

    /// Runs a simulated session, with more arguments after the participant.
    pub fn simulate(&self, participant: &str, more: &[&str]) -> Output {
        let mut args = vec!["run", "study.json", "--participant", participant, "--simulate"];
        args.extend_from_slice(more);
        self.program(&args)
    }

    pub fn journal(&self, participant: &str, session: &str) -> PathBuf {
        self.sessions().join(&self.load().definition.id).join(participant).join(format!("{session}.jsonl"))
    }
}

/// The program `mos` beside the program under test. It is built if it is missing. `None` if it cannot be built here.
pub fn mos() -> Option<PathBuf> {
    let program = Path::new(env!("CARGO_BIN_EXE_cyclopean"));
    let mos = program.with_file_name("mos").with_extension(std::env::consts::EXE_EXTENSION);
    if mos.exists() {
        return Some(mos);
    }
    let profile = program.parent()?;
    let mut build = Command::new(std::env::var_os("CARGO").unwrap_or("cargo".into()));
    build.args(["build", "--locked", "-p", "cyclopean-analysis", "--bin", "mos", "--target-dir"]);
    build.arg(profile.parent()?).current_dir(env!("CARGO_MANIFEST_DIR"));
    if profile.ends_with("release") {
        build.arg("--release");
    }
    let output = build.output().ok();
    if mos.exists() {
        return Some(mos);
    }
    let why = output.map(|o| stderr(&o)).unwrap_or_default();
    assert!(std::env::var_os("CI").is_none(), "mos cannot be built: {why}");
    println!("skipped: `mos` is not beside {} and cannot be built: {why}", program.display());
    None
}

/// A study in which these scenes are rated on five steps, with short times.
pub fn rate(scenes: &[&str], repetitions: u32) -> serde_json::Value {
    serde_json::json!({
        "format": 1, "id": "rate", "title": "Rate", "seed": 11, "participants": 4, "task": "rate",
        "instructions": "Look.", "question": "How much?",
        "labels": ["very strong", "strong", "moderate", "slight", "none"], "scale": [1, 2, 3, 4, 5],
        "protocol": [{"show": "stimulus", "seconds": 2.0}],
        "blank": {"seconds": 0.5},
        "conditions": {"cross": {"scene": scenes, "method": ["sssr", "path-traced"]}},
        "repetitions": repetitions,
        "practice": [{"scene": "pink", "method": "sssr"}],
        "stimuli": {"width_px": 16, "height_px": 16},
        "simulation": {"latent": {"sssr": 2.5, "path-traced": 4.5}, "noise_sd": 0.7, "response_seconds": 1.0}
    })
}
