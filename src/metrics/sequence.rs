//! Splits the errors of a sequence into bias, noise and flicker from frame to frame. The frames of two independent runs
//! and of two independent references go in. `compare::sequence` calls it.
//!
//! Take the difference of one run from the first reference and that of the other run from the second one. The mean of
//! their product is the squared bias, however noisy the runs and the references are. The mean of half the squared
//! difference between the runs is the variance of a run. The reference's noise is not estimated from a standard error,
//! which would be too large, because the samples of a reference are stratified.

use glam::{DAffine3, DVec3};

use super::luminance;
use super::pairs::EyeSurfaces;
use crate::scene::EyeCamera;

/// The squared error of a frame and its parts: means over pixels and channels, in linear radiance squared.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct ErrorParts {
    pub mse: f64,
    /// May be negative by chance where there is hardly any bias.
    pub bias2: f64,
    pub variance: f64,
}

/// The parts of the error over the pixels of a mask. `None` where the mask has no pixel.
pub fn parts(runs: [&[[f32; 3]]; 2], references: [&[[f32; 3]]; 2], mask: &[bool]) -> Option<ErrorParts> {
    let (mut bias2, mut variance, mut n) = (0.0, 0.0, 0.0);
    for i in (0..mask.len()).filter(|i| mask[*i]) {
        for c in 0..3 {
            let (x, y) = (runs.map(|run| f64::from(run[i][c])), references.map(|r| f64::from(r[i][c])));
            // Each run is taken with each reference once.
            bias2 += ((x[0] - y[0]) * (x[1] - y[1]) + (x[0] - y[1]) * (x[1] - y[0])) / 2.0;
            variance += (x[0] - x[1]).powi(2) / 2.0;
            n += 1.0;
        }
    }
    (n > 0.0).then(|| ErrorParts { mse: (bias2 + variance) / n, bias2: bias2 / n, variance: variance / n })
}

/// One eye of a frame: its camera, what it saw, and where the instances were.
#[derive(Debug, Clone, Copy)]
pub struct EyeFrame<'a> {
    pub camera: &'a EyeCamera,
    pub surfaces: EyeSurfaces<'a>,
    pub places: &'a [DAffine3],
    pub size: (usize, usize),
}

/// Two places count as the same where they are no farther apart than this share of their distance from the eye. That
/// allows for half a pixel on a slanted surface.
const SAME_PLACE: f64 = 0.01;

/// For each pixel of a frame, the pixel of the frame before that shows the same place of the moving surface. `None`
/// where nothing was drawn, the place was outside the view, or something stood in front of it.
pub fn previous_pixels(now: EyeFrame<'_>, then: EyeFrame<'_>) -> Vec<Option<u32>> {
    let (width, height) = now.size;
    (0..width * height)
        .map(|i| {
            let instance = now.surfaces.instance[i];
            let place = position(&now, i)?;
            let index = instance.checked_sub(1)? as usize;
            let (is, was) = (now.places.get(index)?, then.places.get(index)?);
            let place = if is == was { place } else { was.transform_point3(is.inverse().transform_point3(place)) };
            let (x, y) = pixel(then.camera, then.size, place)?;
            let there = y * width + x;
            let same = then.surfaces.instance[there] == instance
                && (position(&then, there)? - place).length() <= SAME_PLACE * (place - then.camera.position).length();
            same.then_some(there as u32)
        })
        .collect()
}

/// The world position of what is seen at a pixel's centre. `None`: nothing was drawn there.
fn position(eye_frame: &EyeFrame<'_>, index: usize) -> Option<DVec3> {
    let depth = f64::from(eye_frame.surfaces.depth[index]);
    if depth <= 0.0 {
        return None;
    }
    let ((width, height), fov) = (eye_frame.size, &eye_frame.camera.fov);
    let (x, y) = ((index % width) as f64 + 0.5, (index / width) as f64 + 0.5);
    let mix = |from: f64, to: f64, t: f64| from.tan() + (to.tan() - from.tan()) * t;
    let across = mix(fov.left_rad, fov.right_rad, x / width as f64);
    let up = mix(fov.up_rad, fov.down_rad, y / height as f64);
    let ray = DVec3::new(across, up, -1.0) * (eye_frame.camera.near_m / depth);
    Some(eye_frame.camera.position + eye_frame.camera.world_from_view * ray)
}

