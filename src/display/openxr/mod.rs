//! The display of a headset, through whichever OpenXR runtime is active.
//!
//! ```text
//! open: loader → runtime → headset → Vulkan on its terms → session → warm-up frames (rate, eyes)
//! load: every stimulus, sign and board uploaded
//! wait: events, controllers, operator; else the next frame, with its predicted time on the session's clock
//! present: xrBeginFrame, the layers of the screen, xrEndFrame
//! ```
//! Times are the runtime's predictions (`Trust::Predicted`), because OpenXR does not report when frames appeared.

mod actions;
mod answer;
mod board;
mod clock;
mod frame_statistics;
mod headset;
mod lifecycle;
mod mips;
mod operator;
mod pictures;
mod place;
mod quiet;
mod runtime;
mod stage;
mod standalone;
mod texture;
mod vulkan;

use std::collections::{BTreeSet, VecDeque};
use std::rc::Rc;
use std::sync::mpsc::Receiver;
use std::time::{Duration, Instant};

use cyclopean_analysis::journal::record::{self, Trust};

use self::actions::Actions;
use self::answer::Chooser;
use self::clock::Clock;
use self::headset::{Headset, PendingFrame, RuntimeEvent, Spaces, WarmUp};
use self::operator::Key;
use self::pictures::PairKey;
use self::runtime::failure;
use self::stage::Stage;
use super::content::Content;
use super::panel::View;
use super::{Display, DisplayError, DisplayInfo, HeadPose, StimulusFiles, TimedEvent};
use crate::gpu::Gpu;
use crate::study::protocol::{Event, Input, Screen, Setup};

pub use frame_statistics::FrameStatistics;
pub use operator::KEYS;
pub use runtime::Runtime;
pub use standalone::{EyeInRoom, HeadsetInput, StandaloneFrame, StandaloneHeadset};

/// While no frame is waited for, the runtime's events are polled, and the session is told that nothing is seen, this often.
const IDLE_POLL: Duration = Duration::from_millis(10);
const IDLE_NEWS: Duration = Duration::from_millis(100);
/// A head that leans further than this, degrees, breaks the stereo picture. The operator is warned once, and again
/// after the head was upright.
const LEAN_DEG: f32 = 5.0;

/// See the module's documentation. Fields are dropped in this order: what the session owns before the session and its
/// device.
pub struct OpenXr {
    stage: Option<Stage>,
    actions: Actions,
    spaces: Spaces,
    headset: Headset,
    info: DisplayInfo,
    warm_up: WarmUp,
    /// What [`OpenXr::begin`] was given, until [`Display::load`] takes it.
    upcoming: Option<UpcomingSession>,
    clock: Clock,
    operator: Receiver<Key>,
    chooser: Chooser,
    screen: Screen,
    /// When the reminder appeared, from which the time that is left is computed.
    panel_since: Option<Instant>,
    queue: VecDeque<Event>,
    due: Option<PendingFrame>,
    poses: Vec<HeadPose>,
    /// The time at which the room's origin moves, on the runtime's clock.
    recentred_at: Option<i64>,
    wants_centre: bool,
    is_leaning: bool,
    idle_since: Instant,
}

/// What the coming session will show.
struct UpcomingSession {
    content: Content,
    pairs: BTreeSet<PairKey>,
    start_ns: u64,
}

impl OpenXr {
    /// Finds the headset, makes it ready, and measures its rate.
    ///
    /// # Errors
    /// One sentence that names what is missing.
    pub fn open() -> Result<OpenXr, DisplayError> {
        let (mut headset, spaces) = Headset::open()?;
        let actions = Actions::new(&headset.runtime, &headset.session)?;
        let warm_up = headset.warm_up(&spaces)?;
        let info = info(&headset, &warm_up);
        let clock = Clock::start(0, headset.runtime.now_ns().unwrap_or(warm_up.last_xr));
        Ok(OpenXr {
            stage: None,
            actions,
            spaces,
            headset,
            info,
            warm_up,
            upcoming: None,
            clock,
            operator: operator::listen(),
            chooser: Chooser::default(),
            screen: Screen::Blank,
            panel_since: None,
            queue: VecDeque::new(),
            due: None,
            poses: Vec::new(),
            recentred_at: None,
            wants_centre: false,
            is_leaning: false,
            idle_since: Instant::now(),
        })
    }

