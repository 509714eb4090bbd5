//! The images and ray lists of a frame. Those that [`FrameNeeds`] does not ask for are not allocated.

use std::rc::Rc;

use ash::vk;

use crate::gpu::{Gpu, GpuError, Image, ImageDesc};

use super::ao::images::AoImages;
use super::method::{Method, Traversal};
use super::needs::FrameNeeds;
use super::ray_list::RayList;
use super::settings::Settings;
use super::shading_reuse::images::ShadingReuseImages;

/// Levels of the depth pyramid above its base (twin: `TOP_LEVEL` in march.glsl).
pub const TOP_LEVEL: u32 = 6;

/// The images that the raster pass draws; see `gbuffer.frag`.
pub struct GBuffer {
    pub depth: Image,
    pub surface: Image,
    pub instance: Image,
    /// `None` when nothing emits.
    pub emission: Option<Image>,
}

/// What screen-space rays are marched through, and the lists of rays that go on elsewhere.
pub struct MarchImages {
    /// `None` when no mesh is closed.
    pub back_depth: Option<Image>,
    pub pyramid: Image,
    /// Rays that go on in the other eye's view. The list stays empty if the method has no such rays.
    pub retries: RayList,
    /// Lost rays that ask the scene's geometry; likewise.
    pub lost: RayList,
}

/// The filter's output for blending with the other eye or with earlier frames.
pub struct BlendImages {
    /// C·L, the known share of the light, and C, how much is known.
    pub known: Image,
    /// Weight of the taps; nearness of what is reflected, 1/m; variance of the light, if the method needs it.
    /// In the shaders its name ends in `standing_image`.
    pub statistics: Image,
    /// The pixels in which the eyes may differ visibly, for methods that blend only those.
    pub visible: Option<RayList>,
}

/// The hits of rays, and the images of the filter.
pub struct FilterImages {
    pub hits: Image,
    /// The radiance of hits in the scene's geometry, at the rays' pixels; for methods with such hits.
    pub ray_radiance: Option<Image>,
    /// For methods that blend the filter's output with the other eye or with earlier frames.
    pub pairs: Option<BlendImages>,
    pub reflection: Image,
    /// Sums and weights over a pixel's samples, if it has several.
    pub sums: Option<(Image, Image)>,
}

/// The sums over the reference's samples; see `path_trace.comp`.
pub struct PathSums {
    pub sum: Image,
    pub compensation: Image,
    pub squares: Image,
}

/// The reference's results.
pub struct PathTraceImages {
    /// `None` where the processor traces the paths and adds them up.
    pub sums: Option<PathSums>,
    pub reflection: Image,
    pub error: Image,
}

/// Every image of a frame.
pub struct Targets {
    pub gbuffer: GBuffer,
    /// `None` where ambient light is not occluded.
    pub ao: Option<AoImages>,
    pub radiance: Image,
    /// The outgoing light of the punctual lights at each pixel; `None` where none of them casts a shadow and the eyes do not
    /// share their shading.
    pub direct: Option<Image>,
    /// Baked light of each pixel's surface; `None` without any.
    pub indirect: Option<Image>,
    /// `None` where the eyes do not share their shading.
    pub shading_reuse: Option<ShadingReuseImages>,
    pub rays: Option<RayList>,
    /// What the resolve needs to know of neighbours (guide.glsl); a single texel where nothing is resolved.
    pub guide: Image,
    pub marched: Option<MarchImages>,
    pub filtered: Option<FilterImages>,
    pub path_traced: Option<PathTraceImages>,
    /// The tone-mapped picture, without the guard band.
    pub display: Image,
    pub linear: Image,
    pub reflection_out: Image,
    /// A placeholder (RGBA32F) for images that a shader binds but this frame does not have.
    pub placeholder: Image,
}

impl Targets {
    /// `settings`: those of what is drawn, guard band included; `shown`: the size of what is shown, pixels.
    ///
    /// # Errors
    /// When device memory runs out: the message names the image and its bytes.
    pub fn new(
        gpu: &Rc<Gpu>,
        settings: &Settings,
        shown: (u32, u32),
        needs: &FrameNeeds,
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
        let technique = method.technique();
        let marched = match needs.screen_space {
            false => None,
            true => Some(MarchImages {
                back_depth: needs.back_faces.then(|| drawn("back depth", vk::Format::D32_SFLOAT)).transpose()?,
                pyramid: Image::new(gpu, "depth pyramid", pyramid_desc(w, h))?,
                retries: RayList::new(gpu, if technique.traversal == Traversal::TwoStages { texels } else { 0 })?,
                lost: RayList::new(gpu, if needs.geometry { texels } else { 0 })?,
            }),
        };
        let filtered = match needs.resolve {
            false => None,
            true => Some(FilterImages {
                hits: stereo("hits", vk::Format::R32G32B32A32_UINT)?,
                ray_radiance: (technique.resolved || needs.geometry)
                    .then(|| stereo("ray radiance", rgba16))
                    .transpose()?,
                pairs: match needs.pairs {
                    false => None,
                    true => Some(BlendImages {
                        known: stereo("known light", rgba16)?,
                        statistics: stereo("standing", rgba32)?,
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
        // Images that the processor fills by copies.
        let written = |what: &str| {
            let desc = ImageDesc::stereo(w, h, rgba32);
            Image::new(gpu, what, ImageDesc { usage: desc.usage | vk::ImageUsageFlags::TRANSFER_DST, ..desc })
        };
        let path_traced = match needs.path_trace && !needs.resolve {
            false => None,
            true if needs.cpu_paths => {
                Some(PathTraceImages { sums: None, reflection: written("path mean")?, error: written("path error")? })
            }
            true => Some(PathTraceImages {
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
            shading_reuse: needs.shading_reuse.then(|| ShadingReuseImages::new(gpu, needs, (w, h))).transpose()?,
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
            placeholder: Image::new(gpu, "nothing", ImageDesc::stereo(1, 1, rgba32))?,
        })
    }
}

/// The pyramid's level 0 is padded to whole cells of the top level.
fn pyramid_desc(width: u32, height: u32) -> ImageDesc {
    let whole = |n: u32| n.next_multiple_of(1 << TOP_LEVEL);
    ImageDesc { mips: TOP_LEVEL + 1, ..ImageDesc::stereo(whole(width), whole(height), vk::Format::R32G32_SFLOAT) }
}
