//! The views of shadow maps: where they look from and what they cover, in the maps' space.

use glam::{DMat3, DVec2, DVec3};

use super::super::shared::ShadowMapData;

/// The maps of a point or spot light overlap their neighbours by a band around each map, which the widest filter reads. This is
/// half the band's width, as a share of the map's half width (twin: GUARD in shadow_map.glsl).
const GUARD: f64 = 0.15;
/// Half the opening angle of the widest spot light that one map covers; a wider one needs a cube.
const WIDEST_SPOT_RAD: f64 = 1.22;
/// The near plane of a point or spot light is at the light's radius, within these two shares of the scene's radius. Nearer
/// matter, such as the pole of the lamp, would hide everything from the light's centre.
const NEAREST: [f64; 2] = [1e-4, 0.1];

/// One map's view.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShadowMapView {
    /// Columns: right, up, ahead; orthonormal.
    axes: DMat3,
    /// Where the map looks from, metres.
    from: DVec3,
    /// Takes metres (in a perspective: metres a metre ahead) to ±1 at the map's border.
    scale: DVec2,
    /// Metres ahead.
    near: f64,
    /// Metres ahead; `None`: the map is a perspective from the light, without an end.
    far: Option<f64>,
}

/// A point or spot light, in which the rays of a perspective map meet; metres.
#[derive(Debug, Clone, Copy)]
pub struct LocalLight {
    pub position: DVec3,
    pub radius: f64,
    pub scene_radius: f64,
}

/// Corners of a box, metres.
pub type Corners = [DVec3; 8];

/// The bounds of the scene in the axes of a directional light.
#[derive(Debug, Clone, Copy)]
pub struct LightSpaceBounds {
    axes: DMat3,
    low: DVec3,
    high: DVec3,
}

/// Axes (right, up, ahead) that look along a direction.
fn axes_along(along: DVec3) -> DMat3 {
    let ahead = along.try_normalize().unwrap_or(DVec3::NEG_Y);
    let right = ahead.any_orthonormal_vector();
    DMat3::from_cols(right, right.cross(ahead), ahead)
}

/// The maps of a point light, in the order +x −x +y −y +z −z (twin: `cube_side` in shadow_map.glsl).
pub fn cube(light: LocalLight) -> [ShadowMapView; 6] {
    let ways = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    ways.map(|way| perspective(light, way, 1.0))
}

/// The map of a spot light, or `None` where its cone is too wide for one.
pub fn spot(light: LocalLight, direction: DVec3, outer_rad: f64) -> Option<ShadowMapView> {
    (outer_rad <= WIDEST_SPOT_RAD).then(|| perspective(light, direction, outer_rad.tan().max(1e-3)))
}

fn perspective(light: LocalLight, way: DVec3, tangent: f64) -> ShadowMapView {
    let scale = DVec2::splat(1.0 / (tangent + GUARD));
    let [least, most] = NEAREST.map(|share| share * light.scene_radius);
    ShadowMapView {
        axes: axes_along(way),
        from: light.position,
        scale,
        near: light.radius.clamp(least, most),
        far: None,
    }
}

impl LightSpaceBounds {
    /// `boxes`: the bounding boxes of all instances; `radius`: half the diagonal of the scene's bounds, metres.
    pub fn new(direction: DVec3, boxes: &[Corners], radius: f64) -> LightSpaceBounds {
        let axes = axes_along(direction);
        let seen = || boxes.iter().flatten().map(|c| axes.transpose() * *c);
        // The margin gives a flat scene a thickness, so that nothing is divided by zero.
        let margin = DVec3::splat(0.02 * radius);
        let low = seen().fold(DVec3::INFINITY, DVec3::min) - margin;
        let high = seen().fold(DVec3::NEG_INFINITY, DVec3::max) + margin;
        LightSpaceBounds { axes, low, high }
    }

    /// The view of the whole scene.
    pub fn whole_scene(&self) -> ShadowMapView {
        let (middle, half) = ((self.low + self.high) / 2.0, (self.high - self.low) / 2.0);
        self.square(middle.truncate(), half.truncate())
    }

