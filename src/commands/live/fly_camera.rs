//! A flying camera: keys move it, the mouse turns it.

use std::collections::BTreeSet;

use glam::{DQuat, DVec3};

use crate::scene::View;

/// The direction in which a key moves the camera while it is down.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Direction {
    Forward,
    Back,
    Left,
    Right,
    Up,
    Down,
}

/// Speeds in metres per second, for a person in a room; with shift the camera is three times as fast.
const WALK: f64 = 1.0;
const RUN: f64 = 3.0;
/// Radians of turn for each pixel of the mouse.
const TURN: f64 = 0.003;
/// Largest pitch, radians; straight up and down cannot be reached.
const STEEPEST: f64 = 1.5;

/// The position of the camera and the direction in which it looks.
#[derive(Debug, Clone)]
pub struct FlyCamera {
    view: View,
    /// Angles to the left and up, radians.
    yaw: f64,
    pitch: f64,
    held: BTreeSet<Direction>,
    pub is_fast: bool,
}

impl FlyCamera {
    pub fn new(view: &View) -> FlyCamera {
        let ahead = view.world_from_view * DVec3::NEG_Z;
        let (yaw, pitch) = ((-ahead.x).atan2(-ahead.z), ahead.y.clamp(-1.0, 1.0).asin());
        FlyCamera { view: view.clone(), yaw, pitch, held: BTreeSet::new(), is_fast: false }
    }

    pub fn hold(&mut self, direction: Direction, is_held: bool) {
        if is_held {
            self.held.insert(direction)
        } else {
            self.held.remove(&direction)
        };
    }

    pub fn release_all(&mut self) {
        self.held.clear();
    }

    /// Turns the camera for a move of the mouse by this many pixels, right and down.
    pub fn turn(&mut self, [x, y]: [f32; 2]) {
        self.yaw -= TURN * f64::from(x);
        self.pitch = (self.pitch - TURN * f64::from(y)).clamp(-STEEPEST, STEEPEST);
        self.view.world_from_view = DQuat::from_rotation_y(self.yaw) * DQuat::from_rotation_x(self.pitch);
    }

    /// Moves the camera for this time; returns whether it has moved.
    pub fn step(&mut self, seconds: f64) -> bool {
        let way =
            |to: Direction, back: Direction| f64::from(self.held.contains(&to)) - f64::from(self.held.contains(&back));
        let level = DQuat::from_rotation_y(self.yaw);
        let along =
            level * DVec3::new(way(Direction::Right, Direction::Left), 0.0, way(Direction::Back, Direction::Forward));
        let step = along + DVec3::Y * way(Direction::Up, Direction::Down);
        let speed = if self.is_fast { RUN * WALK } else { WALK };
        self.view.position += step.normalize_or_zero() * speed * seconds;
        step != DVec3::ZERO
    }

    pub fn view(&self) -> &View {
        &self.view
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn forward_is_where_one_looks_and_turning_keeps_the_horizon() {
        let view = View {
            name: "v".to_owned(),
            position: DVec3::ZERO,
            world_from_view: DQuat::from_rotation_y(0.5),
            vertical_fov_rad: 1.0,
            ipd_m: 0.06,
            cant_rad: 0.0,
            near_m: 0.1,
        };
        let mut camera = FlyCamera::new(&view);
        camera.turn([0.0, 0.0]);
        assert!(camera.view().world_from_view.angle_between(view.world_from_view) < 1e-6);
        assert!(!camera.step(1.0));
        camera.hold(Direction::Forward, true);
        assert!(camera.step(2.0));
        let ahead = view.world_from_view * DVec3::NEG_Z;
        assert!((camera.view().position - 2.0 * ahead).length() < 1e-9);
        camera.turn([400.0, -9000.0]);
        let right = camera.view().world_from_view * DVec3::X;
        assert!(right.y.abs() < 1e-9, "the horizon stays level");
    }
}
