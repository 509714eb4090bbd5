//! The OpenXR session with the runtime: its states are followed exactly, and frames are waited for and given.
//!
//! OpenXR 1.0: sections 9 (session), 10 (frames). One thread calls everything, so that no call needs a lock.

use std::rc::Rc;
use std::time::{Duration, Instant};

use ash::vk::Handle as _;
use openxr as xr;

use super::lifecycle::{Do, Lifecycle};
use super::pace::{self, Given, Pace};
use super::place::{self, Pose};
use super::runtime::{Runtime, Said, VIEWS, failure};
use super::texture;
use crate::display::DisplayError;
use crate::gpu::{Gpu, GpuOptions};

/// How long a headset may take to become ready.
const READY_WITHIN: Duration = Duration::from_secs(20);
/// Frames over which the rate is measured, after as many that are ignored.
const WARM_UP: usize = 45;

/// A session with a headset. Dropped after everything that was made with it.
pub(super) struct Headset {
    stream: xr::FrameStream<xr::Vulkan>,
    waiter: xr::FrameWaiter,
    pub session: xr::Session<xr::Vulkan>,
    pub gpu: Rc<Gpu>,
    pub runtime: Runtime,
    pub lifecycle: Lifecycle,
    pub pace: Pace,
    events: xr::EventDataBuffer,
    /// Whether this program asked to leave, so that the session's end is no failure.
    leaving: bool,
}

/// The spaces that poses are given in.
pub(super) struct Spaces {
    /// Fixed in the room, its origin near the head at the start (`LOCAL`).
    pub room: xr::Space,
    /// Fixed to the head (`VIEW`).
    pub head: xr::Space,
}

/// An event of the runtime that is not a change of state.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Heard {
    RefreshRate(f64),
    /// The room's origin moves at this time of the runtime, for instance because its recentre button was pressed.
    Recentred(i64),
}

/// A frame that was waited for and must be given to the runtime.
#[derive(Debug, Clone, Copy)]
pub(super) struct Due {
    pub state: xr::FrameState,
    waited: Instant,
}

impl Due {
    /// Predicted display time.
    pub fn time(&self) -> xr::Time {
        self.state.predicted_display_time
    }
}

/// An eye's pose in the head, and its field of view.
#[derive(Debug, Clone, Copy)]
pub(super) struct EyeView {
    /// The eye's pose, in the head's axes.
    pub pose: Pose,
    pub fov: xr::Fovf,
}

/// What the frames before the first screen showed about the headset.
#[derive(Debug, Clone, Copy)]
pub(super) struct WarmUp {
    pub nominal_hz: f64,
    pub measured_hz: Option<f64>,
    pub interval_sd_ms: Option<f64>,
    pub eyes: [EyeView; 2],
    /// The last predicted display time.
    pub last_xr: i64,
}

impl Headset {
    /// Finds the runtime and the headset, opens the device that the runtime wants, and makes a session.
    pub fn open() -> Result<(Headset, Spaces), DisplayError> {
        let runtime = Runtime::open()?;
        let gpu = Gpu::open(&runtime, &GpuOptions::from_environment()).map_err(texture::from_gpu)?;
        let (_, queue_family_index, queue_index) = gpu.queue();
        let info = xr::vulkan::SessionCreateInfo {
            instance: gpu.instance().handle().as_raw() as _,
            physical_device: gpu.physical().as_raw() as _,
            device: gpu.device().handle().as_raw() as _,
            queue_family_index,
            queue_index,
        };
        // SAFETY: instance, physical device and device were made by this runtime (`Runtime` as `Creator`), the queue
        // exists, and the device outlives the session: `gpu` is declared after everything that holds the session.
        let made = unsafe { runtime.instance.create_session::<xr::Vulkan>(runtime.system, &info) };
        let (session, waiter, stream) = made.said("xrCreateSession")?;
        let formats = session.enumerate_swapchain_formats().said("xrEnumerateSwapchainFormats")?;
        if !formats.contains(&(texture::FORMAT.as_raw() as u32)) {
            return Err(failure(format!("{} has no 8-bit sRGB swapchains (R8G8B8A8_SRGB)", runtime.name)));
        }
        let space = |kind| session.create_reference_space(kind, xr::Posef::IDENTITY).said("xrCreateReferenceSpace");
        let spaces = Spaces { room: space(xr::ReferenceSpaceType::LOCAL)?, head: space(xr::ReferenceSpaceType::VIEW)? };
        let headset = Headset {
            stream,
            waiter,
            session,
            gpu,
            runtime,
            lifecycle: Lifecycle::new(),
            pace: Pace::default(),
            events: xr::EventDataBuffer::new(),
            leaving: false,
        };
        Ok((headset, spaces))
    }

