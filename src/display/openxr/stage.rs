//! Everything that is placed in the room: pictures, boards and the background; and the layers of each screen.

use std::collections::BTreeSet;

use cyclopean_analysis::journal::record::Shown;
use glam::Vec3;
use openxr as xr;

use super::board::{self, Board, Size};
use super::headset::{EyeView, Headset, Layers, Spaces};
use super::pictures::{EYES, PairKey, PictureLimits, Pictures, UploadedStimulus};
use super::place::{self, Pose, SCREEN_M};
use super::texture::Texture;
use crate::display::content::{Content, Geometry};
use crate::display::panel::{DrawnView, Panel, View};
use crate::display::{DisplayError, StimulusFiles};
use crate::study::protocol::Screen;

/// Distance and width of the background, metres. It reaches beyond every field of view and is fixed to the head.
const GROUND: (f32, f32) = (10.0, 80.0);

/// Everything that was uploaded for a session.
pub(super) struct Stage {
    pub content: Content,
    pictures: Pictures,
    /// The study's grey background behind everything; none where it is black.
    ground: Option<Texture>,
    blank: Board,
    page: Board,
    pen: Panel,
    /// The board and the pen of stereograms, whose dots are the display's pixels.
    dots: Option<(Board, Panel)>,
    /// The signs over a stimulus: `A`, `B`, and the mark of a session that is not real.
    signs: Vec<Sign>,
    eyes: [EyeView; 2],
    /// The pose of the head, made upright, when the view was last centred.
    home: Option<Pose>,
}

/// A board over a stimulus that is drawn once.
struct Sign {
    show: Shown,
    board: Board,
    /// Height above straight ahead, metres.
    up_m: f32,
}

impl Stage {
    /// Uploads everything that a session can show. Without `pairs`, stimuli are shown in stereo.
    pub fn new(
        headset: &Headset,
        content: Content,
        files: &[StimulusFiles],
        pairs: &BTreeSet<PairKey>,
        eyes: [EyeView; 2],
        arcsec_per_px: f64,
    ) -> Result<Stage, DisplayError> {
        let half_deg = half_field_deg(&eyes);
        let limits = PictureLimits { half_deg, quad_deg: content.quad_deg, fov_deg: content.stimulus_fov_deg };
        let pictures = Pictures::load(headset, files, pairs, &limits)?;
        let size = Size::page(half_deg, arcsec_per_px);
        let in_px = size.in_display_px(arcsec_per_px);
        let dots = match content.dots.is_empty() {
            true => None,
            false => {
                let pen = board::pen(headset, &content, in_px)?;
                Some((Board::new(headset, &pen, in_px)?, pen))
            }
        };
        let grey = content.blank.byte();
        let ground = match grey {
            0 => None,
            _ => {
                Some(Texture::still(&headset.session, &headset.gpu, (4, 4), vec![[grey, grey, grey, 255].repeat(16)])?)
            }
        };
        let mut pen = board::pen(headset, &content, size)?;
        let mut blank = Board::new(headset, &pen, size)?;
        blank.show(headset, &mut pen, &content, View::of(&Screen::Blank))?;
        let page = Board::new(headset, &pen, size)?;
        let signs = Vec::new();
        let mut stage = Stage { content, pictures, ground, blank, page, pen, dots, signs, eyes, home: None };
        stage.make_signs(headset, size, half_deg)?;
        Ok(stage)
    }

