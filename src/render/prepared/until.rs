//! References that stop at a relative error, and that continue from kept sums.

use glam::Vec3;

use crate::gpu::{GpuError, read_image};

use super::super::convergence::relative_error;
use super::super::cpu::KeptSums;
use super::super::ray_list::RayList;
use super::super::targets::PathTraceImages;
use super::Prepared;

/// The number of samples at the first check of the error, and the least number between checks.
const BETWEEN_CHECKS: u32 = 16;
impl Prepared {
    /// Makes the reference of the next frames stop at the first check at which its relative error is at most `until`, and at
    /// the method's number of samples at the latest. Checks are at 16, 32, 48, 64, 80, 96, … samples, and from 128 on a
    /// quarter further each time. They do not depend on the size of submissions, so that the same request always stops at the
    /// same count.
    ///
    /// The relative error is the mean of σ/max(L, 1 % of the mean L) over the reflecting pixels of both eyes. L and σ are
    /// luminances; σ is the standard error, with the channels' errors added linearly.
    pub fn set_until(&mut self, until: Option<f64>) {
        self.until = until;
    }

    /// Sets the number of the reference's paths for each pixel in the next frames.
    pub fn set_samples(&mut self, samples: u32) {
        self.method = self.method.clone().with_exactly(samples);
    }

    /// Makes the next frame continue from these sums, if they belong to the same pixels and have no more samples than it
    /// needs. Its own sums, complete or interrupted by Ctrl-C, are then kept for [`Prepared::sums`]. This works only for paths
    /// that the processor traces.
    pub fn continue_from(&self, sums: Option<KeptSums>) {
        let mut paths = self.paths.borrow_mut();
        (paths.kept, paths.sums) = (true, sums);
    }

    /// The sums of the last frame, complete or not.
    pub fn sums(&self) -> Option<KeptSums> {
        self.paths.borrow_mut().sums.take()
    }

    /// The number of samples at each check of the last frame, and the relative error at that check.
    pub fn checks(&self) -> Vec<(u32, f64)> {
        self.paths.borrow().checks.clone()
    }

    /// The number of paths for each pixel at the end of the reference's last frame.
    pub fn samples_reached(&self) -> u32 {
        self.paths.borrow().samples
    }

    /// Stores the error if there is a check after this many samples. True: it is small enough.
    pub(super) fn is_enough(
        &self,
        samples: u32,
        error: impl FnOnce() -> Result<f64, GpuError>,
    ) -> Result<bool, GpuError> {
        if !self.is_watched() || next_check(samples - 1) != samples {
            return Ok(false);
        }
        let error = error()?;
        self.paths.borrow_mut().checks.push((samples, error));
        Ok(self.until.is_some_and(|until| error <= until))
    }

    /// The number of samples that may be added before the next check or the end.
    pub(super) fn until_next(&self, first: u32, samples: u32) -> u32 {
        match self.is_watched() {
            true => next_check(first).min(samples) - first,
            false => samples - first,
        }
    }

    /// Whether the error is checked. It is also checked if sums are kept, because it cannot be found out later where they would
    /// have stopped.
    fn is_watched(&self) -> bool {
        self.until.is_some() || self.needs.cpu_paths && self.paths.borrow().kept
    }

    /// The relative error of paths that the device traced.
    pub(super) fn error_on_device(&self, list: &RayList, out: &PathTraceImages) -> Result<f64, GpuError> {
        let listed = list.read(&self.gpu)?;
        let (means, errors) = (read_image(&self.gpu, &out.reflection)?, read_image(&self.gpu, &out.error)?);
        let size = out.reflection.extent();
        let texel = |image: &[u8], packed: u32| {
            let i = 16 * RayList::texel(packed, size);
            let [r, g, b]: [f32; 3] = bytemuck::pod_read_unaligned(&image[i..i + 12]);
            Vec3::new(r, g, b)
        };
        Ok(relative_error(|| listed.iter().map(|&p| (texel(&means, p), texel(&errors, p)))))
    }
}

/// The number of samples of the first check after `samples`.
fn next_check(samples: u32) -> u32 {
    let mut check = BETWEEN_CHECKS;
    while check <= samples {
        check += BETWEEN_CHECKS.max(check / 4 / BETWEEN_CHECKS * BETWEEN_CHECKS);
    }
    check
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn checks_lie_at_the_same_counts_wherever_one_begins() {
        let mut at = vec![0];
        while at.len() < 12 {
            at.push(next_check(at[at.len() - 1]));
        }
        assert_eq!(at, [0, 16, 32, 48, 64, 80, 96, 112, 128, 160, 192, 240]);
        assert_eq!([17, 31, 32, 191, 239].map(next_check), [32, 32, 48, 192, 240]);
    }
}
