//! `cyclopean compare A.exr B.exr`: compares one picture with another, without a GPU.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::WrongUsage;
use crate::console::Console;
use crate::metrics::{Judge, Scores};
use crate::picture::{self, PictureError, StereoPicture};
use crate::scene::Eye;

/// Settings of the tone map and of FLIP.
pub struct Display {
    /// Exposure of the reference, used for both pictures, because an EXR does not state one.
    pub exposure: f32,
    pub pixels_per_degree: f32,
}

/// What is printed.
#[derive(Debug, Serialize)]
struct Report {
    reference: PathBuf,
    picture: PathBuf,
    width: u32,
    height: u32,
    exposure: f32,
    pixels_per_degree: f32,
    left: EyeScores,
    right: EyeScores,
}

/// Scores of one eye. Null: a file lacks that layer, or no pixel counts.
#[derive(Debug, Serialize)]
struct EyeScores {
    /// Scores over all pixels.
    composite: Option<Scores>,
    /// Scores of the layer `reflection`, over the pixels where the reference's is not black.
    reflection: Option<Scores>,
}

/// Compares `picture` with `reference`.
///
/// # Errors
/// A file that cannot be read, or pictures of different sizes.
pub fn compare(reference: &Path, picture: &Path, display: &Display, console: &Console) -> anyhow::Result<()> {
    let colors = [picture::read_exr(reference, "")?, picture::read_exr(picture, "")?];
    let [a, b] = &colors;
    if (a.width, a.height) != (b.width, b.height) {
        let size = |p: &StereoPicture| format!("{}×{}", p.width, p.height);
        let text = "pictures of one size are compared";
        return Err(WrongUsage(format!(
            "{} has {} pixels an eye and {} has {}; {text}",
            reference.display(),
            size(a),
            picture.display(),
            size(b)
        ))
        .into());
    }
    let reflections = match (layer(reference)?, layer(picture)?) {
        (Some(a), Some(b)) => Some([a, b]),
        _ => None,
    };
    let scores = |eye: Eye| EyeScores {
        composite: score(&colors, eye, display, |_| true),
        reflection: reflections.as_ref().and_then(|r| score(r, eye, display, |texel| texel != [0.0; 3])),
    };
    let report = Report {
        reference: reference.to_owned(),
        picture: picture.to_owned(),
        width: a.width,
        height: a.height,
        exposure: display.exposure,
        pixels_per_degree: display.pixels_per_degree,
        left: scores(Eye::Left),
        right: scores(Eye::Right),
    };
    say(console, &report);
    console.object(&report)?;
    Ok(())
}

/// Reads the layer of the reflection alone, if the file has it.
fn layer(path: &Path) -> Result<Option<StereoPicture>, PictureError> {
    match picture::has_layer(path, "reflection")? {
        true => picture::read_exr(path, "reflection").map(Some),
        false => Ok(None),
    }
}

fn score(
    [reference, picture]: &[StereoPicture; 2],
    eye: Eye,
    display: &Display,
    counts: impl Fn([f32; 3]) -> bool,
) -> Option<Scores> {
    let size = (reference.width as usize, reference.height as usize);
    let values = &reference.eyes[eye.layer()];
    let mask = values.iter().map(|t| counts(*t)).collect();
    Judge::new(size, values, mask, display.exposure, display.pixels_per_degree).of(&picture.eyes[eye.layer()])
}

fn say(console: &Console, report: &Report) {
    console.line(format!(
        "{} against {} · {}×{} per eye",
        report.picture.display(),
        report.reference.display(),
        report.width,
        report.height
    ));
    console.line(format!("{:<18} {:>11} {:>11} {:>11} {:>9} {:>9}", "", "MSE", "RSE", "relMSE", "SSIM", "FLIP"));
    for (eye, scores) in [("left", &report.left), ("right", &report.right)] {
        for (layer, s) in [("composite", &scores.composite), ("reflection", &scores.reflection)] {
            let Some(s) = s else { continue };
            let number = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), |v| format!("{v:.4}"));
            let short = |v: Option<f64>| v.map_or_else(|| "–".to_owned(), |v| format!("{v:.4e}"));
            console.line(format!(
                "{:<18} {:>11} {:>11} {:>11} {:>9} {:>9}",
                format!("{eye} {layer}"),
                short(Some(s.mse)),
                short(s.rse),
                short(s.relmse),
                number(s.ssim),
                number(s.flip)
            ));
        }
    }
}
