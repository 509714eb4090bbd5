//! A scene in a headset: renders each eye from where the runtime predicts it, and shows both in a projection layer.

use std::rc::Rc;
use std::sync::Arc;
use std::time::Instant;

use glam::{DQuat, DVec3};

use super::desktop::LiveRequest;
use crate::commands::device::{self, Size};
use crate::console::{Console, check_interrupted};
use crate::display::openxr::{EyeInRoom, HeadsetInput, StandaloneHeadset};
use crate::render::{Method, Prepared, Renderer};
use crate::scene::{EyeCamera, Fov, StereoCamera, View};
use crate::study::protocol::Input;

/// Scales of the resolution, from the runtime's own downwards. A step down is taken when frames are late, and a step
/// back when they are not.
const SCALES: [f64; 5] = [1.0, 0.84, 0.7, 0.6, 0.5];
/// Frames that are counted before the resolution changes.
const WINDOW: u32 = 45;

/// The pose of the room in the scene.
struct RoomPose {
    /// Position of the room's origin.
    position: DVec3,
    scene_from_room: DQuat,
}

struct Live<'a> {
    request: &'a LiveRequest,
    methods: Vec<Method>,
    method: usize,
    scale: usize,
    room_pose: Option<RoomPose>,
    prepared: Option<(usize, Size, Prepared)>,
    renderer: Renderer,
    /// The zero of the scene's time, for what moves by itself.
    began: Instant,
    full: Size,
    period_ms: f64,
    /// Frames since the resolution changed, and how many of them were late.
    seen: u32,
    late: u32,
}

/// Runs until somebody ends it.
///
/// # Errors
/// No headset, or a frame that failed.
pub fn run(request: &LiveRequest, console: &Console) -> anyhow::Result<()> {
    let mut headset = StandaloneHeadset::open()?;
    let info = headset.info().clone();
    let gpu = Rc::clone(headset.gpu());
    let less = if gpu.is_cpu() { 2 } else { 1 };
    let full = request.size.unwrap_or(Size { width: info.width_px / less, height: info.height_px / less });
    let methods = super::methods(&request.method);
    for (i, method) in (1..).zip(methods.iter().take(9)) {
        console.note(format!("{i}: {method}"));
    }
    let mut live = Live {
        renderer: Renderer::new(&gpu, Arc::clone(&request.scene))?,
        began: Instant::now(),
        request,
        methods,
        method: 0,
        scale: 0,
        room_pose: None,
        prepared: None,
        full,
        period_ms: 1e3 / info.nominal_hz,
        seen: 0,
        late: 0,
    };
    let (mut frames, mut total_ms) = (0u64, 0.0);
    while request.frames.is_none_or(|n| frames < n) {
        check_interrupted()?;
        let Some(frame) = headset.wait()? else { continue };
        if live.act(&frame.acts) {
            headset.show_nothing(frame)?;
            break;
        }
        let Some(eyes) = frame.eyes else {
            headset.show_nothing(frame)?;
            continue;
        };
        total_ms += live.draw(&eyes, frame.acts.centre, frames as u32)?;
        frames += 1;
        match &live.prepared {
            Some((_, _, prepared)) => headset.show_projection(frame, prepared.display_image())?,
            None => headset.show_nothing(frame)?,
        }
    }
    gpu.check_validation()?;
    let mean_ms = total_ms / frames.max(1) as f64;
    console.object(&serde_json::json!({ "frames": frames, "mean_ms": mean_ms, "device": gpu.info() }))?;
    console.line(format!("{frames} frames, {mean_ms:.1} ms each, in {} ({})", info.system, info.runtime));
    Ok(())
}

