//! The images of a frame, allocated only where the frame needs them.

use std::rc::Rc;

use ash::vk;

use crate::gpu::{Gpu, GpuError, Image, ImageDesc};

use super::ao::images::AoImages;
use super::method::{Method, Traversal};
use super::needs::Needs;
use super::ray_list::RayList;
use super::settings::Settings;
use super::shading_reuse::images::Shared;

/// Levels of the depth pyramid above its base (twin: `TOP_LEVEL` in march.glsl).
pub const TOP_LEVEL: u32 = 6;

/// What the raster pass leaves behind.
pub struct GBuffer {
    pub depth: Image,
    pub surface: Image,
    pub instance: Image,
    /// `None` when nothing emits.
    pub emission: Option<Image>,
}

/// What rays are marched through.
pub struct Marched {
    /// `None` when no mesh is closed.
    pub back_depth: Option<Image>,
    pub pyramid: Image,
    /// Rays for the other eye; a list that stays empty when the method has none.
    pub retries: RayList,
    /// Rays for the scene's geometry; likewise.
    pub lost: RayList,
}

/// What an eye's filter knows, for the other eye or the frames to come.
pub struct Pairs {
    /// The known share of the light, and how much is known.
    pub known: Image,
    /// Weight of the taps; nearness of what is reflected; variance of the light, where the eyes are blended by it.
    pub standing: Image,
    /// Pixels whose eyes may differ visibly, where only they are blended.
    pub visible: Option<RayList>,
}

/// Hits and their filter.
pub struct Filtered {
    pub hits: Image,
    /// Where rays may bring their own radiance.
    pub ray_radiance: Option<Image>,
    /// Where the other eye has a say.
    pub pairs: Option<Pairs>,
    pub reflection: Image,
    /// Sums over several samples a pixel.
    pub sums: Option<(Image, Image)>,
}

/// The reference's accumulators.
pub struct PathSums {
    pub sum: Image,
    pub compensation: Image,
    pub squares: Image,
}

/// What the reference's paths come to.
pub struct PathTraced {
    /// `None` where the processor adds up.
    pub sums: Option<PathSums>,
    pub reflection: Image,
    pub error: Image,
}

/// Every image of a frame.
pub struct Targets {
    pub gbuffer: GBuffer,
    /// Where ambient light is occluded.
    pub ao: Option<AoImages>,
    pub radiance: Image,
    /// What the punctual lights put on each pixel; `None` where none of them casts a shadow and the eyes share nothing.
    pub direct: Option<Image>,
    /// Baked light of each pixel's surface; `None` without any.
    pub indirect: Option<Image>,
    /// Where the eyes share shading.
    pub shared: Option<Shared>,
    pub rays: Option<RayList>,
    /// What the resolve asks of neighbours; a single texel where nothing is resolved.
    pub guide: Image,
    pub marched: Option<Marched>,
    pub filtered: Option<Filtered>,
    pub path_traced: Option<PathTraced>,
    /// What is shown, without a guard band.
    pub display: Image,
    pub linear: Image,
    pub reflection_out: Image,
    /// Stands in where a shader names an image (RGBA32F) that this frame does without.
    pub nothing: Image,
}

