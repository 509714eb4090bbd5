//! `cyclopean study show`: makes a page that plays a session back, and renders its stimuli again.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::Context as _;
use cyclopean_analysis::journal::record::Stimulus;
use cyclopean_analysis::report::session::{SessionTimeline, session_page};
use cyclopean_analysis::{escape, files};

use super::WrongUsage;
use crate::console::{Console, check_interrupted};
use crate::picture;
use crate::study::show::{RecordedSession, RenderedAgain, render_again};
use crate::study::store::Store;

/// Show what a participant saw: make a page that plays the session back, and render any trial again, checked against
/// the journal.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The journals.
    #[arg(required = true)]
    journals: Vec<PathBuf>,
    /// Render the stimuli of this presentation again; presentations are counted from 0, as in the journal and on the
    /// page.
    #[arg(long, value_name = "N", conflicts_with = "check")]
    trial: Option<u32>,
    /// Render every stimulus of every journal again, each once, and compare its hash; no picture is kept.
    #[arg(long)]
    check: bool,
    /// The folder of prepared stimuli. It gives pictures for the page, and stimuli to compare differing ones with.
    #[arg(long, default_value = "store")]
    store: PathBuf,
    /// Folder for the page and the pictures; it must not exist yet.
    #[arg(long, short, default_value = "shown")]
    out: PathBuf,
}

/// How a stimulus came out when it was rendered again, for people and for JSON.
#[derive(Debug, serde::Serialize)]
struct Report {
    journal: PathBuf,
    /// `stimulus`, `a`, `b` or `reference`; with `--check` the stimulus's index.
    what: String,
    label: String,
    key: String,
    same_key: bool,
    same_bytes: bool,
    differing: Vec<String>,
    /// The difference from the stimulus in the store, if that is there and differs.
    difference: Option<Difference>,
}

/// The difference in display values of both eyes between the picture made now and the one shown then.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Difference {
    /// Share of the pixels that differ, percent.
    pub differing_percent: f64,
    /// Largest difference, of 255.
    pub largest: u8,
    /// Peak signal-to-noise ratio, decibels; none where nothing differs.
    pub psnr_db: Option<f64>,
}

/// See [`Args`].
///
/// # Errors
/// A journal that cannot be read or has no such trial; a renderer or disk that fails. It also fails, with exit code 1,
/// where bytes differ.
pub fn run(args: &Args, console: &Console) -> anyhow::Result<()> {
    if args.trial.is_some() && args.journals.len() > 1 {
        return Err(WrongUsage("--trial: one journal at a time".to_owned()).into());
    }
    anyhow::ensure!(!args.out.exists(), "{} exists; give a folder that does not exist yet", args.out.display());
    let recorded = args
        .journals
        .iter()
        .map(|path| Ok((path, RecordedSession::read(path)?)))
        .collect::<anyhow::Result<Vec<_>>>()?;
    let store = Store::new(&args.store);
    let asked = match args.trial {
        Some(trial) => {
            let (path, recorded) = &recorded[0];
            recorded.of(path, trial)?.into_iter().map(|(what, at)| (0, what.to_owned(), at)).collect()
        }
        None if args.check => every_stimulus(&recorded),
        None => Vec::new(),
    };
    let mut reports = Vec::new();
    if !asked.is_empty() {
        let mut renderer = super::prepare::renderer()?;
        let mut progress = console.progress("rendering", asked.len() as u64);
        for (journal, what, at) in asked {
            check_interrupted()?;
            let (path, recorded) = &recorded[journal];
            let of = &recorded.stimuli[at as usize];
            progress.step(&of.1.label());
            let folder = args.out.join(&what);
            let made = render_again(&mut *renderer, of, &folder)?;
            let difference = difference(&store, &of.0, &made)?;
            if args.check {
                std::fs::remove_dir_all(&folder).with_context(|| format!("cannot empty {}", folder.display()))?;
            }
            reports.push(Report {
                journal: path.to_path_buf(),
                what,
                label: of.1.label(),
                key: of.0.key.clone(),
                same_key: made.same_key,
                same_bytes: made.differing.is_empty(),
                differing: made.differing,
                difference,
            });
        }
    }
    std::fs::create_dir_all(&args.out).with_context(|| format!("cannot make {}", args.out.display()))?;
    let mut pages = Vec::new();
    for (number, (path, recorded)) in recorded.into_iter().enumerate() {
        let name = if args.journals.len() == 1 { "session".to_owned() } else { page_name(number + 1, path, &recorded) };
        pages.push(page(&args.out.join(format!("{name}.html")), path, recorded, &store)?);
    }
    print_reports(&reports, &pages, args, console)
}

/// Every stimulus of all journals, each once, by its address.
fn every_stimulus(recorded: &[(&PathBuf, RecordedSession)]) -> Vec<(usize, String, u32)> {
    let mut found: BTreeMap<&str, (usize, String, u32)> = BTreeMap::new();
    for (journal, (_, recorded)) in recorded.iter().enumerate() {
        for (at, (stimulus, _)) in (0u32..).zip(&recorded.stimuli) {
            found.entry(&stimulus.key).or_insert_with(|| (journal, format!("{journal}-{at}"), at));
        }
    }
    // They are in the order of the journals, so that each scene is uploaded once.
    let mut all: Vec<_> = found.into_values().collect();
    all.sort_by_key(|(journal, _, at)| (*journal, *at));
    all
}

/// The page's name for one of several journals, which may have equal names in different folders. Names in a journal are
/// escaped, so that they lead to no other folder.
fn page_name(number: usize, path: &Path, recorded: &RecordedSession) -> String {
    let session = path.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned());
    escape::file_name(&format!("{number:03}_{}_{}_{session}", recorded.header.study.id, recorded.header.participant))
}

