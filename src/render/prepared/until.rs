//! References that stop when they are good enough, and go on where they stopped.

use glam::Vec3;

use crate::gpu::{GpuError, read_image};

use super::super::convergence::relative_error;
use super::super::cpu::Sums;
use super::super::ray_list::RayList;
use super::super::targets::PathTraced;
use super::Prepared;

/// Samples after which the error is looked at: the first time, and at least so many later.
const BETWEEN_CHECKS: u32 = 16;
impl Prepared {
    /// The reference of the frames to come stops at the first check at which its relative error is at most `until`, or at the
    /// method's samples. Checks lie at 16, 32, 48, 64, 80, 96, … samples, and from 128 on a quarter further each time,
    /// whatever was traced in one go, so that a request stops at one count.
    ///
    /// The relative error is the mean over the reflecting pixels of both eyes of σ/max(L, 1 % of their mean L), of luminances;
    /// σ is the standard error with the channels' errors added linearly.
    pub fn set_until(&mut self, until: Option<f64>) {
        self.until = until;
    }

    /// Paths a pixel of the frames to come, of the reference.
    pub fn set_samples(&mut self, samples: u32) {
        self.method = self.method.clone().with_exactly(samples);
    }

    /// The next frame goes on from these sums, if they are of the same pixels and not more than it asks for; and its own, or
    /// what Ctrl-C left of them, are kept for [`Prepared::sums`]. The processor's paths alone are.
    pub fn take_up(&self, sums: Option<Sums>) {
        let mut paths = self.paths.borrow_mut();
        (paths.kept, paths.sums) = (true, sums);
    }

    /// What the last frame left, finished or not.
    pub fn sums(&self) -> Option<Sums> {
        self.paths.borrow_mut().sums.take()
    }

    /// Samples at which the last frame looked at its relative error, and what it was.
    pub fn checks(&self) -> Vec<(u32, f64)> {
        self.paths.borrow().checks.clone()
    }

    /// Paths a pixel that the last frame of the reference ended with.
    pub fn samples_reached(&self) -> u32 {
        self.paths.borrow().samples
    }

    /// Notes the error after so many samples, if there is a check there; true: it is small enough.
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

    /// Samples that may be added before the next check, or before the end.
    pub(super) fn until_next(&self, first: u32, samples: u32) -> u32 {
        match self.is_watched() {
            true => next_check(first).min(samples) - first,
            false => samples - first,
        }
    }

    /// Kept sums know their errors, too: nobody can tell later where they might have stopped.
    fn is_watched(&self) -> bool {
        self.until.is_some() || self.needs.cpu_paths && self.paths.borrow().kept
    }

    /// Of what the device traced.
    pub(super) fn error_on_device(&self, list: &RayList, out: &PathTraced) -> Result<f64, GpuError> {
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

/// The first check after so many samples.
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
