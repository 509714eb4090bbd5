//! Finds the pairs of pixels, one in each eye, that show the same reflection. The surfaces of both views and the
//! reference go in, and [`Pairs`] come out. `compare` chooses them once for a view, from the reference alone, so that
//! every method is measured at the same pairs.
//!
//! A pixel of the left eye sees the virtual image of what it reflects. The image lies on the pixel's view ray, as far
//! behind the surface as the hit is away from it. The line from the image to the right eye meets the plane of the
//! surface in the partner (paper §4.3, Fig. 7). A pair is kept if it leads back to its pixel, lies on the same surface,
//! and has the same luminance in both eyes of the reference.

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use super::luminance;
use crate::scene::{Eye, EyeCamera, StereoCamera};

/// The largest Weber contrast between the luminances of a pair in the reference. An observer hardly sees it.
pub const MATCH: f64 = 0.02;
/// The largest standard error of that contrast. With a larger one the reference cannot tell whether the pair matches.
pub const SURE: f64 = 0.01;

/// When two pixels show the same surface, as in `common/pair.glsl`: the least cosine between their normals, and the
/// largest distance from the plane relative to the distance along the view's axis.
const LEAST_COSINE: f64 = 0.9;
const PLANE_TOLERANCE: f64 = 0.01;

/// What the pixels of one eye show, with the rows from the top.
#[derive(Debug, Clone, Copy)]
pub struct EyeSurfaces<'a> {
    /// Whether the pixel traces a reflection ray.
    pub traced: &'a [bool],
    /// Raw depth: the near plane over the distance along the view's axis.
    pub depth: &'a [f32],
    pub instance: &'a [u32],
    /// Shading normal, unit length.
    pub normal: &'a [Vec3],
    /// Normal of the triangle, unit length.
    pub face_normal: &'a [Vec3],
    /// Perceptual roughness.
    pub roughness: &'a [f32],
    /// 1 / the distance to what is reflected, in 1/m, as the mean over the lobe. 0 is the sky. It is negative where no
    /// path of the pixel went above the horizon.
    pub inverse_hit_distance: &'a [f32],
}

/// What the pixels of both eyes show, and the cameras that see it.
#[derive(Debug, Clone, Copy)]
pub struct Surfaces<'a> {
    pub camera: &'a StereoCamera,
    /// Size of one eye's picture, pixels.
    pub width: usize,
    pub height: usize,
    /// Perceptual roughness below which a surface is a mirror.
    pub delta_roughness: f32,
    pub eyes: [EyeSurfaces<'a>; 2],
}

/// The reference's pictures by eye, from which pairs are chosen.
#[derive(Debug, Clone, Copy)]
pub struct Reference<'a> {
    /// Linear radiance.
    pub linear: [&'a [[f32; 3]]; 2],
    /// Standard error of the reflection, by channel.
    pub error: [&'a [[f32; 3]]; 2],
}

/// The chosen pairs, and how many were not chosen. They are stored with the reference, so that every method is measured
/// at the same ones.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Pairs {
    /// The number of pixels of the left eye that have a partner by geometry.
    pub candidates: u64,
    /// How many of these the reference is too noisy for: it cannot tell whether they match.
    pub undecided: u64,
    /// How many of these differ between the eyes of the reference by more than [`MATCH`].
    pub different: u64,
    /// ε: the least luminance that a Weber contrast is divided by. It is 1 % of the reference's mean luminance.
    pub epsilon: f64,
    /// The index of the pixel in the left and in the right eye, row-major.
    pub pairs: Vec<[u32; 2]>,
}

impl Pairs {
    /// Chooses the pairs of these surfaces whose luminances match in the reference.
    pub fn choose(surfaces: &Surfaces<'_>, reference: &Reference<'_>) -> Pairs {
        let mean = super::mean(reference.linear.iter().flat_map(|e| e.iter()).map(|c| luminance(*c)));
        let mut chosen = Pairs {
            candidates: 0,
            undecided: 0,
            different: 0,
            // In a black scene every difference is 0, so any number above 0 will do.
            epsilon: (0.01 * mean.unwrap_or(0.0)).max(f64::MIN_POSITIVE),
            pairs: Vec::new(),
        };
        for [left, right] in surfaces.pairs() {
            chosen.candidates += 1;
            let at = [left, right];
            let seen = [0, 1].map(|eye| luminance(reference.linear[eye][at[eye]]));
            // The channels come from the same paths, so their errors are added linearly. This is exact for grey light
            // and an upper bound for any other.
            let error = [0, 1].map(|eye| luminance(reference.error[eye][at[eye]]));
            let base = ((seen[0] + seen[1]) / 2.0).max(chosen.epsilon);
            if error[0].hypot(error[1]) / base > SURE {
                chosen.undecided += 1;
            } else if (seen[0] - seen[1]).abs() / base > MATCH {
                chosen.different += 1;
            } else {
                chosen.pairs.push([left as u32, right as u32]);
            }
        }
        chosen
    }
}