/// Writes the page. Its pictures come from the store, if they are there and whole.
fn page(to: &Path, journal: &Path, recorded: RecordedSession, store: &Store) -> anyhow::Result<PathBuf> {
    let mut pictures = BTreeMap::new();
    for (stimulus, _) in &recorded.stimuli {
        if let Ok(Some(stored)) = store.check(&stimulus.key) {
            let first = stored.frame_paths().into_iter().next();
            if let Some(png) = first.and_then(|path| thumbnail(&path)) {
                pictures.insert(stimulus.id, png);
            }
        }
    }
    let timeline =
        SessionTimeline::of(recorded.entries).with_context(|| format!("{}: it has no header", journal.display()))?;
    files::write_bytes(to, session_page(&timeline, &pictures).as_bytes())?;
    Ok(to.to_owned())
}

/// Width of a picture of both eyes on a page, pixels.
const THUMBNAIL_PX: u32 = 960;

fn thumbnail(path: &Path) -> Option<Vec<u8>> {
    let picture = image::DynamicImage::from(picture::read_png(path).ok()?).into_rgb8();
    let (width, height) = picture.dimensions();
    let small = match width > THUMBNAIL_PX {
        true => {
            let height = (height * THUMBNAIL_PX / width).max(1);
            image::imageops::resize(&picture, THUMBNAIL_PX, height, image::imageops::FilterType::Triangle)
        }
        false => picture,
    };
    let mut png = Vec::new();
    small.write_to(&mut std::io::Cursor::new(&mut png), image::ImageFormat::Png).ok()?;
    Some(png)
}

/// How much a stimulus that came out differently differs from the one in the store; none: it is the same, or not in the
/// store.
fn difference(store: &Store, stimulus: &Stimulus, made: &RenderedAgain) -> anyhow::Result<Option<Difference>> {
    let Ok(Some(stored)) = store.check(&stimulus.key) else { return Ok(None) };
    if made.differing.is_empty() || stored.side_car.files != stimulus.files {
        return Ok(None);
    }
    let name = made.differing.iter().find(|name| name.ends_with(".png"));
    let Some(name) = name else { return Ok(None) };
    let read = |path: PathBuf| -> anyhow::Result<image::RgbImage> {
        Ok(image::DynamicImage::from(picture::read_png(&path)?).into_rgb8())
    };
    let (then, now) = (read(stored.folder.join(name))?, read(made.folder.join(name))?);
    Ok((then.dimensions() == now.dimensions()).then(|| compare(&then, &now)))
}

fn compare(then: &image::RgbImage, now: &image::RgbImage) -> Difference {
    let pairs = || then.pixels().zip(now.pixels());
    let differing = pairs().filter(|(a, b)| a != b).count();
    let apart = || pairs().flat_map(|(a, b)| (0..3).map(move |c| a.0[c].abs_diff(b.0[c])));
    let count = f64::from(then.width()) * f64::from(then.height());
    let mse = apart().map(|d| f64::from(d).powi(2)).sum::<f64>() / (3.0 * count).max(1.0);
    Difference {
        differing_percent: 100.0 * differing as f64 / count.max(1.0),
        largest: apart().max().unwrap_or(0),
        psnr_db: (mse > 0.0).then(|| 10.0 * (255.0f64.powi(2) / mse).log10()),
    }
}

fn print_reports(reports: &[Report], pages: &[PathBuf], args: &Args, console: &Console) -> anyhow::Result<()> {
    console.object(&serde_json::json!({ "stimuli": reports, "pages": pages }))?;
    for report in reports.iter().filter(|r| !args.check || !r.same_bytes) {
        let how = match (&report.same_bytes, &report.difference) {
            (true, _) => "the same bytes as the participant was shown".to_owned(),
            (false, Some(d)) => format!(
                "differs in {}: {:.3} % of the pixels, by {} of 255 at the most, PSNR {}",
                report.differing.join(", "),
                d.differing_percent,
                d.largest,
                d.psnr_db.map_or_else(|| "without end".to_owned(), |db| format!("{db:.1} dB"))
            ),
            (false, None) => {
                format!("differs in {}; the stimulus of that day is not in the store", report.differing.join(", "))
            }
        };
        let why = if report.same_key { "" } else { " (another scene, build, setting or kind of device)" };
        console.line(format!("{}: {}: {how}{why}", report.what, report.label));
    }
    if !reports.is_empty() {
        let same = reports.iter().filter(|r| r.same_bytes).count();
        console.line(format!("{same} of {} stimuli came out byte for byte", reports.len()));
    }
    pages.iter().for_each(|page| console.line(format!("page: {}", page.display())));
    let differing = reports.iter().filter(|r| !r.same_bytes).count();
    anyhow::ensure!(differing == 0, "{differing} stimuli differ from what was shown");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_compared_by_pixels_and_by_value() {
        let then = image::RgbImage::from_pixel(4, 2, image::Rgb([10, 20, 30]));
        let same = compare(&then, &then);
        assert_eq!(same, Difference { differing_percent: 0.0, largest: 0, psnr_db: None });
        let mut now = then.clone();
        now.put_pixel(1, 1, image::Rgb([10, 22, 30]));
        let found = compare(&then, &now);
        assert_eq!((found.differing_percent, found.largest), (12.5, 2));
        // The mean squared error is 4 / 24.
        let expected = 10.0 * (255.0f64.powi(2) / (4.0 / 24.0)).log10();
        assert!((found.psnr_db.unwrap() - expected).abs() < 1e-9);
    }
}
