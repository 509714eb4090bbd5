//! Measures one scene: gets its reference, renders the rounds, and computes the numbers. A [`Subject`] and [`Options`]
//! go in, and a [`SceneReport`] comes out. [`super::scene`] calls it.

use std::collections::BTreeMap;
use std::rc::Rc;

use cyclopean_analysis::interval::student_t;

use super::CompareError;
use super::plan::{Configuration, Options, base_name};
use super::reference::Reference;
use super::report::{EyeReport, PairsReport, ReferenceReport, Rounds, Row, SceneReport, by_percent};
use super::subject::Subject;
use super::times::{self, Groups};
use super::{equal_time, ratios};
use crate::console::{Console, check_interrupted};
use crate::gpu::Gpu;
use crate::metrics::network::{self, NetworkError};
use crate::metrics::stereo::{Consistency, share_beyond};
use crate::metrics::{Fireflies, Judge, Moments, Networks, ReferenceAgreement};
use crate::picture::StereoPicture;
use crate::render::{FrameReport, Prepared, Settings};
use crate::scene::Fallback;

/// The measures of each eye in each round.
const MEASURES: [&str; 16] = [
    "mse",
    "rse",
    "relmse",
    "tonemapped_mse",
    "ssim",
    "flip",
    "reflection_ssim",
    "reflection_flip",
    "composite_mse",
    "composite_rse",
    "composite_tonemapped_mse",
    "fireflies",
    "lpips",
    "dists",
    "reflection_lpips",
    "reflection_dists",
];

type Measured = [Option<f64>; MEASURES.len()];

/// Measures one scene.
///
/// # Errors
/// [`CompareError`]. Then only the scene's reference is kept.
pub fn scene(
    gpu: &Rc<Gpu>,
    subject: &Subject,
    options: &Options,
    console: &Console,
) -> Result<SceneReport, CompareError> {
    let Subject { scene, view, camera } = subject;
    let (mut renderer, reference) = subject.reference(gpu, options, console)?;
    let masks = [0, 1].map(|eye| reference.mask(eye));
    let traced: usize = masks.iter().flatten().filter(|m| **m).count();
    if traced == 0 {
        return Err(CompareError::NoReflection(scene.name.clone()));
    }
    let networks = &options.networks;
    let judges = [0, 1].map(|eye| EyeJudge::new(&reference, eye, &masks[eye], scene.exposure, options));

    let agreement = ReferenceAgreement::new(&reference.pairs, reference.linear.eyes(), reference.again[0].eyes());
    let mut runs = Vec::new();
    for configuration in options.configurations(scene) {
        let settings = Settings { fallback: Some(configuration.fallback), ..options.settings.clone() };
        let prepared = renderer.prepare(camera, &configuration.method, &settings)?;
        runs.push(Run::new(configuration, prepared, &reference, &agreement));
    }
    rounds(&mut runs, &masks, (&judges, networks), options.seeds, &scene.name, console)?;
    // Asked after the last frame, so that the scene fails if there was a validation message about any frame.
    gpu.check_validation()?;

    let results: Vec<Row> = runs.into_iter().map(|run| run.row(&reference, &masks, networks)).collect();
    let baseline = base_name(&options.methods[0]);
    let mut left_out = Vec::new();
    let pairs = &reference.pairs;
    let share = |n: u64| (pairs.candidates > 0).then(|| n as f64 / pairs.candidates as f64);
    Ok(SceneReport {
        scene: scene.name.clone(),
        scene_sha256: scene.content_sha256.clone(),
        view: view.name.clone(),
        exposure: scene.exposure,
        reflective: traced as f64 / masks.iter().map(Vec::len).sum::<usize>() as f64,
        reference: ReferenceReport {
            key: reference.key.clone(),
            files: reference.folder.clone(),
            spp: reference.spp,
            variance: [0, 1].map(|eye| variance_of_two(&reference, eye, &masks[eye])),
        },
        pairs: PairsReport {
            candidates: pairs.candidates,
            used: pairs.pairs.len() as u64,
            undecided: share(pairs.undecided),
            different: share(pairs.different),
            floor: share_beyond(pairs, reference.again[0].eyes()),
        },
        equal_sample: ratios::equal_sample(&results, &baseline, &mut left_out),
        equal_time: equal_time::equal_time(&results, &baseline, &mut left_out),
        overhead: ratios::overhead(&results, &baseline, &mut left_out),
        left_out,
        baseline,
        results,
    })
}

