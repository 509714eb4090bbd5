//! A scene in a window: renders, composes and presents frames, and takes keys and mouse.

use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

use winit::keyboard::{Key, NamedKey};

use super::fly_camera::{Direction, FlyCamera};
use crate::commands::device::{self, Size};
use crate::console::{Console, check_interrupted};
use crate::display::desktop::{Composition, DesktopOptions, Picture, ShellEvent, Stage, fit};
use crate::display::panel::{Corner, Note, Panel};
use crate::gpu::{Gpu, Image};
use crate::render::{Method, Prepared, Renderer};
use crate::scene::{Scene, View};

/// What the command line asked for.
pub struct LiveRequest {
    pub scene: Arc<Scene>,
    pub view: View,
    pub method: Method,
    pub size: Option<Size>,
    pub frames: Option<u64>,
}

struct Live {
    options: DesktopOptions,
    request: LiveRequest,
    methods: Vec<Method>,
    method: usize,
    camera: FlyCamera,
    /// The scene's time, seconds, for what moves by itself.
    time_s: f64,
    is_paused: bool,
    is_turning: bool,
    hides_words: bool,
    is_over: bool,
    /// What is prepared for each method, by its index; made when the method is first shown, all for one size.
    prepared: BTreeMap<usize, Prepared>,
    renderer: Renderer,
    words: Option<Image>,
    panel: Panel,
    gpu: Rc<Gpu>,
}

/// Runs until somebody ends it.
///
/// # Errors
/// No desktop, no device, or a frame that failed.
pub fn run(request: LiveRequest, options: DesktopOptions, console: &Console) -> anyhow::Result<()> {
    let mut stage =
        Stage::open(&DesktopOptions { title: format!("cyclopean: {}", request.scene.name), ..options.clone() })?;
    let gpu = Rc::clone(stage.gpu());
    let methods = super::methods(&request.method);
    let mut live = Live {
        renderer: Renderer::new(&gpu, Arc::clone(&request.scene))?,
        camera: FlyCamera::new(&request.view),
        panel: Panel::new(&gpu, options.px_per_degree, None, false)?,
        time_s: 0.0,
        is_paused: false,
        is_turning: false,
        hides_words: false,
        is_over: false,
        prepared: BTreeMap::new(),
        words: None,
        method: 0,
        methods,
        options,
        request,
        gpu,
    };
    for (i, method) in (1..).zip(live.methods.iter().take(9)) {
        console.note(format!("{i}: {method}"));
    }
    stage.start_clock(0);
    let (mut frame, mut last) = (0, Instant::now());
    let mut total_ms = 0.0;
    while !live.is_over && live.request.frames.is_none_or(|n| frame < n) {
        check_interrupted()?;
        if let Some(event) = stage.wait()? {
            live.handle(event);
            continue;
        }
        let (_, is_drawn) = stage.frame();
        let seconds = std::mem::replace(&mut last, Instant::now()).elapsed().as_secs_f64();
        live.camera.step(seconds.min(0.25));
        if !live.is_paused {
            live.time_s += seconds.min(0.25);
        }
        if is_drawn {
            total_ms += live.draw(&stage, frame as u32, seconds)?;
            frame += 1;
        }
        stage.present()?;
    }
    live.gpu.check_validation()?;
    let mean_ms = total_ms / frame.max(1) as f64;
    console.object(&serde_json::json!({ "frames": frame, "mean_ms": mean_ms, "device": live.gpu.info() }))?;
    console.line(format!("{frame} frames, {mean_ms:.1} ms each"));
    Ok(())
}

impl Live {
    fn handle(&mut self, event: ShellEvent) {
        match event {
            ShellEvent::Key { key, modifiers, is_repeat } => {
                self.camera.is_fast = modifiers.shift_key();
                match direction(&key) {
                    Some(way) => self.camera.hold(way, true),
                    None => self.press(&key, is_repeat),
                }
            }
            ShellEvent::KeyUp(key) => {
                if let Some(way) = direction(&key) {
                    self.camera.hold(way, false);
                }
                if key == Key::Named(NamedKey::Shift) {
                    self.camera.is_fast = false;
                }
            }
            ShellEvent::Click => self.is_turning = true,
            ShellEvent::Release => self.is_turning = false,
            ShellEvent::Moved(by) if self.is_turning => self.camera.turn(by),
            ShellEvent::Focus(false) => {
                self.camera.release_all();
                self.is_turning = false;
            }
            ShellEvent::Resized => {
                self.prepared.clear();
                self.words = None;
            }
            ShellEvent::Close => self.is_over = true,
            _ => {}
        }
    }

