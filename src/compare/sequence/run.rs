//! Measures one scene along a path, frame by frame. Every configuration runs twice, with independent random numbers.
//! The name of a scene goes in and its results come out. [`super::compare`] calls it.

use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

use glam::DAffine3;

use super::SequenceOptions;
use super::report::{SequenceEqualTime, SequenceRow, SequenceScene};
use crate::compare::equal_time::Curve;
use crate::compare::plan::base_name;
use crate::compare::times::{self, Groups};
use crate::compare::{CompareError, ratios, reference, subject};
use crate::console::{Console, check_interrupted};
use crate::gpu::Gpu;
use crate::metrics::sequence::{EyeFrame, disagreement, flicker, noise_flicker, parts, previous_pixels};
use crate::metrics::{Pairs, mean, pairs};
use crate::picture::StereoPicture;
use crate::render::{Geometry, Method, Prepared, Renderer, Settings};
use crate::scene::{self, Eye, Fallback, HeadPath, StereoCamera, View};

/// The seeds of the two runs of each configuration, and those of the two references.
const SEEDS: [u32; 2] = [1, 2];
const REFERENCE_SEEDS: [u32; 2] = [1_000_001, 1_000_002];
/// The roughness from which on a surface does not count as glossy here.
const GLOSSY: f32 = 0.3;

/// The pictures of both runs of a configuration in one frame, or of both references.
type Runs = [StereoPicture; 2];

/// Compares on one scene.
///
/// # Errors
/// [`CompareError`].
pub fn scene(
    gpu: &Rc<Gpu>,
    name: &str,
    options: &SequenceOptions<'_>,
    console: &Console,
) -> Result<SequenceScene, CompareError> {
    let scene = Arc::new(scene::load_with(name, options.loading)?);
    let view = subject::view(&scene, options.view.as_deref())?.clone();
    let path = (options.path)(&scene, &view).map_err(CompareError::Path)?;
    let frames = path.frames_asked(options.frames).map_err(|e| CompareError::Path(e.to_string()))?;
    if frames < 2 {
        let name = &path.name;
        return Err(CompareError::Path(format!("path `{name}` has {frames} frame; a comparison needs two or more")));
    }
    let mut renderer = Renderer::new(gpu, Arc::clone(&scene))?;
    let settings = Settings { fallback: Some(Fallback::Black), ..options.settings.clone() };
    let camera = path.view(&view, 0).stereo_camera(settings.aspect());
    let mut truth = renderer.prepare(&camera, &options.reference, &settings)?;
    let mut all: Vec<Run> = Vec::new();
    for method in configurations(options) {
        let mut made = || renderer.prepare(&camera, &method, &settings);
        all.push(Run::new(method.clone(), [made()?, made()?]));
    }

    let mut bar = console.progress(&scene.name, u64::from(frames) * (1 + all.len() as u64));
    let mut last: Option<Frame> = None;
    for number in 0..frames {
        let at = PathFrame { path: &path, view: &view, number };
        at.draw(&mut truth, REFERENCE_SEEDS[1])?;
        let again = truth.reflection()?;
        at.draw(&mut truth, REFERENCE_SEEDS[0])?;
        let mut now = Frame::of(&truth, again, scene.places_at(path.time_of(number)))?;
        bar.step("reference");
        let count = all.len();
        now.runs = vec![None; count];
        for turn in 0..count {
            let which = (number as usize + turn) % count;
            now.runs[which] = Some(all[which].draw(&at)?);
            bar.step(&all[which].method.to_string());
        }
        if let Some(last) = &last {
            let previous_pixels = [0, 1].map(|eye| previous_pixels(now.eye_frame(eye), last.eye_frame(eye)));
            for (which, run) in all.iter_mut().enumerate() {
                run.add(which, &now, last, &previous_pixels);
            }
        }
        last = Some(now);
    }
    drop(bar);
    // Asked after the last frame, so that the scene fails if there was a validation message about any frame.
    gpu.check_validation()?;

    let cuts: Vec<u32> = (0..frames).filter(|f| path.is_cut(*f)).collect();
    let mut results: Vec<SequenceRow> = all.into_iter().map(|run| run.row(&cuts)).collect();
    let baseline = base_name(&options.methods[0]);
    equal_time(&mut results, &baseline);
    Ok(SequenceScene {
        scene: scene.name.clone(),
        scene_sha256: scene.content_sha256.clone(),
        view: view.name.clone(),
        frames,
        rate_hz: path.rate_hz,
        cuts,
        baseline,
        results,
    })
}

