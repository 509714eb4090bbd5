//! Ambient occlusion estimated from the views: the passes of `mono`, `fsa`, `variant1` and `variant2`.

use std::rc::Rc;

use bytemuck::{Pod, Zeroable};

use super::images::{AoImages, EstimateImages, StereoImages};
use super::settings::AoSettings;
use crate::gpu::{ComputePass, Dispatch, Frame, Gpu, GpuError, Image};
use crate::method::Ao;
use crate::render::context::Context;
use crate::render::ray_list::RayList;
use crate::render::shaders;
use crate::render::targets::GBuffer;

/// What the passes of a frame read and write.
#[derive(Clone, Copy)]
pub struct AoBindings<'a> {
    pub context: &'a Context,
    pub gbuffer: &'a GBuffer,
    pub images: &'a AoImages,
}

/// Estimates and filters the visibility; the stereo methods add passes that combine the eyes.
pub struct ViewsPass {
    settings: AoSettings,
    obscurance: ComputePass,
    filter: [ComputePass; 2],
    stereo: Option<StereoPasses>,
}

struct StereoPasses {
    pairs: ComputePass,
    /// For methods that estimate all pixels in both views.
    reproject: Option<ComputePass>,
    /// Blends all pixels, or with the adaptive methods the listed ones.
    blend: ComputePass,
    /// Lists the pixels that differ visibly between the eyes, with the adaptive methods.
    select: Option<ComputePass>,
    /// Estimates and filters the listed pixels again, in both views, with [`Ao::Variant1`].
    again: Option<(ComputePass, [ComputePass; 2])>,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct EstimateConstants {
    radius_m: f32,
    threshold: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
struct ThresholdConstants {
    share: f32,
}

impl ViewsPass {
    /// # Errors
    /// When a Vulkan call fails.
    pub fn new(gpu: &Rc<Gpu>, settings: AoSettings) -> Result<ViewsPass, GpuError> {
        let ao = settings.method;
        let pass = |name, shader: &crate::gpu::Shader, constants: &[u32]| {
            ComputePass::new(gpu, name, &shader.words(), constants)
        };
        let both = u32::from(ao.samples_both_views());
        let keep = u32::from(ao.is_stereo());
        let filter = |name, shader| -> Result<[ComputePass; 2], GpuError> {
            Ok([pass(name, shader, &[0, keep])?, pass(name, shader, &[1, keep])?])
        };
        let stereo = || -> Result<StereoPasses, GpuError> {
            let again = || -> Result<_, GpuError> {
                let estimate = pass("ao_obscurance_listed", &shaders::AO_OBSCURANCE_LISTED_COMP, &[1])?;
                Ok((estimate, filter("ao_filter_listed", &shaders::AO_FILTER_LISTED_COMP)?))
            };
            let reproject = || pass("ao_reproject", &shaders::AO_REPROJECT_COMP, &[]);
            let select = || pass("ao_adaptive", &shaders::AO_ADAPTIVE_COMP, &[]);
            Ok(StereoPasses {
                pairs: pass("ao_pairs", &shaders::AO_PAIRS_COMP, &[])?,
                reproject: ao.samples_both_views().then(reproject).transpose()?,
                blend: match ao.is_adaptive() {
                    true => pass("ao_blend_listed", &shaders::AO_BLEND_LISTED_COMP, &[])?,
                    false => pass("ao_blend", &shaders::AO_BLEND_COMP, &[])?,
                },
                select: ao.is_adaptive().then(select).transpose()?,
                again: (ao == Ao::Variant1).then(again).transpose()?,
            })
        };
        Ok(ViewsPass {
            settings,
            obscurance: pass("ao_obscurance", &shaders::AO_OBSCURANCE_COMP, &[both])?,
            filter: filter("ao_filter", &shaders::AO_FILTER_COMP)?,
            stereo: ao.is_stereo().then(stereo).transpose()?,
        })
    }

    /// # Errors
    /// When a Vulkan call fails.
    pub fn record(&self, frame: &mut Frame, bindings: AoBindings<'_>) -> Result<(), GpuError> {
        let Some(out) = &bindings.images.estimated else { return Ok(()) };
        let extent = bindings.images.visibility.extent();
        let context = bindings.context;
        let pairs = out.stereo.as_ref().zip(self.stereo.as_ref());
        if let Some((images, passes)) = pairs {
            frame
                .compute(&passes.pairs)
                .uniform(&context.frame)
                .sampled(&bindings.gbuffer.surface, &context.nearest)
                .sampled(&bindings.gbuffer.depth, &context.nearest)
                .write(&images.pairs)
                .dispatch_stereo(extent)?;
        }
        self.estimate(frame.compute(&self.obscurance), bindings, out).dispatch_stereo(extent)?;
        if let Some((images, passes)) = pairs
            && let Some(reproject) = &passes.reproject
        {
            frame
                .compute(reproject)
                .uniform(&context.frame)
                .sampled(&images.pairs, &context.nearest)
                .read_write(&out.raw)
                .dispatch_stereo(extent)?;
        }
        for second in [false, true] {
            let pass = &self.filter[usize::from(second)];
            filter(frame.compute(pass), bindings, out, second).dispatch_stereo(extent)?;
        }
        match pairs {
            Some((images, passes)) => self.compare_eyes(frame, bindings, (out, images), passes),
            None => Ok(()),
        }
    }

    /// Records the passes after each eye's filter: the search for visible differences, and the blending of the eyes.
    fn compare_eyes(
        &self,
        frame: &mut Frame,
        bindings: AoBindings<'_>,
        (out, images): (&EstimateImages, &StereoImages),
        passes: &StereoPasses,
    ) -> Result<(), GpuError> {
        let (context, visibility) = (bindings.context, &bindings.images.visibility);
        let (Some(select), Some(list)) = (&passes.select, &images.visible) else {
            return blend(frame.compute(&passes.blend), bindings, images).dispatch_stereo(visibility.extent());
        };
        list.clear(frame);
        frame
            .compute(select)
            .uniform(&context.frame)
            .sampled(&images.pairs, &context.nearest)
            .sampled(visibility, &context.nearest)
            .write_buffer(&list.rays)
            .write_buffer(&list.arguments)
            .constants(&ThresholdConstants { share: self.settings.threshold })
            .dispatch_stereo(visibility.extent())?;
        if let Some((obscurance, filters)) = &passes.again {
            self.estimate(frame.compute(obscurance), bindings, out)
                .read_buffer(&list.rays)
                .read_buffer(&list.arguments)
                .sampled(visibility, &context.nearest)
                .dispatch_indirect(&list.arguments, 0)?;
            for second in [false, true] {
                listed(filter(frame.compute(&filters[usize::from(second)]), bindings, out, second), list)?;
            }
        }
        listed(blend(frame.compute(&passes.blend), bindings, images), list)
    }

    /// Binds what `ao_obscurance.comp` reads and writes.
    fn estimate<'f>(&self, chain: Dispatch<'f>, bindings: AoBindings<'f>, out: &'f EstimateImages) -> Dispatch<'f> {
        let context = bindings.context;
        // Without pairs the shader does not read this image.
        let pairs = out.stereo.as_ref().map_or(&bindings.gbuffer.surface, |s| &s.pairs);
        chain
            .uniform(&context.frame)
            .sampled(&bindings.gbuffer.surface, &context.nearest)
            .sampled(&bindings.gbuffer.depth, &context.nearest)
            .sampled(pairs, &context.nearest)
            .write(&out.raw)
            .constants(&EstimateConstants { radius_m: self.settings.radius_m, threshold: self.settings.threshold })
    }
}