    /// Takes what the coming session can show, and the time at which the session clock goes on; to be called before
    /// [`Display::load`].
    pub fn begin(&mut self, content: Content, setup: &Setup, start_ns: u64) {
        let mut pairs = BTreeSet::new();
        if content.is_mirrored_pair {
            for presentation in 0..setup.presentations.len() as u32 {
                let eye = content.presentations.get(presentation as usize).map_or(0, |p| p.eye);
                for segment in &setup.segments {
                    if let Some((test, Some(reference))) = setup.stimulus(presentation, segment.show) {
                        pairs.insert((reference, test, eye));
                    }
                }
            }
        }
        self.upcoming = Some(UpcomingSession { content, pairs, start_ns });
    }

    /// Statistics of the frames.
    pub fn frame_statistics(&self) -> &FrameStatistics {
        &self.headset.frame_statistics
    }

    /// The device that draws.
    pub fn gpu(&self) -> &Rc<Gpu> {
        &self.headset.gpu
    }

    fn now_ns(&self) -> u64 {
        self.clock.now_ns(self.headset.runtime.now_ns())
    }

    /// Reads the runtime's states, the controllers and the operator's keys, and queues the events that follow.
    fn listen(&mut self) -> Result<(), DisplayError> {
        for heard in self.headset.poll()? {
            match heard {
                RuntimeEvent::RefreshRate(hz) => self.queue.push_back(Event::RefreshRate(hz)),
                RuntimeEvent::Recentred(at_xr) => self.recentred_at = Some(at_xr),
            }
        }
        self.queue.extend(self.headset.lifecycle.changes());
        while let Ok(key) = self.operator.try_recv() {
            match key {
                Key::Input(input) => self.queue.push_back(Event::Input(input)),
                Key::Recentre => self.wants_centre = true,
            }
        }
        if self.headset.lifecycle.is_focused() {
            self.listen_to_hands()?;
        }
        Ok(())
    }

    fn listen_to_hands(&mut self) -> Result<(), DisplayError> {
        let done = self.actions.read(&self.headset.session)?;
        let Some(stage) = &self.stage else { return Ok(()) };
        self.wants_centre |= done.recentre;
        let mut inputs = Vec::new();
        if done.pause {
            inputs.push(Input::Pause { by_operator: false });
        }
        if let Some(drawn) = stage.drawn(&self.screen) {
            let choices = stage.content.choices_of(&self.screen);
            let before = self.chooser.hover();
            if done.step != 0 {
                inputs.extend(self.chooser.step(&self.screen, choices, drawn, done.step));
            }
            if done.confirm {
                inputs.extend(self.chooser.confirm(&self.screen, drawn));
            }
            if !inputs.is_empty() || before != self.chooser.hover() {
                self.actions.pulse(&self.headset.session, done.hand);
            }
        }
        self.queue.extend(inputs.into_iter().map(Event::Input));
        Ok(())
    }

    /// Waits for the runtime's next frame, and finds out where the head and the hands are in it.
    fn next_frame(&mut self) -> Result<TimedEvent, DisplayError> {
        let due = self.headset.wait()?;
        let at_ns = self.clock.at_ns(due.time().as_nanos());
        self.look(&due, at_ns)?;
        let rendered = due.state.should_render && self.headset.lifecycle.is_visible();
        self.due = Some(due);
        Ok(TimedEvent { now_ns: self.now_ns(), event: Event::Frame { at_ns, rendered } })
    }

    fn look(&mut self, due: &PendingFrame, at_ns: u64) -> Result<(), DisplayError> {
        let head = self.headset.head(&self.spaces, due.time())?;
        let Some(stage) = &mut self.stage else { return Ok(()) };
        if let Some(head) = head {
            self.poses.push(HeadPose {
                t_ns: at_ns,
                position: head.position.to_array(),
                orientation: head.orientation.to_array(),
            });
            let moved = self.recentred_at.take_if(|at| due.time().as_nanos() >= *at).is_some();
            if moved || self.wants_centre || !stage.is_placed() {
                self.wants_centre = false;
                if let Some(eyes) = self.headset.eyes(&self.spaces, due.time())? {
                    stage.centre(head, eyes);
                }
            }
            let lean = place::roll_deg(head).abs();
            if !self.is_leaning && lean > LEAN_DEG {
                tracing::warn!("the head leans by {lean:.0}°: both eyes' pictures fit only while it is upright");
            }
            self.is_leaning = lean > if self.is_leaning { 0.8 * LEAN_DEG } else { LEAN_DEG };
        }
        let Some((board, pose)) = stage.board(&self.screen).filter(|_| self.headset.lifecycle.is_focused()) else {
            return Ok(());
        };
        let mut target = None;
        // The right hand comes first. If it points elsewhere, the other hand counts.
        for hand in [1, 0] {
            if target.is_none() {
                let ray = self.actions.ray(hand, &self.spaces, due.time())?;
                target = ray.and_then(|ray| board.target_at(ray, pose));
            }
        }
        self.chooser.point(target);
        Ok(())
    }

