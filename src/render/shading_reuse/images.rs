//! What the passes of shared shading leave for each other, allocated only where the eyes share shading.

use std::rc::Rc;

use ash::vk;

use crate::gpu::{Gpu, GpuError, Image, ImageDesc};
use crate::render::needs::FrameNeeds;
use crate::render::ray_list::RayList;

/// See the module's documentation.
pub struct ShadingReuseImages {
    /// The diffuse part of the lights' light at the left eye's pixels, without the albedo.
    pub(super) diffuse: Image,
    /// The pixels of the right eye that take nothing from the left one.
    pub list: RayList,
    /// Which lights arrive in full and which are hidden (known_lights.glsl); a single texel where no light casts a shadow.
    pub(super) known: Image,
}

impl ShadingReuseImages {
    /// For views of this width and height, pixels.
    ///
    /// # Errors
    /// When device memory runs out: the message names the image and its bytes.
    pub fn new(gpu: &Rc<Gpu>, needs: &FrameNeeds, (width, height): (u32, u32)) -> Result<ShadingReuseImages, GpuError> {
        let one_eye = |width, height| ImageDesc {
            layers: 1,
            ..ImageDesc::stereo(width, height, vk::Format::R16G16B16A16_SFLOAT)
        };
        let (known_width, known_height) = if needs.shadows { (width, height) } else { (1, 1) };
        let known = ImageDesc::stereo(known_width, known_height, vk::Format::R32G32B32A32_UINT);
        Ok(ShadingReuseImages {
            known: Image::new(gpu, "known lights", known)?,
            diffuse: Image::new(gpu, "diffuse light", one_eye(width, height))?,
            list: RayList::new(gpu, u64::from(width) * u64::from(height))?,
        })
    }
}