/// Binds what `ao_filter.comp` reads and writes: along x in the first pass, along y in the second.
fn filter<'f>(chain: Dispatch<'f>, bindings: AoBindings<'f>, out: &'f EstimateImages, second: bool) -> Dispatch<'f> {
    let context = bindings.context;
    // Without pairs the second filter keeps no weights and does not write to this image.
    let filtered = out.stereo.as_ref().map_or(&out.raw, |s| &s.filtered);
    let (from, to): (&Image, &Image) = if second { (&out.rows, filtered) } else { (&out.raw, &out.rows) };
    chain
        .uniform(&context.frame)
        .sampled(&bindings.gbuffer.surface, &context.nearest)
        .sampled(from, &context.nearest)
        .write(to)
        .write(&bindings.images.visibility)
}

/// Binds what `ao_blend.comp` reads and writes.
fn blend<'f>(chain: Dispatch<'f>, bindings: AoBindings<'f>, images: &'f StereoImages) -> Dispatch<'f> {
    let context = bindings.context;
    chain
        .uniform(&context.frame)
        .sampled(&images.pairs, &context.nearest)
        .sampled(&images.filtered, &context.nearest)
        .write(&bindings.images.visibility)
}

/// Dispatches over the listed pixels.
fn listed<'f>(chain: Dispatch<'f>, list: &'f RayList) -> Result<(), GpuError> {
    chain.read_buffer(&list.rays).read_buffer(&list.arguments).dispatch_indirect(&list.arguments, 0)
}