/// Every method with every sample count, each once.
fn configurations(options: &SequenceOptions<'_>) -> Vec<Method> {
    let mut all: Vec<Method> = Vec::new();
    for (method, spp) in options.methods.iter().flat_map(|m| options.spp.iter().map(move |spp| (m, *spp))) {
        let method = method.clone().with_samples(Some(spp));
        if !all.contains(&method) {
            all.push(method);
        }
    }
    all
}

/// A frame of the path: the path, the view that it begins at, and the number of the frame.
struct PathFrame<'a> {
    path: &'a HeadPath,
    view: &'a View,
    number: u32,
}

impl PathFrame<'_> {
    fn draw(&self, prepared: &mut Prepared, seed: u32) -> Result<Groups, CompareError> {
        check_interrupted()?;
        let aspect = prepared.settings().aspect();
        prepared.set_time(self.path.time_of(self.number))?;
        prepared.set_camera(&self.path.view(self.view, self.number).stereo_camera(aspect));
        prepared.set_seed(seed, self.number);
        let report = prepared.frame(&mut |_, _| check_interrupted())?;
        Ok(times::groups(&report.passes))
    }
}

/// What a frame showed: its geometry, its references, and the pictures of all configurations.
struct Frame {
    camera: StereoCamera,
    places: Vec<DAffine3>,
    geometry: Geometry,
    /// The reflections of both references.
    references: Runs,
    pairs: Pairs,
    size: (usize, usize),
    /// The reflections of each configuration, and its composites.
    runs: Vec<Option<[Runs; 2]>>,
}

impl Frame {
    /// The frame whose first reference `truth` has just drawn. `again` has the reflections of the second reference.
    fn of(truth: &Prepared, again: StereoPicture, places: Vec<DAffine3>) -> Result<Frame, CompareError> {
        let (linear, reflection, geometry) = (truth.linear()?, truth.reflection()?, truth.geometry()?);
        let error = truth.standard_error(&reflection)?.unwrap_or_else(|| reference::black(&reflection));
        let size = (linear.width as usize, linear.height as usize);
        let by_reference = pairs::Reference { linear: linear.eyes(), error: error.eyes() };
        let pairs = Pairs::choose(&reference::surfaces_of(truth, &geometry, size), &by_reference);
        let (camera, references) = (*truth.camera(), [reflection, again]);
        Ok(Frame { camera, places, geometry, references, pairs, size, runs: Vec::new() })
    }

    fn eye_frame(&self, eye: usize) -> EyeFrame<'_> {
        let surfaces = reference::surfaces(&self.geometry.eyes[eye]);
        EyeFrame { camera: self.camera.eye(Eye::BOTH[eye]), surfaces, places: &self.places, size: self.size }
    }
}

/// A configuration, and what the frames so far have measured of it.
struct Run {
    method: Method,
    prepared: [Prepared; 2],
    groups: Vec<Groups>,
    by_frame: BTreeMap<&'static str, Vec<Option<f64>>>,
}

impl Run {
    fn new(method: Method, prepared: [Prepared; 2]) -> Run {
        Run { method, prepared, groups: Vec::new(), by_frame: BTreeMap::new() }
    }

    /// Draws a frame in both runs. Returns the reflections and the composites.
    fn draw(&mut self, at: &PathFrame<'_>) -> Result<[Runs; 2], CompareError> {
        for (prepared, seed) in self.prepared.iter_mut().zip(SEEDS) {
            self.groups.push(at.draw(prepared, seed)?);
        }
        let [a, b] = &self.prepared;
        Ok([[a.reflection()?, b.reflection()?], [a.linear()?, b.linear()?]])
    }

    fn add(&mut self, which: usize, now: &Frame, last: &Frame, previous_pixels: &[Vec<Option<u32>>; 2]) {
        let (Some([own, shown]), Some([own_before, _])) = (&now.runs[which], &last.runs[which]) else { return };
        let delta = self.prepared[0].settings().delta_roughness;
        let mut sums: BTreeMap<&'static str, Vec<Option<f64>>> = BTreeMap::new();
        for (eye, previous) in previous_pixels.iter().enumerate() {
            let g = &now.geometry.eyes[eye];
            let glossy: Vec<bool> =
                g.traced.iter().zip(&g.roughness).map(|(t, r)| *t && (delta..GLOSSY).contains(r)).collect();
            let uncovered: Vec<bool> = g.traced.iter().zip(previous).map(|(t, b)| *t && b.is_none()).collect();
            let of = |mask: &[bool]| parts(eye_of(own, eye), eye_of(&now.references, eye), mask);
            let all = of(&g.traced);
            let flickers = [0, 1].map(|run: usize| {
                let here = judged(&own[run], now, eye);
                let there = judged(&own_before[run], last, eye);
                flicker(here, there, previous, &g.traced)
            });
            let found = [
                ("mse", all.map(|p| p.mse)),
                ("bias2", all.map(|p| p.bias2)),
                ("variance", all.map(|p| p.variance)),
                ("glossy_mse", of(&glossy).map(|p| p.mse)),
                ("uncovered_mse", of(&uncovered).map(|p| p.mse)),
                ("flicker", flickers[0].zip(flickers[1]).map(|(a, b)| (a + b) / 2.0)),
                ("noise_flicker", noise_flicker(eye_of(own, eye), eye_of(own_before, eye), previous, &g.traced)),
            ];
            for (name, value) in found {
                sums.entry(name).or_default().push(value);
            }
        }
        let between = disagreement([shown[0].eyes(), shown[1].eyes()], &now.pairs.pairs, now.pairs.epsilon);
        sums.insert("lasting_contrast2", vec![between.map(|d| d.lasting)]);
        sums.insert("noise", vec![between.map(|d| d.noise)]);
        for (name, eyes) in sums {
            self.by_frame.entry(name).or_default().push(mean(eyes.into_iter().flatten()));
        }
    }

