//! Reads the images and lists of the last frame back.

use crate::gpu::{GpuError, Image, read_image};
use crate::picture::StereoPicture;

use super::super::ao::images::AoImages;
use super::super::geometry::Geometry;
use super::super::hits::{self, RayEnd};
use super::super::targets::GBuffer;
use super::Prepared;

impl Prepared {
    /// Linear radiance of the last frame.
    ///
    /// # Errors
    /// When a Vulkan call fails.
    pub fn linear(&self) -> Result<StereoPicture, GpuError> {
        self.picture(&self.targets.linear)
    }

    /// The outgoing reflection alone; zero where none was traced.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn reflection(&self) -> Result<StereoPicture, GpuError> {
        self.picture(&self.targets.reflection_out)
    }

    /// How much of its surroundings each pixel sees, by eye: 1 open, 0 hidden; `None` where ambient light is not occluded.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn ambient_visibility(&self) -> Result<Option<[Vec<f32>; 2]>, GpuError> {
        let Some(ao) = &self.targets.ao else { return Ok(None) };
        let bytes = read_image(&self.gpu, &ao.visibility)?;
        let texels: Vec<f32> = bytemuck::pod_collect_to_vec(&bytes);
        let (left, right) = texels.split_at(texels.len() / 2);
        Ok(Some([left, right].map(|eye| self.framing.crop(eye))))
    }

    /// The number of pixels of the last frame, in both eyes and with a guard band, that adaptive ambient occlusion listed because
    /// they differed visibly between the eyes; `None` for other methods.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn ambient_pixels_again(&self) -> Result<Option<u32>, GpuError> {
        let Some(list) = self.targets.ao.as_ref().and_then(AoImages::listed) else { return Ok(None) };
        list.read_count(&self.gpu).map(Some)
    }

    /// The number of pixels of the right eye, with a guard band, that took no shading from the left eye when the view was last
    /// lit, and were lit in full; `None` if the eyes do not share their shading.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn pixels_lit_again(&self) -> Result<Option<u32>, GpuError> {
        let Some(images) = &self.targets.shading_reuse else { return Ok(None) };
        images.list.read_count(&self.gpu).map(Some)
    }

    /// Standard error of the reflection's mean, per channel; the reference only.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn standard_error(&self, reflection: &StereoPicture) -> Result<Option<StereoPicture>, GpuError> {
        let error = self.targets.path_traced.as_ref().map(|p| self.picture(&p.error)).transpose()?;
        Ok(error.map(|e| masked(e, reflection)))
    }

    /// How the rays of the last sample ended, for each pixel, with a guard band; `None` for methods without a filter.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn ray_ends(&self) -> Result<Option<[Vec<RayEnd>; 2]>, GpuError> {
        self.targets.filtered.as_ref().map(|f| hits::read(&self.gpu, &f.hits, &self.targets.guide)).transpose()
    }

    /// The G-buffer of the last frame, and with the reference the inverse distances of what is reflected.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn geometry(&self) -> Result<Geometry, GpuError> {
        let GBuffer { depth, surface, instance, .. } = &self.targets.gbuffer;
        let read = |image: &Image| read_image(&self.gpu, image);
        let reflection = self.targets.path_traced.as_ref().map(|p| read(&p.reflection)).transpose()?;
        let images = [read(depth)?, read(surface)?, read(instance)?];
        let limit = self.settings.ray_roughness_limit;
        let drawn = Geometry::decode(images.each_ref().map(Vec::as_slice), reflection.as_deref(), limit);
        Ok(drawn.cropped(&self.framing))
    }

    /// sRGB bytes (RGBA) by eye.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn display(&self) -> Result<[Vec<u8>; 2], GpuError> {
        let bytes = read_image(&self.gpu, &self.targets.display)?;
        let (left, right) = bytes.split_at(bytes.len() / 2);
        Ok([left.to_vec(), right.to_vec()])
    }

    /// The tone-mapped picture on the device: two layers of RGBA8 with sRGB values.
    pub fn display_image(&self) -> &Image {
        &self.targets.display
    }

    fn picture(&self, image: &Image) -> Result<StereoPicture, GpuError> {
        let bytes = read_image(&self.gpu, image)?;
        let texels: Vec<[f32; 3]> = bytes
            .chunks_exact(16)
            .map(|t| [0, 4, 8].map(|i| f32::from_le_bytes([t[i], t[i + 1], t[i + 2], t[i + 3]])))
            .collect();
        let (left, right) = texels.split_at(texels.len() / 2);
        let eyes = [left, right].map(|eye| self.framing.crop(eye));
        Ok(StereoPicture { width: self.settings.width, height: self.settings.height, eyes })
    }
}

/// Sets the error to 0 where there is no reflection, because the image of errors was never written there.
fn masked(mut error: StereoPicture, reflection: &StereoPicture) -> StereoPicture {
    for (errors, values) in error.eyes.iter_mut().zip(&reflection.eyes) {
        for (e, v) in errors.iter_mut().zip(values) {
            if *v == [0.0; 3] {
                *e = [0.0; 3];
            }
        }
    }
    error
}
