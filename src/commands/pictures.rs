//! `cyclopean compare A.exr B.exr`: compares one picture with another, without a GPU.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::WrongUsage;
use super::networks::NetworkFiles;
use crate::console::Console;
use crate::metrics::{Judge, Networks, Scores};
use crate::picture::{self, PictureError, StereoPicture};
use crate::scene::Eye;

/// How the pictures are seen: what the tone map and FLIP need to know.
pub struct ViewingConditions {
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
    composite: Option<LayerScores>,
    /// Scores of the layer `reflection`, over the pixels where the reference's is not black.
    reflection: Option<LayerScores>,
}

/// All measures of a layer.
#[derive(Debug, Serialize)]
struct LayerScores {
    #[serde(flatten)]
    scores: Scores,
    /// Absent without the network.
    #[serde(skip_serializing_if = "Option::is_none")]
    lpips: Option<f64>,
    #[serde(skip_serializing_if = "Option::is_none")]
    dists: Option<f64>,
}

/// Compares `picture` with `reference`.
///
/// # Errors
/// A file that cannot be read, pictures of different sizes, or a network that cannot compare them.
pub fn compare(
    reference: &Path,
    picture: &Path,
    (display, networks): (&ViewingConditions, &NetworkFiles),
    console: &Console,
) -> anyhow::Result<()> {
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
    let networks = networks.load((a.width as usize, a.height as usize))?;
    let reflections = match (layer(reference)?, layer(picture)?) {
        (Some(a), Some(b)) => Some([a, b]),
        _ => None,
    };
    let scores = |eye: Eye| -> anyhow::Result<EyeScores> {
        let reflection = reflections.as_ref().map(|r| score(r, eye, (display, &networks), |texel| texel != [0.0; 3]));
        Ok(EyeScores {
            composite: score(&colors, eye, (display, &networks), |_| true)?,
            reflection: reflection.transpose()?.flatten(),
        })
    };
    let report = Report {
        reference: reference.to_owned(),
        picture: picture.to_owned(),
        width: a.width,
        height: a.height,
        exposure: display.exposure,
        pixels_per_degree: display.pixels_per_degree,
        left: scores(Eye::Left)?,
        right: scores(Eye::Right)?,
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
    (display, networks): (&ViewingConditions, &Networks),
    counts: impl Fn([f32; 3]) -> bool,
) -> anyhow::Result<Option<LayerScores>> {
    let size = (reference.width as usize, reference.height as usize);
    let values = &reference.eyes[eye.layer()];
    let mask = values.iter().map(|t| counts(*t)).collect();
    let judge = Judge::new(size, values, mask, display.exposure, display.pixels_per_degree);
    let shown = judge.displayed(&picture.eyes[eye.layer()]);
    let Some(scores) = judge.of_displayed(&picture.eyes[eye.layer()], &shown) else { return Ok(None) };
    let [lpips, dists] = networks.distances(size, judge.reference_displayed(), &shown)?;
    Ok(Some(LayerScores { scores, lpips, dists }))
}

fn say(console: &Console, report: &Report) {
    console.line(format!(
        "{} against {} · {}×{} per eye",
        report.picture.display(),
        report.reference.display(),
        report.width,
        report.height
    ));
    let eyes = [("left", &report.left), ("right", &report.right)];
    let layers = eyes.into_iter().flat_map(|(eye, s)| {
        [(format!("{eye} composite"), &s.composite), (format!("{eye} reflection"), &s.reflection)]
    });
    let layers: Vec<(String, &LayerScores)> = layers.filter_map(|(name, s)| Some((name, s.as_ref()?))).collect();
    type Column = (&'static str, usize, fn(&LayerScores) -> String);
    let mut columns: Vec<Column> = vec![
        ("MSE", 11, |s| short(Some(s.scores.mse))),
        ("RSE", 11, |s| short(s.scores.rse)),
        ("relMSE", 11, |s| short(s.scores.relmse)),
        ("SSIM", 9, |s| number(s.scores.ssim)),
        ("FLIP", 9, |s| number(s.scores.flip)),
    ];
    if layers.iter().any(|(_, s)| s.lpips.is_some()) {
        columns.push(("LPIPS", 9, |s| number(s.lpips)));
    }
    if layers.iter().any(|(_, s)| s.dists.is_some()) {
        columns.push(("DISTS", 9, |s| number(s.dists)));
    }
    let titles: String = columns.iter().map(|(title, width, _)| format!(" {title:>width$}")).collect();
    console.line(format!("{:<18}{titles}", ""));
    for (name, scores) in layers {
        let cells: String = columns.iter().map(|(_, width, of)| format!(" {:>width$}", of(scores))).collect();
        console.line(format!("{name:<18}{cells}"));
    }
}

fn number(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |v| format!("{v:.4}"))
}

fn short(value: Option<f64>) -> String {
    value.map_or_else(|| "–".to_owned(), |v| format!("{v:.4e}"))
}
