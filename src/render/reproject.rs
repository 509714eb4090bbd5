//! Pass 9: blends each pixel's reflection with the other eye's view of the same reflection.

use std::rc::Rc;

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::context::Context;
use super::history::History;
use super::method::{Method, Reprojection};
use super::needs::FrameNeeds;
use super::shaders;
use super::targets::Targets;
use super::upload::{EnvironmentMaps, SceneResources};

/// See `shaders/reproject.comp`.
pub struct ReprojectPass {
    /// Lists the pixels in which the eyes may differ visibly, for methods that reproject only those.
    select: Option<ComputePass>,
    pass: ComputePass,
}

impl ReprojectPass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(
        gpu: &Rc<Gpu>,
        needs: &FrameNeeds,
        (how, method): (Reprojection, &Method),
    ) -> Result<ReprojectPass, GpuError> {
        let select = || ComputePass::new(gpu, "resolve_select", &shaders::RESOLVE_SELECT_COMP.words(), &[]);
        let select = method.weber_share().is_some().then(select).transpose()?;
        let specialization = [how.filling, how.back_check, how.lobe_tolerance, needs.blend_by_variance].map(u32::from);
        let words = shaders::REPROJECT_COMP.words();
        Ok(ReprojectPass { select, pass: ComputePass::new(gpu, "reproject", &words, &specialization)? })
    }

    /// `fallback` stands in for unknown rays, unless the settings say black. With a history the accumulated reflection is blended
    /// in place of this frame's.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        resources: &SceneResources,
        fallback: &EnvironmentMaps,
        context: &Context,
        (targets, history): (&Targets, Option<&History>),
    ) -> Result<(), GpuError> {
        let (Some(list), Some(out)) = (&targets.rays, &targets.filtered) else { return Ok(()) };
        let Some(pairs) = &out.pairs else { return Ok(()) };
        let list = match (&self.select, &pairs.visible) {
            (Some(select), Some(visible)) => {
                visible.clear(frame);
                frame
                    .compute(select)
                    .read_buffer(&list.rays)
                    .read_buffer(&list.arguments)
                    .sampled(&pairs.statistics, &context.nearest)
                    .write_buffer(&visible.rays)
                    .write_buffer(&visible.arguments)
                    .dispatch_indirect(&list.arguments, 0)?;
                visible
            }
            _ => list,
        };
        let (known, statistics) = match history {
            Some(history) => (&history.new_set().known, &history.new_set().statistics),
            None => (&pairs.known, &pairs.statistics),
        };
        frame
            .compute(&self.pass)
            .uniform(&context.frame)
            .read_buffer(&list.rays)
            .read_buffer(&list.arguments)
            .write_buffer(&context.counters)
            .sampled(&targets.gbuffer.surface, &context.nearest)
            .sampled(&targets.guide, &context.nearest)
            .sampled(known, &context.nearest)
            .sampled(statistics, &context.nearest)
            .with(|chain| context.bind_surroundings(chain, &resources.environment, fallback))
            .write(&out.reflection)
            .dispatch_indirect(&list.arguments, 0)
    }
}