    /// Takes all waiting events of the runtime.
    pub fn poll(&mut self) -> Result<Vec<Heard>, DisplayError> {
        let mut heard = Vec::new();
        while let Some(event) = self.runtime.instance.poll_event(&mut self.events).said("xrPollEvent")? {
            match event {
                xr::Event::SessionStateChanged(e) => {
                    let state = e.state();
                    tracing::debug!("openxr: session {state:?}");
                    match self.lifecycle.to(state) {
                        Do::Nothing => {}
                        Do::Begin => {
                            self.session.begin(VIEWS).said("xrBeginSession")?;
                            self.pace.cut();
                        }
                        Do::End => {
                            self.session.end().said("xrEndSession")?;
                        }
                        Do::Lost => {
                            let what =
                                "the headset goes away (LOSS_PENDING); connect it again, then go on with --resume";
                            return Err(failure(what));
                        }
                        Do::Exit if self.leaving => {}
                        Do::Exit => {
                            return Err(failure("the runtime ended the session (EXITING); go on with --resume"));
                        }
                    }
                }
                xr::Event::InstanceLossPending(_) => {
                    return Err(failure("the OpenXR runtime shuts down; start it again, then go on with --resume"));
                }
                xr::Event::UserPresenceChangedEXT(e) => self.lifecycle.set_worn(e.is_user_present()),
                xr::Event::DisplayRefreshRateChangedFB(e) => {
                    heard.push(Heard::RefreshRate(f64::from(e.to_display_refresh_rate())));
                }
                xr::Event::ReferenceSpaceChangePending(e)
                    if e.reference_space_type() == xr::ReferenceSpaceType::LOCAL =>
                {
                    heard.push(Heard::Recentred(e.change_time().as_nanos()));
                }
                xr::Event::EventsLost(e) => tracing::warn!("openxr: {} events were lost", e.lost_event_count()),
                _ => {}
            }
        }
        Ok(heard)
    }

    /// Waits until the runtime wants the next frame. Call it only while the session is running.
    pub fn wait(&mut self) -> Result<Due, DisplayError> {
        let state = self.waiter.wait().said("xrWaitFrame")?;
        Ok(Due { state, waited: Instant::now() })
    }

    /// Begins and ends a frame. `draw` runs in between, but only where it would be seen; otherwise the frame is empty.
    pub fn give<'a>(
        &mut self,
        due: Due,
        draw: impl FnOnce(&mut Layers<'a>) -> Result<(), DisplayError>,
    ) -> Result<(), DisplayError> {
        self.stream.begin().said("xrBeginFrame")?;
        let begun = Instant::now();
        let mut layers = Layers::default();
        if due.state.should_render && self.lifecycle.is_visible() {
            draw(&mut layers)?;
        }
        let with = |space, views| xr::CompositionLayerProjection::new().space(space).views(views);
        let projections: Vec<_> = layers.projections.iter().map(|(space, views)| with(*space, views)).collect();
        let mut bases: Vec<&xr::CompositionLayerBase<'_, xr::Vulkan>> = Vec::new();
        projections.iter().for_each(|p| bases.push(p));
        layers.quads.iter().for_each(|q| bases.push(q));
        let drawing_ns = begun.elapsed().as_nanos() as u64;
        self.stream.end(due.time(), self.runtime.blend, &bases).said("xrEndFrame")?;
        self.pace.add(Given {
            at_ns: due.time().as_nanos(),
            period_ns: due.state.predicted_display_period.as_nanos(),
            drawing_ns,
            ours_ns: due.waited.elapsed().as_nanos() as u64,
            is_empty: bases.is_empty(),
            is_stimulus: layers.is_stimulus,
        });
        Ok(())
    }

