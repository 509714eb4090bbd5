//! A desktop for tests: an X server without a monitor, with simulated keys and pictures of the screen.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use cyclopean::study::sha256_hex;
use cyclopean::study::stimulus::{StimulusInfo, StimulusRenderer, StimulusRequest, frame_file};
use cyclopean_analysis::journal::record::Film;
use cyclopean_analysis::journal::{self, Entry};

use crate::screen;

/// An X server with a window manager. Both are killed when this is dropped.
pub struct Desk {
    server: Child,
    manager: Option<Child>,
    display: String,
    gallery: PathBuf,
    /// The folder with the server's frame buffer.
    buffer: tempfile::TempDir,
}

/// Prints why displays cannot be tested here. Panics instead if `CYCLOPEAN_REQUIRE_DISPLAYS` or `CI` is set.
pub fn skip(why: &str) {
    let set = |name: &str| std::env::var(name).is_ok_and(|v| !v.is_empty() && v != "0" && v != "false");
    assert!(!set("CYCLOPEAN_REQUIRE_DISPLAYS") && !set("CI"), "{why}");
    eprintln!("SKIPPED: {why}");
}

impl Desk {
    /// Starts a desk, or returns `None` where Xvfb or xdotool is missing (`./x setup` installs them). Pictures are stored as `target/tmp/desktop/NAME-*.png`.
    pub fn new(name: &str) -> Option<Desk> {
        for tool in ["Xvfb", "xdotool"] {
            if Command::new("sh").args(["-c", &format!("command -v {tool} >/dev/null")]).status().ok()?.code()
                != Some(0)
            {
                skip(&format!("{tool} is not installed; ./x setup installs it"));
                return None;
            }
        }
        let buffer = tempfile::tempdir().expect("a temporary folder");
        let args = ["-displayfd", "1", "-screen", "0", "1280x720x24", "-nolisten", "tcp", "-noreset", "-nocursor"];
        let mut server = Command::new("Xvfb")
            .args(args)
            .arg("-fbdir")
            .arg(buffer.path())
            .stdout(Stdio::piped())
            .stderr(Stdio::null())
            .spawn()
            .expect("Xvfb starts");
        let mut number = String::new();
        BufReader::new(server.stdout.take().unwrap()).read_line(&mut number).unwrap();
        let display = format!(":{}", number.trim());
        let gallery = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("desktop");
        std::fs::create_dir_all(&gallery).unwrap();
        let manager =
            Command::new("openbox").env("DISPLAY", &display).stdout(Stdio::null()).stderr(Stdio::null()).spawn().ok();
        let desk = Desk { server, manager, display, gallery: gallery.join(name), buffer };
        if desk.has_manager() {
            // Only a window manager answers this question.
            until("the window manager runs", || desk.xdotool(&["get_num_desktops"]).is_some());
        }
        Some(desk)
    }

    /// Whether there is a window manager, which minimising a window needs.
    pub fn has_manager(&self) -> bool {
        self.manager.is_some()
    }

    /// Runs a command on this desk, with Vulkan validation.
    pub fn on(&self, command: &mut Command) -> Child {
        command
            .env("DISPLAY", &self.display)
            .env_remove("WAYLAND_DISPLAY")
            .env("CYCLOPEAN_VALIDATION", "1")
            .env("CYCLOPEAN_LOG", "cyclopean=info")
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts")
    }

    /// The same, but standard error goes to the file `said`, which can be read while the command runs.
    pub fn on_saying(&self, command: &mut Command, said: &Path) -> Child {
        let said = std::fs::File::create(said).unwrap();
        command.env("DISPLAY", &self.display).env_remove("WAYLAND_DISPLAY").env("CYCLOPEAN_VALIDATION", "1");
        command.stdout(Stdio::piped()).stderr(said).spawn().expect("the program starts")
    }

    fn xdotool(&self, args: &[&str]) -> Option<String> {
        let output = Command::new("xdotool").env("DISPLAY", &self.display).args(args).output().expect("xdotool");
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    }

    /// Waits for the program's window, gives it the keyboard focus and returns its number.
    pub fn window(&self) -> String {
        let began = Instant::now();
        loop {
            let found = self.xdotool(&["search", "--onlyvisible", "--name", "^cyclopean"]);
            if let Some(window) = found.and_then(|text| text.lines().last().map(str::to_owned)) {
                self.xdotool(&["windowfocus", &window]);
                return window;
            }
            assert!(began.elapsed() < Duration::from_secs(60), "there was no window within a minute");
            std::thread::sleep(Duration::from_millis(100));
        }
    }

    /// Presses and releases a key.
    pub fn key(&self, key: &str) {
        self.xdotool(&["key", key]);
    }

    pub fn click(&self, x: i32, y: i32) {
        self.xdotool(&["mousemove", &x.to_string(), &y.to_string(), "click", "1"]);
    }

