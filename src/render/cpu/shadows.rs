//! Twin of `shaders/shadows.comp`: the outgoing light of the punctual lights at each pixel of the views, with shadows.

use std::f32::consts::TAU;
use std::rc::Rc;
use std::time::Instant;

use glam::{Vec2, Vec3A};

use crate::gpu::{Gpu, GpuError, Image, PassTime, read_image};

use super::super::context::Context;
use super::super::shadows::rays_a_light;
use super::super::shared::FrameUniform;
use super::super::targets::GBuffer;
use super::lights::Light;
use super::parallel::on_all_cores;
use super::path_trace::View;
use super::random::{DRAW_LIGHT, DRAW_RIM, Sequence, draw_1d};
use super::shade::{LightWalk, on_disc};
use super::surface::Surface;
use super::world::World;

/// Shares of a light that differ by less than this count as equal, because the share that glass lets through is rounded
/// differently for each order of surfaces.
const ALIKE: f32 = 1e-3;

/// Replaces [`super::super::shadows::ShadowsPass`].
pub struct CpuShadows {
    gpu: Rc<Gpu>,
    soft_rays: u32,
}

impl CpuShadows {
    /// `soft_rays`: rays to a light that has a size, for each pixel in its penumbra.
    pub fn new(gpu: &Rc<Gpu>, soft_rays: u32) -> CpuShadows {
        CpuShadows { gpu: Rc::clone(gpu), soft_rays }
    }

    /// Reads back what the device has drawn, by a frame that must have finished, and writes `direct`. `finer`: see
    /// [`super::super::shadows::ShadowsPass::record`].
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn run(
        &self,
        world: &World,
        context: &Context,
        (gbuffer, direct): (&GBuffer, &Image),
        finer: u32,
    ) -> Result<PassTime, GpuError> {
        let started = Instant::now();
        let depth = read_image(&self.gpu, &gbuffer.depth)?;
        let surface = read_image(&self.gpu, &gbuffer.surface)?;
        let (width, height) = gbuffer.depth.extent();
        let frame = context.uniform();
        let rays = rays_a_light(self.soft_rays, finer);
        let mut texels = vec![[0.0f32, 0.0, 0.0, 1.0]; 2 * width as usize * height as usize];
        on_all_cores(
            texels.chunks_mut(width.max(1) as usize).enumerate(),
            || ShadowTracer { world, frame: &frame, rays, walk: LightWalk::new(world) },
            |lit, (row, texels)| {
                let (eye, y) = (row as u32 / height, row as u32 % height);
                let view = View::of(&frame, eye);
                for (x, texel) in (0u32..).zip(texels) {
                    let i = row * width as usize + x as usize;
                    let depth: f32 = bytemuck::pod_read_unaligned(&depth[4 * i..4 * i + 4]);
                    if depth != 0.0 {
                        let packed = bytemuck::pod_read_unaligned(&surface[16 * i..16 * i + 16]);
                        let light = lit.pixel(&view, Surface::unpack(packed), depth, [x, y, eye]);
                        texel[..3].copy_from_slice(&light.to_array());
                    }
                }
            },
        );
        direct.write_layers(bytemuck::cast_slice(&texels))?;
        Ok(PassTime { name: "shadows".to_owned(), ms: started.elapsed().as_secs_f64() * 1e3 })
    }
}

/// A thread's state.
struct ShadowTracer<'a> {
    world: &'a World,
    frame: &'a FrameUniform,
    /// The numbers of rays to a light's rim, and in its penumbra.
    rays: (u32, u32),
    walk: LightWalk<'a>,
}

impl ShadowTracer<'_> {
    fn pixel(&mut self, view: &View, surface: Surface, depth: f32, [x, y, eye]: [u32; 3]) -> Vec3A {
        let position = view.position([x as f32 + 0.5, y as f32 + 0.5], depth);
        let v = (view.eye() - position).normalize();
        // As in the shader, a guard band does not change the random numbers of the pixels that are shown.
        let [left, top] = self.frame.guard;
        let shown = [x.wrapping_sub(left), y.wrapping_sub(top), eye];
        let mut direct = Vec3A::ZERO;
        for (i, light) in (0u32..self.frame.light_count).zip(&self.world.lights) {
            let arrives = light.on(&surface, position, v);
            if arrives != Vec3A::ZERO {
                direct += arrives * self.mean_share((i, light), position, surface.face_normal, shown);
            }
        }
        direct
    }

    /// The share of a light that reaches a point. For a light with a size, a few rays to the rim of its disc first ask whether
    /// all of the rim is equally visible. If it is, all of the disc counts as visible or hidden: an edge across the disc that
    /// none of six rays finds hides at most 3 % of it.
    fn mean_share(
        &mut self,
        (i, light): (u32, &Light),
        position: Vec3A,
        face_normal: Vec3A,
        [x, y, eye]: [u32; 3],
    ) -> Vec3A {
        if !light.casts_shadow {
            return Vec3A::ONE;
        }
        let mut share = |disc: Vec2| self.walk.share(i as usize, position, face_normal, || disc);
        if light.size == 0.0 {
            return share(Vec2::ZERO);
        }
        let (rim_rays, soft_rays) = self.rays;
        let turn = draw_1d(0, eye, [x, y], i, DRAW_RIM);
        let (mut low, mut high) = (Vec3A::ONE, Vec3A::ZERO);
        for k in 0..rim_rays {
            let (sin, cos) = (TAU * (k as f32 + turn) / rim_rays as f32).sin_cos();
            let found = share(Vec2::new(cos, sin));
            (low, high) = (low.min(found), high.max(found));
        }
        if (high - low).max_element() < ALIKE {
            return low;
        }
        // The random numbers do not depend on the seed, so that a view's shadows are as fixed as its geometry.
        let points = Sequence::of_purpose(0, DRAW_LIGHT + i, eye, [x, y]);
        let sum: Vec3A = (0..soft_rays).map(|k| share(on_disc(points.sample(k)))).sum();
        sum / soft_rays as f32
    }
}
