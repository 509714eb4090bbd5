//! Cases of the history of earlier frames: when there is none, when the head jumps or the eyes change, when light
//! moves, and after very many frames.

use std::sync::Arc;

use glam::{DQuat, DVec3, Vec3};

use crate::console::check_interrupted;
use crate::picture::StereoPicture;
use crate::render::{Prepared, RenderError, Settings};
use crate::scene::motion::{Motion, Path};
use crate::scene::{Scene, View, head_path};

use super::bench::Bench;
use super::case::{Bound, Case, Worst};
use super::measure::{differing_percent, relative_squared_error};
use super::shapes::{glowing, hall, look, material, place, plane, scene, settings, sphere, upright};

pub const CASES: &[Case] = &[
    Case {
        name: "history-first-frame",
        hazard: "a history is used where there is none: first frame, after forgetting, after a change of size",
        checks: "pixels that differ from the method without history by more than 0.2 %, the rounding of images",
        unit: "% of the pixels",
        bound: Bound::AtMost(0.0),
        run: first_frame,
    },
    Case {
        name: "history-teleport",
        hazard: "the history is stale after a jump of the head or a change of the distance between the eyes",
        checks: "error of the third frame after it, over that of a third frame without earlier ones",
        unit: "ratio",
        bound: Bound::AtMost(1.1),
        run: teleport,
    },
    Case {
        name: "history-moving-light",
        hazard: "light that moves or jumps leaves a trail",
        checks: "error of the reflection of a moving, glowing ball, over that of the method without history",
        unit: "ratio",
        bound: Bound::AtMost(1.2),
        run: moving_light,
    },
    Case {
        name: "history-endless",
        hazard: "the history grows stale or drifts over very many frames",
        checks: "error at rest after 1000 frames of a moving head, over that at rest without them",
        unit: "ratio",
        bound: Bound::AtMost(1.1),
        run: endless,
    },
];

/// The methods with history, each with its counterpart without one.
const METHODS: [(&str, &str); 3] =
    [("sssr-temporal", "sssr"), ("stereo-temporal", "stereo"), ("stereo-hybrid-temporal", "stereo-hybrid")];
const SEED: u32 = 5;
/// The largest relative difference by two roundings to half precision.
const ROUNDING: f64 = 2e-3;

fn small() -> Settings {
    Settings { edge_fade: 0.1, ..settings(64, 40) }
}

fn prepare(bench: &mut Bench, scene: &Arc<Scene>, method: &str, settings: &Settings) -> Result<Prepared, RenderError> {
    let camera = scene.views[0].stereo_camera(settings.aspect());
    bench.prepare(scene, method, settings, &camera)
}

/// Renders one frame from a view at a time. A value that is not finite is an error.
fn frame(prepared: &mut Prepared, view: &View, time_s: f64, number: u32) -> Result<(), RenderError> {
    prepared.set_time(time_s)?;
    prepared.set_camera(&view.stereo_camera(small().aspect()));
    prepared.set_seed(SEED, number);
    prepared.frame(&mut |_, _| check_interrupted())?;
    Ok(())
}

/// The reflection after these frames. The last frames have the same random numbers, however many were before them.
fn after(
    bench: &mut Bench,
    scene: &Arc<Scene>,
    method: &str,
    frames: &[(View, f64)],
) -> Result<StereoPicture, RenderError> {
    let mut prepared = prepare(bench, scene, method, &small())?;
    for (number, (view, time_s)) in (0u32..).zip(frames) {
        frame(&mut prepared, view, *time_s, number.wrapping_sub(frames.len() as u32))?;
    }
    Ok(prepared.reflection()?)
}

/// The reference's reflection, from a view at a time.
fn truth(bench: &mut Bench, scene: &Arc<Scene>, moment: &(View, f64)) -> Result<StereoPicture, RenderError> {
    after(bench, scene, "path-traced@128", std::slice::from_ref(moment))
}

fn first_frame(bench: &mut Bench) -> Result<Worst, RenderError> {
    let scene = Arc::new(hall(0.2, 0.063));
    let view = scene.views[0].clone();
    let mut worst = Worst::largest();
    for (with, without) in METHODS {
        let (mut prepared, mut plain) =
            (prepare(bench, &scene, with, &small())?, prepare(bench, &scene, without, &small())?);
        frame(&mut plain, &view, 0.0, 0)?;
        let expected = plain.linear()?;
        for what in ["first", "after forgetting"] {
            prepared.forget();
            frame(&mut prepared, &view, 0.0, 0)?;
            let percent = differing_percent(&prepared.linear()?, &expected, ROUNDING);
            worst.include(percent, format!("{what}, {with}"));
            frame(&mut prepared, &view, 0.0, 1)?;
        }
        // A view of another size begins without a history.
        let wide = Settings { width: 48, height: 64, ..small() };
        let (mut prepared, mut plain) = (prepare(bench, &scene, with, &wide)?, prepare(bench, &scene, without, &wide)?);
        for view in [&mut prepared, &mut plain] {
            view.set_seed(SEED, 0);
            view.frame(&mut |_, _| check_interrupted())?;
        }
        let percent = differing_percent(&prepared.linear()?, &plain.linear()?, ROUNDING);
        worst.include(percent, format!("another size, {with}"));
    }
    Ok(worst)
}

