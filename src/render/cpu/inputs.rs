//! What every path reads, and what all of them count.

use glam::{Vec2, Vec3A};

use super::super::baked::HostBakedLight;
use super::super::shared::{Counts, FrameUniform};
use super::environment::bilinear;
use super::world::World;

/// What every path reads.
pub struct Inputs<'a> {
    pub world: &'a World,
    pub table: &'a BrdfTable,
    /// Baked light, if it replaces the environment's diffuse light.
    pub gathered: Option<&'a HostBakedLight>,
    pub frame: &'a FrameUniform,
    /// Some light casts a shadow.
    pub shadows: bool,
}

/// A and B of the specular lobe's albedo F0·A + B, as `brdf_table.comp` integrated them on the device.
pub struct BrdfTable {
    pub side: i32,
    /// x: A, y: B.
    pub texels: Vec<Vec3A>,
}

impl BrdfTable {
    /// The albedo of a lobe of `roughness` (0 to 1) seen at the cosine `nv`, with `f0` at normal incidence.
    pub fn specular_albedo(&self, f0: Vec3A, nv: f32, roughness: f32) -> Vec3A {
        let side = self.side as f32;
        let uv = (Vec2::new(nv.clamp(0.0, 1.0), roughness.clamp(0.0, 1.0)) * (side - 1.0) + 0.5) / side;
        let ab = bilinear(uv, [self.side; 2], |i, j| {
            let inside = |k: i32| k.clamp(0, self.side - 1);
            self.texels[(inside(j) * self.side + inside(i)) as usize]
        });
        f0 * ab.x + Vec3A::splat(ab.y)
    }
}

/// Counts how paths ended.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tally {
    pub below_horizon: u64,
    pub sky: u64,
    pub hits: u64,
    pub nan: u64,
    pub clamped: u64,
    /// Rays from hits to lights, which the counters of a frame do not count.
    pub light_rays: u64,
}

impl Tally {
    pub fn add(&mut self, other: &Tally) {
        self.below_horizon += other.below_horizon;
        self.sky += other.sky;
        self.hits += other.hits;
        self.nan += other.nan;
        self.clamped += other.clamped;
        self.light_rays += other.light_rays;
    }

    /// Adds them to a frame's counters.
    pub fn count(&self, counts: &mut Counts) {
        counts.below_horizon += self.below_horizon;
        counts.sky += self.sky;
        counts.hits += self.hits;
        counts.rays += self.sky + self.hits;
        counts.nan += self.nan;
        counts.clamped += self.clamped;
    }
}
