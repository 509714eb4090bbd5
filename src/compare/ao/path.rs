//! The methods along a path of the head: the seed's figure 10.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use super::report::{AoAlong, AoPath};
use super::run::{Run, mean_of, places, slices, visibility};
use crate::compare::CompareError;
use crate::console::{Console, check_interrupted};
use crate::metrics::ambient;
use crate::render::Ao;
use crate::scene::View;

/// How far the head moves to each side and forwards, metres, and turns to each side, radians: as somebody moves who
/// stands and looks around.
const ASIDE_M: f64 = 0.25;
const FORWARDS_M: f64 = 0.25;
const TURN_RAD: f64 = 0.15;

/// Renders each method at each pose; the pose's number is its seed. The adaptive methods' sweep is left out.
///
/// # Errors
/// What the device said, or Ctrl-C.
pub fn along(runs: &mut [Run], view: &View, poses: u32, console: &Console) -> Result<AoPath, CompareError> {
    let runs = &mut runs[..Ao::OF_VIEWS.len()];
    let mut bar = console.progress("path", u64::from(poses));
    let nothing = |run: &Run| AoAlong {
        method: run.ao.method,
        mean_inconsistency: None,
        mean_mae_fsa: None,
        inconsistency: Vec::new(),
        mae_fsa: Vec::new(),
    };
    let mut methods: Vec<AoAlong> = runs.iter().map(nothing).collect();
    for pose in 0..poses {
        check_interrupted()?;
        let mut shown = Vec::new();
        for run in runs.iter_mut() {
            let aspect = run.prepared.settings().aspect();
            run.prepared.set_camera(&at(view, f64::from(pose) / f64::from(poses)).stereo_camera(aspect));
            run.prepared.set_seed(pose, 0);
            run.prepared.ambient_frame(&mut |_, _| check_interrupted())?;
            shown.push(visibility(&run.prepared)?);
        }
        let pairs = places(&runs[0].prepared)?;
        let fsa = runs.iter().position(|r| r.ao.method == Ao::Fsa).map(|i| shown[i].clone());
        for (along, shown) in methods.iter_mut().zip(&shown) {
            along.inconsistency.push(ambient::inconsistency(&pairs, slices(shown)));
            let error = |fsa| ambient::mean_absolute_error(slices(shown), slices(fsa));
            along.mae_fsa.push(fsa.as_ref().and_then(error));
        }
        bar.step("");
    }
    for along in &mut methods {
        along.mean_inconsistency = mean_of(&along.inconsistency);
        along.mean_mae_fsa = mean_of(&along.mae_fsa);
    }
    Ok(AoPath { poses, methods })
}

/// The view after this share of the path, a closed loop that begins in the scene's own view.
fn at(view: &View, share: f64) -> View {
    let angle = TAU * share;
    let step = DVec3::new(ASIDE_M * angle.sin(), 0.0, -FORWARDS_M * (1.0 - angle.cos()) / 2.0);
    View {
        position: view.position + view.world_from_view * step,
        world_from_view: view.world_from_view * DQuat::from_rotation_y(TURN_RAD * (2.0 * angle).sin()),
        ..view.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_path_is_a_loop_from_the_view() {
        let view = View {
            name: "main".to_owned(),
            position: DVec3::new(1.0, 2.0, 3.0),
            world_from_view: DQuat::from_rotation_y(0.4),
            vertical_fov_rad: 0.9,
            ipd_m: 0.064,
            cant_rad: 0.0,
            near_m: 0.05,
        };
        for share in [0.0, 1.0] {
            let there = at(&view, share);
            assert!(there.position.distance(view.position) < 1e-9);
            assert!(there.world_from_view.angle_between(view.world_from_view) < 1e-6);
        }
        let farthest = (0..100).map(|i| at(&view, f64::from(i) / 100.0).position.distance(view.position));
        let farthest = farthest.fold(0.0, f64::max);
        assert!((0.2..0.5).contains(&farthest), "{farthest}");
        assert!((at(&view, 0.37).position - at(&view, 0.38).position).length() < 0.02);
    }
}