/// Renders every configuration once in each round. The first round only warms up and is not measured.
fn rounds(
    runs: &mut [Run<'_>],
    masks: &[Vec<bool>; 2],
    (judges, networks): (&[EyeJudge; 2], &Networks),
    seeds: u32,
    scene: &str,
    console: &Console,
) -> Result<(), CompareError> {
    let count = runs.len();
    let mut bar = console.progress(scene, u64::from(seeds + 1) * count as u64);
    for round in 0..=seeds {
        for turn in 0..count {
            check_interrupted()?;
            let run = &mut runs[(round as usize + turn) % count];
            run.prepared.set_seed(round, 0);
            let frame = run.prepared.frame(&mut |_, _| check_interrupted())?;
            if round > 0 {
                run.add(frame, masks, (judges, networks))?;
            }
            bar.step(&run.configuration.method.to_string());
        }
    }
    Ok(())
}

/// One eye's reference, prepared for comparison with many frames. The reflection is judged over the pixels that trace,
/// and the composite over all pixels. Fireflies of the composite are counted among the pixels that trace.
struct EyeJudge {
    size: (usize, usize),
    reflection: Judge,
    composite: Judge,
    fireflies: Fireflies,
}

impl EyeJudge {
    fn new(reference: &Reference, eye: usize, mask: &[bool], exposure: f32, options: &Options) -> EyeJudge {
        let size = (reference.linear.width as usize, reference.linear.height as usize);
        let judge = |picture: &StereoPicture, mask: Vec<bool>| {
            Judge::new(size, &picture.eyes[eye], mask, exposure, options.pixels_per_degree)
        };
        let composite = judge(&reference.linear, vec![true; mask.len()]);
        let shown = composite.displayed(&reference.linear.eyes[eye]);
        EyeJudge {
            size,
            reflection: judge(&reference.reflection, mask.to_vec()),
            fireflies: Fireflies::new(size, &shown, mask.to_vec()),
            composite,
        }
    }

    /// The measures of a frame in the order of [`MEASURES`], and its number of fireflies.
    ///
    /// # Errors
    /// A network that cannot compare the pictures.
    fn measure(
        &self,
        reflection: &[[f32; 3]],
        composite: &[[f32; 3]],
        networks: &Networks,
    ) -> Result<(Measured, u64), NetworkError> {
        let shown = self.composite.displayed(composite);
        let shown_reflection = self.reflection.displayed(reflection);
        let scores = (
            self.reflection.of_displayed(reflection, &shown_reflection),
            self.composite.of_displayed(composite, &shown),
        );
        let (Some(r), Some(c)) = scores else { return Ok((Measured::default(), 0)) };
        let distances =
            |judge: &Judge, shown: &[[f32; 3]]| networks.distances(self.size, judge.reference_displayed(), shown);
        let [lpips, dists] = distances(&self.composite, &shown)?;
        let [reflection_lpips, reflection_dists] = distances(&self.reflection, &shown_reflection)?;
        let fireflies = self.fireflies.count(&shown);
        let measured = [
            Some(r.mse),
            r.rse,
            r.relmse,
            Some(r.tonemapped_mse),
            c.ssim,
            c.flip,
            r.ssim,
            r.flip,
            Some(c.mse),
            c.rse,
            Some(c.tonemapped_mse),
            self.fireflies.per_megapixel(fireflies),
            lpips,
            dists,
            reflection_lpips,
            reflection_dists,
        ];
        Ok((measured, fireflies))
    }
}

/// A configuration, and what the rounds so far have measured of it.
struct Run<'a> {
    configuration: Configuration,
    prepared: Prepared,
    groups: Vec<Groups>,
    passes: Vec<BTreeMap<String, f64>>,
    measured: [Vec<Measured>; 2],
    /// The moments of the reflection's channels over the pixels that trace, by eye.
    moments: [Moments; 2],
    consistency: Consistency<'a>,
    fireflies: u64,
    clamped: u64,
}

