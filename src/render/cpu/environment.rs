//! Twin of `shaders/common/environment.glsl`: maps of half-precision texels, read bilinearly, repeated around the horizon and
//! clamped at the poles.

use std::f32::consts::PI;

use glam::{Vec2, Vec3A};
use half::f16;

use crate::scene::{self, Equirect};

/// The map's middle column looks along −Z, and its top row looks up.
#[inline]
fn equirect_uv(d: Vec3A) -> Vec2 {
    Vec2::new(d.x.atan2(-d.z) / (2.0 * PI) + 0.5, d.y.clamp(-1.0, 1.0).acos() / PI)
}

struct Map {
    width: i32,
    height: i32,
    texels: Vec<Vec3A>,
}

impl Map {
    /// In half precision, as on the device.
    fn new<'a>(width: u32, levels: impl Iterator<Item = &'a Equirect>) -> Map {
        let half = |x: f32| f16::from_f32(x.clamp(0.0, 65504.0)).to_f32();
        let texels: Vec<Vec3A> = levels.flat_map(|l| &l.texels).map(|t| Vec3A::from(t.map(half))).collect();
        Map { width: width as i32, height: (texels.len() / width as usize) as i32, texels }
    }

    fn sample(&self, uv: Vec2) -> Vec3A {
        bilinear(uv, [self.width, self.height], |i, j| {
            let column = i.rem_euclid(self.width);
            let row = j.clamp(0, self.height - 1);
            self.texels[(row * self.width + column) as usize]
        })
    }
}

/// Bilinear interpolation between texel centres, as the device samples.
#[inline]
pub fn bilinear(uv: Vec2, [width, height]: [i32; 2], texel: impl Fn(i32, i32) -> Vec3A) -> Vec3A {
    let p = uv * Vec2::new(width as f32, height as f32) - 0.5;
    let base = p.floor();
    let f = p - base;
    let (x, y) = (base.x as i32, base.y as i32);
    let row = |y| texel(x, y).lerp(texel(x + 1, y), f.x);
    row(y).lerp(row(y + 1), f.y)
}

/// Light from infinity.
pub struct Environment {
    radiance: Map,
    irradiance: Map,
    /// The prefiltered levels, one below the other.
    specular: Map,
    levels: u32,
}

impl Environment {
    pub fn new(of: &scene::Environment) -> Environment {
        let map = |m: &Equirect| Map::new(m.width, std::iter::once(m));
        // Without prefiltered levels the irradiance replaces them, as in `EnvironmentMaps::new`.
        let specular = match of.specular.first() {
            Some(first) => Map::new(first.width, of.specular.iter()),
            None => map(&of.irradiance),
        };
        let levels = (specular.height * 2 / specular.width).max(1) as u32;
        Environment { radiance: map(&of.radiance), irradiance: map(&of.irradiance), specular, levels }
    }

    pub fn radiance(&self, d: Vec3A) -> Vec3A {
        self.radiance.sample(equirect_uv(d))
    }

    /// Irradiance / π.
    pub fn irradiance(&self, n: Vec3A) -> Vec3A {
        self.irradiance.sample(equirect_uv(n))
    }

    fn specular_level(&self, uv: Vec2, level: f32) -> Vec3A {
        let levels = self.levels as f32;
        let rows = self.specular.height as f32 / levels;
        let v = uv.y.clamp(0.5 / rows, 1.0 - 0.5 / rows);
        self.specular.sample(Vec2::new(uv.x, (level + v) / levels))
    }

    /// GGX-prefiltered radiance about d.
    pub fn specular(&self, d: Vec3A, roughness: f32) -> Vec3A {
        let top = self.levels as f32 - 1.0;
        let level = roughness.clamp(0.0, 1.0) * top;
        let uv = equirect_uv(d);
        let below = level.floor();
        self.specular_level(uv, below).lerp(self.specular_level(uv, (below + 1.0).min(top)), level - below)
    }
}
