//! Baked light: indirect diffuse light, gathered by path tracing once for a scene and kept at points of its surfaces. The
//! renderer obtains it; `indirect.comp` and the shading of hits look it up.
//!
//! In each round every point sends cosine-weighted rays. Their hits are shaded by the lights, their emission and the light of the
//! previous round, so that each round adds a bounce. Rounds go on until the mean light has converged; a last round sends more
//! rays. Lights and geometry are those of time 0: moving instances keep the light that they have there.

mod gather;
mod lattice;
pub mod light;
mod store;

use std::path::Path;
use std::rc::Rc;

use bytemuck::{Pod, Zeroable};

use crate::console::check_interrupted;
use crate::gpu::{Buffer, ComputePass, Frame, Gpu, GpuError, Image, read_buffer};
use crate::scene::Scene;

use super::bvh::{RayScene, upload_rows};
use super::context::Context;
use super::error::RenderError;
use super::needs::FrameNeeds;
use super::shaders;
use super::upload::SceneResources;
use gather::Gathering;
use lattice::Lattice;
pub use light::{BakedLight, HostBakedLight};

/// The approximate number of gathering points; there are fewer where surfaces are small.
const POINTS: f64 = 40_000.0;
/// The least spacing of points, metres.
const CLOSEST: f64 = 0.01;
/// Rays of each point in the rounds, and in the last one, whose light is kept.
const RAYS: u32 = 16;
const LAST_RAYS: u32 = 96;
/// Rounds end when the mean light changes by less than this share, or after MOST_ROUNDS of them.
const SETTLED: f64 = 0.004;
const MOST_ROUNDS: u32 = 24;
/// The largest number of rays in a submission, which take about half a second on a software device.
const RAYS_A_SUBMISSION: u32 = 200_000;

impl BakedLight {
    /// Reads the scene's baked light from `folder`, or gathers it and stores it there.
    ///
    /// # Errors
    /// When a Vulkan call fails, on Ctrl-C, or when the folder cannot be written.
    pub fn obtain(
        gpu: &Rc<Gpu>,
        scene: &Scene,
        (resources, rays): (&SceneResources, &RayScene),
        (context, needs): (&Context, &FrameNeeds),
        folder: Option<&Path>,
    ) -> Result<BakedLight, RenderError> {
        let key = store::key(scene, needs, gpu.info().kind);
        let folder = folder.filter(|_| !scene.content_sha256.is_empty());
        if let Some(kept) = folder.and_then(|f| store::read(f, &key))
            && let Some(lattice) = Lattice::new(scene, rays.head, kept.spacing)
            && lattice.points.len() == kept.values.len()
        {
            return BakedLight::new(gpu, lattice, kept.values);
        }
        let (lattice, gathering, spacing) = place(scene, rays);
        let patches = upload_rows(gpu, "light patches", &lattice.patches)?;
        let points = upload_points(gpu, &gathering, spacing as f32)?;
        let emitters = Buffer::with_content(gpu, "emitters", &rays.emitters)?;
        let baker = Baker { gpu, resources, rays, context, points, emitters };
        let kept = store::BakedLightFile { spacing, values: baker.rounds(&gathering, &patches, needs)? };
        if let Some(folder) = folder {
            store::write(folder, &key, &kept)?;
        }
        BakedLight::new(gpu, lattice, kept.values)
    }

    fn new(gpu: &Rc<Gpu>, lattice: Lattice, light: Vec<[f32; 4]>) -> Result<BakedLight, RenderError> {
        let gathered = HostBakedLight { patches: lattice.patches, light };
        Ok(BakedLight {
            patches: upload_rows(gpu, "light patches", &gathered.patches)?,
            light: upload_rows(gpu, "baked light", &gathered.light)?,
            gathered,
        })
    }
}

/// The lattice and the gathering points of a scene, and their spacing in metres, which is as fine as [`POINTS`] allows.
fn place(scene: &Scene, rays: &RayScene) -> (Lattice, Gathering, f64) {
    let mut spacing = (lattice::area(scene) / POINTS).sqrt().max(CLOSEST);
    loop {
        if let Some(lattice) = Lattice::new(scene, rays.head, spacing) {
            let gathering = Gathering::new(&lattice, spacing as f32);
            if (gathering.points.len() as f64) < 1.5 * POINTS || spacing > 1e6 {
                return (lattice, gathering, spacing);
            }
        }
        spacing *= 1.5;
    }
}

