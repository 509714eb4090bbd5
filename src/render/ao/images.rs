//! The images of ambient occlusion. Those that the method does not use are not allocated.

use std::rc::Rc;

use ash::vk;

use super::super::method::Ao;
use crate::gpu::{Gpu, GpuError, Image, ImageDesc};
use crate::render::ray_list::RayList;

/// See the module's documentation.
pub struct AoImages {
    /// How much of its surroundings a pixel sees: 1 open, 0 hidden.
    pub visibility: Image,
    pub estimated: Option<EstimateImages>,
    /// Sums over the rays so far, with [`Ao::RayTraced`].
    pub sum: Option<Image>,
}

/// The images of the methods that estimate visibility from the views.
pub struct EstimateImages {
    /// Visibility before the filter, with depth.
    pub raw: Image,
    /// Visibility filtered along x, with the taps' weight and depth.
    pub rows: Image,
    pub stereo: Option<StereoImages>,
}

/// The further images of the methods that combine both eyes.
pub struct StereoImages {
    /// The map of pairs: each pixel's depth, and the other eye's pixel that shows the same place.
    pub pairs: Image,
    /// Filtered visibility, with the taps' weight and depth.
    pub filtered: Image,
    /// The list of pixels that differ visibly from their pair, of the adaptive methods.
    pub visible: Option<RayList>,
}

impl AoImages {
    /// The list of pixels that differ visibly between the eyes, of the adaptive methods.
    pub fn listed(&self) -> Option<&RayList> {
        self.estimated.as_ref()?.stereo.as_ref()?.visible.as_ref()
    }

    /// # Errors
    /// When device memory runs out: the message names the image and its bytes.
    pub fn new(gpu: &Rc<Gpu>, ao: Ao, (width, height): (u32, u32)) -> Result<AoImages, GpuError> {
        let stereo = |what: &str, format| Image::new(gpu, what, ImageDesc::stereo(width, height, format));
        let words = |what: &str| stereo(what, vk::Format::R32G32_UINT);
        let pixels = 2 * u64::from(width) * u64::from(height);
        Ok(AoImages {
            visibility: stereo("ambient visibility", vk::Format::R32_SFLOAT)?,
            estimated: match ao.is_estimated() {
                false => None,
                true => Some(EstimateImages {
                    raw: words("raw ambient visibility")?,
                    rows: words("ambient visibility along x")?,
                    stereo: match ao.is_stereo() {
                        false => None,
                        true => Some(StereoImages {
                            pairs: words("pairs of places")?,
                            filtered: words("filtered ambient visibility")?,
                            visible: ao.is_adaptive().then(|| RayList::new(gpu, pixels)).transpose()?,
                        }),
                    },
                }),
            },
            sum: (ao == Ao::RayTraced).then(|| stereo("ambient rays", vk::Format::R32_SFLOAT)).transpose()?,
        })
    }
}
