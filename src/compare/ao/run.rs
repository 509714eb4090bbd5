//! One scene: its rounds, its oracle, its path.

use std::collections::BTreeMap;
use std::rc::Rc;
use std::sync::Arc;

use super::AoOptions;
use super::kept::Kept;
use super::path;
use super::report::{AoRow, AoScene, Oracle};
use crate::compare::{CompareError, ratios, reference, subject};
use crate::console::{Console, check_interrupted};
use crate::gpu::{Gpu, PassTime};
use crate::metrics::{ambient, mean};
use crate::render::{Ao, AoSettings, Method, Prepared, Renderer, Settings, median_of_sorted};
use crate::scene::{Scene, StereoCamera, View};

/// Thresholds of the sweep: the seed's figure 11 and beyond.
const THRESHOLDS: [f32; 6] = [0.005, 0.01, 0.02, 0.03, 0.05, 0.1];
/// Random numbers of the oracle, far from the rounds'.
pub const ORACLE_SEED: u32 = 1_000_001;

/// Visibility by eye.
pub type Visibility = [Vec<f32>; 2];

/// Compares on one scene, or takes what `options.keep` holds of it.
///
/// # Errors
/// [`CompareError`].
pub fn scene(gpu: &Rc<Gpu>, name: &str, options: &AoOptions, console: &Console) -> Result<AoScene, CompareError> {
    let scene = options.scenes.load(name)?;
    let view = subject::view(&scene, options.view.as_deref())?;
    let kept = options.keep.as_ref().map(|folder| Kept::new(folder, gpu, (&scene, view), options)).transpose()?;
    if let Some(found) = kept.as_ref().and_then(|kept| kept.find(console)) {
        return Ok(found);
    }
    let found = measure(gpu, (&scene, view), options, console)?;
    kept.map_or(Ok(()), |kept| kept.keep(&found, console))?;
    Ok(found)
}

fn measure(
    gpu: &Rc<Gpu>,
    (scene, view): (&Arc<Scene>, &View),
    options: &AoOptions,
    console: &Console,
) -> Result<AoScene, CompareError> {
    let camera = view.stereo_camera(options.settings.aspect());
    let mut renderer = Renderer::new(gpu, Arc::clone(scene))?;

    let mut runs = Vec::new();
    for ao in configurations(options.settings.ao) {
        runs.push(Run::new(ao, prepare(&mut renderer, &camera, &options.settings, ao)?));
    }
    let rays = AoSettings { method: Ao::RayTraced, ..options.settings.ao };
    let mut oracle = prepare(&mut renderer, &camera, &options.settings, rays)?;
    oracle.set_seed(ORACLE_SEED, 0);
    let passes = oracle.ambient_frame(&mut |_, _| check_interrupted())?;
    let truth = visibility(&oracle)?;
    let pairs = places(&oracle)?;

    rounds(&mut runs, (&pairs, &truth), options.seeds, &scene.name, console)?;
    let path = match options.poses {
        0 => None,
        poses => Some(path::along(&mut runs, view, poses, console)?),
    };
    // After the last frame, so that a message about any of them refuses the scene's numbers.
    gpu.check_validation()?;

    let mono: Vec<f64> = runs.iter().find(|r| r.ao.method == Ao::Mono).map_or(Vec::new(), |r| r.ms.clone());
    let pixels = f64::from(options.settings.width) * f64::from(options.settings.height);
    let rows: Vec<AoRow> = runs.iter().map(|run| run.row(&mono, 2.0 * pixels)).collect();
    // What was asked for stands in front, the sweep's other thresholds behind it.
    let mut thresholds: Vec<AoRow> = rows.iter().filter(|r| r.method.is_adaptive()).cloned().collect();
    thresholds.sort_by(|a, b| a.method.name().cmp(b.method.name()).then(a.threshold.total_cmp(&b.threshold)));
    Ok(AoScene {
        scene: scene.name.clone(),
        scene_sha256: scene.content_sha256.clone(),
        view: view.name.clone(),
        pairs: pairs.len() as u64,
        paired: pairs.len() as f64 / pixels,
        methods: rows.into_iter().take(Ao::OF_VIEWS.len()).collect(),
        thresholds,
        ray_traced: Oracle {
            ms: total(&passes),
            trace: oracle.way().map(str::to_owned),
            inconsistency: ambient::inconsistency(&pairs, slices(&truth)),
            mean_visibility: mean(truth.iter().flatten().map(|v| f64::from(*v))),
        },
        path,
    })
}

/// Every method at the threshold that was asked for, then the adaptive ones at the sweep's.
pub fn configurations(asked: AoSettings) -> Vec<AoSettings> {
    let mut all: Vec<AoSettings> = Ao::OF_VIEWS.map(|method| AoSettings { method, ..asked }).to_vec();
    for method in Ao::OF_VIEWS.into_iter().filter(|ao| ao.is_adaptive()) {
        let others = THRESHOLDS.into_iter().filter(|t| *t != asked.threshold);
        all.extend(others.map(|threshold| AoSettings { method, threshold, ..asked }));
    }
    all
}

/// Any method would do: only what stands before the reflections is drawn.
pub fn method() -> Method {
    Method::parse("sssr").expect("the baseline exists")
}

fn prepare(
    renderer: &mut Renderer,
    camera: &StereoCamera,
    settings: &Settings,
    ao: AoSettings,
) -> Result<Prepared, CompareError> {
    Ok(renderer.prepare(camera, &method(), &Settings { ao, ..settings.clone() })?)
}

