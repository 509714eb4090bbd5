//! What is read back of the last frame.

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
    /// What the device said; also below.
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

    /// Pixels of the last frame, of both eyes and a guard band, that adaptive ambient occlusion worked on again; `None`
    /// of other methods.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn ambient_pixels_again(&self) -> Result<Option<u32>, GpuError> {
        let Some(list) = self.targets.ao.as_ref().and_then(AoImages::listed) else { return Ok(None) };
        list.read_count(&self.gpu).map(Some)
    }

    /// Pixels of the right eye, a guard band included, that took no shading from the left one and were lit in full, when the
    /// view was lit last; `None` where the eyes share nothing.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn pixels_lit_again(&self) -> Result<Option<u32>, GpuError> {
        let Some(shared) = &self.targets.shared else { return Ok(None) };
        shared.list.read_count(&self.gpu).map(Some)
    }

    /// Standard error of the reflection's mean, per channel; the reference only.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn standard_error(&self, reflection: &StereoPicture) -> Result<Option<StereoPicture>, GpuError> {
        let error = self.targets.path_traced.as_ref().map(|p| self.picture(&p.error)).transpose()?;
        Ok(error.map(|e| masked(e, reflection)))
    }

    /// How the rays of the last sample ended, pixel by pixel; `None` where none are filtered. A guard band is in it.
    ///
    /// # Errors
    /// As [`Prepared::linear`].
    pub fn ray_ends(&self) -> Result<Option<[Vec<RayEnd>; 2]>, GpuError> {
        self.targets.filtered.as_ref().map(|f| hits::read(&self.gpu, &f.hits, &self.targets.guide)).transpose()
    }

    /// What the pixels of the last frame show, apart from light.
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

    /// The tone-mapped picture where it lies: two layers of RGBA8, sRGB values.
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

/// The error exists where a reflection does; elsewhere the image was never written.
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
