//! Uploads the stimuli as textures before trial 1, so that a toggle is only a change of layer.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use openxr as xr;

use super::headset::Headset;
use super::runtime::failure;
use super::texture::Texture;
use crate::display::{DisplayError, StimulusFiles, memory};

/// A picture of a mirrored pair: reference, test image, and the eye whose images it shows (0 left).
pub(super) type PairKey = (u32, u32, usize);

/// One uploaded stimulus, still or moving, and its angular size.
pub(super) struct UploadedStimulus {
    /// The frames in order; every texture but the last holds `frames_each` of them.
    textures: Vec<Texture>,
    frames_each: u32,
    /// Layers of a frame: two for stereo, one for a mirrored pair.
    layers: u32,
    /// Width, degrees: of each eye's picture for stereo, of the whole for a pair.
    pub width_deg: f64,
    /// Width over height.
    pub aspect: f64,
}

impl UploadedStimulus {
    /// The texture and the layer that an eye (0 left) sees of a frame; of a pair both eyes see the same. None: there is
    /// no such frame.
    pub fn picture(&self, frame: u32, eye: u32) -> Option<(&Texture, u32)> {
        let texture = self.textures.get((frame / self.frames_each) as usize)?;
        let layer = (frame % self.frames_each) * self.layers + eye.min(self.layers - 1);
        (layer < texture.layers()).then_some((texture, layer))
    }
}

/// All uploaded stimuli.
#[derive(Default)]
pub(super) struct Pictures {
    /// Stereo pictures by stimulus, layer 0 for the left eye; empty where pairs are shown.
    pub stereo: Vec<UploadedStimulus>,
    pub pairs: BTreeMap<PairKey, UploadedStimulus>,
}

/// How large pictures may be, degrees.
#[derive(Debug, Clone, Copy)]
pub(super) struct PictureLimits {
    /// Angles from straight ahead to the nearest edge over both eyes and both sides: left/right, up/down.
    pub half_deg: [f64; 2],
    /// Largest width of a mirrored pair.
    pub quad_deg: f64,
    /// Horizontal field of view of stimuli that do not state their own.
    pub fov_deg: Option<f64>,
}

impl PictureLimits {
    /// Width of a mirrored pair. It stays within four fifths of the field, because lenses blur beyond.
    pub fn pair_deg(&self) -> f64 {
        self.quad_deg.min(0.8 * 2.0 * self.half_deg[0])
    }
}

impl Pictures {
    /// Reads and uploads the stimuli. Without `pairs`, each stimulus is shown in stereo.
    ///
    /// # Errors
    /// A file cannot be read, is larger than the runtime takes, or is wider than the view.
    pub fn load(
        headset: &Headset,
        files: &[StimulusFiles],
        pairs: &BTreeSet<PairKey>,
        limits: &PictureLimits,
    ) -> Result<Pictures, DisplayError> {
        let file = |id: u32| files.get(id as usize).ok_or_else(|| failure(format!("there is no stimulus {id}")));
        let mut out = Pictures::default();
        if pairs.is_empty() {
            memory::check(&headset.gpu, files, memory::MipLevels::All).map_err(failure)?;
            for file in files {
                let width_deg = file.fov_deg.or(limits.fov_deg).ok_or_else(|| {
                    let file = file.first().display();
                    failure(format!("{file} does not say how wide its view is: run `cyclopean prepare` again"))
                })?;
                let uploaded = upload(headset, file.frames.len(), width_deg, |frame| {
                    let eyes = StereoTexels::read(&file.frames[frame])?;
                    fits(file, width_deg, eyes.aspect(), limits)?;
                    let size = (eyes.width, eyes.height);
                    Ok(Frame { path: &file.frames[frame], size, texels: eyes.texels.into() })
                })?;
                out.stereo.push(uploaded);
            }
            return Ok(out);
        }
        let tests: Vec<&StimulusFiles> = pairs.iter().map(|&(_, test, _)| file(test)).collect::<Result<_, _>>()?;
        memory::check(&headset.gpu, tests, memory::MipLevels::All).map_err(failure)?;
        for &(reference, test, eye) in pairs {
            let (of, beside) = (file(test)?, file(reference)?);
            if of.frames.len() != beside.frames.len() {
                let (a, b) = (beside.first().display(), of.first().display());
                return Err(failure(format!("{a} and {b} have different numbers of frames")));
            }
            let uploaded = upload(headset, of.frames.len(), limits.pair_deg(), |frame| {
                let (left, right) =
                    (StereoTexels::read(&beside.frames[frame])?, StereoTexels::read(&of.frames[frame])?);
                if (left.width, left.height) != (right.width, right.height) {
                    let (a, b) = (beside.frames[frame].display(), of.frames[frame].display());
                    return Err(failure(format!("{a} and {b} differ in size and cannot stand side by side")));
                }
                let size = (2 * left.width, left.height);
                let texels = side_by_side(&left.texels[eye], &right.texels[eye], left.width as usize);
                Ok(Frame { path: &of.frames[frame], size, texels: vec![texels] })
            })?;
            out.pairs.insert((reference, test, eye), uploaded);
        }
        Ok(out)
    }
}

/// One frame that is ready to be uploaded.
struct Frame<'a> {
    /// The file, for messages.
    path: &'a Path,
    size: (u32, u32),
    /// RGBA bytes of each layer.
    texels: Vec<Vec<u8>>,
}

/// The most bytes of a texture that holds several frames, because a runtime need not give more in one piece.
const TEXTURE_BYTES: usize = 1 << 28;
/// The most layers of a texture; Vulkan guarantees 256.
const TEXTURE_LAYERS: usize = 128;

