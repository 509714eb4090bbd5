//! Compares methods of ambient occlusion on one scene: by rounds, against the picture by rays, and along a path. The
//! name of a scene goes in and its results come out. [`super::compare`] and `paper` call it.

use std::rc::Rc;
use std::sync::Arc;

use super::AoOptions;
use super::configuration::{ORACLE_SEED, Run, Visibility, configurations, method, places, slices, total, visibility};
use super::kept::KeptAoScene;
use super::path;
use super::report::{AoRow, AoScene, Oracle};
use crate::compare::{CompareError, subject};
use crate::console::{Console, check_interrupted};
use crate::gpu::Gpu;
use crate::metrics::{ambient, mean};
use crate::render::{Ao, AoSettings, Prepared, Renderer, Settings};
use crate::scene::{Scene, StereoCamera, View};

/// Compares on one scene, or takes the results that `options.keep` holds of it.
///
/// # Errors
/// [`CompareError`].
pub fn scene(gpu: &Rc<Gpu>, name: &str, options: &AoOptions, console: &Console) -> Result<AoScene, CompareError> {
    let scene = options.scenes.load(name)?;
    let view = subject::view(&scene, options.view.as_deref())?;
    let kept =
        options.keep.as_ref().map(|folder| KeptAoScene::new(folder, gpu, (&scene, view), options)).transpose()?;
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
    // Asked after the last frame, so that the scene fails if there was a validation message about any frame.
    gpu.check_validation()?;

    let mono: Vec<f64> = runs.iter().find(|r| r.ao.method == Ao::Mono).map_or(Vec::new(), |r| r.ms.clone());
    let pixels = f64::from(options.settings.width) * f64::from(options.settings.height);
    let rows: Vec<AoRow> = runs.iter().map(|run| run.row(&mono, 2.0 * pixels)).collect();
    // The threshold that was asked for comes first and the others after it, so they are sorted.
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
            trace: oracle.tracer().map(str::to_owned),
            inconsistency: ambient::inconsistency(&pairs, slices(&truth)),
            mean_visibility: mean(truth.iter().flatten().map(|v| f64::from(*v))),
        },
        path,
    })
}

fn prepare(
    renderer: &mut Renderer,
    camera: &StereoCamera,
    settings: &Settings,
    ao: AoSettings,
) -> Result<Prepared, CompareError> {
    Ok(renderer.prepare(camera, &method(), &Settings { ao, ..settings.clone() })?)
}

/// Renders every configuration once in each round. Each round begins one configuration later than the one before. The
/// first round only warms up and is not measured.
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