fn pixel(camera: &EyeCamera, (width, height): (usize, usize), place: DVec3) -> Option<(usize, usize)> {
    let at = camera.world_from_view.inverse() * (place - camera.position);
    if at.z >= 0.0 {
        return None;
    }
    let share = |value: f64, from: f64, to: f64| (value / -at.z - from.tan()) / (to.tan() - from.tan());
    let x = share(at.x, camera.fov.left_rad, camera.fov.right_rad) * width as f64;
    let y = share(at.y, camera.fov.up_rad, camera.fov.down_rad) * height as f64;
    let inside = x >= 0.0 && y >= 0.0 && x < width as f64 && y < height as f64;
    inside.then_some((x as usize, y as usize))
}

/// The flicker of an eye, in linear radiance squared. It is the mean over pixels and channels of half the squared
/// change of the error, along the motion of the surfaces. The square is the product of the changes of the error against
/// the first and against the second reference, so that the references' noise does not add to it. `None` without any
/// pixel.
///
/// `now` and `then` each hold a run's frame and the frames of the two references.
pub fn flicker(
    now: [&[[f32; 3]]; 3],
    then: [&[[f32; 3]]; 3],
    previous_pixels: &[Option<u32>],
    mask: &[bool],
) -> Option<f64> {
    let (mut sum, mut n) = (0.0, 0.0);
    for (i, there) in previous_pixels.iter().enumerate().filter(|(i, _)| mask[*i]) {
        let Some(there) = there.map(|t| t as usize) else { continue };
        for c in 0..3 {
            let change = [0, 1, 2].map(|of: usize| f64::from(now[of][i][c]) - f64::from(then[of][there][c]));
            sum += (change[0] - change[1]) * (change[0] - change[2]) / 2.0;
            n += 1.0;
        }
    }
    (n > 0.0).then(|| sum / n)
}

/// The part of the flicker that is noise: the part of the change along the motion that two runs do not have in common.
/// It contains neither noise of the references nor an error that both runs share. `now` and `then` hold the runs'
/// frames.
pub fn noise_flicker(
    now: [&[[f32; 3]]; 2],
    then: [&[[f32; 3]]; 2],
    previous_pixels: &[Option<u32>],
    mask: &[bool],
) -> Option<f64> {
    let (mut sum, mut n) = (0.0, 0.0);
    for (i, there) in previous_pixels.iter().enumerate().filter(|(i, _)| mask[*i]) {
        let Some(there) = there.map(|t| t as usize) else { continue };
        for c in 0..3 {
            let change = [0, 1].map(|run: usize| f64::from(now[run][i][c]) - f64::from(then[run][there][c]));
            sum += (change[0] - change[1]).powi(2) / 4.0;
            n += 1.0;
        }
    }
    (n > 0.0).then(|| sum / n)
}

/// How much the eyes disagree in a frame: means over the pairs of pixels that show the same reflection.
#[derive(Debug, Clone, Copy, PartialEq, serde::Serialize)]
pub struct Disagreement {
    /// The squared Weber contrast that both runs have in common.
    pub lasting: f64,
    /// The variance of the difference between the eyes' luminances.
    pub noise: f64,
}