    /// Waits for the headset to become ready, then gives empty frames to find out its rate and its eyes.
    pub fn warm_up(&mut self, spaces: &Spaces) -> Result<WarmUp, DisplayError> {
        let begun = Instant::now();
        let mut times = Vec::new();
        let mut period_ns = 0;
        while times.len() < 2 * WARM_UP {
            if begun.elapsed() > READY_WITHIN {
                let what =
                    format!("{} did not become ready in {} s; put it on", self.runtime.headset, READY_WITHIN.as_secs());
                return Err(failure(what));
            }
            self.poll()?;
            if !self.lifecycle.is_running() {
                std::thread::sleep(Duration::from_millis(10));
                continue;
            }
            let due = self.wait()?;
            self.give(due, |_| Ok(()))?;
            times.push(due.time().as_nanos());
            period_ns = due.state.predicted_display_period.as_nanos();
        }
        let last_xr = times[times.len() - 1];
        let eyes = self.eyes(spaces, xr::Time::from_nanos(last_xr))?;
        let eyes = eyes.ok_or_else(|| failure(format!("{} does not say where its eyes are", self.runtime.headset)))?;
        let reported = match self.runtime.enabled.fb_display_refresh_rate {
            true => self.session.get_display_refresh_rate().ok().map(f64::from).filter(|hz| *hz > 0.0),
            false => None,
        };
        let regular = pace::regularity(&times[WARM_UP..]);
        self.pace = Pace::default();
        Ok(WarmUp {
            nominal_hz: pace::nominal_hz(reported.unwrap_or(1e9 / period_ns.max(1) as f64)),
            measured_hz: regular.map(|r| r.0),
            interval_sd_ms: regular.map(|r| r.1),
            eyes,
            last_xr,
        })
    }

    /// The poses of the eyes in the head; none while the runtime does not know them.
    pub fn eyes(&self, spaces: &Spaces, time: xr::Time) -> Result<Option<[EyeView; 2]>, DisplayError> {
        let (flags, views) = self.session.locate_views(VIEWS, time, &spaces.head).said("xrLocateViews")?;
        let known = flags.contains(xr::ViewStateFlags::ORIENTATION_VALID | xr::ViewStateFlags::POSITION_VALID);
        Ok(match views.as_slice() {
            [left, right] if known => Some([left, right].map(|v| EyeView { pose: Pose::of(v.pose), fov: v.fov })),
            _ => None,
        })
    }

    /// The pose of the head in the room; none while it is not tracked.
    pub fn head(&self, spaces: &Spaces, time: xr::Time) -> Result<Option<Pose>, DisplayError> {
        let located = spaces.head.locate(&spaces.room, time).said("xrLocateSpace")?;
        let needed = xr::SpaceLocationFlags::ORIENTATION_VALID | xr::SpaceLocationFlags::POSITION_VALID;
        Ok(located.location_flags.contains(needed).then(|| Pose::of(located.pose)))
    }

    /// Leaves in order: asks for the end, keeps the frame loop running until the runtime agrees, and ends the session.
    /// A runtime that is gone or does not answer within two seconds is left alone.
    pub fn leave(&mut self) {
        self.leaving = true;
        if !self.lifecycle.is_running() || self.session.request_exit().is_err() {
            return;
        }
        let begun = Instant::now();
        while self.lifecycle.is_running() && begun.elapsed() < Duration::from_secs(2) {
            let given = self.poll().and_then(|_| match self.lifecycle.is_running() {
                true => self.wait().and_then(|due| self.give(due, |_| Ok(()))),
                false => Ok(()),
            });
            if given.is_err() {
                return;
            }
        }
    }
}

/// The layers of one frame: projections first, then quads over them in this order.
#[derive(Default)]
pub(super) struct Layers<'a> {
    pub projections: Vec<(&'a xr::Space, [xr::CompositionLayerProjectionView<'a, xr::Vulkan>; 2])>,
    pub quads: Vec<xr::CompositionLayerQuad<'a, xr::Vulkan>>,
    /// Whether a picture of the study is among them.
    pub is_stimulus: bool,
}

impl EyeView {
    /// See [`place::field_deg`].
    pub fn field_deg(&self) -> [f64; 4] {
        place::field_deg(self.pose.orientation, self.fov)
    }
}