/// Uploads two vectors for each point: where its rays start and how far they are lifted off the surface; the normal.
fn upload_points(gpu: &Rc<Gpu>, gathering: &Gathering, spacing: f32) -> Result<Buffer, GpuError> {
    let lift = |p: f32| (2e-4 * p).max(2e-3 * spacing);
    let words: Vec<[f32; 4]> = gathering
        .points
        .iter()
        .flat_map(|p| [p.inner.extend(lift(p.inner.length())).to_array(), p.normal.extend(0.0).to_array()])
        .collect();
    Buffer::with_content(gpu, "gathering points", &words)
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    first_point: u32,
    point_count: u32,
    ray_count: u32,
    round: u32,
    emitter_count: u32,
    emitted: f32,
}

struct Baker<'a> {
    gpu: &'a Rc<Gpu>,
    resources: &'a SceneResources,
    rays: &'a RayScene,
    context: &'a Context,
    points: Buffer,
    emitters: Buffer,
}

impl Baker<'_> {
    fn rounds(&self, gathering: &Gathering, patches: &Image, needs: &FrameNeeds) -> Result<Vec<[f32; 4]>, RenderError> {
        let words = self.rays.variant(&shaders::GATHER_COMP, &shaders::GATHER_RAY_QUERY_COMP).words();
        let [mask, shadows, glass, _] = needs.of_hits();
        let pass = ComputePass::new(self.gpu, "gather", &words, &[mask, shadows, glass, 1])?;
        let count = gathering.points.len();
        let mut values = gathering.spread(&vec![[0.0; 4]; count]);
        // The mean light after the previous round, and after the one before it.
        let (mut before, mut earlier) = (0.0f64, 0.0f64);
        for round in 0..MOST_ROUNDS {
            let mut gathered = self.round(&pass, (patches, &values), count as u32, (RAYS, round))?;
            let mean = mean(&gathered);
            let (last, this) = (before - earlier, mean - before);
            // The bounces form nearly a geometric series: after the third round, the rest of it is added at once.
            let ratio = this / last;
            if round == 2 && (0.0..0.95).contains(&ratio) {
                let rest = (ratio / (1.0 - ratio) * this / mean.max(f64::MIN_POSITIVE)) as f32;
                gathered.iter_mut().for_each(|g| (0..3).for_each(|c| g[c] *= 1.0 + rest));
            }
            values = gathering.spread(&gathered);
            (earlier, before) = (before, self::mean(&gathered));
            if this.abs() <= SETTLED * mean {
                break;
            }
        }
        let gathered = self.round(&pass, (patches, &values), count as u32, (LAST_RAYS, MOST_ROUNDS))?;
        Ok(gathering.spread(&gathered))
    }

    /// Gathers one round for every point.
    fn round(
        &self,
        pass: &ComputePass,
        (patches, values): (&Image, &[[f32; 4]]),
        count: u32,
        (ray_count, round): (u32, u32),
    ) -> Result<Vec<[f32; 4]>, RenderError> {
        let light = upload_rows(self.gpu, "baked light", values)?;
        let gathered = Buffer::device(self.gpu, "gathered", u64::from(count.max(1)) * 16)?;
        let (emitter_count, emitted) = (self.rays.emitters.len() as u32, self.rays.emitted);
        let step = (RAYS_A_SUBMISSION / ray_count).next_multiple_of(64);
        for first in (0..count).step_by(step as usize) {
            check_interrupted()?;
            let point_count = step.min(count - first);
            let mut frame = Frame::begin(self.gpu)?;
            frame
                .compute(pass)
                .uniform(&self.context.frame)
                .read_buffer(&self.context.lights)
                .with(|chain| self.rays.bind(chain, self.resources, self.context))
                .with(|chain| self.context.bind_environment(chain, &self.resources.environment))
                .sampled(patches, &self.context.nearest)
                .sampled(&light, &self.context.nearest)
                .read_buffer(&self.points)
                .write_buffer(&gathered)
                .read_buffer(&self.emitters)
                .constants(&Constants { first_point: first, point_count, ray_count, round, emitter_count, emitted })
                .dispatch(point_count.div_ceil(64), 1, 1)?;
            frame.finish()?;
        }
        let bytes = read_buffer(self.gpu, &gathered)?;
        Ok(bytes.chunks_exact(16).take(count as usize).map(bytemuck::pod_read_unaligned).collect())
    }
}

fn mean(gathered: &[[f32; 4]]) -> f64 {
    let sum: f64 = gathered.iter().map(|g| f64::from(g[0]) + f64::from(g[1]) + f64::from(g[2])).sum();
    sum / (3 * gathered.len().max(1)) as f64
}
