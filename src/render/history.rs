//! What the frames before knew of each pixel's reflection, by eye, and where everything stood in the last one.
//!
//! Two sets of images take turns: one is read while the other is written. They hold 56 bytes a pixel each, for both eyes
//! 224 bytes a pixel of one eye; a method without history has none of them.

use std::cell::{Cell, RefCell};
use std::rc::Rc;

use ash::vk;
use glam::{DAffine3, DVec3};

use crate::gpu::{Buffer, Gpu, GpuError, Image, ImageDesc};
use crate::scene::{Eye, StereoCamera};

use super::shared::FrameUniform;

/// One of the two sets; see `shaders/accumulate.comp`.
pub struct Remembered {
    /// What the resolve asked of neighbours in that frame.
    pub guide: Image,
    /// The known share of the light, and how much is known.
    pub known: Image,
    /// Weight of the taps, nearness of what is reflected, variance of the light, effective number of frames.
    pub standing: Image,
    /// Variance of the light of a single frame; running mean of how far the frames lay above the history.
    pub trend: Image,
}

impl Remembered {
    fn new(gpu: &Rc<Gpu>, (width, height): (u32, u32)) -> Result<Remembered, GpuError> {
        let image = |what: &str, format| Image::new(gpu, what, ImageDesc::stereo(width, height, format));
        Ok(Remembered {
            guide: image("history guide", vk::Format::R32G32B32A32_UINT)?,
            known: image("history light", vk::Format::R32G32B32A32_SFLOAT)?,
            standing: image("history standing", vk::Format::R32G32B32A32_SFLOAT)?,
            trend: image("history trend", vk::Format::R32G32_SFLOAT)?,
        })
    }
}

/// See the module's documentation.
pub struct History {
    sets: [Remembered; 2],
    /// Index of the set that the next frame writes.
    turn: Cell<usize>,
    /// The eyes of the last frame, on the device.
    last_frame: Buffer,
    /// Of each instance, the rows that take its points from where they are to where they were in the last frame.
    motions: Buffer,
    /// Something moved by itself since the last frame.
    is_changing: Cell<bool>,
    /// The last frame that ended; `None`: none did, or it no longer counts.
    last: RefCell<Option<Last>>,
}

struct Last {
    frame: FrameUniform,
    moment: Moment,
    /// Where each instance stood.
    places: Vec<DAffine3>,
}

/// From where and when a frame sees the scene.
#[derive(Debug, Clone, Copy)]
pub struct Moment {
    pub camera: StereoCamera,
    /// Of what moves by itself, seconds; 0 where nothing does.
    pub time_s: f64,
}

/// How far an eye moves (metres) and turns (radians) from one frame to the next at the most, and how much time passes for
/// what moves by itself (seconds): more is a jump. A head that turns by 500 degrees a second, faster than people turn it,
/// turns by 8 degrees within a frame of a 60th of a second.
const MOST_MOVED_M: f64 = 0.25;
const MOST_TURNED_RAD: f64 = 0.35;
const MOST_PASSED_S: f64 = 0.25;
/// How much the distance between the eyes changes (metres).
const MOST_APART_M: f64 = 0.005;

impl Moment {
    /// What was known then does not hold now: a surface that is seen again reflects something else.
    fn is_after_a_jump(&self, last: &Moment) -> bool {
        let eye_jumps = |eye: Eye| {
            let (now, was) = (self.camera.eye(eye), last.camera.eye(eye));
            now.position.distance(was.position) > MOST_MOVED_M
                || now.world_from_view.angle_between(was.world_from_view) > MOST_TURNED_RAD
        };
        let apart_m = |moment: &Moment| moment.camera.left.position.distance(moment.camera.right.position);
        Eye::BOTH.into_iter().any(eye_jumps)
            || (apart_m(self) - apart_m(last)).abs() > MOST_APART_M
            || (self.time_s - last.time_s).abs() > MOST_PASSED_S
    }
}

impl History {
    /// Of views of this size, of a scene of so many instances.
    ///
    /// # Errors
    /// When device memory runs out.
    pub fn new(gpu: &Rc<Gpu>, size: (u32, u32), instances: usize) -> Result<History, GpuError> {
        Ok(History {
            sets: [Remembered::new(gpu, size)?, Remembered::new(gpu, size)?],
            turn: Cell::new(0),
            last_frame: Buffer::upload(gpu, "last frame", size_of::<FrameUniform>() as u64)?,
            motions: Buffer::upload(gpu, "motions", (instances.max(1) * 48) as u64)?,
            is_changing: Cell::new(false),
            last: RefCell::new(None),
        })
    }

    /// Whether there is a frame to look back to.
    pub fn exists(&self) -> bool {
        self.last.borrow().is_some()
    }

    /// Whether an instance stands elsewhere than in the last frame; known once the frame has begun.
    pub fn is_changing(&self) -> bool {
        self.is_changing.get()
    }

    /// What the frames so far knew.
    pub fn last(&self) -> &Remembered {
        &self.sets[1 - self.turn.get()]
    }

    /// What this frame writes.
    pub fn new_set(&self) -> &Remembered {
        &self.sets[self.turn.get()]
    }

    pub fn last_frame(&self) -> &Buffer {
        &self.last_frame
    }

    pub fn motions(&self) -> &Buffer {
        &self.motions
    }

    /// Before a frame: forgets what was before a jump; else tells the device where eyes and instances were. `places` are the instances' now, `head` the origin
    /// of render space.
    pub fn begin(&self, moment: &Moment, places: &[DAffine3], head: DVec3) {
        if self.last.borrow().as_ref().is_some_and(|last| moment.is_after_a_jump(&last.moment)) {
            self.forget();
        }
        let last = self.last.borrow();
        let Some(Last { frame, places: before, .. }) = &*last else { return };
        self.last_frame.write(bytemuck::bytes_of(frame));
        self.is_changing.set(places != before.as_slice());
        let rows: Vec<[[f32; 4]; 3]> = places.iter().zip(before).map(|(now, was)| rows(now, was, head)).collect();
        if !rows.is_empty() {
            self.motions.write(bytemuck::cast_slice(&rows));
        }
    }

    /// After a frame that ended: it is the last one now.
    pub fn end(&self, frame: FrameUniform, moment: Moment, places: Vec<DAffine3>) {
        *self.last.borrow_mut() = Some(Last { frame, moment, places });
        self.turn.set(1 - self.turn.get());
    }

    /// The next frame begins anew.
    pub fn forget(&self) {
        *self.last.borrow_mut() = None;
    }
}

/// From where a point of an instance is to where it was, in render space.
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