/// The disagreement in the composites of two runs, given by run and eye. `epsilon` is the least luminance that a
/// contrast is divided by. `None` without pairs.
pub fn disagreement(runs: [[&[[f32; 3]]; 2]; 2], pairs: &[[u32; 2]], epsilon: f64) -> Option<Disagreement> {
    let (mut lasting, mut noise) = (0.0, 0.0);
    for pair in pairs {
        let luminances = runs.map(|eyes| [0, 1].map(|eye: usize| luminance(eyes[eye][pair[eye] as usize])));
        let d = luminances.map(|[l, r]| l - r);
        let base = (luminances.iter().flatten().sum::<f64>() / 4.0).max(epsilon);
        lasting += d[0] * d[1] / (base * base);
        noise += (d[0] - d[1]).powi(2) / 2.0;
    }
    let n = pairs.len() as f64;
    (n > 0.0).then(|| Disagreement { lasting: lasting / n, noise: noise / n })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Fov, StereoCamera, View};
    use cyclopean_analysis::chance::Stream;
    use glam::{DQuat, Vec3};

    #[test]
    fn bias_and_noise_are_told_apart_whatever_the_reference_brings() {
        let mut stream = Stream::new(3, 1);
        let n = 40_000;
        let mut noisy = |mean: f64, deviation: f64| -> Vec<[f32; 3]> {
            (0..n).map(|_| [(mean + deviation * stream.normal()) as f32; 3]).collect()
        };
        let (y, z, a, b) = (noisy(1.0, 0.1), noisy(1.0, 0.1), noisy(1.3, 0.2), noisy(1.3, 0.2));
        let found = parts([&a, &b], [&y, &z], &vec![true; n]).expect("pixels");
        assert!((found.bias2 - 0.09).abs() < 3e-3, "{found:?}");
        assert!((found.variance - 0.04).abs() < 1e-3, "{found:?}");
        assert!((found.mse - found.bias2 - found.variance).abs() < 1e-12);
        assert_eq!(parts([&a, &b], [&y, &z], &vec![false; n]), None);
        // Frames with this noise and a constant bias flicker by the variance.
        let then = [noisy(1.0, 0.1), noisy(1.0, 0.1)];
        let same: Vec<Option<u32>> = (0..n as u32).map(Some).collect();
        let found = flicker([&a, &y, &z], [&b, &then[0], &then[1]], &same, &vec![true; n]).expect("pixels");
        assert!((found - 0.04).abs() < 1e-3, "{found}");
        // Two runs of independent frames give the same without the references.
        let (c, d) = (noisy(1.3, 0.2), noisy(1.3, 0.2));
        let found = noise_flicker([&a, &b], [&c, &d], &same, &vec![true; n]).expect("pixels");
        assert!((found - 0.04).abs() < 1e-3, "{found}");
    }

    #[test]
    fn what_the_eyes_disagree_on_is_split() {
        let mut stream = Stream::new(4, 1);
        let n = 40_000u32;
        let mut eye =
            |mean: f64| -> Vec<[f32; 3]> { (0..n).map(|_| [(mean + 0.1 * stream.normal()) as f32; 3]).collect() };
        let (l1, r1, l2, r2) = (eye(1.1), eye(0.9), eye(1.1), eye(0.9));
        let pairs: Vec<[u32; 2]> = (0..n).map(|i| [i, i]).collect();
        let found = disagreement([[&l1, &r1], [&l2, &r2]], &pairs, 1e-3).expect("pairs");
        assert!((found.lasting - 0.04).abs() < 2e-3 && (found.noise - 0.02).abs() < 1e-3, "{found:?}");
    }

    #[test]
    fn a_place_is_found_again_and_what_was_hidden_is_not() {
        let view = View {
            name: "v".to_owned(),
            position: DVec3::new(0.0, 0.0, 2.0),
            world_from_view: DQuat::IDENTITY,
            vertical_fov_rad: 1.0,
            ipd_m: 0.0,
            cant_rad: 0.0,
            near_m: 0.1,
        };
        let size = (16, 8);
        let camera = |x: f64| -> StereoCamera {
            View { position: view.position + DVec3::X * x, ..view.clone() }.stereo_camera(2.0)
        };
        assert_eq!(camera(0.0).left.fov, Fov::symmetric(1.0, 2.0));
        // The wall is two metres ahead, so a pixel is 2·2·tan(0.5)/8 = 0.273 m wide.
        let step = 4.0 * 0.5f64.tan() / 8.0;
        let (depth, instance) = (vec![0.05f32; 128], vec![1u32; 128]);
        let normal = vec![Vec3::Z; 128];
        let (traced, numbers) = (vec![true; 128], vec![0.0f32; 128]);
        let surfaces = EyeSurfaces {
            traced: &traced,
            depth: &depth,
            instance: &instance,
            normal: &normal,
            face_normal: &normal,
            roughness: &numbers,
            inverse_hit_distance: &numbers,
        };
        let (here, there) = (camera(step), camera(0.0));
        let still = [DAffine3::IDENTITY];
        let eye_frame =
            |camera: &'static EyeCamera, places: &'static [DAffine3]| EyeFrame { camera, surfaces, places, size };
        let leak = |c: StereoCamera| -> &'static EyeCamera { Box::leak(Box::new(c.left)) };
        let places = |p: [DAffine3; 1]| -> &'static [DAffine3] { Box::leak(Box::new(p)) };
        let found = previous_pixels(eye_frame(leak(here), places(still)), eye_frame(leak(there), places(still)));
        // The head moved one pixel to the right, so everything was one pixel further right before.
        assert_eq!((found[0], found[14], found[15]), (Some(1), Some(15), None));
        // The wall moved with the head, so it is seen at the same pixels.
        let moved = [DAffine3::from_translation(DVec3::X * step)];
        let found = previous_pixels(eye_frame(leak(here), places(moved)), eye_frame(leak(there), places(still)));
        assert_eq!((found[0], found[15]), (Some(0), Some(15)));
        // Another instance was there before.
        let other = vec![2u32; 128];
        let then = EyeFrame {
            surfaces: EyeSurfaces { instance: &other, ..surfaces },
            ..eye_frame(leak(there), places(still))
        };
        assert!(previous_pixels(eye_frame(leak(here), places(still)), then).iter().all(Option::is_none));
    }
}
