//! The history of methods that accumulate frames: each pixel's accumulated reflection, and where the eyes and the instances were
//! in the last frame. `prepared` begins and ends it with each frame; `accumulate` and `reproject` read it.
//!
//! Two sets of images take turns: one is read while the other is written. Each set has 56 bytes for each pixel of each eye, which
//! makes 224 bytes for each pixel of one eye's image. A method without history allocates none of them.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use ash::vk;
use glam::{DAffine3, DVec3};

use crate::gpu::{Buffer, Gpu, GpuError, Image, ImageDesc};
use crate::scene::{Eye, StereoCamera};

use super::shared::FrameUniform;

/// One of the two sets; see `shaders/accumulate.comp`.
pub struct HistorySet {
    /// That frame's guide: what the resolve needed to know of neighbours.
    pub guide: Image,
    /// C·L, the known share of the light, and C, how much is known.
    pub known: Image,
    /// Weight of the taps; nearness of what is reflected, 1/m; variance of the light; effective number of frames.
    /// In the shaders its name ends in `standing_image`.
    pub statistics: Image,
    /// Variance of the light of a single frame; running mean of how far the frames lay above the history.
    pub trend: Image,
}

impl HistorySet {
    fn new(gpu: &Rc<Gpu>, (width, height): (u32, u32)) -> Result<HistorySet, GpuError> {
        let image = |what: &str, format| Image::new(gpu, what, ImageDesc::stereo(width, height, format));
        Ok(HistorySet {
            guide: image("history guide", vk::Format::R32G32B32A32_UINT)?,
            known: image("history light", vk::Format::R32G32B32A32_SFLOAT)?,
            statistics: image("history standing", vk::Format::R32G32B32A32_SFLOAT)?,
            trend: image("history trend", vk::Format::R32G32_SFLOAT)?,
        })
    }
}

/// See the module's documentation.
pub struct History {
    sets: [HistorySet; 2],
    /// Index of the set that the next frame writes.
    turn: Cell<usize>,
    /// The uniforms of the last frame, on the device.
    last_frame: Buffer,
    /// For each instance the three rows of the matrix that takes its points from where they are to where they were in the last
    /// frame.
    motions: Buffer,
    /// Some instance has moved since the last frame.
    is_changing: Cell<bool>,
    /// The last frame that ended; `None` before the first frame and after [`History::forget`].
    last: RefCell<Option<LastFrame>>,
}

struct LastFrame {
    frame: FrameUniform,
    moment: TimedCamera,
    /// The transform of each instance.
    places: Vec<DAffine3>,
}

/// The camera of a frame and its time in the scene's motions.
#[derive(Debug, Clone, Copy)]
pub struct TimedCamera {
    pub camera: StereoCamera,
    /// Time in the scene's motions, seconds; 0 without any.
    pub time_s: f64,
}

/// The largest motion (metres) and rotation (radians) of an eye between two frames, and the most time (seconds) that may pass for
/// moving objects. Anything more is a jump. A head that turns by 500 degrees a second, which is faster than people turn it, turns
/// by 8 degrees within a frame of 1/60 s.
const MOST_MOVED_M: f64 = 0.25;
const MOST_TURNED_RAD: f64 = 0.35;
const MOST_PASSED_S: f64 = 0.25;
/// The largest change of the distance between the eyes between two frames (metres); likewise.
const MOST_APART_M: f64 = 0.005;

impl TimedCamera {
    /// Whether there was a jump since `last`. The history then no longer holds: even a surface that is seen again reflects
    /// something else.
    fn is_after_a_jump(&self, last: &TimedCamera) -> bool {
        let eye_jumps = |eye: Eye| {
            let (now, was) = (self.camera.eye(eye), last.camera.eye(eye));
            now.position.distance(was.position) > MOST_MOVED_M
                || now.world_from_view.angle_between(was.world_from_view) > MOST_TURNED_RAD
        };
        let apart_m = |moment: &TimedCamera| moment.camera.left.position.distance(moment.camera.right.position);
        Eye::BOTH.into_iter().any(eye_jumps)
            || (apart_m(self) - apart_m(last)).abs() > MOST_APART_M
            || (self.time_s - last.time_s).abs() > MOST_PASSED_S
    }
}

