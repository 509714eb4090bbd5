//! Numerical stability: every known hazard as a case with a scene made in code, a measured value and its bound; and
//! sweeps that show how errors grow towards the extremes.
//!
//! A case is declared data ([`Case`]); one file a family. `cyclopean stress` runs them all.

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

pub use bench::{Bench, Shot};
pub use case::{Bound, Case, Outcome, Worst, run};
pub use lobe::albedo;
pub use sweep::{Along, Row, SWEEPS, Sweep, run as run_sweep};

/// Every case, family after family.
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