impl Targets {
    /// `settings` are those of what is drawn, `shown` is the size of what is shown of it.
    ///
    /// # Errors
    /// When device memory runs out: the message names the image and its bytes.
    pub fn new(
        gpu: &Rc<Gpu>,
        settings: &Settings,
        shown: (u32, u32),
        needs: &Needs,
        method: &Method,
    ) -> Result<Targets, GpuError> {
        let (w, h) = (settings.width, settings.height);
        let stereo = |what: &str, format| Image::new(gpu, what, ImageDesc::stereo(w, h, format));
        let drawn = |what: &str, format| Image::new(gpu, what, ImageDesc::stereo_target(w, h, format));
        let rgba32 = vk::Format::R32G32B32A32_SFLOAT;
        let rgba16 = vk::Format::R16G16B16A16_SFLOAT;
        let whole = |what: &str| match needs.composite {
            true => stereo(what, rgba32),
            false => Image::new(gpu, what, ImageDesc::stereo(1, 1, rgba32)),
        };
        let texels = u64::from(w) * u64::from(h) * 2;
        let gbuffer = GBuffer {
            depth: drawn("depth", vk::Format::D32_SFLOAT)?,
            surface: drawn("surface", vk::Format::R32G32B32A32_UINT)?,
            instance: drawn("instance", vk::Format::R32_UINT)?,
            emission: needs.emission.then(|| drawn("emission", rgba16)).transpose()?,
        };
        let rays = match needs.rays {
            false => None,
            true => Some(RayList::new(gpu, texels)?),
        };
        let parts = method.parts();
        let marched = match needs.screen_space {
            false => None,
            true => Some(Marched {
                back_depth: needs.back_faces.then(|| drawn("back depth", vk::Format::D32_SFLOAT)).transpose()?,
                pyramid: Image::new(gpu, "depth pyramid", pyramid_desc(w, h))?,
                retries: RayList::new(gpu, if parts.traversal == Traversal::TwoStages { texels } else { 0 })?,
                lost: RayList::new(gpu, if needs.geometry { texels } else { 0 })?,
            }),
        };
        let filtered = match needs.resolve {
            false => None,
            true => Some(Filtered {
                hits: stereo("hits", vk::Format::R32G32B32A32_UINT)?,
                ray_radiance: (parts.resolved || needs.geometry).then(|| stereo("ray radiance", rgba16)).transpose()?,
                pairs: match needs.pairs {
                    false => None,
                    true => Some(Pairs {
                        known: stereo("known light", rgba16)?,
                        standing: stereo("standing", rgba32)?,
                        visible: method.weber_share().map(|_| RayList::new(gpu, texels)).transpose()?,
                    }),
                },
                reflection: stereo("reflection", rgba16)?,
                sums: match method.samples() {
                    1 => None,
                    _ => Some((stereo("reflection sums", rgba32)?, stereo("reflection weights", rgba32)?)),
                },
            }),
        };
        // What the processor writes.
        let written = |what: &str| {
            let desc = ImageDesc::stereo(w, h, rgba32);
            Image::new(gpu, what, ImageDesc { usage: desc.usage | vk::ImageUsageFlags::TRANSFER_DST, ..desc })
        };
        let path_traced = match needs.path_trace && !needs.resolve {
            false => None,
            true if needs.cpu_paths => {
                Some(PathTraced { sums: None, reflection: written("path mean")?, error: written("path error")? })
            }
            true => Some(PathTraced {
                sums: Some(PathSums {
                    sum: stereo("path sums", rgba32)?,
                    compensation: stereo("path compensation", rgba32)?,
                    squares: stereo("path squares", rgba32)?,
                }),
                reflection: stereo("path mean", rgba32)?,
                error: stereo("path error", rgba32)?,
            }),
        };
        Ok(Targets {
            gbuffer,
            ao: (!settings.ao.is_off()).then(|| AoImages::new(gpu, settings.ao.method, (w, h))).transpose()?,
            radiance: stereo("radiance", rgba16)?,
            indirect: needs.indirect.then(|| stereo("indirect light", rgba16)).transpose()?,
            direct: match needs.direct() {
                false => None,
                true if needs.cpu_shadows => Some(written("direct light")?),
                true => Some(stereo("direct light", rgba32)?),
            },
            shared: needs.shading_reuse.then(|| Shared::new(gpu, needs, (w, h))).transpose()?,
            guide: match needs.resolve {
                true => stereo("guide", vk::Format::R32G32B32A32_UINT)?,
                false => Image::new(gpu, "guide", ImageDesc::stereo(1, 1, vk::Format::R32G32B32A32_UINT))?,
            },
            rays,
            marched,
            filtered,
            path_traced,
            display: Image::new(gpu, "display", ImageDesc::stereo(shown.0, shown.1, vk::Format::R8G8B8A8_UNORM))?,
            linear: whole("linear")?,
            reflection_out: whole("reflection out")?,
            nothing: Image::new(gpu, "nothing", ImageDesc::stereo(1, 1, rgba32))?,
        })
    }
}

/// The base is padded to whole cells of the top level.
fn pyramid_desc(width: u32, height: u32) -> ImageDesc {
    let whole = |n: u32| n.next_multiple_of(1 << TOP_LEVEL);
    ImageDesc { mips: TOP_LEVEL + 1, ..ImageDesc::stereo(whole(width), whole(height), vk::Format::R32G32_SFLOAT) }
}