impl Live<'_> {
    /// Carries out what was done with the controllers; returns whether the program ends.
    fn act(&mut self, acts: &HeadsetInput) -> bool {
        let n = self.methods.len();
        if acts.step != 0 {
            self.method = (self.method as i32 + acts.step).rem_euclid(n as i32) as usize;
        }
        for input in &acts.typed {
            match input {
                Input::Choose(at) if (*at as usize) < n => self.method = *at as usize,
                Input::Continue => self.method = (self.method + 1) % n,
                Input::Quit => return true,
                _ => {}
            }
        }
        acts.pause
    }

    /// Renders one frame; returns its milliseconds.
    fn draw(&mut self, eyes: &[EyeInRoom; 2], is_centred: bool, frame: u32) -> anyhow::Result<f64> {
        if is_centred {
            self.room_pose = None;
        }
        let room_pose = self.room_pose.get_or_insert_with(|| RoomPose::at_view(&self.request.view, eyes));
        let camera = room_pose.camera(eyes, self.request.view.near_m);
        let scaled = |side: u32| ((f64::from(side) * SCALES[self.scale]) as u32).max(16);
        let size = Size { width: scaled(self.full.width), height: scaled(self.full.height) };
        if !self.prepared.as_ref().is_some_and(|(method, of, _)| (*method, *of) == (self.method, size)) {
            // The reference takes one path per pixel. It is noisy while the head moves, but frames keep coming.
            let method = self.methods[self.method].clone();
            let method = if method.samples() > 64 { method.with_samples(Some(1)) } else { method };
            self.prepared = None;
            let made = self.renderer.prepare(&camera, &method, &device::live_settings(self.renderer.gpu(), size))?;
            self.prepared = Some((self.method, size, made));
        }
        let Some((_, _, prepared)) = &mut self.prepared else { return Ok(0.0) };
        prepared.set_time(self.began.elapsed().as_secs_f64())?;
        prepared.set_camera(&camera);
        prepared.set_seed(1, frame);
        let report = prepared.frame(&mut |_, _| check_interrupted())?;
        self.pace(report.wall_ms);
        Ok(report.wall_ms)
    }

    /// Renders fewer pixels when more than a tenth of the frames took longer than a period, and more when none took
    /// half of one.
    fn pace(&mut self, ms: f64) {
        self.seen += 1;
        self.late += u32::from(ms > 0.9 * self.period_ms);
        if self.seen < WINDOW {
            return;
        }
        if 10 * self.late > self.seen && self.scale + 1 < SCALES.len() {
            self.scale += 1;
        } else if self.late == 0 && ms < 0.5 * self.period_ms && self.scale > 0 {
            self.scale -= 1;
        }
        (self.seen, self.late) = (0, 0);
    }
}

impl RoomPose {
    /// Places the room so that the head is now at the view and looks in its direction; the horizon stays level.
    fn at_view(view: &View, eyes: &[EyeInRoom; 2]) -> RoomPose {
        let head = (position(&eyes[0]) + position(&eyes[1])) / 2.0;
        let scene_from_room = DQuat::from_rotation_y(yaw(view.world_from_view) - yaw(orientation(&eyes[0])));
        RoomPose { position: view.position - scene_from_room * head, scene_from_room }
    }

    fn camera(&self, eyes: &[EyeInRoom; 2], near_m: f64) -> StereoCamera {
        let eye = |eye: &EyeInRoom| {
            let [left_rad, right_rad, up_rad, down_rad] = eye.fov_rad.map(f64::from);
            EyeCamera {
                position: self.position + self.scene_from_room * position(eye),
                world_from_view: self.scene_from_room * orientation(eye),
                fov: Fov { left_rad, right_rad, up_rad, down_rad },
                near_m,
            }
        };
        StereoCamera { left: eye(&eyes[0]), right: eye(&eyes[1]) }
    }
}

fn position(eye: &EyeInRoom) -> DVec3 {
    DVec3::from_array(eye.position.map(f64::from))
}

fn orientation(eye: &EyeInRoom) -> DQuat {
    DQuat::from_array(eye.orientation.map(f64::from)).normalize()
}

/// The turn about the vertical axis, radians to the left.
fn yaw(turn: DQuat) -> f64 {
    let ahead = turn * DVec3::NEG_Z;
    (-ahead.x).atan2(-ahead.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_head_begins_where_the_view_is_and_moves_with_it() {
        let view = View {
            name: "v".to_owned(),
            position: DVec3::new(5.0, 1.0, -3.0),
            world_from_view: DQuat::from_rotation_y(1.1) * DQuat::from_rotation_x(-0.4),
            vertical_fov_rad: 1.0,
            ipd_m: 0.06,
            cant_rad: 0.0,
            near_m: 0.1,
        };
        let turned = DQuat::from_rotation_y(-0.6);
        let eye = |x: f64, ahead: f64| EyeInRoom {
            position: (turned * DVec3::new(x, 0.0, -ahead) + DVec3::new(0.2, 1.6, 0.1)).as_vec3().to_array(),
            orientation: turned.as_quat().to_array(),
            fov_rad: [-0.8, 0.7, 0.6, -0.5],
        };
        let room_pose = RoomPose::at_view(&view, &[eye(-0.03, 0.0), eye(0.03, 0.0)]);
        let camera = room_pose.camera(&[eye(-0.03, 0.0), eye(0.03, 0.0)], 0.1);
        assert!((camera.head() - view.position).length() < 1e-6);
        assert!((yaw(camera.left.world_from_view) - 1.1).abs() < 1e-6);
        assert!(((camera.right.position - camera.left.position).length() - 0.06).abs() < 1e-6);
        // A step forward in the room is a step in the view's direction.
        let moved = room_pose.camera(&[eye(-0.03, 1.0), eye(0.03, 1.0)], 0.1);
        let ahead = DQuat::from_rotation_y(1.1) * DVec3::NEG_Z;
        assert!((moved.head() - view.position - ahead).length() < 1e-6);
        assert!((camera.left.fov.left_rad + 0.8).abs() < 1e-6);
    }
}