/// A pixel that reflects.
struct Pixel {
    instance: u32,
    position: DVec3,
    /// Direction towards its eye, unit length.
    v: DVec3,
    normal: DVec3,
    face_normal: DVec3,
    roughness: f32,
    /// Distance along the view's axis, metres.
    distance: f64,
    inverse_hit_distance: f64,
}

impl Surfaces<'_> {
    /// Every pixel of the left eye that has a partner in the right eye by geometry alone, with that partner. Both are
    /// indices, row-major.
    pub fn pairs(&self) -> impl Iterator<Item = [usize; 2]> {
        (0..self.width * self.height).filter_map(|left| Some([left, self.partner(left)?]))
    }

    /// The pixel of the right eye that shows the same reflection as a pixel of the left eye.
    fn partner(&self, left: usize) -> Option<usize> {
        let p = self.pixel(Eye::Left, left)?;
        let right = self.index(self.image_in(&p, Eye::Right)?)?;
        let q = self.pixel(Eye::Right, right)?;
        let mirror = |pixel: &Pixel| pixel.roughness < self.delta_roughness;
        let same = q.instance == p.instance
            && mirror(&q) == mirror(&p)
            && q.normal.dot(p.normal) >= LEAST_COSINE
            && (q.position - p.position).dot(p.face_normal).abs() <= PLANE_TOLERANCE * p.distance;
        // The way back uses the partner's own hit distance. So it leads back only where both reflect something at the
        // same distance, to within the lobe's footprint.
        let back = self.image_in(&q, Eye::Left).filter(|_| same)?;
        let off = (back.0 - self.centre(left).0).hypot(back.1 - self.centre(left).1);
        (off <= self.lobe_pixels(&p).max(1.0)).then_some(right)
    }

    fn pixel(&self, eye: Eye, index: usize) -> Option<Pixel> {
        let s = &self.eyes[eye.layer()];
        if !s.traced[index] || s.inverse_hit_distance[index] < 0.0 {
            return None;
        }
        let camera = self.camera.eye(eye);
        let distance = camera.near_m / f64::from(s.depth[index]);
        let (x, y) = self.centre(index);
        let [left, right, up, down] = sides(camera);
        let ray =
            DVec3::new(left + (right - left) * x / self.width as f64, up + (down - up) * y / self.height as f64, -1.0);
        let from_eye = camera.world_from_view * ray * distance;
        Some(Pixel {
            instance: s.instance[index],
            position: camera.position + from_eye,
            v: -from_eye.normalize(),
            normal: s.normal[index].as_dvec3(),
            face_normal: s.face_normal[index].as_dvec3(),
            roughness: s.roughness[index],
            distance,
            inverse_hit_distance: f64::from(s.inverse_hit_distance[index]),
        })
    }

    /// The place in an eye's picture (pixels) where that eye sees, in the plane of p, what p reflects. It is computed
    /// with inverse distances, so that the sky is no special case.
    fn image_in(&self, p: &Pixel, eye: Eye) -> Option<(f64, f64)> {
        let camera = self.camera.eye(eye);
        let to_eye = camera.position - p.position;
        let height = to_eye.dot(p.normal);
        let along = height * p.inverse_hit_distance + p.v.dot(p.normal);
        if height <= 0.0 || along <= 0.0 {
            return None;
        }
        let from_eye = -(to_eye * p.inverse_hit_distance + p.v) * (height / along);
        let view = camera.world_from_view.inverse() * from_eye;
        if view.z >= 0.0 {
            return None;
        }
        let [left, right, up, down] = sides(camera);
        let x = (view.x / -view.z - left) / (right - left) * self.width as f64;
        let y = (view.y / -view.z - up) / (down - up) * self.height as f64;
        Some((x, y))
    }

    /// Half the width of the lobe, in pixels, as a disparity of what is reflected.
    fn lobe_pixels(&self, p: &Pixel) -> f64 {
        let [left, right, up, down] = sides(&self.camera.left);
        let pixel = ((right - left) / self.width as f64).max((up - down) / self.height as f64);
        f64::from(p.roughness * p.roughness) / (1.0 + p.distance * p.inverse_hit_distance) / pixel
    }

    fn centre(&self, index: usize) -> (f64, f64) {
        ((index % self.width) as f64 + 0.5, (index / self.width) as f64 + 0.5)
    }

    /// The index of the pixel that holds a point. `None`: the point is outside the view.
    fn index(&self, (x, y): (f64, f64)) -> Option<usize> {
        let inside = x >= 0.0 && y >= 0.0 && x < self.width as f64 && y < self.height as f64;
        inside.then(|| y as usize * self.width + x as usize)
    }
}

/// The sides of the frustum at distance 1: left, right, up, down.
fn sides(camera: &EyeCamera) -> [f64; 4] {
    let fov = &camera.fov;
    [fov.left_rad, fov.right_rad, fov.up_rad, fov.down_rad].map(f64::tan)
}

