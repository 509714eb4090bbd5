//! Twin of `shaders/common/lights.glsl`: the light that arrives at a surface from punctual lights, and that leaves it towards v.

use std::f32::consts::PI;

use glam::Vec3A;

use super::super::shared::LightData;
use super::brdf::{ggx_times_cosine, schlick};
use super::math::{normalize_or, square};
use super::surface::Surface;

/// Punctual lights have no size, so that a mirror would not show them. Their highlights are computed with at least this
/// roughness.
const PUNCTUAL_ROUGHNESS: f32 = 0.1;
/// The least squared distance of a light, in square metres; a nearer light is treated as being that far away.
const NEAREST_SQUARED: f32 = 1e-8;
/// More than any target can hold, and still finite after the multiplication by the lobe and a sum over lights.
const MOST_IRRADIANCE: Vec3A = Vec3A::splat(1e30);

/// [`LightData`] in the types of this folder.
pub struct Light {
    pub kind: LightKind,
    /// Irradiance (directional) or radiant intensity.
    color: Vec3A,
    /// Radius, metres; for a directional light the tangent of half its angular diameter.
    pub size: f32,
    pub casts_shadow: bool,
}

pub enum LightKind {
    /// The light travels along it.
    Directional(Vec3A),
    At {
        position: Vec3A,
        range: f32,
        cone: Option<Cone>,
    },
}

pub struct Cone {
    direction: Vec3A,
    cos_inner: f32,
    cos_outer: f32,
}

impl Light {
    pub fn new(data: &LightData) -> Light {
        let direction = Vec3A::from(data.direction);
        let (cos_inner, cos_outer) = (data.cos_inner, data.cos_outer);
        let kind = match data.kind {
            0 => LightKind::Directional(direction),
            kind => LightKind::At {
                position: Vec3A::from(data.position),
                range: data.range,
                cone: (kind == 2).then_some(Cone { direction, cos_inner, cos_outer }),
            },
        };
        Light { kind, color: Vec3A::from(data.color), size: data.size, casts_shadow: data.casts_shadow != 0 }
    }

    /// Irradiance on a surface facing the light, and the direction towards it.
    #[inline]
    fn incident(&self, position: Vec3A) -> (Vec3A, Vec3A) {
        match &self.kind {
            LightKind::Directional(direction) => (self.color.min(MOST_IRRADIANCE), -*direction),
            LightKind::At { position: at, range, cone } => {
                let to_light = *at - position;
                let d2 = to_light.dot(to_light).max(NEAREST_SQUARED);
                let l = to_light * (1.0 / d2.sqrt());
                // The range's window function of KHR_lights_punctual.
                let q = d2 / square(*range);
                let window = (1.0 - q * q).clamp(0.0, 1.0);
                let cone = cone.as_ref().map_or(1.0, |c| {
                    let cos = c.direction.dot(-l);
                    square(((cos - c.cos_outer) / (c.cos_inner - c.cos_outer).max(1e-4)).clamp(0.0, 1.0))
                });
                ((self.color * (window * cone / d2)).min(MOST_IRRADIANCE), l)
            }
        }
    }

    /// The outgoing light of this light, without shadows.
    #[inline]
    pub fn on(&self, s: &Surface, position: Vec3A, v: Vec3A) -> Vec3A {
        let (e, l) = self.incident(position);
        let nl = s.normal.dot(l);
        if nl <= 0.0 {
            return Vec3A::ZERO;
        }
        let alpha = square(s.roughness.max(PUNCTUAL_ROUGHNESS));
        let f = schlick(s.f0, v.dot(normalize_or(v + l, s.normal)).max(0.0));
        e * (s.albedo * (Vec3A::ONE - f) * (nl / PI) + ggx_times_cosine(s.normal, v, l, alpha, s.f0))
    }
}
