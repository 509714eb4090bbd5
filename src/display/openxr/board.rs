//! Boards of words: pages, questions, the rating panel, and what is shown over a stimulus. Each is a quad of its own,
//! drawn once for each change, with at least as many pixels per degree as letters need.

use openxr as xr;

use super::headset::Headset;
use super::place::{self, Pose, SCREEN_M};
use super::runtime::failure;
use super::texture::{Texture, TextureDesc, from_gpu};
use crate::display::DisplayError;
use crate::display::content::Content;
use crate::display::panel::{DrawnView, Panel, View};
use crate::gpu::Image;
use crate::study::protocol::Screen;

/// With fewer pixels per degree than this, letters are hard to read, whatever the headset shows.
const LEAST_PX_PER_DEG: f64 = 20.0;
/// Largest size of a page, degrees.
const PAGE_DEG: [f64; 2] = [58.0, 44.0];

/// One quad of words: an image that the panel draws into, and the texture the compositor reads.
pub(super) struct Board {
    image: Image,
    texture: Texture,
    pub size_m: (f32, f32),
    px: (u32, u32),
    shown: Option<View>,
    drawn: DrawnView,
}

/// Size of a board.
#[derive(Debug, Clone, Copy)]
pub(super) struct Size {
    pub deg: [f64; 2],
    pub px_per_deg: f64,
}

impl Size {
    /// The size of a page within a field of view (degrees from straight ahead to its edges).
    pub fn page(half_deg: [f64; 2], arcsec_per_px: f64) -> Size {
        let deg = [0, 1].map(|i| PAGE_DEG[i].min(1.8 * half_deg[i]));
        Size { deg, px_per_deg: (3600.0 / arcsec_per_px).max(LEAST_PX_PER_DEG) }
    }

    /// The same size with exactly the display's pixels, so that a dot of a stereogram is one pixel.
    pub fn in_display_px(self, arcsec_per_px: f64) -> Size {
        Size { px_per_deg: 3600.0 / arcsec_per_px, ..self }
    }
}

impl Board {
    /// Makes an empty board; `pen` draws at the pixels per degree of `size`.
    pub fn new(headset: &Headset, pen: &Panel, size: Size) -> Result<Board, DisplayError> {
        let size_m = [0, 1].map(|i| place::size_m(size.deg[i], 1.0, SCREEN_M).0);
        // A pixel in the middle has exactly the angle that it should have; towards the edges of a flat quad the angle
        // is smaller.
        let px_m = f64::from(SCREEN_M) * (1.0 / size.px_per_deg).to_radians();
        let largest = headset.runtime.max_side_px.min(4096);
        let px = size_m.map(|m| ((f64::from(m) / px_m).round() as u32).clamp(16, largest));
        let image = pen.image(px[0], px[1]).map_err(from_gpu)?;
        let shape = TextureDesc { width: px[0], height: px[1], layers: 2, is_still: false };
        let texture = Texture::new(&headset.session, &headset.gpu, shape)?;
        let size_m = [0, 1].map(|i| (f64::from(px[i]) * px_m) as f32);
        let drawn = DrawnView::default();
        Ok(Board { image, texture, size_m: (size_m[0], size_m[1]), px: (px[0], px[1]), shown: None, drawn })
    }

    /// Draws a view, unless the board shows it already.
    pub fn show(
        &mut self,
        headset: &Headset,
        pen: &mut Panel,
        content: &Content,
        view: View,
    ) -> Result<(), DisplayError> {
        if self.shown.as_ref() == Some(&view) {
            return Ok(());
        }
        self.drawn = pen.draw(content, &view, &self.image).map_err(from_gpu)?;
        let image = &self.image;
        self.texture.write(&headset.gpu, |frame, target| frame.copy_texels(image, target))?;
        self.shown = Some(view);
        Ok(())
    }

    /// Size of the board's image, pixels.
    pub fn px(&self) -> (u32, u32) {
        self.px
    }

    /// What can be pointed at.
    pub fn drawn(&self) -> &DrawnView {
        &self.drawn
    }

    /// The target that a ray meets. The ray and the board are given in the same space.
    pub fn target_at(&self, ray: Pose, board: Pose) -> Option<usize> {
        let [x, y] = place::meets(ray, board, self.size_m)?;
        self.drawn.at([x * self.px.0 as f32, y * self.px.1 as f32])
    }

    /// One quad for both eyes, or one for each eye where the pictures differ. `over`: what lies behind shines through.
    pub fn quads<'a>(
        &'a self,
        space: &'a xr::Space,
        pose: Pose,
        over: bool,
    ) -> Vec<xr::CompositionLayerQuad<'a, xr::Vulkan>> {
        let flags = match over {
            true => xr::CompositionLayerFlags::BLEND_TEXTURE_SOURCE_ALPHA,
            false => xr::CompositionLayerFlags::EMPTY,
        };
        let quad = |layer: u32, eye: xr::EyeVisibility| {
            xr::CompositionLayerQuad::new()
                .layer_flags(flags)
                .space(space)
                .eye_visibility(eye)
                .sub_image(self.texture.layer(layer))
                .pose(pose.xr())
                .size(xr::Extent2Df { width: self.size_m.0, height: self.size_m.1 })
        };
        match self.drawn.is_stereo {
            true => super::pictures::EYES.map(|(layer, eye)| quad(layer, eye)).into(),
            false => vec![quad(0, xr::EyeVisibility::BOTH)],
        }
    }
}

/// Makes a drawer of words with a size's pixels per degree.
pub(super) fn pen(headset: &Headset, content: &Content, size: Size) -> Result<Panel, DisplayError> {
    Panel::new(&headset.gpu, size.px_per_deg as f32, content.font.as_deref(), false).map_err(from_gpu)
}

/// The error for a screen whose index is beyond the study's content.
pub(super) fn unknown(screen: &Screen) -> DisplayError {
    failure(format!("nothing is known of {screen:?}"))
}