/// The luminances of a pair in the left and in the right eye.
pub(super) fn pair_luminances(pair: &[u32; 2], eyes: [&[[f32; 3]]; 2]) -> [f64; 2] {
    [0, 1].map(|eye| luminance(eyes[eye][pair[eye] as usize]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::View;
    use glam::DQuat;

    const W: usize = 64;
    const H: usize = 48;

    /// A floor one metre below the eyes, which look 45° downwards. It reflects something that is `hit_m` away from it.
    struct Floor {
        camera: StereoCamera,
        depth: [Vec<f32>; 2],
        roughness: Vec<f32>,
        inverse: Vec<f32>,
    }

    impl Floor {
        fn new(hit_m: f64, roughness: f32, cant_rad: f64) -> Floor {
            let view = View {
                name: "main".to_owned(),
                position: DVec3::new(0.0, 1.0, 0.0),
                world_from_view: DQuat::from_rotation_x(-std::f64::consts::FRAC_PI_4),
                vertical_fov_rad: 0.9,
                ipd_m: 0.064,
                cant_rad,
                near_m: 0.05,
            };
            let camera = view.stereo_camera(W as f64 / H as f64);
            let depth = Eye::BOTH.map(|eye| {
                let e = camera.eye(eye);
                let [left, right, up, down] = sides(e);
                let ray = |i: usize| {
                    let (x, y) = ((i % W) as f64 + 0.5, (i / W) as f64 + 0.5);
                    DVec3::new(left + (right - left) * x / W as f64, up + (down - up) * y / H as f64, -1.0)
                };
                (0..W * H).map(|i| (e.near_m * -(e.world_from_view * ray(i)).y) as f32).collect()
            });
            Floor { camera, depth, roughness: vec![roughness; W * H], inverse: vec![(1.0 / hit_m) as f32; W * H] }
        }

        fn pairs(&self, left: &[[f32; 3]], right: &[[f32; 3]], error: f32) -> Pairs {
            let (traced, instance, up) = ([true; W * H], [1; W * H], [Vec3::Y; W * H]);
            let eyes = [0, 1].map(|eye| EyeSurfaces {
                traced: &traced,
                depth: &self.depth[eye],
                instance: &instance,
                normal: &up,
                face_normal: &up,
                roughness: &self.roughness,
                inverse_hit_distance: &self.inverse,
            });
            let error = vec![[error; 3]; W * H];
            let reference = Reference { linear: [left, right], error: [&error, &error] };
            let surfaces = Surfaces { camera: &self.camera, width: W, height: H, delta_roughness: 0.03, eyes };
            Pairs::choose(&surfaces, &reference)
        }
    }

    /// A mirror shows a point where the eye would see the mirrored point below the floor.
    #[test]
    fn a_mirror_pairs_pixels_that_see_the_same_point() {
        let grey = vec![[1.0; 3]; W * H];
        for (hit_m, cant) in [(2.0, 0.0), (0.3, 0.05), (f64::INFINITY, 0.02)] {
            let floor = Floor::new(hit_m, 0.0, cant);
            let found = floor.pairs(&grey, &grey, 0.0);
            assert!(found.pairs.len() > W * H / 2, "{} pairs", found.pairs.len());
            for [l, r] in found.pairs.iter().map(|p| p.map(|i| i as usize)) {
                // The left eye's ray, prolonged by hit_m below the floor, ends in the virtual image.
                let e = &floor.camera.left;
                let [left, right, up, down] = sides(e);
                let (x, y) = ((l % W) as f64 + 0.5, (l / W) as f64 + 0.5);
                let ray = e.world_from_view
                    * DVec3::new(left + (right - left) * x / W as f64, up + (down - up) * y / H as f64, -1.0);
                let direction = ray.normalize();
                let on_floor = e.position + direction * (1.0 / -direction.y);
                let image = on_floor + direction * hit_m.min(1e9);
                let seen = floor.camera.right.world_from_view.inverse() * (image - floor.camera.right.position);
                let e = &floor.camera.right;
                let [left, right, up, down] = sides(e);
                let px = (seen.x / -seen.z - left) / (right - left) * W as f64;
                let py = (seen.y / -seen.z - up) / (down - up) * H as f64;
                let off = (px - ((r % W) as f64 + 0.5)).hypot(py - ((r / W) as f64 + 0.5));
                assert!(off < 0.75, "{off} px at hit distance {hit_m}");
            }
        }
    }

    #[test]
    fn the_reference_decides() {
        let floor = Floor::new(1.0, 0.2, 0.0);
        let (one, brighter) = (vec![[1.0; 3]; W * H], vec![[1.05; 3]; W * H]);
        let equal = floor.pairs(&one, &one, 0.005);
        assert_eq!(equal.pairs.len() as u64, equal.candidates);
        assert!((equal.epsilon - 0.01).abs() < 1e-9);
        let different = floor.pairs(&one, &brighter, 0.005);
        assert_eq!((different.pairs.len(), different.different), (0, different.candidates));
        let noisy = floor.pairs(&one, &one, 0.02);
        assert_eq!((noisy.pairs.len(), noisy.undecided), (0, noisy.candidates));
        let black = floor.pairs(&vec![[0.0; 3]; W * H], &vec![[0.0; 3]; W * H], 0.0);
        assert_eq!(black.pairs.len() as u64, black.candidates);
    }
}
