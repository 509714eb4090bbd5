//! An X display without a monitor for the compositor's window, and pictures of it.

use std::io::BufRead as _;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use image::RgbImage;

use crate::screen;

/// An X server (Xvfb) in the root, whose frame buffer is a file. It is killed when this is dropped.
pub struct Window {
    folder: tempfile::TempDir,
    child: Child,
    /// The display's number in `DISPLAY`.
    pub number: u32,
}

impl Window {
    pub fn open() -> Window {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let mut command = Command::new(super::repository().join("tests/xr/inside"));
        command.args(["Xvfb", "-displayfd", "1", "-screen", "0", "1024x600x24", "-ac", "-nolisten", "tcp", "-fbdir"]);
        command.arg(folder.path()).current_dir(folder.path()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().expect("Xvfb starts");
        let mut line = String::new();
        std::io::BufReader::new(child.stdout.take().expect("a pipe")).read_line(&mut line).expect("its number");
        Window { folder, child, number: line.trim().parse().expect("a number") }
    }

    /// A picture of what the display shows now.
    pub fn picture(&self) -> RgbImage {
        screen::picture(self.folder.path())
    }

    /// The same. The picture is also saved so that people can look at it.
    pub fn keep(&self, name: &str) -> RgbImage {
        let picture = self.picture();
        let path = kept(name);
        picture.save(&path).expect("a PNG");
        picture
    }

    /// Waits until the display shows a picture that `wanted` accepts, saves it and returns it.
    ///
    /// # Panics
    /// After half a minute, with `what` in the message. The last picture is saved.
    pub fn until(&self, name: &str, what: &str, wanted: impl Fn(&RgbImage) -> bool) -> RgbImage {
        let limit = Instant::now() + Duration::from_secs(30);
        loop {
            let picture = self.picture();
            if wanted(&picture) {
                picture.save(kept(name)).expect("a PNG");
                return picture;
            }
            if Instant::now() > limit {
                self.keep(name);
                panic!("waited for {what}; the last picture is {}", kept(name).display());
            }
            std::thread::sleep(Duration::from_millis(50));
        }
    }
}

/// Whether two pictures of the window show the same view. Their poses agree only up to rounding, and the software
/// driver's code depends on the processor, so that a texel on the edge of a glyph may round differently. At most one
/// value in a thousand may differ, and none by more than 3 of 255. A shift by half a pixel violates both conditions.
pub fn same_view(a: &RgbImage, b: &RgbImage) -> bool {
    let differences = || a.as_raw().iter().zip(b.as_raw()).map(|(x, y)| x.abs_diff(*y));
    let differing = differences().filter(|d| *d > 0).count();
    a.dimensions() == b.dimensions() && differing * 1000 <= a.as_raw().len() && differences().all(|d| d <= 3)
}

/// The path of the saved picture with this name.
pub fn kept(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("openxr");
    std::fs::create_dir_all(&folder).expect("the folder of kept pictures");
    folder.join(format!("{name}.png"))
}

impl Drop for Window {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The centres, in pixels, of the spots whose colour `is_spot` accepts, sorted by x and then by y.
pub fn spots(picture: &RgbImage, is_spot: impl Fn([u8; 3]) -> bool) -> Vec<(f64, f64)> {
    let mut groups: Vec<Vec<(f64, f64)>> = Vec::new();
    for (x, y, p) in picture.enumerate_pixels() {
        if !is_spot(p.0) {
            continue;
        }
        let at = (f64::from(x) + 0.5, f64::from(y) + 0.5);
        let near = |g: &&mut Vec<(f64, f64)>| g.iter().any(|q| (q.0 - at.0).abs() < 3.0 && (q.1 - at.1).abs() < 3.0);
        match groups.iter_mut().find(near) {
            Some(group) => group.push(at),
            None => groups.push(vec![at]),
        }
    }
    let mean = |g: &Vec<(f64, f64)>| {
        let n = g.len() as f64;
        (g.iter().map(|p| p.0).sum::<f64>() / n, g.iter().map(|p| p.1).sum::<f64>() / n)
    };
    let mut centres: Vec<_> = groups.iter().map(mean).collect();
    centres.sort_by(|a, b| a.partial_cmp(b).expect("numbers"));
    centres
}
