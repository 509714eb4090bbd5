//! The pass that traces the reference's paths on the processor: reads the device's images back, adds samples, and writes the
//! results to the device.

use std::rc::Rc;
use std::time::Instant;

use glam::Vec3A;
use half::f16;

use crate::gpu::{Gpu, GpuError, Image, PassTime, read_image};

use super::super::baked::HostBakedLight;
use super::super::context::Context;
use super::super::convergence::relative_error;
use super::super::needs::FrameNeeds;
use super::super::ray_list::RayList;
use super::super::shared::Counts;
use super::super::targets::{GBuffer, PathTraceImages};
use super::inputs::{BrdfTable, Inputs, Tally};
use super::path_trace::{KeptPixel, KeptSums, Pixel, add_samples};
use super::world::World;

/// Replaces [`super::super::path_trace::PathTracePass`].
pub struct CpuPathTrace {
    gpu: Rc<Gpu>,
    table: BrdfTable,
    shadows: bool,
    indirect: bool,
}

/// The pixels of a frame while their samples are added.
pub struct Paths<'a> {
    pass: &'a CpuPathTrace,
    world: &'a World,
    context: &'a Context,
    gathered: Option<&'a HostBakedLight>,
    pixels: Vec<Pixel>,
    samples: u32,
    tally: Tally,
    started: Instant,
}

impl CpuPathTrace {
    /// # Errors
    /// When the BRDF table cannot be read back.
    pub fn new(gpu: &Rc<Gpu>, needs: &FrameNeeds, context: &Context) -> Result<CpuPathTrace, GpuError> {
        let bytes = read_image(gpu, &context.brdf_table)?;
        let half = |b: &[u8]| f16::from_le_bytes([b[0], b[1]]).to_f32();
        let texels = bytes.chunks_exact(8).map(|t| Vec3A::new(half(t), half(&t[2..]), 0.0)).collect();
        let table = BrdfTable { side: context.brdf_table.extent().0 as i32, texels };
        Ok(CpuPathTrace { gpu: Rc::clone(gpu), table, shadows: needs.shadows, indirect: needs.indirect })
    }

    /// Reads back what the device has drawn and listed, by frames that must have finished. Continues from `kept`, if those are
    /// the sums of the same pixels.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn begin<'a>(
        &'a self,
        world: &'a World,
        context: &'a Context,
        (list, gbuffer): (&RayList, &GBuffer),
        kept: Option<&KeptSums>,
    ) -> Result<Paths<'a>, GpuError> {
        let started = Instant::now();
        let mut listed = list.read(&self.gpu)?;
        // Sorted row by row, because neighbours meet the same geometry; the device's threads wrote them in any order.
        listed.sort_unstable();
        let depth = read_image(&self.gpu, &gbuffer.depth)?;
        let surface = read_image(&self.gpu, &gbuffer.surface)?;
        let size = gbuffer.depth.extent();
        let pixels = listed.into_iter().map(|packed| {
            let i = RayList::texel(packed, size);
            let depth = bytemuck::pod_read_unaligned(&depth[4 * i..4 * i + 4]);
            Pixel::new(packed, depth, bytemuck::pod_read_unaligned(&surface[16 * i..16 * i + 16]))
        });
        let mut pixels: Vec<Pixel> = pixels.collect();
        let mut samples = 0;
        let same = |kept: &&KeptSums| kept.pixels.iter().map(KeptPixel::packed).eq(pixels.iter().map(Pixel::packed));
        if let Some(kept) = kept.filter(same) {
            pixels.iter_mut().zip(&kept.pixels).for_each(|(pixel, kept)| pixel.continue_from(kept));
            samples = kept.samples;
        }
        let gathered = self.indirect.then(|| context.baked.gathered());
        Ok(Paths { pass: self, world, context, gathered, pixels, samples, tally: Tally::default(), started })
    }
}

impl Paths<'_> {
    /// Adds this many samples to each pixel.
    pub fn add(&mut self, count: u32, counts: &mut Counts) {
        let frame = self.context.uniform();
        let inputs = Inputs {
            world: self.world,
            table: &self.pass.table,
            gathered: self.gathered,
            frame: &frame,
            shadows: self.pass.shadows,
        };
        let tally = add_samples(&inputs, &mut self.pixels, (self.samples, count));
        tally.count(counts);
        self.tally.add(&tally);
        self.samples += count;
    }

    /// The number of samples of each pixel so far.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    pub fn sums(&self) -> KeptSums {
        KeptSums { samples: self.samples, pixels: self.pixels.iter().map(Pixel::keep).collect() }
    }

    /// See [`relative_error`].
    pub fn relative_error(&self) -> f64 {
        let results = || self.pixels.iter().map(|p| p.result(self.samples));
        relative_error(|| results().map(|(mean, error)| (mean.truncate(), error.into())))
    }

    /// Writes mean and standard error into the pass' images, and returns the time since [`CpuPathTrace::begin`].
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn finish(self, out: &PathTraceImages, counts: &mut Counts) -> Result<PassTime, GpuError> {
        let size = out.reflection.extent();
        let texels = 2 * size.0 as usize * size.1 as usize;
        let (mut means, mut errors) = (vec![[0.0f32; 4]; texels], vec![[0.0f32; 4]; texels]);
        for pixel in &self.pixels {
            let (mean, error) = pixel.result(self.samples);
            let color = mean.truncate();
            counts.nan += u64::from(color.is_nan());
            counts.inf += u64::from(color.to_array().iter().any(|c| c.is_infinite()));
            let i = RayList::texel(pixel.packed(), size);
            (means[i], errors[i]) = (mean.to_array(), error.extend(0.0).to_array());
        }
        let write = |image: &Image, texels: &[[f32; 4]]| image.write_layers(bytemuck::cast_slice(texels));
        write(&out.reflection, &means)?;
        write(&out.error, &errors)?;
        let seconds = self.started.elapsed().as_secs_f64();
        tracing::debug!("{} rays from hits to lights, {seconds:.3} s on the processor", self.tally.light_rays);
        Ok(PassTime { name: "path_trace".to_owned(), ms: seconds * 1e3 })
    }
}
