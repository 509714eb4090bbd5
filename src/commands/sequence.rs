//! `cyclopean render --path`: renders the frames of a path, one after the other, as numbered pictures.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context as _;
use cyclopean_analysis::{escape, files};
use serde::Serialize;

use crate::console::{Console, check_interrupted};
use crate::gpu::{DeviceInfo, Gpu};
use crate::picture::{self, Part};
use crate::render::{Method, Renderer, Settings};
use crate::scene::{HeadPath, Scene, View};

use super::WrongUsage;
use super::device;

/// The sequence that is rendered.
pub struct Sequence<'a> {
    pub scene: &'a Arc<Scene>,
    pub view: &'a View,
    pub path: &'a HeadPath,
    /// How many of the path's first frames are rendered; `None`: all.
    pub frames: Option<u32>,
    pub method: &'a Method,
    pub settings: &'a Settings,
    pub out: &'a Path,
}

/// `sequence.json`.
#[derive(Debug, Serialize)]
struct Report<'a> {
    scene: &'a str,
    scene_sha256: &'a str,
    view: &'a str,
    path: &'a str,
    rate_hz: f64,
    method: String,
    rendered_method: String,
    width: u32,
    height: u32,
    seed: u32,
    device: &'a DeviceInfo,
    settings: &'a Settings,
    nan: u64,
    inf: u64,
    frames: Vec<FrameReport>,
}

#[derive(Debug, Serialize)]
struct FrameReport {
    /// Seconds since the beginning of the path.
    time_s: f64,
    /// Whether the head has jumped since the frame before.
    cut: bool,
    /// Milliseconds of all passes on the device.
    ms: f64,
    exr: PathBuf,
    png: PathBuf,
}

/// Renders and writes frame by frame. Frame i uses the random numbers with index i of the settings' seed.
///
/// # Errors
/// More frames than the path has, no memory, an unwritable folder; frames that were written stay.
pub fn run(gpu: &std::rc::Rc<Gpu>, of: &Sequence<'_>, console: &Console) -> anyhow::Result<()> {
    let count = of.path.frames_asked(of.frames).map_err(|e| WrongUsage(e.to_string()))?;
    std::fs::create_dir_all(of.out).with_context(|| format!("cannot make the folder {}", of.out.display()))?;
    let mut renderer = Renderer::new(gpu, Arc::clone(of.scene))?.keep_light_in(device::light_folder());
    let first = of.path.view(of.view, 0).stereo_camera(of.settings.aspect());
    let mut prepared = renderer.prepare(&first, of.method, of.settings)?;
    let stem = escape::file_name(&format!("{}_{}_{}", of.scene.name, of.path.name, of.method));
    let mut report = Report {
        scene: &of.scene.name,
        scene_sha256: &of.scene.content_sha256,
        view: &of.view.name,
        path: &of.path.name,
        rate_hz: of.path.rate_hz,
        method: of.method.to_string(),
        rendered_method: prepared.method().to_string(),
        width: of.settings.width,
        height: of.settings.height,
        seed: of.settings.seed,
        device: gpu.info(),
        settings: of.settings,
        nan: 0,
        inf: 0,
        frames: Vec::new(),
    };
    let mut bar = console.progress("frames", u64::from(count));
    for frame in 0..count {
        prepared.follow(of.path, of.view, of.settings.seed, frame)?;
        let rendered = prepared.frame(&mut |_, _| check_interrupted())?;
        let (exr, png) = (format!("{stem}_{frame:04}.exr"), format!("{stem}_{frame:04}.png"));
        let (exr, png) = (of.out.join(exr), of.out.join(png));
        let (linear, reflection) = (prepared.linear()?, prepared.reflection()?);
        let parts = [Part { layer: "", picture: &linear }, Part { layer: "reflection", picture: &reflection }];
        picture::write_exr(&exr, &parts)?;
        let [left, right] = prepared.display()?;
        picture::write_side_by_side(&png, linear.width, linear.height, [&left, &right])?;
        gpu.check_validation()?;
        report.nan += rendered.counters.nan;
        report.inf += rendered.counters.inf;
        let ms = rendered.passes.iter().map(|p| p.ms).sum();
        let time_s = of.path.time_of(frame);
        report.frames.push(FrameReport { time_s, cut: of.path.is_cut(frame), ms, exr, png });
        bar.step("");
    }
    drop(bar);
    let path = of.out.join("sequence.json");
    files::write_bytes(&path, &serde_json::to_vec_pretty(&report)?)?;
    let pattern = of.out.join(format!("{stem}_%04d.png"));
    console.line(format!(
        "{} · path {} · {} · {}×{} per eye · {count} frames at {} a second · {}",
        report.scene, report.path, report.method, report.width, report.height, report.rate_hz, report.device.name
    ));
    console.line(format!("  {}", path.display()));
    console.line(format!(
        "  a film of them: ffmpeg -framerate {} -i {} -pix_fmt yuv420p {stem}.mp4",
        report.rate_hz,
        pattern.display()
    ));
    console.object(&report)?;
    Ok(())
}