impl<'a> Run<'a> {
    fn new(
        configuration: Configuration,
        prepared: Prepared,
        reference: &'a Reference,
        agreement: &'a ReferenceAgreement,
    ) -> Run<'a> {
        Run {
            configuration,
            prepared,
            groups: Vec::new(),
            passes: Vec::new(),
            measured: [Vec::new(), Vec::new()],
            moments: [Moments::default(), Moments::default()],
            consistency: Consistency::new(&reference.pairs, agreement),
            fireflies: 0,
            clamped: 0,
        }
    }

    fn add(
        &mut self,
        frame: FrameReport,
        masks: &[Vec<bool>; 2],
        (judges, networks): (&[EyeJudge; 2], &Networks),
    ) -> Result<(), CompareError> {
        let (linear, reflection) = (self.prepared.linear()?, self.prepared.reflection()?);
        self.groups.push(times::groups(&frame.passes));
        self.passes.push(frame.passes.into_iter().map(|p| (p.name, p.ms)).collect());
        self.clamped += frame.counters.clamped;
        self.consistency.add(linear.eyes());
        // The eyes are measured in parallel. No frame is rendered meanwhile, so this disturbs no times.
        let eye = |eye: usize, moments: &mut Moments| {
            moments.add(masked(&reflection.eyes[eye], &masks[eye]));
            judges[eye].measure(&reflection.eyes[eye], &linear.eyes[eye], networks)
        };
        let [left, right] = &mut self.moments;
        let measured = std::thread::scope(|scope| {
            let other = scope.spawn(|| eye(1, right));
            let own = eye(0, left);
            [own, other.join().expect("metrics do not panic on pictures of one size")]
        });
        for (all, measured) in self.measured.iter_mut().zip(measured) {
            let (one, fireflies) = measured?;
            all.push(one);
            self.fireflies += fireflies;
        }
        Ok(())
    }

    fn row(self, reference: &Reference, masks: &[Vec<bool>; 2], networks: &Networks) -> Row {
        // A measure whose network was not named is left out; it is not null.
        let is_measured = |name: &str| network::measure_of(name).is_none_or(|m| networks.measures(m));
        let eye = |eye: usize| {
            let split = self.moments[eye].split(masked(&reference.reflection.eyes[eye], &masks[eye]));
            EyeReport {
                means: MEASURES
                    .iter()
                    .enumerate()
                    .filter(|(_, name)| is_measured(name))
                    .map(|(m, name)| ((*name).to_owned(), mean(&self.series(eye, m))))
                    .collect(),
                bias2: split.map(|s| s.bias2),
                variance: split.map(|s| s.variance),
                intervals: self.intervals(eye),
            }
        };
        let found = self.consistency.found();
        let systematic = found.and_then(|f| f.systematic);
        let over_seeds = self.consistency.over_seeds();
        Row {
            method: self.configuration.name.clone(),
            rendered_method: self.prepared.method().to_string(),
            spp: self.configuration.method.samples(),
            fallback: fallback_name(self.configuration.fallback).to_owned(),
            seeds: self.groups.len() as u32,
            ms: quantiles(&self.groups).map(|(name, q)| (name, q[1])).collect(),
            ms_quartiles: quantiles(&self.groups).map(|(name, q)| (name, [q[0], q[2]])).collect(),
            passes: quantiles(&self.passes).map(|(name, q)| (name, q[1])).collect(),
            left: eye(0),
            right: eye(1),
            systematic_inconsistency: systematic.map(|s| s.share),
            systematic_inconsistency_interval: over_seeds.as_ref().and_then(|o| o.share),
            systematic,
            systematic_unbiased: over_seeds.as_ref().map(|o| o.unbiased),
            systematic_over: systematic.map(|s| by_percent(s.over)),
            noise_variance: found.and_then(|f| f.noise_variance),
            noise_variance_interval: over_seeds.as_ref().and_then(|o| o.noise_variance),
            noise_variance_relative: found.and_then(|f| f.noise_variance_relative),
            noise_over: found.map(|f| by_percent(f.noise_over)),
            jackknife: over_seeds.map(|o| o.replicates),
            fireflies_total: self.fireflies,
            clamped: self.clamped,
            rounds: Rounds { measures: self.by_round(), ms: self.groups },
        }
    }

    /// The values of a measure by round. Empty where any of them is undefined.
    fn series(&self, eye: usize, measure: usize) -> Vec<f64> {
        let values: Option<Vec<f64>> = self.measured[eye].iter().map(|m| m[measure]).collect();
        values.unwrap_or_default()
    }

    fn intervals(&self, eye: usize) -> BTreeMap<String, [f64; 2]> {
        let interval = |m: usize| {
            let i = student_t(&self.series(eye, m), 0.95);
            Some([i.lo?, i.hi?])
        };
        MEASURES.iter().enumerate().filter_map(|(m, name)| Some(((*name).to_owned(), interval(m)?))).collect()
    }

    fn by_round(&self) -> BTreeMap<String, Vec<f64>> {
        let both = |m: usize| -> Vec<f64> {
            self.series(0, m).iter().zip(self.series(1, m)).map(|(l, r)| (l + r) / 2.0).collect()
        };
        MEASURES
            .iter()
            .enumerate()
            .map(|(m, name)| ((*name).to_owned(), both(m)))
            .filter(|(_, v)| !v.is_empty())
            .collect()
    }
}

