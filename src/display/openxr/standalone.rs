//! A headset without a study, which shows frames rendered for the moment, or words for each eye. `live` and `display
//! test` use it.

use std::rc::Rc;
use std::sync::mpsc::Receiver;

use openxr as xr;

use super::actions::{Actions, ControllerInput};
use super::board::Size;
use super::headset::{Headset, Layers, PendingFrame, Spaces, WarmUp};
use super::operator::{self, Key};
use super::pictures::EYES;
use super::place::{self, Pose, SCREEN_M};
use super::runtime::{CallContext, VIEWS, failure};
use super::stage::half_field_deg;
use super::texture::{Texture, TextureDesc};
use crate::display::{DisplayError, DisplayInfo};
use crate::gpu::{Gpu, Image};
use crate::study::protocol::Input;

/// One eye's pose in the room, as the runtime predicts it for a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EyeInRoom {
    /// Position to the right, up and backward, metres.
    pub position: [f32; 3],
    /// Unit quaternion x, y, z, w.
    pub orientation: [f32; 4],
    /// Signed angles from the eye's axis to left, right, up, down, radians.
    pub fov_rad: [f32; 4],
}

/// What was done with the controllers, or typed, since the last frame.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct HeadsetInput {
    pub confirm: bool,
    pub pause: bool,
    /// +1: the stick was pushed right or down; −1: left or up.
    pub step: i32,
    /// Place what is shown in front of the head.
    pub centre: bool,
    pub typed: Vec<Input>,
}

/// A frame, which must be given back by one of the `show` functions.
pub struct StandaloneFrame {
    due: PendingFrame,
    /// Predicted display time, nanoseconds of the runtime's clock.
    pub at_ns: u64,
    /// The eyes; none where they are not tracked, or nothing would be seen.
    pub eyes: Option<[EyeInRoom; 2]>,
    pub acts: HeadsetInput,
}

/// See the module's documentation. Fields are dropped in this order, as in [`super::OpenXr`].
pub struct StandaloneHeadset {
    picture: Option<Texture>,
    words: Option<Texture>,
    actions: Actions,
    spaces: Spaces,
    headset: Headset,
    warm_up: WarmUp,
    info: DisplayInfo,
    operator: Receiver<Key>,
    home: Option<Pose>,
}

impl StandaloneHeadset {
    /// Opens the headset, as [`super::OpenXr::open`] does.
    ///
    /// # Errors
    /// One sentence that names what is missing.
    pub fn open() -> Result<StandaloneHeadset, DisplayError> {
        let (mut headset, spaces) = Headset::open()?;
        let actions = Actions::new(&headset.runtime, &headset.session)?;
        let warm_up = headset.warm_up(&spaces)?;
        let info = super::info(&headset, &warm_up);
        let operator = operator::listen();
        Ok(StandaloneHeadset {
            picture: None,
            words: None,
            actions,
            spaces,
            headset,
            warm_up,
            info,
            operator,
            home: None,
        })
    }

    /// The device that draws, chosen by the runtime.
    pub fn gpu(&self) -> &Rc<Gpu> {
        &self.headset.gpu
    }

    pub fn info(&self) -> &DisplayInfo {
        &self.info
    }

    /// Size of a page of words, pixels, and its pixels per degree.
    pub fn page_px(&self) -> ((u32, u32), f32) {
        let size = Size::page(half_field_deg(&self.warm_up.eyes), self.info.arcsec_per_px);
        let px =
            size.deg.map(|deg| (2.0 * (deg.to_radians() / 2.0).tan() * size.px_per_deg.to_degrees()).round() as u32);
        ((px[0], px[1]), size.px_per_deg as f32)
    }

    /// Waits for the next frame. None while the headset wants no frame, so that the caller can do other things.
    ///
    /// # Errors
    /// The headset is gone.
    pub fn wait(&mut self) -> Result<Option<StandaloneFrame>, DisplayError> {
        self.headset.poll()?;
        if !self.headset.lifecycle.is_running() {
            std::thread::sleep(super::IDLE_POLL);
            return Ok(None);
        }
        let acts = self.acts()?;
        let due = self.headset.wait()?;
        let is_seen = due.state.should_render && self.headset.lifecycle.is_visible();
        let eyes = if is_seen { self.eyes(due.time())? } else { None };
        if let Some(head) = self.headset.head(&self.spaces, due.time())?
            && (acts.centre || self.home.is_none())
        {
            self.home = Some(place::upright(head));
        }
        Ok(Some(StandaloneFrame { at_ns: due.time().as_nanos().max(0) as u64, due, eyes, acts }))
    }

    fn acts(&mut self) -> Result<HeadsetInput, DisplayError> {
        let mut acts = HeadsetInput::default();
        if self.headset.lifecycle.is_focused() {
            let ControllerInput { confirm, pause, recentre, step, hand } = self.actions.read(&self.headset.session)?;
            acts = HeadsetInput { confirm, pause, step, centre: recentre, typed: Vec::new() };
            if confirm || pause || recentre || step != 0 {
                self.actions.pulse(&self.headset.session, hand);
            }
        }
        while let Ok(key) = self.operator.try_recv() {
            match key {
                Key::Input(input) => acts.typed.push(input),
                Key::Recentre => acts.centre = true,
            }
        }
        Ok(acts)
    }

