//! The configurations of ambient occlusion that a comparison runs, and what is measured of each. `run` and `path` call
//! it.

use std::collections::BTreeMap;

use super::report::AoRow;
use crate::compare::{CompareError, ratios, reference};
use crate::gpu::PassTime;
use crate::metrics::{ambient, mean};
use crate::render::{Ao, AoSettings, Method, Prepared, median_of_sorted};

/// The thresholds at which the adaptive methods are measured: those of figure 11 of seed 001, and more.
const THRESHOLDS: [f32; 6] = [0.005, 0.01, 0.02, 0.03, 0.05, 0.1];
/// The seed of the picture by rays. It is far from the seeds of the rounds, so that no random numbers are shared.
pub const ORACLE_SEED: u32 = 1_000_001;

/// The visibility of each pixel, by eye.
pub type Visibility = [Vec<f32>; 2];

/// Every method at the threshold that was asked for, then the adaptive methods at the other thresholds.
pub fn configurations(asked: AoSettings) -> Vec<AoSettings> {
    let mut all: Vec<AoSettings> = Ao::OF_VIEWS.map(|method| AoSettings { method, ..asked }).to_vec();
    for method in Ao::OF_VIEWS.into_iter().filter(|ao| ao.is_adaptive()) {
        let others = THRESHOLDS.into_iter().filter(|t| *t != asked.threshold);
        all.extend(others.map(|threshold| AoSettings { method, threshold, ..asked }));
    }
    all
}

/// The method of reflection that frames are prepared with. Any would do, because only the passes before the reflections
/// are run.
pub fn method() -> Method {
    Method::parse("sssr").expect("the baseline exists")
}

/// A configuration, and what the rounds so far have measured of it.
pub struct Run {
    pub ao: AoSettings,
    pub prepared: Prepared,
    pub ms: Vec<f64>,
    passes: BTreeMap<String, Vec<f64>>,
    pub inconsistency: Vec<Option<f64>>,
    pub mae_fsa: Vec<Option<f64>>,
    pub mae_ray_traced: Vec<Option<f64>>,
    /// The number of pixels that an adaptive method processed further, by round.
    again: Vec<Option<f64>>,
}

impl Run {
    /// A configuration of which nothing is measured yet.
    pub fn new(ao: AoSettings, prepared: Prepared) -> Run {
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

    /// Adds the times of the frame that was just drawn, and how many of its pixels were processed further.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn add_times(&mut self, passes: &[PassTime]) -> Result<(), CompareError> {
        self.ms.push(total(passes));
        for pass in of_ao(passes) {
            self.passes.entry(pass.name.clone()).or_default().push(pass.ms);
        }
        self.again.push(self.prepared.ambient_pixels_again()?.map(f64::from));
        Ok(())
    }

    /// The results over the rounds. `mono` has the times of the method `mono`, by round, and `pixels` is the number of
    /// pixels of both eyes.
    pub fn row(&self, mono: &[f64], pixels: f64) -> AoRow {
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

/// The mean of some values. `None` where any of them is undefined, or where there are none.
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

/// The time of all passes of ambient occlusion, ms.
pub fn total(passes: &[PassTime]) -> f64 {
    of_ao(passes).map(|p| p.ms).sum()
}

/// The visibility in the last frame that was drawn.
///
/// # Errors
/// When a Vulkan call fails.
pub fn visibility(prepared: &Prepared) -> Result<Visibility, CompareError> {
    Ok(prepared.ambient_visibility()?.expect("prepared with ambient occlusion"))
}

pub fn slices(of: &Visibility) -> [&[f32]; 2] {
    of.each_ref().map(Vec::as_slice)
}

/// The pairs of pixels that show the same place in the last frame that was drawn.
///
/// # Errors
/// When a Vulkan call fails.
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
        // The threshold that was asked for is measured only once.
        assert_eq!(configurations(AoSettings::default()).len(), 4 + 2 * (THRESHOLDS.len() - 1));
    }
}