    /// The view of `half` metres to each side of `center`. The centre is rounded to whole texels of a map with `side` texels
    /// along a side, so that maps with other centres have the same texels.
    pub fn centered_at(&self, center: DVec3, half: f64, side: u32) -> ShadowMapView {
        let texel = 2.0 * half / f64::from(side);
        let seen = (self.axes.transpose() * center).truncate();
        self.square((seen / texel).round() * texel, DVec2::splat(half))
    }

    fn square(&self, center: DVec2, half: DVec2) -> ShadowMapView {
        let from = self.axes * center.extend(0.0);
        ShadowMapView { axes: self.axes, from, scale: half.recip(), near: self.low.z, far: Some(self.high.z) }
    }
}

impl ShadowMapView {
    /// The view as shaders read it.
    pub fn data(&self) -> ShadowMapData {
        let row = |axis: DVec3| axis.extend(-axis.dot(self.from)).as_vec4().to_array();
        ShadowMapData {
            right: row(self.axes.x_axis),
            up: row(self.axes.y_axis),
            forward: row(self.axes.z_axis),
            scale: self.scale.as_vec2().to_array(),
            near: self.near as f32,
            far: self.far.unwrap_or(0.0) as f32,
        }
    }

    /// Whether something inside the box can be on the map.
    pub fn sees(&self, corners: &Corners) -> bool {
        let seen = corners.map(|c| {
            let p = self.axes.transpose() * (c - self.from);
            let across = p.truncate() * self.scale;
            (across, if self.far.is_some() { 1.0 } else { p.z }, p.z)
        });
        let is_beyond = |beyond: &dyn Fn(&(DVec2, f64, f64)) -> bool| seen.iter().all(beyond);
        !(is_beyond(&|(p, w, _)| p.x > *w)
            || is_beyond(&|(p, w, _)| p.x < -w)
            || is_beyond(&|(p, w, _)| p.y > *w)
            || is_beyond(&|(p, w, _)| p.y < -w)
            || is_beyond(&|(_, _, ahead)| *ahead < self.near))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn box_at(center: DVec3, half: f64) -> Corners {
        std::array::from_fn(|i| {
            let sign = |bit: usize| if i >> bit & 1 == 1 { half } else { -half };
            center + DVec3::new(sign(0), sign(1), sign(2))
        })
    }

    #[test]
    fn each_side_of_a_cube_sees_what_is_before_it() {
        let sides = cube(LocalLight { position: DVec3::new(1.0, 2.0, 3.0), radius: 0.0, scene_radius: 10.0 });
        let ways = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        for (i, way) in ways.into_iter().enumerate() {
            let there = box_at(DVec3::new(1.0, 2.0, 3.0) + 5.0 * way, 0.5);
            let seen: Vec<usize> = (0..6).filter(|&k| sides[k].sees(&there)).collect();
            assert_eq!(seen, [i]);
        }
        let around = box_at(DVec3::new(1.0, 2.0, 3.0), 0.5);
        assert!(sides.iter().all(|s| s.sees(&around)));
    }

    #[test]
    fn a_cascade_moves_by_whole_texels() {
        let along = LightSpaceBounds::new(DVec3::new(0.3, -1.0, 0.2), &[box_at(DVec3::ZERO, 5.0)], 9.0);
        let (a, b) =
            (along.centered_at(DVec3::ZERO, 2.0, 256), along.centered_at(DVec3::new(0.31, 0.0, -0.17), 2.0, 256));
        let moved = (a.axes.transpose() * (b.from - a.from)).truncate() * (256.0 / 4.0);
        assert!(moved.length() > 1.0 && moved.distance(moved.round()) < 1e-9, "{moved}");
    }

    #[test]
    fn a_wide_spot_takes_a_cube() {
        let local_light = LocalLight { position: DVec3::ZERO, radius: 0.0, scene_radius: 1.0 };
        assert!(spot(local_light, DVec3::NEG_Y, 0.6).is_some());
        assert!(spot(local_light, DVec3::NEG_Y, 1.5).is_none());
    }
}