    /// Makes the signs: letters are below the largest picture, a mark is around it.
    fn make_signs(&mut self, headset: &Headset, size: Size, half_deg: [f64; 2]) -> Result<(), DisplayError> {
        let stills = self.pictures.stereo.iter().chain(self.pictures.pairs.values());
        let spans = stills.map(|s| [s.width_deg, place::vertical_deg(s.width_deg, s.aspect)]);
        let [width, height] = spans.fold([0.0f64; 2], |a, b| [a[0].max(b[0]), a[1].max(b[1])]);
        // The letters are two and a half degrees below the picture, or as low as can be seen.
        let below_deg = (height / 2.0 + 2.5).min(half_deg[1] - 2.0);
        let below_m = SCREEN_M * (below_deg.to_radians().tan() as f32);
        for show in [Shown::Stimulus, Shown::A, Shown::B] {
            let has_letter = show != Shown::Stimulus;
            let mut view = View::of(&Screen::Stimulus {
                presentation: 0,
                attempt: 0,
                show,
                stimulus: 0,
                reference: None,
                frame: 0,
            });
            let (deg, up_m) = match &self.content.mark {
                None if !has_letter => continue,
                None => ([8.0, 4.0], -below_m),
                Some(_) => ([width + 1.0, 2.0 * (below_deg + 2.0)], 0.0),
            };
            let mut board = Board::new(headset, &self.pen, Size { deg, ..size })?;
            if has_letter && self.content.mark.is_some() {
                let (w, h) = board.px();
                view.label_at = Some([w as f32 / 2.0, h as f32 * (0.5 + below_m / board.size_m.1)]);
            }
            board.show(headset, &mut self.pen, &self.content, view)?;
            self.signs.push(Sign { show, board, up_m });
        }
        Ok(())
    }

    /// Places everything straight ahead of this head, as if it were upright.
    pub fn centre(&mut self, head: Pose, eyes: [EyeView; 2]) {
        self.home = Some(place::upright(head));
        self.eyes = eyes;
    }

    /// Whether the view was centred, that is, whether the head was ever tracked.
    pub fn is_placed(&self) -> bool {
        self.home.is_some()
    }

    /// The board that people answer on, and its pose in the room.
    pub fn board(&self, screen: &Screen) -> Option<(&Board, Pose)> {
        let board = match screen {
            Screen::Dots(_) => &self.dots.as_ref()?.0,
            Screen::Stimulus { .. } | Screen::Blank => return None,
            _ => &self.page,
        };
        Some((board, self.home?.then(place::ahead(Vec3::ZERO, SCREEN_M))))
    }

    /// What can be pointed at on a screen.
    pub fn drawn(&self, screen: &Screen) -> Option<&DrawnView> {
        self.board(screen).map(|(board, _)| board.drawn())
    }

    /// Draws the words of a screen, unless they are drawn already.
    pub fn prepare(&mut self, headset: &Headset, view: View) -> Result<(), DisplayError> {
        match &view.screen {
            Screen::Stimulus { .. } | Screen::Blank => Ok(()),
            Screen::Dots(_) => match &mut self.dots {
                Some((board, pen)) => board.show(headset, pen, &self.content, view),
                None => Err(board::unknown(&view.screen)),
            },
            _ => self.page.show(headset, &mut self.pen, &self.content, view),
        }
    }

