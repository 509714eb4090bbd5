//! Twin of `shaders/common/shade.glsl`, `shade_hit.glsl` and `shadow.glsl`: the light that leaves the point where a ray hit the
//! scene's geometry, and the share of each light that reaches that point.

use std::f32::consts::PI;

use glam::{Vec2, Vec3A};

use super::super::shared::{FrameUniform, MASKED, TRANSMITS};
use super::baked::baked_light;
use super::inputs::{Inputs, Tally};
use super::lights::LightKind;
use super::math::{Basis, FAR, reflect};
use super::random::Sequence;
use super::surface::Surface;
use super::tree::{Intersection, Obstacle, Stack};
use super::world::World;

/// How far off the surface's plane a ray to a light starts, as a share of the distance from the head. Rounding can put a point
/// below its triangle by less than this.
const SHADOW_OFFSET: f32 = 2e-4;

/// Maps the unit square to the unit disc so that neighbours stay neighbours (Shirley & Chiu 1997).
pub fn on_disc(u: [f32; 2]) -> Vec2 {
    let (x, y) = (2.0 * u[0] - 1.0, 2.0 * u[1] - 1.0);
    if x == 0.0 && y == 0.0 {
        return Vec2::ZERO;
    }
    let wide = x.abs() > y.abs();
    let r = if wide { x } else { y };
    let phi = if wide { 0.25 * PI * y / x } else { 0.5 * PI - 0.25 * PI * x / y };
    let (sin, cos) = phi.sin_cos();
    Vec2::new(cos, sin) * r
}

/// The random numbers of the sample to which a hit belongs.
pub struct Draws<'a> {
    /// For each light the sequence of points on its disc; used only for lights that have a size.
    pub lights: &'a [Sequence],
    pub index: u32,
}

/// A thread's state for shading hits.
pub struct Shading<'a> {
    pub inputs: &'a Inputs<'a>,
    pub stack: Stack,
    pub walk: LightWalk<'a>,
    pub tally: Tally,
}

impl Shading<'_> {
    /// The light that leaves a hit: emission, punctual lights with their shadows, baked light or the diffuse environment, and the
    /// specular environment where the surface is too rough for a ray.
    pub fn shade_hit(
        &mut self,
        (s, emission): (&Surface, Vec3A),
        hit: &Intersection,
        (position, v): (Vec3A, Vec3A),
        draws: &Draws<'_>,
    ) -> Vec3A {
        let inputs = self.inputs;
        let mut sum = self.without_lights((s, emission), hit, v);
        for (i, light) in inputs.world.lights.iter().enumerate() {
            let mut arrives = light.on(s, position, v);
            if arrives == Vec3A::ZERO {
                continue;
            }
            if inputs.shadows && light.casts_shadow {
                let disc = || on_disc(draws.lights[i].sample(draws.index));
                arrives *= self.walk.share(i, position, s.face_normal, disc);
            }
            sum += arrives;
        }
        sum
    }

    /// `shade_without_lights`, or `shade_without_lights_in` where there is baked light.
    fn without_lights(&self, (s, emission): (&Surface, Vec3A), hit: &Intersection, v: Vec3A) -> Vec3A {
        let Inputs { world, table, gathered, frame, .. } = self.inputs;
        let FrameUniform { ray_roughness_limit, .. } = **frame;
        let specular = table.specular_albedo(s.f0, s.normal.dot(v).max(1e-4), s.roughness);
        let mut diffuse = s.albedo * (Vec3A::ONE - specular);
        let too_rough = s.roughness > ray_roughness_limit;
        if let Some(gathered) = gathered {
            let back = world.sees_back(hit.triangle, -v);
            if too_rough {
                diffuse += specular;
            }
            return emission + diffuse * baked_light(gathered, world, hit.triangle, hit.uv, back);
        }
        let environment = &world.content.environment;
        let mut sum = emission + diffuse * environment.irradiance(s.normal);
        if too_rough {
            sum += specular * environment.specular(reflect(-v, s.normal), s.roughness);
        }
        sum
    }
}

/// A thread's state for rays from surfaces to lights.
pub struct LightWalk<'a> {
    world: &'a World,
    stack: Stack,
    /// The number of rays so far.
    pub rays: u64,
    /// For each light the pack of triangles that hid it last. The same pack often hides it from the next point, so it is tested
    /// before the tree. The result is the same, because any opaque triangle hides the light.
    hid_last: Vec<Option<u32>>,
}

impl<'a> LightWalk<'a> {
    pub fn new(world: &'a World) -> LightWalk<'a> {
        LightWalk { world, stack: Stack::new(), rays: 0, hid_last: vec![None; world.lights.len()] }
    }

    /// The share of a shadow-casting light that reaches a point. `index` is the light's; `disc` gives the point of the light,
    /// as a point of the unit disc.
    pub fn share(&mut self, index: usize, position: Vec3A, face_normal: Vec3A, disc: impl FnOnce() -> Vec2) -> Vec3A {
        let light = &self.world.lights[index];
        let origin = position + face_normal * (SHADOW_OFFSET * position.length());
        let across = |toward: Vec3A, size: f32, disc: Vec2| {
            let basis = Basis::about(toward);
            basis.x * (size * disc.x) + basis.y * (size * disc.y)
        };
        let mut toward;
        // The ray ends just before the light, so that a surface on which the light lies does not hide it.
        let mut t_max = 1.0 - 1e-4;
        match light.kind {
            LightKind::Directional(direction) => {
                toward = -direction;
                if light.size > 0.0 {
                    toward += across(toward, light.size, disc());
                }
                t_max = FAR;
            }
            LightKind::At { position, .. } => {
                toward = position - origin;
                let d = toward.length();
                // The disc is never wider than its distance from the point, not even for a point inside the light.
                if light.size > 0.0 && d > 0.0 {
                    toward += across(toward / d, light.size.min(0.5 * d), disc());
                }
            }
        }
        if toward.dot(face_normal) <= 0.0 {
            return Vec3A::ZERO;
        }
        self.transmittance(index, (origin, toward, t_max))
    }

    fn transmittance(&mut self, light: usize, (origin, direction, t_max): (Vec3A, Vec3A, f32)) -> Vec3A {
        self.rays += 1;
        let world = self.world;
        let is_cut = |met: &Obstacle| met.flags & MASKED != 0 && !world.uncut(met.triangle, met.uv);
        let lets_on = |met: Obstacle| met.flags & TRANSMITS != 0 || is_cut(&met);
        if let Some(pack) = self.hid_last[light]
            && !world.tree.every_of_pack(pack, (origin, direction, t_max), lets_on)
        {
            return Vec3A::ZERO;
        }
        let mut share = Vec3A::ONE;
        let hid_last = &mut self.hid_last[light];
        world.tree.every(origin, direction, t_max, &mut self.stack, |met| {
            if is_cut(&met) {
                return true;
            }
            if met.flags & TRANSMITS == 0 {
                share = Vec3A::ZERO;
                *hid_last = Some(met.pack);
                return false;
            }
            share *= world.let_through(met.triangle, met.uv);
            true
        });
        share
    }
}
