//! Measures of ambient occlusion: how much the eyes differ, and how far one method is from another. They are those of
//! seed 001 (Wu, adaptive stereo ambient occlusion), its equation 2, table 1 and table 2. `compare::ao` calls them. A
//! picture holds one visibility for each pixel: 1 is open and 0 is hidden.

use super::Surfaces;
use super::pairs::EyeSurfaces;

/// The least difference between the eyes that can be seen, as a share of the pixel's own value. This is Weber's law
/// with the 2 % of Walter et al.'s Lightcuts.
pub const VISIBLE: f64 = 0.02;

/// The pairs of pixels, one in each eye, that show the same place on a surface. They are found by reprojection and a
/// check that leads back. Both are indices, row-major. `traced` and `inverse_hit_distance` of the surfaces are not
/// used.
pub fn places(surfaces: &Surfaces<'_>) -> Vec<[u32; 2]> {
    // The search for pairs looks for what a pixel reflects. With a hit at no distance, that is the surface itself.
    let drawn = surfaces.eyes.map(|eye| eye.depth.iter().map(|d| *d > 0.0).collect::<Vec<bool>>());
    let near = surfaces.eyes.map(|eye| vec![ON_THE_SURFACE; eye.depth.len()]);
    let eyes =
        [0, 1].map(|i: usize| EyeSurfaces { traced: &drawn[i], inverse_hit_distance: &near[i], ..surfaces.eyes[i] });
    Surfaces { eyes, ..*surfaces }.pairs().map(|pair| pair.map(|i| i as u32)).collect()
}

/// 1 / the distance of a hit that lies practically on the surface, in 1/m.
const ON_THE_SURFACE: f32 = 1e12;

/// The share of the paired pixels that differ visibly from their partner: |A(p) − A(p*)| is at least 2 % of A(p). Both
/// pixels of a pair are counted, each by its own value. `None` without pairs.
pub fn inconsistency(pairs: &[[u32; 2]], eyes: [&[f32]; 2]) -> Option<f64> {
    super::mean(pairs.iter().map(|pair| {
        let [l, r] = [0, 1].map(|eye| f64::from(eyes[eye][pair[eye] as usize]));
        let seen = |own: f64| f64::from(u8::from(l != r && (l - r).abs() >= VISIBLE * own));
        (seen(l) + seen(r)) / 2.0
    }))
}

/// The mean absolute difference over all pixels of both eyes.
pub fn mean_absolute_error(of: [&[f32]; 2], reference: [&[f32]; 2]) -> Option<f64> {
    let pixels = of.into_iter().zip(reference).flat_map(|(x, y)| x.iter().zip(y));
    super::mean(pixels.map(|(x, y)| f64::from((x - y).abs())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::View;
    use glam::{DQuat, DVec3, Vec3};

    #[test]
    fn a_difference_is_seen_relative_to_what_is_there() {
        let pairs = [[0, 0], [1, 1], [2, 2], [3, 3]];
        // The pairs are equal, differ by 1 %, differ by 3 %, and are both black.
        let (left, right) = ([1.0, 0.5, 0.5, 0.0], [1.0, 0.505, 0.515, 0.0]);
        assert_eq!(inconsistency(&pairs, [&left, &right]), Some(0.25));
        // The difference is 2.02 % of the darker value and 1.98 % of the brighter one.
        assert_eq!(inconsistency(&[[0, 0]], [&[0.99], &[1.01]]), Some(0.5));
        assert_eq!(inconsistency(&[], [&left, &right]), None);
    }

    #[test]
    fn errors_are_absolute_and_of_both_eyes() {
        let found = mean_absolute_error([&[0.5, 1.0], &[0.0, 1.0]], [&[0.75, 1.0], &[0.25, 0.5]]);
        assert_eq!(found, Some(0.25));
        assert_eq!(mean_absolute_error([&[], &[]], [&[], &[]]), None);
    }

    /// For a wall two metres in front of the eyes, the two pixels of a place are a constant number of pixels apart.
    #[test]
    fn places_are_those_of_the_surface() {
        const W: usize = 64;
        const H: usize = 32;
        let view = View {
            name: "main".to_owned(),
            position: DVec3::ZERO,
            world_from_view: DQuat::IDENTITY,
            vertical_fov_rad: 0.9,
            ipd_m: 0.2,
            cant_rad: 0.0,
            near_m: 0.05,
        };
        let camera = view.stereo_camera(W as f64 / H as f64);
        let depth = [(0.05f32 / 2.0); W * H];
        let (instance, normal, none, rough) = ([1; W * H], [Vec3::Z; W * H], [false; W * H], [1.0; W * H]);
        // No pixel traces a ray, because places do not depend on that.
        let eye = EyeSurfaces {
            traced: &none,
            depth: &depth,
            instance: &instance,
            normal: &normal,
            face_normal: &normal,
            roughness: &rough,
            inverse_hit_distance: &[-1.0; W * H],
        };
        let surfaces = Surfaces { camera: &camera, width: W, height: H, delta_roughness: 0.03, eyes: [eye, eye] };
        let found = places(&surfaces);
        assert!(found.len() > W * H / 2, "{}", found.len());
        let metres_a_pixel = 2.0 * 2.0 * (0.45f64).tan() / H as f64;
        for [l, r] in found {
            assert_eq!(l as usize / W, r as usize / W);
            let off = (l as f64 - r as f64) - 0.2 / metres_a_pixel;
            assert!(off.abs() <= 0.51, "{l} and {r}");
        }
    }
}
