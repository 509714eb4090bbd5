//! Pass 9: accumulates each eye's filtered reflection over frames, for methods with a history.
//!
//! Reads the resolve's output and the [`History`], and writes the history of this frame. Recorded by `prepared::record`.

use std::rc::Rc;

use bytemuck::{Pod, Zeroable};

use crate::gpu::{ComputePass, Frame, Gpu, GpuError};

use super::context::Context;
use super::history::History;
use super::method::{Accumulation, HistorySource, Temporal};
use super::needs::FrameNeeds;
use super::shaders;
use super::targets::Targets;
use super::upload::{EnvironmentMaps, SceneResources};

/// See `shaders/accumulate.comp`.
pub struct AccumulatePass {
    pass: ComputePass,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct Constants {
    has_history: u32,
    /// Some object has moved since the last frame.
    is_changing: u32,
}

impl AccumulatePass {
    /// `finish`: no reuse between the eyes follows, so this pass writes the outgoing reflection.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(
        gpu: &Rc<Gpu>,
        needs: &FrameNeeds,
        (how, weights): (Accumulation, Temporal),
        finish: bool,
    ) -> Result<AccumulatePass, GpuError> {
        let weights = match weights {
            Temporal::Variance => 0,
            Temporal::Constant => 1,
            Temporal::Clamp => 2,
        };
        let source = match how.source {
            HistorySource::Better => 0,
            HistorySource::Surface => 1,
            HistorySource::Image => 2,
        };
        let specialization = [weights, source, u32::from(needs.motion), u32::from(finish)];
        let words = shaders::ACCUMULATE_COMP.words();
        Ok(AccumulatePass { pass: ComputePass::new(gpu, "accumulate", &words, &specialization)? })
    }

    /// `fallback` stands in for unknown rays, unless the settings say black.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(
        &self,
        frame: &mut Frame,
        resources: &SceneResources,
        fallback: &EnvironmentMaps,
        context: &Context,
        (targets, history): (&Targets, &History),
    ) -> Result<(), GpuError> {
        let Some(out) = &targets.filtered else { return Ok(()) };
        let Some(pairs) = &out.pairs else { return Ok(()) };
        let (last, new) = (history.last(), history.new_set());
        frame
            .compute(&self.pass)
            .uniform(&context.frame)
            .uniform(history.last_frame())
            .write_buffer(&context.counters)
            .sampled(&targets.gbuffer.surface, &context.nearest)
            .sampled(&targets.guide, &context.nearest)
            .sampled(&pairs.known, &context.nearest)
            .sampled(&pairs.statistics, &context.nearest)
            .sampled(&last.guide, &context.nearest)
            .sampled(&last.known, &context.nearest)
            .sampled(&last.statistics, &context.nearest)
            .sampled(&last.trend, &context.nearest)
            .write(&new.guide)
            .write(&new.known)
            .write(&new.statistics)
            .write(&new.trend)
            .with(|chain| context.bind_surroundings(chain, &resources.environment, fallback))
            .write(&out.reflection)
            .read_buffer(history.motions())
            .sampled(&out.hits, &context.nearest)
            .sampled(&targets.gbuffer.instance, &context.nearest)
            .constants(&Constants {
                has_history: u32::from(history.exists()),
                is_changing: u32::from(history.is_changing()),
            })
            .dispatch_stereo(targets.gbuffer.depth.extent())
    }
}
