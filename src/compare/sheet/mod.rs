//! Sheets: pictures that show what every method shows, where the methods differ most, and where the eyes disagree
//! (paper §5, Figs. 10 to 14). Each shows one frame of every method and the reference. A [`Subject`] goes in, and a
//! page for each fallback comes out. [`super::scene`] calls it.

mod canvas;
mod compared_frame;
mod heat;
mod layout;
mod regions;
mod text;

use std::rc::Rc;

use super::CompareError;
use super::plan::{Configuration, Options};
use super::run::fallback_name;
use super::subject::Subject;
use crate::console::{Console, check_interrupted};
use crate::gpu::Gpu;
use crate::render::{Method, Settings};

pub use canvas::Canvas;
use canvas::Rect;
use compared_frame::{ComparedFrame, Frame, Scores, Truth};

/// The seed of the frame that is shown. It is that of the first round that is measured.
const SEED: u32 = 1;

/// Everything that a sheet shows.
struct Sheet {
    title: String,
    /// How the pictures were made.
    about: String,
    /// Pixels of one eye.
    size: (usize, usize),
    parts: Vec<Part>,
    rows: Vec<Row>,
}

/// A part of the view that is shown enlarged.
struct Part {
    /// The two methods that differ most there, in words.
    step: String,
    /// The part in the left and in the right eye.
    rects: [Rect; 2],
}

/// A row of the sheet: a method, or the reference.
struct Row {
    name: String,
    about: String,
    compared: ComparedFrame,
    whole: Scores,
    /// The scores of each part, in the order of the parts.
    parts: Vec<Scores>,
    /// Whether this is the reference, for which no errors are shown.
    is_reference: bool,
}

/// A sheet for each fallback, with the fallback's name.
///
/// # Errors
/// [`CompareError`].
pub fn sheets(
    gpu: &Rc<Gpu>,
    subject: &Subject,
    options: &Options,
    console: &Console,
) -> Result<Vec<(String, Canvas)>, CompareError> {
    let Subject { scene, view, camera } = subject;
    let (mut renderer, reference) = subject.reference(gpu, options, console)?;
    let mut shown: Vec<(Configuration, _)> = Vec::new();
    let mut pairs = Vec::new();
    for configuration in options.configurations(scene) {
        let settings = Settings { fallback: Some(configuration.fallback), ..options.settings.clone() };
        let mut prepared = renderer.prepare(camera, &configuration.method, &settings)?;
        prepared.set_seed(SEED, 0);
        prepared.frame(&mut |_, _| check_interrupted())?;
        if pairs.is_empty() {
            pairs = reference.geometric_pairs(&prepared)?;
        }
        let frame = Frame { composite: prepared.linear()?, reflection: prepared.reflection()? };
        shown.push((configuration, frame));
    }
    gpu.check_validation()?;

    let traced = [0, 1].map(|eye| reference.mask(eye));
    let pictures = (&reference.linear, &reference.reflection);
    let truth = Truth::new(pictures, traced, scene.exposure, &pairs, reference.pairs.epsilon);
    let (mut sheets, mut rest) = (Vec::new(), shown.into_iter().peekable());
    while let Some(fallback) = rest.peek().map(|(c, _)| c.fallback) {
        let mut methods = Vec::new();
        while let Some((configuration, frame)) = rest.next_if(|(c, _)| c.fallback == fallback) {
            methods.push((configuration.method, truth.compare(frame)));
        }
        let about = format!(
            "view {}  ·  {} × {} pixels an eye  ·  one frame, seed {SEED}  ·  unknown rays see {}  ·  reference: {} paths \
             a pixel",
            view.name,
            truth.width,
            truth.height,
            fallback_name(fallback),
            options.reference.samples(),
        );
        let frame = Frame { composite: reference.linear.clone(), reflection: reference.reflection.clone() };
        let last = (options.reference.clone(), truth.compare(frame));
        let sheet = sheet(&truth, (scene.name.clone(), about), methods, last);
        sheets.push((fallback_name(fallback).to_owned(), layout::draw(&sheet)));
    }
    Ok(sheets)
}

/// Chooses the parts of a sheet and computes the scores. Each method is compared with the last method, and the only
/// method of a sheet is compared with the reference.
fn sheet(
    truth: &Truth<'_>,
    (title, about): (String, String),
    mut rows: Vec<(Method, ComparedFrame)>,
    reference: (Method, ComparedFrame),
) -> Sheet {
    let methods = rows.len();
    rows.push(reference);
    let last = (methods - 1).max(1);
    let steps: Vec<Vec<f32>> = rows[..last].iter().map(|(_, compared)| compared.change_to(&rows[last].1)).collect();
    let side = regions::side(truth.width, truth.height);
    let found = side.map_or(Vec::new(), |side| regions::choose(&steps, truth.width, truth.height, side));
    let part = |region: &regions::Region| Part {
        step: format!("{} against {}", rows[region.step].0, rows[last].0),
        rects: [region.rect, truth.counterpart(region.rect, regions::margin(region.rect.width))],
    };
    let parts: Vec<Part> = found.iter().map(part).collect();
    let whole = Rect { x: 0, y: 0, width: truth.width, height: truth.height };
    let row = |(i, (method, compared)): (usize, (Method, ComparedFrame))| Row {
        name: method.to_string(),
        about: about_of(&method),
        whole: truth.scores(&compared, [whole; 2]),
        parts: parts.iter().map(|p| truth.scores(&compared, p.rects)).collect(),
        compared,
        is_reference: i == methods,
    };
    let rows = rows.into_iter().enumerate().map(row).collect();
    Sheet { title, about, size: (truth.width, truth.height), parts, rows }
}

fn about_of(method: &Method) -> String {
    let name = super::plan::base_name(method);
    let about = Method::described().find(|(n, _)| *n == name).map_or("", |(_, about)| about);
    let rays = if method.samples() == 1 { "1 ray".to_owned() } else { format!("{} rays", method.samples()) };
    format!("{about}; {rays} a pixel")
}