    fn row(self, cuts: &[u32]) -> SequenceRow {
        let means =
            self.by_frame.iter().map(|(name, values)| (*name, mean(values.iter().flatten().copied()))).collect();
        let lag_frames = cuts.first().and_then(|cut| {
            let end = cuts.get(1).map_or(usize::MAX, |next| *next as usize - 1);
            let mse = &self.by_frame["mse"];
            // The first frame has no value, so frame n has index n − 1.
            lag(mse.get(*cut as usize - 1..end.min(mse.len()))?)
        });
        let mut by_name: BTreeMap<String, Vec<f64>> = BTreeMap::new();
        for (name, ms) in self.groups.iter().flatten() {
            by_name.entry(name.clone()).or_default().push(*ms);
        }
        let median = |mut values: Vec<f64>| {
            values.sort_by(f64::total_cmp);
            ratios::quartiles(&values)[1]
        };
        SequenceRow {
            method: base_name(&self.method),
            rendered_method: self.prepared[0].method().to_string(),
            spp: self.method.samples(),
            ms: by_name.into_iter().map(|(name, values)| (name, median(values))).collect(),
            means,
            lag_frames,
            by_frame: self.by_frame,
            equal_time: None,
        }
    }
}

/// One eye's picture of a run, and of both references of the frame.
fn judged<'a>(run: &'a StereoPicture, frame: &'a Frame, eye: usize) -> [&'a [[f32; 3]]; 3] {
    let [first, second] = eye_of(&frame.references, eye);
    [&run.eyes[eye], first, second]
}

/// One eye's pictures of both runs.
fn eye_of(runs: &Runs, eye: usize) -> [&[[f32; 3]]; 2] {
    runs.each_ref().map(|run| run.eyes[eye].as_slice())
}

/// The number of frames until an error has lost half of what it loses in total. Its final value is taken to be the mean
/// of its last quarter.
fn lag(mse: &[Option<f64>]) -> Option<u32> {
    let values: Vec<f64> = mse.iter().flatten().copied().collect();
    let first = *values.first()?;
    let end = mean(values[values.len() - values.len().div_ceil(4)..].iter().copied())?;
    let half = (first + end) / 2.0;
    if first <= end {
        return Some(0);
    }
    values.iter().position(|v| *v <= half).map(|n| n as u32)
}

fn equal_time(rows: &mut [SequenceRow], baseline: &str) {
    let point = |row: &SequenceRow| -> Option<(f64, f64)> {
        let point = (row.ms.get("total")?.ln(), row.means.get("mse").copied().flatten()?.ln());
        (point.0.is_finite() && point.1.is_finite()).then_some(point)
    };
    let points: Vec<(f64, f64)> = rows.iter().filter(|r| r.method == baseline).filter_map(point).collect();
    let curve = Curve::new(points);
    for row in rows.iter_mut().filter(|r| r.method != baseline) {
        row.equal_time = point(row).and_then(|(time, error)| {
            let (of_baseline, extrapolated) = curve.at(time)?;
            let (mse, baseline_mse) = (error.exp(), of_baseline.exp());
            Some(SequenceEqualTime { mse, baseline_mse, ratio: mse / baseline_mse, extrapolated })
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lag_counts_frames_until_half_of_the_excess_is_gone() {
        let some = |values: &[f64]| values.iter().map(|v| Some(*v)).collect::<Vec<_>>();
        assert_eq!(lag(&some(&[9.0, 8.0, 5.0, 2.0, 1.0, 1.0, 1.0, 1.0])), Some(2));
        assert_eq!(lag(&some(&[1.0, 1.0, 1.0, 1.0])), Some(0));
        assert_eq!(lag(&[]), None);
    }
}
