//! The configurations that a comparison runs, and what is measured of each.

use std::collections::BTreeMap;

use super::report::AoRow;
use crate::compare::{CompareError, ratios, reference};
use crate::gpu::PassTime;
use crate::metrics::{ambient, mean};
use crate::render::{Ao, AoSettings, Method, Prepared, median_of_sorted};

/// Thresholds of the sweep: the seed's figure 11 and beyond.
const THRESHOLDS: [f32; 6] = [0.005, 0.01, 0.02, 0.03, 0.05, 0.1];
/// Random numbers of the oracle, far from the rounds'.
pub const ORACLE_SEED: u32 = 1_000_001;

/// Visibility by eye.
pub type Visibility = [Vec<f32>; 2];

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

/// A configuration on its way through the rounds.
pub struct Run {
    pub ao: AoSettings,
    pub prepared: Prepared,
    pub ms: Vec<f64>,
    passes: BTreeMap<String, Vec<f64>>,
    pub inconsistency: Vec<Option<f64>>,
    pub mae_fsa: Vec<Option<f64>>,
    pub mae_ray_traced: Vec<Option<f64>>,
    /// Pixels worked on again.
    again: Vec<Option<f64>>,
}

impl Run {
    /// Nothing is measured yet.
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

    /// One frame's times, and how many pixels were worked on again.
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

    /// What the rounds came to; `mono`: the times of the method that treats each eye alone; `pixels`: of both eyes.
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

/// Of all passes of ambient occlusion, ms.
pub fn total(passes: &[PassTime]) -> f64 {
    of_ao(passes).map(|p| p.ms).sum()
}

/// Of the last frame.
///
/// # Errors
/// When a Vulkan call fails.
pub fn visibility(prepared: &Prepared) -> Result<Visibility, CompareError> {
    Ok(prepared.ambient_visibility()?.expect("prepared with ambient occlusion"))
}

pub fn slices(of: &Visibility) -> [&[f32]; 2] {
    of.each_ref().map(Vec::as_slice)
}

/// The pairs of the last frame's places.
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
        // The threshold that was asked for is measured once.
        assert_eq!(configurations(AoSettings::default()).len(), 4 + 2 * (THRESHOLDS.len() - 1));
    }
}
