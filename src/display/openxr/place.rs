//! Computes where pictures are placed in the room, from poses and angles alone.
//!
//! Parallel cameras show infinity at the same place in both images. Each eye's image is therefore centred on that eye's
//! own axis, straight ahead. With both images on one shared quad at distance D, depth Z would appear at Z·D/(Z + D).
//! The two quads are as far apart as the viewer's own eyes, never further. Perceived depth scales with the ratio of
//! that distance to the one that the stimuli were rendered with (both are in the journal).

use glam::{Quat, Vec3};
use openxr as xr;

/// Distance of every quad, metres. With one quad for each eye it matters only for the vergence on what both eyes see:
/// the panel, the fixation cross, the mirrored pair.
pub(super) const SCREEN_M: f32 = 2.0;

/// Position (metres) and orientation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Pose {
    pub position: Vec3,
    pub orientation: Quat,
}

impl Pose {
    pub const IDENTITY: Pose = Pose { position: Vec3::ZERO, orientation: Quat::IDENTITY };

    pub fn of(p: xr::Posef) -> Pose {
        let (o, t) = (p.orientation, p.position);
        Pose { position: Vec3::new(t.x, t.y, t.z), orientation: Quat::from_xyzw(o.x, o.y, o.z, o.w).normalize() }
    }

    pub fn xr(self) -> xr::Posef {
        let (o, t) = (self.orientation, self.position);
        xr::Posef {
            orientation: xr::Quaternionf { x: o.x, y: o.y, z: o.z, w: o.w },
            position: xr::Vector3f { x: t.x, y: t.y, z: t.z },
        }
    }

    /// Applies `self` after `inner`: turns a pose in the space of `self` into a pose in the space in which `self` is
    /// given.
    pub fn then(self, inner: Pose) -> Pose {
        Pose {
            position: self.position + self.orientation * inner.position,
            orientation: self.orientation * inner.orientation,
        }
    }

    pub fn inverse(self) -> Pose {
        let orientation = self.orientation.inverse();
        Pose { position: -(orientation * self.position), orientation }
    }
}

/// The pose of an upright head that looks where the participant looked when the view was last centred.
///
/// Only the turn about the vertical axis is taken over, because a quad must not lean when the head did.
pub(super) fn upright(head: Pose) -> Pose {
    let forward = head.orientation * Vec3::NEG_Z;
    // A view straight up or down has no horizontal direction, but the head's right-hand side still has one.
    let yaw = if forward.x.hypot(forward.z) > 1e-3 {
        (-forward.x).atan2(-forward.z)
    } else {
        let right = head.orientation * Vec3::X;
        (-right.z).atan2(right.x)
    };
    Pose { position: head.position, orientation: Quat::from_rotation_y(yaw) }
}

/// How far a head leans to a side, degrees: the angle of its right-hand axis to the horizon.
pub(super) fn roll_deg(head: Pose) -> f32 {
    (head.orientation * Vec3::X).y.clamp(-1.0, 1.0).asin().to_degrees()
}

/// The pose of a picture straight ahead of a point of the head (`from`, metres in the head's own axes).
pub(super) fn ahead(from: Vec3, distance_m: f32) -> Pose {
    Pose { position: from + Vec3::new(0.0, 0.0, -distance_m), orientation: Quat::IDENTITY }
}

/// Width and height, metres, of a picture that spans `horizontal_deg` at this distance.
pub(super) fn size_m(horizontal_deg: f64, aspect: f64, distance_m: f32) -> (f32, f32) {
    let width = 2.0 * f64::from(distance_m) * (horizontal_deg.to_radians() / 2.0).tan();
    (width as f32, (width / aspect) as f32)
}

/// Vertical angle of a picture that spans `horizontal_deg`.
pub(super) fn vertical_deg(horizontal_deg: f64, aspect: f64) -> f64 {
    2.0 * ((horizontal_deg.to_radians() / 2.0).tan() / aspect).atan().to_degrees()
}

/// How far an eye sees to the left, right, up and down, degrees, all positive. The angles begin straight ahead, not at
/// the middle of the eye's display, which may be turned outwards.
pub(super) fn field_deg(eye_in_head: Quat, fov: xr::Fovf) -> [f64; 4] {
    let edge = |x: f32, y: f32| eye_in_head * Vec3::new(x, y, -1.0);
    let across = |d: Vec3| f64::from(d.x.atan2(-d.z)).to_degrees();
    let upward = |d: Vec3| f64::from(d.y.atan2(-d.z)).to_degrees();
    [
        -across(edge(fov.angle_left.tan(), 0.0)),
        across(edge(fov.angle_right.tan(), 0.0)),
        upward(edge(0.0, fov.angle_up.tan())),
        -upward(edge(0.0, fov.angle_down.tan())),
    ]
}

