//! Opens the graphics device for a command, and chooses the defaults that differ on a software device.

use std::path::PathBuf;
use std::rc::Rc;

use crate::console::Console;
use crate::gpu::{Gpu, GpuError, GpuOptions, OwnDevice};
use crate::render::method::HitSource;
use crate::render::{Method, Settings, Shadows, Trace, fast_ray_queries};
use crate::scene::Scene;

use super::WrongUsage;

/// Opens the best device, or the one whose name contains `name`.
///
/// # Errors
/// [`GpuError`] naming what is missing.
pub fn open(name: Option<&str>) -> Result<Rc<Gpu>, GpuError> {
    Gpu::open(&OwnDevice { name: name.map(str::to_owned) }, &GpuOptions::from_environment())
}

/// The folder for what can be made again: `cyclopean` in the user's cache folder, or `.cyclopean` in the current folder
/// where there is no cache folder.
pub fn cache_folder() -> PathBuf {
    GpuOptions::from_environment().pipeline_cache.unwrap_or_else(|| PathBuf::from(".cyclopean"))
}

/// The folder in which baked light is kept.
pub fn light_folder() -> PathBuf {
    cache_folder().join("references").join("light")
}

/// Pixels of one eye, as `WxH`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Size {
    pub width: u32,
    pub height: u32,
}

/// The longest side, pixels: ray lists pack a coordinate into 14 bits.
pub const MAX_SIDE: u32 = 16383;

impl std::str::FromStr for Size {
    type Err = String;

    fn from_str(text: &str) -> Result<Size, String> {
        let wrong =
            || format!("`{text}` is no size; give WIDTHxHEIGHT of one eye, each 1 to {MAX_SIDE}, such as 1920x1080");
        let (width, height) = text.split_once('x').ok_or_else(wrong)?;
        let side = |s: &str| s.parse::<u32>().ok().filter(|n| (1..=MAX_SIDE).contains(n)).ok_or_else(wrong);
        Ok(Size { width: side(width)?, height: side(height)? })
    }
}

/// The requested size; without one, the paper's 1920×1080, or 640×360 on a software device, which a note says.
pub fn size_or_default(gpu: &Gpu, size: Option<Size>, console: &Console) -> Size {
    size.unwrap_or_else(|| match gpu.is_cpu() {
        false => Size { width: 1920, height: 1080 },
        true => {
            console.note(format!("{} is a software device: 640x360 per eye (--size changes it)", gpu.info().name));
            Size { width: 640, height: 360 }
        }
    })
}

/// The method with the requested samples. On a software device the reference takes 64 unless told otherwise, which a
/// note says.
pub fn samples_or_default(gpu: &Gpu, method: Method, samples: Option<u32>, console: &Console) -> Method {
    let untold = samples.is_none() && method.samples() == 1024;
    if untold && gpu.is_cpu() && method.technique().hit_source == HitSource::PathTraced && !method.technique().resolved
    {
        console.note(format!("{} is a software device: 64 paths a pixel (--spp changes it)", gpu.info().name));
        return method.with_samples(Some(64));
    }
    method.with_samples(samples)
}

/// Settings for pictures of this size.
pub fn settings(size: Size, seed: u32) -> Settings {
    Settings { width: size.width, height: size.height, seed, ..Settings::default() }
}

/// Settings for a view that is rendered frame by frame. Where hardware answers rays, rays to every light are fast
/// enough; elsewhere shadows are looked up in maps. On a software device that look-up costs more than the rest of a
/// frame, so lights cast no shadows there.
pub fn live_settings(gpu: &Gpu, size: Size) -> Settings {
    let shadows_by = if fast_ray_queries(gpu, Trace::Auto) { Shadows::Rays } else { Shadows::Maps };
    Settings { shadows: !gpu.is_cpu(), shadows_by, ..settings(size, 1) }
}

/// The scene's view of this name, or its first.
///
/// # Errors
/// [`WrongUsage`] listing the views.
pub fn view<'a>(scene: &'a Scene, name: Option<&str>) -> Result<&'a crate::scene::View, WrongUsage> {
    let known = || scene.views.iter().map(|v| v.name.as_str()).collect::<Vec<_>>().join(", ");
    match name {
        None => scene.views.first().ok_or_else(|| WrongUsage(format!("scene `{}` has no view", scene.name))),
        Some(name) => scene
            .views
            .iter()
            .find(|v| v.name == name)
            .ok_or_else(|| WrongUsage(format!("scene `{}` has no view `{name}`; it has: {}", scene.name, known()))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_or_refused() {
        assert_eq!("640x360".parse(), Ok(Size { width: 640, height: 360 }));
        for wrong in ["", "640", "0x360", "640x0", "1000000x1000000", "-1x2", "640X360", "640x360x2"] {
            assert!(wrong.parse::<Size>().expect_err("refused").contains("WIDTHxHEIGHT"), "{wrong}");
        }
    }
}