    fn press(&mut self, key: &Key, is_repeat: bool) {
        const ARROW: f32 = 20.0;
        match key {
            Key::Named(NamedKey::ArrowLeft) => self.camera.turn([-ARROW, 0.0]),
            Key::Named(NamedKey::ArrowRight) => self.camera.turn([ARROW, 0.0]),
            Key::Named(NamedKey::ArrowUp) => self.camera.turn([0.0, -ARROW]),
            Key::Named(NamedKey::ArrowDown) => self.camera.turn([0.0, ARROW]),
            _ if is_repeat => {}
            Key::Named(NamedKey::Escape) => self.is_over = true,
            Key::Named(NamedKey::Tab) => self.method = (self.method + 1) % self.methods.len(),
            Key::Character(c) => match c.to_lowercase().as_str() {
                "h" => self.hides_words = !self.hides_words,
                "p" => self.is_paused = !self.is_paused,
                "r" => self.camera = FlyCamera::new(&self.request.view),
                "v" => {
                    let views = &self.request.scene.views;
                    let at = views.iter().position(|v| v.name == self.request.view.name).unwrap_or(0);
                    if let Some(view) = views.get((at + 1) % views.len().max(1)) {
                        self.request.view = view.clone();
                        self.camera = FlyCamera::new(view);
                    }
                }
                digit => {
                    let number = digit.parse::<usize>().ok().and_then(|n| n.checked_sub(1));
                    self.method = number.filter(|n| *n < self.methods.len()).unwrap_or(self.method);
                }
            },
            _ => {}
        }
    }

    /// Renders and composes one frame; returns its milliseconds on the device.
    fn draw(&mut self, stage: &Stage, frame: u32, seconds: f64) -> anyhow::Result<f64> {
        let Some(window) = stage.size() else { return Ok(0.0) };
        let view_px = self.options.mode.view(window);
        let size = self.request.size.unwrap_or_else(|| {
            let less = if self.gpu.is_cpu() { 4 } else { 1 };
            Size { width: (view_px.0 / less).max(16), height: (view_px.1 / less).max(16) }
        });
        let camera = self.camera.view().stereo_camera(f64::from(size.width) / f64::from(size.height));
        if !self.prepared.contains_key(&self.method) {
            let settings = device::live_settings(&self.gpu, size);
            // The reference takes one path per pixel. It is noisy while the camera moves, but frames keep coming.
            let method = self.methods[self.method].clone();
            let method = if method.samples() > 64 { method.with_samples(Some(1)) } else { method };
            let made = self.renderer.prepare(&camera, &method, &settings)?;
            self.prepared.insert(self.method, made);
        }
        let Some(prepared) = self.prepared.get_mut(&self.method) else { return Ok(0.0) };
        prepared.set_time(self.time_s)?;
        prepared.set_camera(&camera);
        prepared.set_seed(1, frame);
        let report = prepared.frame(&mut |_, _| check_interrupted())?;
        let name = self.methods[self.method].to_string();
        let says = format!(
            "{name}   {:.1} ms   {:.0} a second   {}×{} an eye",
            report.wall_ms,
            1.0 / seconds.max(1e-3),
            size.width,
            size.height
        );
        let at = [0.0, view_px.1 as f32];
        let note = Note::Text { text: says, at, corner: Corner::LowerLeft, size: 0.7 };
        let notes = if self.hides_words { &[][..] } else { std::slice::from_ref(&note) };
        let words = match self.words.take().filter(|w| w.extent() == view_px) {
            Some(words) => words,
            None => self.panel.image(view_px.0, view_px.1)?,
        };
        self.panel.write([notes, notes], [0.0; 4], &words)?;
        let place = fit(view_px, (size.width, size.height), u32::MAX, 0);
        stage.compose(&Composition {
            mode: self.options.mode,
            picture: Picture::Stereo { image: prepared.display_image(), is_encoded: true },
            place,
            words: &words,
            apart_px: self.options.apart_px,
            ground: 0.0,
            patch: None,
        })?;
        self.words = Some(words);
        Ok(report.wall_ms)
    }
}

fn direction(key: &Key) -> Option<Direction> {
    let Key::Character(c) = key else { return None };
    Some(match c.to_lowercase().as_str() {
        "w" => Direction::Forward,
        "s" => Direction::Back,
        "a" => Direction::Left,
        "d" => Direction::Right,
        "e" => Direction::Up,
        "q" => Direction::Down,
        _ => return None,
    })
}