/// The point where a ray meets a quad: to the right and down from the quad's upper left corner, each 0 to 1.
pub(super) fn meets(ray: Pose, quad: Pose, size_m: (f32, f32)) -> Option<[f32; 2]> {
    let local = quad.inverse().then(ray);
    let direction = local.orientation * Vec3::NEG_Z;
    // Only rays from the front count.
    if direction.z >= -1e-6 || local.position.z <= 0.0 {
        return None;
    }
    let hit = local.position + direction * (local.position.z / -direction.z);
    let (x, y) = (hit.x / size_m.0 + 0.5, 0.5 - hit.y / size_m.1);
    ((0.0..=1.0).contains(&x) && (0.0..=1.0).contains(&y)).then_some([x, y])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: Vec3, b: Vec3) {
        assert!((a - b).length() < 1e-5, "{a} is not {b}");
    }

    #[test]
    fn each_eyes_quad_is_on_its_own_axis_and_as_far_apart_as_the_eyes() {
        let head = Pose {
            position: Vec3::new(1.0, 1.6, -0.5),
            orientation: Quat::from_rotation_y(0.7) * Quat::from_rotation_x(-0.3) * Quat::from_rotation_z(0.2),
        };
        let straight = upright(head);
        let eyes = [-0.0315, 0.0315].map(|x| straight.then(ahead(Vec3::new(x, 0.0, 0.0), SCREEN_M)));
        assert!(((eyes[1].position - eyes[0].position).length() - 0.063).abs() < 1e-6);
        let forward = Vec3::new(-0.7f32.sin(), 0.0, -0.7f32.cos());
        let right = Vec3::new(0.7f32.cos(), 0.0, -0.7f32.sin());
        close(eyes[0].position, head.position - 0.0315 * right + SCREEN_M * forward);
        // The quad faces back: its front is towards the eye.
        close(eyes[0].orientation * Vec3::Z, -forward);
    }

    #[test]
    fn roll_is_the_lean_and_nothing_else() {
        let turned = Quat::from_rotation_y(1.2) * Quat::from_rotation_x(0.4);
        assert!(roll_deg(Pose { position: Vec3::ZERO, orientation: turned }).abs() < 1e-4);
        let lean = turned * Quat::from_rotation_z(0.2);
        let degrees = roll_deg(Pose { position: Vec3::ZERO, orientation: lean });
        // asin(sin(0.2)·cos(0.4)) is less than the turn, because the head also nods.
        assert!((degrees - (0.2f32.sin() * 0.4f32.cos()).asin().to_degrees()).abs() < 1e-3, "{degrees}");
    }

    #[test]
    fn a_canted_display_sees_less_across_the_nose() {
        let fov = xr::Fovf { angle_left: -0.8, angle_right: 0.8, angle_up: 0.7, angle_down: -0.6 };
        let straight = field_deg(Quat::IDENTITY, fov);
        for (is, should) in straight.iter().zip([0.8f64, 0.8, 0.7, 0.6]) {
            assert!((is - should.to_degrees()).abs() < 1e-4, "{straight:?}");
        }
        // The left display is turned by 0.1 to the left.
        let canted = field_deg(Quat::from_rotation_y(0.1), fov);
        assert!((canted[0] - 0.9f64.to_degrees()).abs() < 1e-3 && (canted[1] - 0.7f64.to_degrees()).abs() < 1e-3);
    }

    #[test]
    fn a_ray_meets_the_panel_where_it_points() {
        let quad = Pose { position: Vec3::new(0.0, 0.0, -2.0), orientation: Quat::IDENTITY };
        let middle = meets(Pose::IDENTITY, quad, (1.0, 0.5)).unwrap();
        assert!((middle[0] - 0.5).abs() < 1e-6 && (middle[1] - 0.5).abs() < 1e-6);
        let right = Pose { position: Vec3::ZERO, orientation: Quat::from_rotation_y(-0.2f32.atan()) };
        let [x, y] = meets(right, quad, (1.0, 0.5)).unwrap();
        assert!((x - 0.9).abs() < 1e-5 && (y - 0.5).abs() < 1e-5);
        let behind = Pose { position: Vec3::ZERO, orientation: Quat::from_rotation_y(3.0) };
        assert!(meets(behind, quad, (1.0, 0.5)).is_none());
        assert!(meets(right, quad, (0.2, 0.5)).is_none());
    }

    #[test]
    fn sixty_degrees_upright_are_ninety_one_across() {
        assert!((vertical_deg(91.5, 16.0 / 9.0) - 60.0).abs() < 0.1);
        let (w, h) = size_m(90.0, 2.0, 2.0);
        assert!((w - 4.0).abs() < 1e-5 && (h - 2.0).abs() < 1e-5);
    }
}
