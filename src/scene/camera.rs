//! The two eyes and where they look. Each eye is a camera of its own, which may have an asymmetric frustum and may be
//! canted.

use glam::{DQuat, DVec3, Mat4, Quat, Vec3, Vec4};

/// Distance between the eyes for a glTF camera, which does not state one: the mean of adults, metres.
pub const DEFAULT_IPD_M: f64 = 0.063;

/// The left or the right eye. Its index is its array layer in all images and buffers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Eye {
    Left,
    Right,
}

impl Eye {
    /// Both eyes, in the order of their layers.
    pub const BOTH: [Eye; 2] = [Eye::Left, Eye::Right];

    /// The array layer: 0 for the left eye and 1 for the right one.
    pub fn layer(self) -> usize {
        match self {
            Eye::Left => 0,
            Eye::Right => 1,
        }
    }

    /// The other eye.
    pub fn other(self) -> Eye {
        match self {
            Eye::Left => Eye::Right,
            Eye::Right => Eye::Left,
        }
    }
}

/// The four sides of a frustum as signed angles from the axis, radians, as OpenXR gives them. Left and down are
/// negative.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fov {
    pub left_rad: f64,
    pub right_rad: f64,
    pub up_rad: f64,
    pub down_rad: f64,
}

impl Fov {
    /// A frustum symmetric about its axis.
    pub fn symmetric(vertical_rad: f64, aspect: f64) -> Fov {
        let up = vertical_rad / 2.0;
        let right = (up.tan() * aspect).atan();
        Fov { left_rad: -right, right_rad: right, up_rad: up, down_rad: -up }
    }
}

/// One eye: where it is, which way it is turned, and what it sees.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EyeCamera {
    pub position: DVec3,
    pub world_from_view: DQuat,
    pub fov: Fov,
    /// Distance of the near plane, metres.
    pub near_m: f64,
}

impl EyeCamera {
    /// The projection: reverse-Z with an infinite far plane, so that depth = near / distance along −Z. y points up in
    /// clip space.
    ///
    /// The Vulkan viewport is flipped (it has a negative height), so that image row 0 is the top.
    pub fn clip_from_view(&self) -> Mat4 {
        let (l, r) = (self.fov.left_rad.tan(), self.fov.right_rad.tan());
        let (u, d) = (self.fov.up_rad.tan(), self.fov.down_rad.tan());
        Mat4::from_cols(
            Vec4::new((2.0 / (r - l)) as f32, 0.0, 0.0, 0.0),
            Vec4::new(0.0, (2.0 / (u - d)) as f32, 0.0, 0.0),
            Vec4::new(((r + l) / (r - l)) as f32, ((u + d) / (u - d)) as f32, 0.0, -1.0),
            Vec4::new(0.0, 0.0, self.near_m as f32, 0.0),
        )
    }

    /// The view transform from positions relative to `origin`. The subtraction of `origin` is done in f64.
    pub fn view_from_relative(&self, origin: DVec3) -> Mat4 {
        let view_from_world = self.world_from_view.inverse();
        let translation = view_from_world * (origin - self.position);
        let q = Quat::from_xyzw(
            view_from_world.x as f32,
            view_from_world.y as f32,
            view_from_world.z as f32,
            view_from_world.w as f32,
        );
        Mat4::from_rotation_translation(q, Vec3::new(translation.x as f32, translation.y as f32, translation.z as f32))
    }
}

/// The two eyes of a frame.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StereoCamera {
    pub left: EyeCamera,
    pub right: EyeCamera,
}

impl StereoCamera {
    /// The point half-way between the eyes, which is the origin of the frame.
    pub fn head(&self) -> DVec3 {
        (self.left.position + self.right.position) * 0.5
    }

    /// The camera of an eye.
    pub fn eye(&self, eye: Eye) -> &EyeCamera {
        match eye {
            Eye::Left => &self.left,
            Eye::Right => &self.right,
        }
    }
}

/// A named viewpoint of a scene.
#[derive(Debug, Clone, PartialEq)]
pub struct View {
    pub name: String,
    /// Position of the head: half-way between the eyes.
    pub position: DVec3,
    pub world_from_view: DQuat,
    pub vertical_fov_rad: f64,
    /// Distance between the eyes in scene units (metres).
    pub ipd_m: f64,
    /// Angle by which each eye is turned outwards, radians, as on canted displays; 0 for parallel eyes.
    pub cant_rad: f64,
    pub near_m: f64,
}

impl View {
    /// The cameras of both eyes for an image with this aspect (width / height of one eye).
    pub fn stereo_camera(&self, aspect: f64) -> StereoCamera {
        let half = self.world_from_view * DVec3::new(self.ipd_m / 2.0, 0.0, 0.0);
        let eye = |offset: DVec3, cant: f64| EyeCamera {
            position: self.position + offset,
            world_from_view: self.world_from_view * DQuat::from_rotation_y(cant),
            fov: Fov::symmetric(self.vertical_fov_rad, aspect),
            near_m: self.near_m,
        };
        StereoCamera { left: eye(-half, self.cant_rad), right: eye(half, -self.cant_rad) }
    }
}