    /// Seconds left on a panel that shows its reminder.
    fn time_left_s(&mut self, screen: &Screen) -> Option<u32> {
        let Screen::Panel { reminder, .. } = screen else {
            self.panel_since = None;
            return None;
        };
        let since = *self.panel_since.get_or_insert_with(Instant::now);
        let stage = self.stage.as_ref().filter(|_| *reminder)?;
        Some(stage.content.time_left_s(since.elapsed().as_secs_f64()))
    }
}

impl Display for OpenXr {
    fn info(&self) -> &DisplayInfo {
        &self.info
    }

    fn load(&mut self, stimuli: &[StimulusFiles]) -> Result<(), DisplayError> {
        let Some(UpcomingSession { content, pairs, start_ns }) = self.upcoming.take() else {
            return Err(failure("no session has begun"));
        };
        let (eyes, arcsec_per_px) = (self.warm_up.eyes, self.info.arcsec_per_px);
        self.stage = Some(Stage::new(&self.headset, content, stimuli, &pairs, eyes, arcsec_per_px)?);
        self.headset.frame_statistics.cut();
        self.clock = Clock::start(start_ns, self.headset.runtime.now_ns().unwrap_or(self.warm_up.last_xr));
        Ok(())
    }

    fn wait(&mut self, _idle_frames: u64) -> Result<TimedEvent, DisplayError> {
        loop {
            if self.queue.is_empty() {
                self.listen()?;
            }
            if let Some(event) = self.queue.pop_front() {
                return Ok(TimedEvent { now_ns: self.now_ns(), event });
            }
            if self.headset.lifecycle.is_running() {
                self.idle_since = Instant::now();
                return self.next_frame();
            }
            std::thread::sleep(IDLE_POLL);
            if self.idle_since.elapsed() > IDLE_NEWS {
                self.idle_since = Instant::now();
                return Ok(TimedEvent { now_ns: self.now_ns(), event: Event::Visible(false) });
            }
        }
    }

    fn present(&mut self, screen: &Screen) -> Result<(), DisplayError> {
        let time_left_s = self.time_left_s(screen);
        if self.screen != *screen {
            // A panel with another choice is still the same panel.
            if std::mem::discriminant(&self.screen) != std::mem::discriminant(screen)
                || !matches!(screen, Screen::Panel { .. })
            {
                self.chooser.reset();
            }
            self.screen = screen.clone();
        }
        let view = View { hover: self.chooser.hover(), time_left_s, ..View::of(screen) };
        let OpenXr { stage, headset, spaces, due, .. } = self;
        let Some(stage) = stage else { return Err(failure("nothing was loaded")) };
        stage.prepare(headset, view)?;
        let Some(due) = due.take() else { return Ok(()) };
        headset.submit(due, |layers| stage.layers(screen, spaces, layers))
    }

    fn take_poses(&mut self) -> Vec<HeadPose> {
        std::mem::take(&mut self.poses)
    }
}

impl Drop for OpenXr {
    fn drop(&mut self) {
        // A frame that was waited for must be given before the session can end.
        if let Some(due) = self.due.take() {
            let _ = self.headset.submit(due, |_| Ok(()));
        }
        self.headset.exit_session();
    }
}

fn info(headset: &Headset, warm_up: &WarmUp) -> DisplayInfo {
    let fov_deg = warm_up.eyes.map(|eye| eye.field_deg());
    let (width_px, height_px) = headset.runtime.eye_px;
    let fov = warm_up.eyes[0].fov;
    // The angle of a pixel at the centre of a flat image of that many pixels, where stereograms are.
    let radians_per_px = f64::from(fov.angle_right.tan() - fov.angle_left.tan()) / f64::from(width_px.max(1));
    let device = headset.gpu.info();
    DisplayInfo {
        kind: "openxr".to_owned(),
        system: headset.runtime.headset.clone(),
        runtime: headset.runtime.name.clone(),
        trust: Trust::Predicted,
        nominal_hz: warm_up.nominal_hz,
        measured_hz: warm_up.measured_hz,
        interval_sd_ms: warm_up.interval_sd_ms,
        width_px,
        height_px,
        fov_deg: Some(fov_deg),
        ipd_m: Some(f64::from((warm_up.eyes[1].pose.position - warm_up.eyes[0].pose.position).length())),
        arcsec_per_px: radians_per_px.to_degrees() * 3600.0,
        tracks_head: true,
        device: Some(record::Device {
            gpu: device.name.clone(),
            driver: device.driver.clone(),
            vulkan: device.vulkan.clone(),
        }),
    }
}