    /// Adds the layers of a screen, from the background forwards.
    pub fn layers<'a>(&'a self, screen: &Screen, spaces: &'a Spaces, out: &mut Layers<'a>) -> Result<(), DisplayError> {
        let Some(home) = self.home else { return Ok(()) };
        if let Some(ground) = &self.ground {
            let pose = place::ahead(Vec3::ZERO, GROUND.0);
            out.quads.push(quad(ground, 0, xr::EyeVisibility::BOTH, &spaces.head, pose, (GROUND.1, GROUND.1)));
        }
        let straight = home.then(place::ahead(Vec3::ZERO, SCREEN_M));
        match screen {
            Screen::Blank => out.quads.extend(self.blank.quads(&spaces.room, straight, false)),
            Screen::Stimulus { presentation, show, stimulus, reference, frame, .. } => {
                out.is_stimulus = true;
                match reference {
                    Some(reference) => {
                        let eye = self.content.presentations.get(*presentation as usize).map_or(0, |p| p.eye);
                        let uploaded = self.pictures.pairs.get(&(*reference, *stimulus, eye));
                        let shown = uploaded.and_then(|uploaded| self.pair(uploaded, *frame, home, spaces, out));
                        shown.ok_or_else(|| board::unknown(screen))?;
                    }
                    None => {
                        let uploaded = self.pictures.stereo.get(*stimulus as usize);
                        let shown = uploaded.and_then(|uploaded| self.stereo(uploaded, *frame, home, spaces, out));
                        shown.ok_or_else(|| board::unknown(screen))?;
                    }
                }
                if let Some(sign) = self.signs.iter().find(|s| s.show == *show) {
                    let (space, from) = self.anchor(home, spaces);
                    let pose = from.then(place::ahead(Vec3::new(0.0, sign.up_m, 0.0), SCREEN_M));
                    out.quads.extend(sign.board.quads(space, pose, true));
                }
            }
            _ => {
                if let Some((board, pose)) = self.board(screen) {
                    out.quads.extend(board.quads(&spaces.room, pose, false));
                }
            }
        }
        Ok(())
    }

    /// The space and pose in which stimuli are fixed: in the room, as the view was centred, or to the head.
    fn anchor<'a>(&self, home: Pose, spaces: &'a Spaces) -> (&'a xr::Space, Pose) {
        match self.content.geometry {
            Geometry::HeadLocked => (&spaces.head, Pose::IDENTITY),
            Geometry::World | Geometry::Projection => (&spaces.room, home),
        }
    }

    /// Adds a mirrored pair: both eyes see one flat picture at zero disparity. None: there is no such frame.
    fn pair<'a>(
        &self,
        uploaded: &'a UploadedStimulus,
        frame: u32,
        home: Pose,
        spaces: &'a Spaces,
        out: &mut Layers<'a>,
    ) -> Option<()> {
        let (space, from) = self.anchor(home, spaces);
        let pose = from.then(place::ahead(Vec3::ZERO, SCREEN_M));
        let size = place::size_m(uploaded.width_deg, uploaded.aspect, SCREEN_M);
        let (texture, layer) = uploaded.picture(frame, 0)?;
        out.quads.push(quad(texture, layer, xr::EyeVisibility::BOTH, space, pose, size));
        Some(())
    }

    /// Adds a stereo picture: each eye sees its own, centred on its own axis. None: there is no such frame.
    fn stereo<'a>(
        &self,
        uploaded: &'a UploadedStimulus,
        frame: u32,
        home: Pose,
        spaces: &'a Spaces,
        out: &mut Layers<'a>,
    ) -> Option<()> {
        let pictures = [uploaded.picture(frame, 0)?, uploaded.picture(frame, 1)?];
        let (space, from) = self.anchor(home, spaces);
        if self.content.geometry == Geometry::Projection {
            let half_x = (uploaded.width_deg / 2.0).to_radians() as f32;
            let half_y = (place::vertical_deg(uploaded.width_deg, uploaded.aspect) / 2.0).to_radians() as f32;
            let fov = xr::Fovf { angle_left: -half_x, angle_right: half_x, angle_up: half_y, angle_down: -half_y };
            let view = |eye: usize| {
                let at = Pose { position: self.eyes[eye].pose.position, ..Pose::IDENTITY };
                xr::CompositionLayerProjectionView::new()
                    .pose(from.then(at).xr())
                    .fov(fov)
                    .sub_image(pictures[eye].0.layer(pictures[eye].1))
            };
            out.projections.push((space, [view(0), view(1)]));
            return Some(());
        }
        let size = place::size_m(uploaded.width_deg, uploaded.aspect, SCREEN_M);
        for (((texture, layer), (_, visible_to)), eye) in pictures.into_iter().zip(EYES).zip(&self.eyes) {
            let pose = from.then(place::ahead(eye.pose.position, SCREEN_M));
            out.quads.push(quad(texture, layer, visible_to, space, pose, size));
        }
        Some(())
    }
}

/// Angles from straight ahead to the nearest edge of either eye's view: sideways, and up or down; degrees.
pub(super) fn half_field_deg(eyes: &[EyeView; 2]) -> [f64; 2] {
    let fields = eyes.map(|e| e.field_deg());
    let least = |i: usize, j: usize| fields.iter().flat_map(|f| [f[i], f[j]]).fold(f64::INFINITY, f64::min);
    [least(0, 1), least(2, 3)]
}

fn quad<'a>(
    texture: &'a Texture,
    layer: u32,
    visible_to: xr::EyeVisibility,
    space: &'a xr::Space,
    pose: Pose,
    (width, height): (f32, f32),
) -> xr::CompositionLayerQuad<'a, xr::Vulkan> {
    xr::CompositionLayerQuad::new()
        .space(space)
        .eye_visibility(visible_to)
        .sub_image(texture.layer(layer))
        .pose(pose.xr())
        .size(xr::Extent2Df { width, height })
}
