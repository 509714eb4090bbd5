//! The OpenXR session with the runtime: its states are followed exactly, and frames are waited for and given.
//!
//! OpenXR 1.0: sections 9 (session), 10 (frames). One thread calls everything, so that no call needs a lock.

use std::rc::Rc;
use std::time::{Duration, Instant};

use ash::vk::Handle as _;
use openxr as xr;

use super::frame_statistics::{self, FrameStatistics, SubmittedFrame};
use super::lifecycle::{Lifecycle, LifecycleAction};
use super::place::{self, Pose};
use super::runtime::{CallContext, Runtime, VIEWS, failure};
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
    pub frame_statistics: FrameStatistics,
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
pub(super) enum RuntimeEvent {
    RefreshRate(f64),
    /// The room's origin moves at this time of the runtime, for instance because its recentre button was pressed.
    Recentred(i64),
}

/// A frame that was waited for and must be given to the runtime.
#[derive(Debug, Clone, Copy)]
pub(super) struct PendingFrame {
    pub state: xr::FrameState,
    waited: Instant,
}

impl PendingFrame {
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
        let (session, waiter, stream) = made.in_call("xrCreateSession")?;
        let formats = session.enumerate_swapchain_formats().in_call("xrEnumerateSwapchainFormats")?;
        if !formats.contains(&(texture::FORMAT.as_raw() as u32)) {
            return Err(failure(format!("{} has no 8-bit sRGB swapchains (R8G8B8A8_SRGB)", runtime.name)));
        }
        let space = |kind| session.create_reference_space(kind, xr::Posef::IDENTITY).in_call("xrCreateReferenceSpace");
        let spaces = Spaces { room: space(xr::ReferenceSpaceType::LOCAL)?, head: space(xr::ReferenceSpaceType::VIEW)? };
        let headset = Headset {
            stream,
            waiter,
            session,
            gpu,
            runtime,
            lifecycle: Lifecycle::new(),
            frame_statistics: FrameStatistics::default(),
            events: xr::EventDataBuffer::new(),
            leaving: false,
        };
        Ok((headset, spaces))
    }

    /// Takes all waiting events of the runtime.
    pub fn poll(&mut self) -> Result<Vec<RuntimeEvent>, DisplayError> {
        let mut heard = Vec::new();
        while let Some(event) = self.runtime.instance.poll_event(&mut self.events).in_call("xrPollEvent")? {
            match event {
                xr::Event::SessionStateChanged(e) => {
                    let state = e.state();
                    tracing::debug!("openxr: session {state:?}");
                    match self.lifecycle.enter(state) {
                        LifecycleAction::Nothing => {}
                        LifecycleAction::Begin => {
                            self.session.begin(VIEWS).in_call("xrBeginSession")?;
                            self.frame_statistics.cut();
                        }
                        LifecycleAction::End => {
                            self.session.end().in_call("xrEndSession")?;
                        }
                        LifecycleAction::Lost => {
                            let what =
                                "the headset goes away (LOSS_PENDING); connect it again, then go on with --resume";
                            return Err(failure(what));
                        }
                        LifecycleAction::Exit if self.leaving => {}
                        LifecycleAction::Exit => {
                            return Err(failure("the runtime ended the session (EXITING); go on with --resume"));
                        }
                    }
                }
                xr::Event::InstanceLossPending(_) => {
                    return Err(failure("the OpenXR runtime shuts down; start it again, then go on with --resume"));
                }
                xr::Event::UserPresenceChangedEXT(e) => self.lifecycle.set_worn(e.is_user_present()),
                xr::Event::DisplayRefreshRateChangedFB(e) => {
                    heard.push(RuntimeEvent::RefreshRate(f64::from(e.to_display_refresh_rate())));
                }
                xr::Event::ReferenceSpaceChangePending(e)
                    if e.reference_space_type() == xr::ReferenceSpaceType::LOCAL =>
                {
                    heard.push(RuntimeEvent::Recentred(e.change_time().as_nanos()));
                }
                xr::Event::EventsLost(e) => tracing::warn!("openxr: {} events were lost", e.lost_event_count()),
                _ => {}
            }
        }
        Ok(heard)
    }

    /// Waits until the runtime wants the next frame. Call it only while the session is running.
    pub fn wait(&mut self) -> Result<PendingFrame, DisplayError> {
        let state = self.waiter.wait().in_call("xrWaitFrame")?;
        Ok(PendingFrame { state, waited: Instant::now() })
    }

    /// Begins and ends a frame. `draw` runs in between, but only where it would be seen; otherwise the frame is empty.
    pub fn submit<'a>(
        &mut self,
        due: PendingFrame,
        draw: impl FnOnce(&mut Layers<'a>) -> Result<(), DisplayError>,
    ) -> Result<(), DisplayError> {
        self.stream.begin().in_call("xrBeginFrame")?;
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
        self.stream.end(due.time(), self.runtime.blend, &bases).in_call("xrEndFrame")?;
        self.frame_statistics.add(SubmittedFrame {
            at_ns: due.time().as_nanos(),
            period_ns: due.state.predicted_display_period.as_nanos(),
            drawing_ns,
            busy_ns: due.waited.elapsed().as_nanos() as u64,
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
            self.submit(due, |_| Ok(()))?;
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
        let regular = frame_statistics::regularity(&times[WARM_UP..]);
        self.frame_statistics = FrameStatistics::default();
        Ok(WarmUp {
            nominal_hz: frame_statistics::nominal_hz(reported.unwrap_or(1e9 / period_ns.max(1) as f64)),
            measured_hz: regular.map(|r| r.0),
            interval_sd_ms: regular.map(|r| r.1),
            eyes,
            last_xr,
        })
    }

    /// The poses of the eyes in the head; none while the runtime does not know them.
    pub fn eyes(&self, spaces: &Spaces, time: xr::Time) -> Result<Option<[EyeView; 2]>, DisplayError> {
        let (flags, views) = self.session.locate_views(VIEWS, time, &spaces.head).in_call("xrLocateViews")?;
        let known = flags.contains(xr::ViewStateFlags::ORIENTATION_VALID | xr::ViewStateFlags::POSITION_VALID);
        Ok(match views.as_slice() {
            [left, right] if known => Some([left, right].map(|v| EyeView { pose: Pose::of(v.pose), fov: v.fov })),
            _ => None,
        })
    }

    /// The pose of the head in the room; none while it is not tracked.
    pub fn head(&self, spaces: &Spaces, time: xr::Time) -> Result<Option<Pose>, DisplayError> {
        let located = spaces.head.locate(&spaces.room, time).in_call("xrLocateSpace")?;
        let needed = xr::SpaceLocationFlags::ORIENTATION_VALID | xr::SpaceLocationFlags::POSITION_VALID;
        Ok(located.location_flags.contains(needed).then(|| Pose::of(located.pose)))
    }

    /// Leaves in order: asks for the end, keeps the frame loop running until the runtime agrees, and ends the session.
    /// A runtime that is gone or does not answer within two seconds is left alone.
    pub fn exit_session(&mut self) {
        self.leaving = true;
        if !self.lifecycle.is_running() || self.session.request_exit().is_err() {
            return;
        }
        let begun = Instant::now();
        while self.lifecycle.is_running() && begun.elapsed() < Duration::from_secs(2) {
            let given = self.poll().and_then(|_| match self.lifecycle.is_running() {
                true => self.wait().and_then(|due| self.submit(due, |_| Ok(()))),
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