/// The name of a fallback, as in the option `--fallback`.
pub(super) fn fallback_name(fallback: Fallback) -> &'static str {
    match fallback {
        Fallback::Black => "black",
        Fallback::Probe => "probe",
        Fallback::Environment => "environment",
    }
}

/// The channels of the pixels of a mask.
fn masked<'p>(values: &'p [[f32; 3]], mask: &'p [bool]) -> impl Iterator<Item = f64> + 'p {
    values.iter().zip(mask).filter(|(_, m)| **m).flat_map(|(v, _)| v.map(f64::from))
}

/// The variance of the reference: half the mean squared difference between the two references.
fn variance_of_two(reference: &Reference, eye: usize, mask: &[bool]) -> f64 {
    let values = |picture: &'_ StereoPicture| masked(&picture.eyes[eye], mask).collect::<Vec<_>>();
    let (a, b) = (values(&reference.reflection), values(&reference.again[1]));
    mean(&a.iter().zip(&b).map(|(a, b)| (a - b).powi(2) / 2.0).collect::<Vec<_>>()).unwrap_or(0.0)
}

fn mean(values: &[f64]) -> Option<f64> {
    crate::metrics::mean(values.iter().copied())
}

/// The first quartile, the median and the third quartile over the rounds, by name.
fn quantiles(rounds: &[BTreeMap<String, f64>]) -> impl Iterator<Item = (String, [f64; 3])> {
    let mut by_name: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for (name, ms) in rounds.iter().flatten() {
        by_name.entry(name.clone()).or_default().push(*ms);
    }
    by_name.into_iter().map(|(name, mut values)| {
        values.sort_by(f64::total_cmp);
        (name, ratios::quartiles(&values))
    })
}
