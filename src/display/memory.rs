//! Whether the stimuli of a session fit into the memory of the device that shows them.

use super::StimulusFiles;
use crate::gpu::Gpu;
use crate::picture;

/// How a picture is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum MipLevels {
    /// Only at its own size.
    One,
    /// With all of its smaller versions, which take a third more.
    All,
}

/// Share of the device's own memory that stimuli may take. The rest is for the compositor and the words.
const SHARE: f64 = 0.8;

/// Refuses pictures (RGBA, both eyes) that the device cannot hold all at once. All are uploaded before the first trial,
/// so that showing one never waits for a file.
///
/// # Errors
/// A file cannot be read, or the pictures do not fit: how much they take, and how much there is.
pub fn check<'a>(
    gpu: &Gpu,
    stimuli: impl IntoIterator<Item = &'a StimulusFiles>,
    levels: MipLevels,
) -> Result<(), String> {
    let mut bytes = 0.0;
    for files in stimuli {
        let path = files.first();
        let (width, height) = picture::png_size(path).map_err(|e| e.to_string())?;
        bytes += 4.0 * f64::from(width) * f64::from(height) * files.frames.len() as f64;
    }
    let bytes = if levels == MipLevels::All { bytes * 4.0 / 3.0 } else { bytes };
    let has = gpu.local_memory_bytes() as f64;
    if bytes <= SHARE * has {
        return Ok(());
    }
    let gib = |bytes: f64| bytes / f64::from(1 << 30);
    Err(format!(
        "the stimuli take {:.1} GiB, and {:.1} of the {:.1} GiB of {} can be used for them; prepare smaller ones (stimuli.width_px, stimuli.height_px), show moving ones for a shorter time, or fewer of them",
        gib(bytes),
        gib(SHARE * has),
        gib(has),
        gpu.info().name
    ))
}