    pub fn window_does(&self, what: &str, window: &str, more: &[&str]) {
        self.xdotool(&[&[what, window], more].concat());
    }

    /// What the screen shows now.
    pub fn screen(&self) -> image::RgbImage {
        screen::picture(self.buffer.path())
    }

    /// The same. The picture is also saved so that people can look at it.
    pub fn picture(&self, what: &str) -> image::RgbImage {
        let picture = self.screen();
        picture.save(format!("{}-{what}.png", self.gallery.display())).expect("a PNG");
        picture
    }

    /// The same, once the screen has not changed for a quarter of a second.
    pub fn still_picture(&self, what: &str) -> image::RgbImage {
        let (mut last, mut since) = (self.screen(), Instant::now());
        until(&format!("{what}: the screen no longer changes"), || {
            let now = self.screen();
            if now != last {
                (last, since) = (now, Instant::now());
            }
            since.elapsed() > Duration::from_millis(250)
        });
        self.picture(what)
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        for child in self.manager.iter_mut().chain([&mut self.server]) {
            let _ = child.kill();
            let _ = child.wait();
        }
    }
}

/// The entries of a journal so far, without a last line that is not yet complete.
pub fn entries(journal: &Path) -> Vec<Entry> {
    match journal::read(journal) {
        Ok(entries) => entries.map_while(Result::ok).collect(),
        Err(_) => Vec::new(),
    }
}

/// Waits until `is` returns true, and panics with `what` after two minutes.
pub fn until(what: &str, mut is: impl FnMut() -> bool) {
    let began = Instant::now();
    while !is() {
        assert!(began.elapsed() < Duration::from_secs(120), "this did not happen within two minutes: {what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Renders stimuli whose eyes can be told apart: the left one is reddish with a disc on the left, and the right one is
/// bluish with a disc on the right. The stimuli differ in the green of their ground.
#[derive(Default)]
pub struct EyePainter;

pub const STILL: (u32, u32) = (320, 180);
/// The frames of a stimulus along a path.
pub const FILM: Film = Film { rate_hz: 10.0, frames: 6 };
/// How far the disc moves down with each of them, in pixels.
pub const SINKS_PX: u32 = 10;
pub const LEFT: [u8; 3] = [200, 60, 60];
pub const RIGHT: [u8; 3] = [60, 60, 200];

/// Whether this screen shows a stimulus of [`EyePainter`]. Its ground is coloured in every display mode, while panels
/// and pages are grey. The title bar is left out. The coloured frame that marks a pilot session has far fewer pixels.
pub fn shows_stimulus(screen: &image::RgbImage) -> bool {
    let chroma = |p: [u8; 3]| p.iter().max().zip(p.iter().min()).map_or(0, |(high, low)| high - low);
    screen.enumerate_pixels().filter(|(_, y, p)| *y > 40 && chroma(p.0) > 15).count() > 20_000
}

/// Whether this screen shows a panel or a page. Their text has many shades of grey, while a blank has one.
pub fn shows_text(screen: &image::RgbImage) -> bool {
    let inside = screen.enumerate_pixels().filter(|(x, y, _)| (60..1180).contains(x) && (60..640).contains(y));
    let shades: BTreeSet<u8> = inside.map(|(_, _, p)| p.0[1]).collect();
    shades.len() > 20 && !shows_stimulus(screen)
}

impl StimulusRenderer for EyePainter {
    fn identity(&self, request: &StimulusRequest) -> anyhow::Result<String> {
        Ok(sha256_hex(serde_json::to_string(request)?.as_bytes()))
    }

    fn render(&mut self, request: &StimulusRequest, into: &Path) -> anyhow::Result<StimulusInfo> {
        let tell = u8::from_str_radix(&self.identity(request)?[..2], 16)? / 2;
        let (w, h) = STILL;
        let film = request.path.as_ref().map(|_| FILM);
        let picture = |frame: u32| {
            image::RgbImage::from_fn(2 * w, h, |x, y| {
                let (eye, x) = (x / w, x % w);
                let mut color = [LEFT, RIGHT][eye as usize];
                color[1] = color[1] / 2 + tell;
                let cx = if eye == 0 { w / 4 } else { 3 * w / 4 };
                // In a film the disc moves down with each frame.
                let (dx, dy) = (x as i32 - cx as i32, y as i32 - (h / 2 + frame * SINKS_PX) as i32);
                image::Rgb(if dx * dx + dy * dy < 400 { [240, 240, 240] } else { color })
            })
        };
        for frame in 0..film.map_or(1, |film| film.frames) {
            picture(frame).save(into.join(frame_file(frame)))?;
        }
        exr::prelude::write_rgb_file(into.join("stereo.exr"), 4, 4, |_, _| (0.5_f32, 0.5_f32, 0.5_f32))?;
        Ok(StimulusInfo { renderer: "eyes".to_owned(), samples: 1, film, ..StimulusInfo::default() })
    }
}