impl History {
    /// For views of this size (pixels) and a scene with this many instances.
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn new(gpu: &Rc<Gpu>, size: (u32, u32), instances: usize) -> Result<History, GpuError> {
        Ok(History {
            sets: [HistorySet::new(gpu, size)?, HistorySet::new(gpu, size)?],
            turn: Cell::new(0),
            last_frame: Buffer::upload(gpu, "last frame", size_of::<FrameUniform>() as u64)?,
            motions: Buffer::upload(gpu, "motions", (instances.max(1) * 48) as u64)?,
            is_changing: Cell::new(false),
            last: RefCell::new(None),
        })
    }

    /// Whether there is a last frame.
    pub fn exists(&self) -> bool {
        self.last.borrow().is_some()
    }

    /// Whether an instance has moved since the last frame; valid after [`History::begin`].
    pub fn is_changing(&self) -> bool {
        self.is_changing.get()
    }

    /// The set that this frame reads.
    pub fn last(&self) -> &HistorySet {
        &self.sets[1 - self.turn.get()]
    }

    /// The set that this frame writes.
    pub fn new_set(&self) -> &HistorySet {
        &self.sets[self.turn.get()]
    }

    pub fn last_frame(&self) -> &Buffer {
        &self.last_frame
    }

    pub fn motions(&self) -> &Buffer {
        &self.motions
    }

    /// Call before a frame. After a jump it forgets the history; otherwise it uploads where the eyes and instances were in the
    /// last frame. `places`: the instances' transforms in this frame; `head`: the origin of render space.
    pub fn begin(&self, moment: &TimedCamera, places: &[DAffine3], head: DVec3) {
        if self.last.borrow().as_ref().is_some_and(|last| moment.is_after_a_jump(&last.moment)) {
            self.forget();
        }
        let last = self.last.borrow();
        let Some(LastFrame { frame, places: before, .. }) = &*last else { return };
        self.last_frame.write(bytemuck::bytes_of(frame));
        self.is_changing.set(places != before.as_slice());
        let rows: Vec<[[f32; 4]; 3]> = places.iter().zip(before).map(|(now, was)| rows(now, was, head)).collect();
        if !rows.is_empty() {
            self.motions.write(bytemuck::cast_slice(&rows));
        }
    }

    /// Call after a frame: it becomes the last one.
    pub fn end(&self, frame: FrameUniform, moment: TimedCamera, places: Vec<DAffine3>) {
        *self.last.borrow_mut() = Some(LastFrame { frame, moment, places });
        self.turn.set(1 - self.turn.get());
    }

    /// Forgets the last frame, so that the next one starts without history.
    pub fn forget(&self) {
        *self.last.borrow_mut() = None;
    }
}

/// The rows of the matrix that takes a point of an instance from where it is to where it was, in render space.
fn rows(now: &DAffine3, was: &DAffine3, head: DVec3) -> [[f32; 4]; 3] {
    let invertible = now.matrix3.determinant().abs() > 1e-300;
    let world = if invertible && now != was { *was * now.inverse() } else { DAffine3::IDENTITY };
    let offset = world.transform_point3(head) - head;
    std::array::from_fn(|i| {
        let r = world.matrix3.row(i);
        [r.x as f32, r.y as f32, r.z as f32, offset[i] as f32]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_rows_lead_back_to_where_a_point_was() {
        let head = DVec3::new(10.0, 2.0, -3.0);
        let was = DAffine3::from_rotation_y(0.3);
        let now = DAffine3::from_translation(DVec3::new(0.5, 0.0, 1.0)) * DAffine3::from_rotation_y(0.7);
        let object = DVec3::new(1.0, 2.0, 3.0);
        let is = (now.transform_point3(object) - head).as_vec3().extend(1.0);
        let rows = rows(&now, &was, head).map(glam::Vec4::from_array);
        let found = DVec3::from_array(rows.map(|r| f64::from(r.dot(is))));
        assert!((found - (was.transform_point3(object) - head)).length() < 1e-5, "{found}");
    }
}