/// Uploads the frames of a stimulus as they are read: at most the frames of one texture are in memory at a time.
fn upload<'a>(
    headset: &Headset,
    frames: usize,
    width_deg: f64,
    read: impl Fn(usize) -> Result<Frame<'a>, DisplayError>,
) -> Result<UploadedStimulus, DisplayError> {
    let first = read(0)?;
    let ((width, height), layers) = (first.size, first.texels.len());
    let largest = headset.runtime.max_side_px;
    if width.max(height) > largest {
        let file = first.path.display();
        return Err(failure(format!(
            "{file} needs {width}×{height} pixels, the runtime takes at most {largest} a side"
        )));
    }
    let bytes = layers * width as usize * height as usize * 4;
    let frames_each = (TEXTURE_BYTES / bytes).min(TEXTURE_LAYERS / layers).clamp(1, frames.max(1));
    let mut textures = Vec::new();
    let mut texels = first.texels;
    for frame in 1..=frames {
        if frame % frames_each == 0 || frame == frames {
            textures.push(Texture::still(
                &headset.session,
                &headset.gpu,
                (width, height),
                std::mem::take(&mut texels),
            )?);
        }
        if frame < frames {
            let next = read(frame)?;
            if next.size != (width, height) {
                let what = format!("{} is not as large as the frame before it", next.path.display());
                return Err(failure(what));
            }
            texels.extend(next.texels);
        }
    }
    let aspect = f64::from(width) / f64::from(height);
    Ok(UploadedStimulus { textures, frames_each: frames_each as u32, layers: layers as u32, width_deg, aspect })
}

fn fits(file: &StimulusFiles, width_deg: f64, aspect: f64, limits: &PictureLimits) -> Result<(), DisplayError> {
    let height_deg = super::place::vertical_deg(width_deg, aspect);
    let [across, upward] = limits.half_deg.map(|half| 2.0 * half);
    // A tenth of a degree more is allowed: it is one or two pixels.
    if width_deg <= across + 0.1 && height_deg <= upward + 0.1 {
        return Ok(());
    }
    Err(failure(format!(
        "{} spans {width_deg:.0}° × {height_deg:.0}°, this headset shows {across:.0}° × {upward:.0}° around straight ahead: its borders would be cut off; set stimuli.horizontal_fov_deg in the study and prepare again",
        file.first().display()
    )))
}

/// Both eyes' pictures as RGBA bytes, rows from the top.
struct StereoTexels {
    width: u32,
    height: u32,
    texels: [Vec<u8>; 2],
}

impl StereoTexels {
    fn read(path: &Path) -> Result<StereoTexels, DisplayError> {
        let both = crate::picture::read_png(path).map_err(|e| failure(e.to_string()))?;
        let (width, height) = (both.width() / 2, both.height());
        if width == 0 || both.width() % 2 != 0 {
            return Err(failure(format!("{} does not hold two pictures side by side", path.display())));
        }
        let row = width as usize * 4;
        let half =
            |eye: usize| both.as_raw().chunks_exact(2 * row).flat_map(|r| &r[eye * row..][..row]).copied().collect();
        Ok(StereoTexels { width, height, texels: [half(0), half(1)] })
    }

    fn aspect(&self) -> f64 {
        f64::from(self.width) / f64::from(self.height)
    }
}

/// Places the left picture as it is and the right one mirrored about its vertical axis, without a gap: they meet at the
/// axis.
fn side_by_side(left: &[u8], right: &[u8], width: usize) -> Vec<u8> {
    let mut out = Vec::with_capacity(left.len() + right.len());
    for (l, r) in left.chunks_exact(4 * width).zip(right.chunks_exact(4 * width)) {
        out.extend_from_slice(l);
        r.rchunks_exact(4).for_each(|texel| out.extend_from_slice(texel));
    }
    out
}

/// Each eye's layer, with its visibility in OpenXR.
pub(super) const EYES: [(u32, xr::EyeVisibility); 2] = [(0, xr::EyeVisibility::LEFT), (1, xr::EyeVisibility::RIGHT)];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_test_image_stands_mirrored_beside_the_reference() {
        let texel = |v: u8| [v, v, v, 255];
        let (left, right) = ([1, 2, 3, 4].map(texel).concat(), [5, 6, 7, 8].map(texel).concat());
        let both = side_by_side(&left, &right, 2);
        let values: Vec<u8> = both.chunks(4).map(|t| t[0]).collect();
        assert_eq!(values, [1, 2, 6, 5, 3, 4, 8, 7]);
    }

    #[test]
    fn what_is_wider_than_the_view_is_refused_with_the_way_out() {
        let file = StimulusFiles { exr: "a.exr".into(), frames: vec!["a/sbs.png".into()], fov_deg: None };
        let limits = PictureLimits { half_deg: [45.0, 45.0], quad_deg: 70.0, fov_deg: None };
        assert!(fits(&file, 90.0, 16.0 / 9.0, &limits).is_ok());
        let error = fits(&file, 91.5, 16.0 / 9.0, &limits).expect_err("too wide").to_string();
        assert!(error.contains("91° × 60°") || error.contains("92° × 60°"), "{error}");
        assert!(error.contains("90° × 90°") && error.contains("horizontal_fov_deg"), "{error}");
        assert_eq!(limits.pair_deg(), 70.0);
        assert_eq!(PictureLimits { half_deg: [40.0, 40.0], ..limits }.pair_deg(), 64.0);
    }
}
