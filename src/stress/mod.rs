//! Checks of numerical stability. Every known hazard is a case: a scene that is made in code, a value that is measured,
//! and its bound. Sweeps show how errors grow towards the extremes.
//!
//! Cases are data ([`Case`]), with one file for each family. `cyclopean stress` runs them on a device, and an
//! [`Outcome`] or an [`SweepResult`] comes out of each. docs/stress.md describes them. The tests of the renderer use the
//! [`shapes`] too.

mod ambient;
mod bench;
mod case;
mod depth;
mod eyes;
mod gltf;
mod lights;
mod lobe;
mod measure;
mod meshes;
mod poor;
mod range;
mod rays;
pub mod shapes;
mod sizes;
mod sweep;
mod time;

pub use bench::{Bench, CasePicture};
pub use case::{Bound, Case, Outcome, Worst, run};
pub use lobe::albedo;
pub use sweep::{Row, SWEEPS, Sweep, SweepResult, run as run_sweep};

/// All cases, family after family.
pub fn cases() -> impl Iterator<Item = &'static Case> {
    [
        poor::CASES,
        meshes::CASES,
        lobe::CASES,
        rays::CASES,
        depth::CASES,
        eyes::CASES,
        lights::CASES,
        range::CASES,
        sizes::CASES,
        ambient::CASES,
        time::CASES,
    ]
    .into_iter()
    .flatten()
}