fn teleport(bench: &mut Bench) -> Result<Worst, RenderError> {
    let scene = Arc::new(hall(0.25, 0.063));
    let here = scene.views[0].clone();
    let far = View { position: here.position + DVec3::new(1.6, 0.3, -0.4), ..here.clone() };
    let about = View { world_from_view: here.world_from_view * DQuat::from_rotation_y(0.5), ..here.clone() };
    let eyes = |ipd_m: f64| View { ipd_m, ..here.clone() };
    let mut worst = Worst::largest();
    for (what, there) in [("jump", far), ("turn", about), ("eyes 0.2 m apart", eyes(0.2)), ("eyes in one", eyes(0.0))] {
        let truth = truth(bench, &scene, &(there.clone(), 0.0))?;
        let past = vec![(here.clone(), 0.0); 8];
        let then = vec![(there, 0.0); 3];
        for (method, _) in METHODS {
            let mut error = |frames: &[(View, f64)]| -> Result<f64, RenderError> {
                Ok(relative_squared_error(&after(bench, &scene, method, frames)?, &truth))
            };
            let (with, without) = (error(&[past.clone(), then.clone()].concat())?, error(&then)?);
            worst.include(with / without, format!("{what}, {method}: {with:.4} instead of {without:.4}"));
        }
    }
    Ok(worst)
}

/// A polished floor in front of a dark wall, and a glowing ball between them that moves to and fro.
fn lantern() -> Scene {
    let ball = place([0.3, 0.3, 0.3], DQuat::IDENTITY, [0.0, 0.35, -1.5]);
    let parts = vec![
        (plane(2), material(0.15), place([6.0, 1.0, 6.0], DQuat::IDENTITY, [0.0, 0.0, 0.0])),
        (plane(2), glowing(Vec3::splat(0.05)), place([40.0, 1.0, 40.0], upright(), [0.0, 0.0, -5.0])),
        (sphere(16), glowing(Vec3::new(0.9, 0.6, 0.2)), ball),
    ];
    let mut scene = scene(parts, 0.0, look(DVec3::new(0.0, 0.8, 1.2), DVec3::new(0.0, 0.2, -1.5)));
    let path = Path::Sway { offset_m: DVec3::new(1.5, 0.0, 0.0), period_s: 4.0 };
    scene.motions.push(Motion { instances: vec![2], rest: vec![ball], path });
    scene
}

fn moving_light(bench: &mut Bench) -> Result<Worst, RenderError> {
    let scene = Arc::new(lantern());
    let view = scene.views[0].clone();
    let moving: Vec<f64> = (0..12).map(|i| f64::from(i) / 60.0).collect();
    let jumping: Vec<f64> = (0..12).map(|i| if i < 11 { 0.0 } else { 1.0 }).collect();
    let mut worst = Worst::largest();
    for (what, times) in [("moving", moving), ("jumping", jumping)] {
        let frames: Vec<(View, f64)> = times.into_iter().map(|time_s| (view.clone(), time_s)).collect();
        let truth = truth(bench, &scene, &frames[11])?;
        for (with, without) in METHODS {
            let mut error = |method: &str| -> Result<f64, RenderError> {
                Ok(relative_squared_error(&after(bench, &scene, method, &frames)?, &truth))
            };
            let (kept, plain) = (error(with)?, error(without)?);
            worst.include(kept / plain, format!("{what}, {with}: {kept:.4}, without history {plain:.4}"));
        }
    }
    Ok(worst)
}

/// The number of frames in which the head moves, and of those after that in which it rests.
const MOVING: u32 = 1000;
const RESTING: u32 = 32;

fn endless(bench: &mut Bench) -> Result<Worst, RenderError> {
    let scene = Arc::new(hall(0.25, 0.063));
    let view = scene.views[0].clone();
    let truth = truth(bench, &scene, &(view.clone(), 0.0))?;
    let mut worst = Worst::largest();
    let method = "stereo-temporal";
    let mut error = |moving: u32| -> Result<f64, RenderError> {
        let mut prepared = prepare(bench, &scene, method, &small())?;
        for number in 0..moving + RESTING {
            // The head goes through its path four times in a thousand frames.
            let at = if number < moving { head_path::sway(&view, f64::from(number) / 250.0) } else { view.clone() };
            // The random numbers at rest are the same, however long the head moved.
            frame(&mut prepared, &at, 0.0, number.wrapping_sub(moving))?;
        }
        Ok(relative_squared_error(&prepared.reflection()?, &truth))
    };
    let (with, without) = (error(MOVING)?, error(0)?);
    worst.include(with / without, format!("{with:.5} after {MOVING} frames, {without:.5} at rest alone"));
    Ok(worst)
}