    fn eyes(&self, time: xr::Time) -> Result<Option<[EyeInRoom; 2]>, DisplayError> {
        let (flags, views) =
            self.headset.session.locate_views(VIEWS, time, &self.spaces.room).in_call("xrLocateViews")?;
        let known = flags.contains(xr::ViewStateFlags::ORIENTATION_VALID | xr::ViewStateFlags::POSITION_VALID);
        let eye = |view: &xr::View| {
            let pose = Pose::of(view.pose);
            let fov = view.fov;
            EyeInRoom {
                position: pose.position.to_array(),
                orientation: pose.orientation.to_array(),
                fov_rad: [fov.angle_left, fov.angle_right, fov.angle_up, fov.angle_down],
            }
        };
        Ok(match views.as_slice() {
            [left, right] if known => Some([eye(left), eye(right)]),
            _ => None,
        })
    }

    /// Shows two layers of RGBA8 (sRGB values), each rendered for its eye as it was given, in a projection layer.
    ///
    /// # Errors
    /// The headset is gone.
    pub fn show_projection(&mut self, frame: StandaloneFrame, image: &Image) -> Result<(), DisplayError> {
        let (Some(eyes), (width, height)) = (frame.eyes, image.extent()) else { return self.show_nothing(frame) };
        let texture = kept(&mut self.picture, &self.headset, (width, height))?;
        texture.write(&self.headset.gpu, |record, target| record.copy_texels(image, target))?;
        let StandaloneHeadset { headset, spaces, picture, .. } = self;
        let Some(picture) = picture else { return Err(failure("no picture")) };
        let view = |eye: usize| {
            let EyeInRoom { position: p, orientation: o, fov_rad: [left, right, up, down] } = eyes[eye];
            xr::CompositionLayerProjectionView::new()
                .pose(xr::Posef {
                    orientation: xr::Quaternionf { x: o[0], y: o[1], z: o[2], w: o[3] },
                    position: xr::Vector3f { x: p[0], y: p[1], z: p[2] },
                })
                .fov(xr::Fovf { angle_left: left, angle_right: right, angle_up: up, angle_down: down })
                .sub_image(picture.layer(eye as u32))
        };
        headset.submit(frame.due, |layers: &mut Layers<'_>| {
            layers.projections.push((&spaces.room, [view(0), view(1)]));
            Ok(())
        })
    }

    /// Shows a page, layer 0 to the left eye and layer 1 to the right, straight ahead of where the view was centred.
    /// `is_new`: the image has changed since the last call.
    ///
    /// # Errors
    /// The headset is gone.
    pub fn show_page(&mut self, frame: StandaloneFrame, image: &Image, is_new: bool) -> Result<(), DisplayError> {
        let texture = kept(&mut self.words, &self.headset, image.extent())?;
        if is_new {
            texture.write(&self.headset.gpu, |record, target| record.copy_texels(image, target))?;
        }
        let StandaloneHeadset { headset, spaces, words, home, .. } = self;
        let (Some(words), Some(home)) = (words.as_ref(), *home) else {
            return headset.submit(frame.due, |_| Ok(()));
        };
        let pose = home.then(place::ahead(glam::Vec3::ZERO, SCREEN_M)).xr();
        let ((width, _), px_per_degree) = (image.extent(), self.info.arcsec_per_px);
        let px_m = f64::from(SCREEN_M) * (1.0 / (3600.0 / px_per_degree).max(20.0)).to_radians();
        let (width_m, aspect) = ((f64::from(width) * px_m) as f32, image.extent().1 as f32 / width as f32);
        headset.submit(frame.due, |layers: &mut Layers<'_>| {
            for (layer, eye) in EYES {
                layers.quads.push(
                    xr::CompositionLayerQuad::new()
                        .space(&spaces.room)
                        .eye_visibility(eye)
                        .sub_image(words.layer(layer))
                        .pose(pose)
                        .size(xr::Extent2Df { width: width_m, height: width_m * aspect }),
                );
            }
            Ok(())
        })
    }

    /// Gives the runtime an empty frame.
    ///
    /// # Errors
    /// The headset is gone.
    pub fn show_nothing(&mut self, frame: StandaloneFrame) -> Result<(), DisplayError> {
        self.headset.submit(frame.due, |_| Ok(()))
    }
}

impl Drop for StandaloneHeadset {
    fn drop(&mut self) {
        self.headset.exit_session();
    }
}

/// The texture for an image of this size. It is made again when there is none of this size.
fn kept<'a>(
    texture: &'a mut Option<Texture>,
    headset: &Headset,
    (width, height): (u32, u32),
) -> Result<&'a mut Texture, DisplayError> {
    if texture.as_ref().is_some_and(|t| t.extent() != (width, height)) {
        *texture = None;
    }
    match texture {
        Some(texture) => Ok(texture),
        empty => {
            let shape = TextureDesc { width, height, layers: 2, is_still: false };
            Ok(empty.insert(Texture::new(&headset.session, &headset.gpu, shape)?))
        }
    }
}