/// Every configuration once a round, each round beginning one later; the first round only warms up.
fn rounds(
    runs: &mut [Run],
    (pairs, truth): (&[[u32; 2]], &Visibility),
    seeds: u32,
    scene: &str,
    console: &Console,
) -> Result<(), CompareError> {
    let count = runs.len();
    let mut bar = console.progress(scene, u64::from(seeds + 1) * count as u64);
    for round in 0..=seeds {
        let mut shown: Vec<Option<Visibility>> = vec![None; count];
        for turn in 0..count {
            check_interrupted()?;
            let at = (round as usize + turn) % count;
            let run = &mut runs[at];
            run.prepared.set_seed(round, 0);
            let passes = run.prepared.ambient_frame(&mut |_, _| check_interrupted())?;
            shown[at] = Some(visibility(&run.prepared)?);
            if round > 0 {
                run.add_times(&passes)?;
            }
            bar.step(run.ao.method.name());
        }
        if round > 0 {
            let fsa = runs.iter().position(|r| r.ao.method == Ao::Fsa).and_then(|i| shown[i].clone());
            for (run, shown) in runs.iter_mut().zip(shown) {
                if let (Some(shown), Some(fsa)) = (shown, &fsa) {
                    run.inconsistency.push(ambient::inconsistency(pairs, slices(&shown)));
                    run.mae_fsa.push(ambient::mean_absolute_error(slices(&shown), slices(fsa)));
                    run.mae_ray_traced.push(ambient::mean_absolute_error(slices(&shown), slices(truth)));
                }
            }
        }
    }
    Ok(())
}

/// A configuration on its way through the rounds.
pub struct Run {
    pub ao: AoSettings,
    pub prepared: Prepared,
    ms: Vec<f64>,
    passes: BTreeMap<String, Vec<f64>>,
    inconsistency: Vec<Option<f64>>,
    mae_fsa: Vec<Option<f64>>,
    mae_ray_traced: Vec<Option<f64>>,
    /// Pixels worked on again.
    again: Vec<Option<f64>>,
}

impl Run {
    fn new(ao: AoSettings, prepared: Prepared) -> Run {
        Run {
            ao,
            prepared,
            ms: Vec::new(),
            passes: BTreeMap::new(),
            inconsistency: Vec::new(),
            mae_fsa: Vec::new(),
            mae_ray_traced: Vec::new(),
            again: Vec::new(),
        }
    }

    fn add_times(&mut self, passes: &[PassTime]) -> Result<(), CompareError> {
        self.ms.push(total(passes));
        for pass in of_ao(passes) {
            self.passes.entry(pass.name.clone()).or_default().push(pass.ms);
        }
        self.again.push(self.prepared.ambient_pixels_again()?.map(f64::from));
        Ok(())
    }

    fn row(&self, mono: &[f64], pixels: f64) -> AoRow {
        let [low, ms, high] = quartiles(self.ms.clone());
        AoRow {
            method: self.ao.method,
            threshold: self.ao.threshold,
            ms,
            ms_quartiles: [low, high],
            ratio: quartiles(self.ms.iter().zip(mono).map(|(own, mono)| own / mono).collect()),
            passes: self.passes.iter().map(|(name, ms)| (name.clone(), median(ms.clone()))).collect(),
            inconsistency: mean_of(&self.inconsistency),
            mae_fsa: mean_of(&self.mae_fsa),
            mae_ray_traced: mean_of(&self.mae_ray_traced),
            again: mean_of(&self.again).map(|n| n / pixels),
        }
    }
}

/// `None` where any is undefined, or there is none.
pub fn mean_of(values: &[Option<f64>]) -> Option<f64> {
    mean(values.iter().copied().collect::<Option<Vec<f64>>>()?)
}

fn quartiles(mut values: Vec<f64>) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    ratios::quartiles(&values)
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    median_of_sorted(&values)
}

fn of_ao(passes: &[PassTime]) -> impl Iterator<Item = &PassTime> {
    passes.iter().filter(|p| p.name.starts_with("ao_"))
}

fn total(passes: &[PassTime]) -> f64 {
    of_ao(passes).map(|p| p.ms).sum()
}

/// Of the last frame.
///
/// # Errors
/// What the device said.
pub fn visibility(prepared: &Prepared) -> Result<Visibility, CompareError> {
    Ok(prepared.ambient_visibility()?.expect("prepared with ambient occlusion"))
}

pub fn slices(of: &Visibility) -> [&[f32]; 2] {
    of.each_ref().map(Vec::as_slice)
}

/// The pairs of the last frame's places.
///
/// # Errors
/// What the device said.
pub fn places(prepared: &Prepared) -> Result<Vec<[u32; 2]>, CompareError> {
    let settings = prepared.settings();
    let geometry = prepared.geometry()?;
    let size = (settings.width as usize, settings.height as usize);
    Ok(ambient::places(&reference::surfaces_of(prepared, &geometry, size)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_method_is_compared_and_the_adaptive_ones_at_every_threshold() {
        let asked = AoSettings { threshold: 0.04, ..AoSettings::default() };
        let all = configurations(asked);
        let names: Vec<Ao> = all[..4].iter().map(|ao| ao.method).collect();
        assert_eq!(names, Ao::OF_VIEWS);
        assert!(all[..4].iter().all(|ao| ao.threshold == 0.04));
        for method in [Ao::Variant1, Ao::Variant2] {
            let swept: Vec<f32> = all[4..].iter().filter(|ao| ao.method == method).map(|ao| ao.threshold).collect();
            assert_eq!(swept, THRESHOLDS);
        }
        // The threshold that was asked for is measured once.
        assert_eq!(configurations(AoSettings::default()).len(), 4 + 2 * (THRESHOLDS.len() - 1));
    }
}
