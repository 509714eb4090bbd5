//! Measures the methods along the path `sway` of the head, as in figure 10 of seed 001. `run` calls it.

use super::configuration::{Run, mean_of, places, slices, visibility};
use super::report::{AoPath, AoPathRow};
use crate::compare::CompareError;
use crate::console::{Console, check_interrupted};
use crate::metrics::ambient;
use crate::render::Ao;
use crate::scene::View;
use crate::scene::head_path::sway;

/// Renders each method at each pose, with the number of the pose as its seed. Of the adaptive methods only the
/// threshold that was asked for is used.
///
/// # Errors
/// When a Vulkan call fails, or on Ctrl-C.
pub fn along(runs: &mut [Run], view: &View, poses: u32, console: &Console) -> Result<AoPath, CompareError> {
    let runs = &mut runs[..Ao::OF_VIEWS.len()];
    let mut bar = console.progress("path", u64::from(poses));
    let nothing = |run: &Run| AoPathRow {
        method: run.ao.method,
        mean_inconsistency: None,
        mean_mae_fsa: None,
        inconsistency: Vec::new(),
        mae_fsa: Vec::new(),
    };
    let mut methods: Vec<AoPathRow> = runs.iter().map(nothing).collect();
    for pose in 0..poses {
        check_interrupted()?;
        let mut shown = Vec::new();
        for run in runs.iter_mut() {
            let aspect = run.prepared.settings().aspect();
            run.prepared.set_camera(&sway(view, f64::from(pose) / f64::from(poses)).stereo_camera(aspect));
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
