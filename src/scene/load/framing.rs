//! The default view of scenes that have none: a three-quarter view from slightly above, filled by the part with the
//! most detail. Also the distance of the nearest content, which the loader and the renderer use.

use glam::{DMat3, DQuat, DVec3};

use crate::scene::{Instance, Primitive, View};

const VERTICAL_FOV_DEG: f64 = 45.0;
/// The image that the content should fill. Wider windows show more at the sides.
const ASPECT: f64 = 16.0 / 9.0;
/// The viewer stands to the right of +Z by this angle and above the content by that one.
const AZIMUTH_DEG: f64 = 30.0;
const ELEVATION_DEG: f64 = 22.0;
/// Share of the content that is ignored at each end of each axis, so that distant backdrops do not make the subject
/// small.
const TRIMMED: f64 = 0.01;
/// Share of the distance from which every corner of the content's box would be visible. The corners are mostly empty,
/// so the view comes closer.
const FILLED: f64 = 0.82;
/// Distance between the eyes over the distance of the nearest content: 63 mm at 1.9 m. A file without cameras does not
/// reveal its true size. So it is shown like a model that is held at a comfortable distance, whatever its units are.
const IPD_OVER_NEAREST: f64 = 1.0 / 30.0;

/// The default view of a scene without cameras.
pub fn default_view(primitives: &[Primitive], instances: &[Instance]) -> View {
    let samples = samples(primitives, instances);
    let (low, high) = trimmed_box(&samples);
    let center = (low + high) / 2.0;
    let (azimuth, elevation) = (AZIMUTH_DEG.to_radians(), ELEVATION_DEG.to_radians());
    let back = DVec3::new(azimuth.sin() * elevation.cos(), elevation.sin(), azimuth.cos() * elevation.cos());
    let right = DVec3::Y.cross(back).normalize();
    let up = back.cross(right);
    let tan_up = (VERTICAL_FOV_DEG.to_radians() / 2.0).tan();
    let tan_right = tan_up * ASPECT;
    // The distance at which every corner of the box is inside the frustum.
    let half = (high - low) / 2.0;
    let mut distance: f64 = 0.0;
    for corner in 0..8 {
        let sign = |bit: i32| if corner & bit == 0 { -1.0 } else { 1.0 };
        let p = half * DVec3::new(sign(1), sign(2), sign(4));
        let needed = (p.dot(right).abs() / tan_right).max(p.dot(up).abs() / tan_up);
        distance = distance.max(needed + p.dot(back));
    }
    let size = half.length().max(1e-6);
    // The corners of the box are mostly empty.
    let distance = (distance * FILLED).max(size * 0.5);
    let position = center + back * distance;
    let nearest = samples
        .iter()
        .map(|(p, _)| (position - *p).dot(back))
        .filter(|depth| *depth > distance * 0.05)
        .fold(distance, f64::min);
    View {
        name: "default".to_owned(),
        position,
        world_from_view: DQuat::from_mat3(&DMat3::from_cols(right, up, back)),
        vertical_fov_rad: VERTICAL_FOV_DEG.to_radians(),
        ipd_m: nearest * IPD_OVER_NEAREST,
        cant_rad: 0.0,
        near_m: nearest * 0.02,
    }
}

/// Centres of the triangles in the world, each weighted by the square root of its area. So both the amount of detail
/// and its size count.
fn samples(primitives: &[Primitive], instances: &[Instance]) -> Vec<(DVec3, f64)> {
    let mut out = Vec::new();
    for instance in instances {
        let primitive = &primitives[instance.primitive];
        for t in primitive.indices.chunks_exact(3) {
            let [a, b, c] = [t[0], t[1], t[2]]
                .map(|i| instance.world_from_object.transform_point3(primitive.positions[i as usize].as_dvec3()));
            let area = (b - a).cross(c - a).length() / 2.0;
            if area.is_finite() {
                out.push(((a + b + c) / 3.0, area.sqrt()));
            }
        }
    }
    out
}

fn trimmed_box(samples: &[(DVec3, f64)]) -> (DVec3, DVec3) {
    if samples.is_empty() {
        return (DVec3::splat(-0.5), DVec3::splat(0.5));
    }
    let total: f64 = samples.iter().map(|s| s.1).sum();
    let (mut low, mut high) = (DVec3::ZERO, DVec3::ZERO);
    for axis in 0..3 {
        let mut along: Vec<(f64, f64)> = samples.iter().map(|(p, w)| (p[axis], *w)).collect();
        along.sort_by(|a, b| a.0.total_cmp(&b.0));
        let at = |share: f64| {
            let mut sum = 0.0;
            let found = along.iter().find(|(_, w)| {
                sum += w;
                sum >= share * total
            });
            found.or(along.last()).map_or(0.0, |s| s.0)
        };
        low[axis] = at(TRIMMED);
        high[axis] = at(1.0 - TRIMMED);
    }
    (low, high)
}

/// Distance along the view's axis to the nearest triangle centre in front of the near plane; 1 when there is none.
pub fn nearest(view: &View, primitives: &[Primitive], instances: &[Instance]) -> f64 {
    let forward = view.world_from_view * DVec3::NEG_Z;
    let depths = samples(primitives, instances).into_iter().map(|(p, _)| (p - view.position).dot(forward));
    let nearest = depths.filter(|d| *d > view.near_m).fold(f64::INFINITY, f64::min);
    if nearest.is_finite() { nearest } else { 1.0 }
}

/// The box around instances in the world. It is a point at the origin when there are no instances.
pub fn bounds<'a>(primitives: &[Primitive], instances: impl Iterator<Item = &'a Instance>) -> (DVec3, DVec3) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for instance in instances {
        for p in &primitives[instance.primitive].positions {
            let p = instance.world_from_object.transform_point3(p.as_dvec3());
            low = low.min(p);
            high = high.max(p);
        }
    }
    if low.is_finite() { (low, high) } else { (DVec3::ZERO, DVec3::ZERO) }
}
