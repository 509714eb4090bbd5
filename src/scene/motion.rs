//! Things that move: rigid paths through the world as functions of time. Manifests define them; renderers set the time.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use super::Scene;

/// One frame at the studies' frame rate: what "previous" means for stills, seconds.
pub const FRAME_S: f64 = 1.0 / 90.0;

/// A group of instances on one path.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion {
    /// Indices into [`Scene::instances`].
    pub instances: Vec<usize>,
    /// The transform of each of them at time 0, in the same order.
    pub rest: Vec<DAffine3>,
    pub path: Path,
}

/// A rigid movement in the world, which is the identity at time 0.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Path {
    /// One rotation about the axis through `center` in `period_s`, counter-clockwise for a viewer towards whom `axis`
    /// (unit length) points.
    ///
    /// With a centre inside the group it is a spin on the spot.
    Orbit { center: DVec3, axis: DVec3, period_s: f64 },
    /// A movement to and fro along `offset_m`: `offset_m · sin(2π t / period_s)`.
    Sway { offset_m: DVec3, period_s: f64 },
}

impl Path {
    /// The transform of the world from time 0 to `time_s`.
    pub fn at(&self, time_s: f64) -> DAffine3 {
        match *self {
            Path::Orbit { center, axis, period_s } => {
                let turn = DQuat::from_axis_angle(axis, std::f64::consts::TAU * time_s / period_s);
                let matrix = DMat3::from_quat(turn);
                DAffine3 { matrix3: matrix, translation: center - matrix * center }
            }
            Path::Sway { offset_m, period_s } => {
                DAffine3::from_translation(offset_m * (std::f64::consts::TAU * time_s / period_s).sin())
            }
        }
    }
}

impl Scene {
    /// The present transform of each instance, in the order of [`Scene::instances`].
    pub fn places(&self) -> Vec<DAffine3> {
        self.instances.iter().map(|i| i.world_from_object).collect()
    }

    /// The transform of each instance at `time_s`, in the order of [`Scene::instances`].
    pub fn places_at(&self, time_s: f64) -> Vec<DAffine3> {
        let mut places = self.places();
        for motion in &self.motions {
            let now = motion.path.at(time_s);
            for (index, rest) in motion.instances.iter().zip(&motion.rest) {
                if let Some(place) = places.get_mut(*index) {
                    *place = now * *rest;
                }
            }
        }
        places
    }

    /// Places everything that moves at `time_s`. Its previous transform becomes the one `frame_s` earlier.
    pub fn set_time(&mut self, time_s: f64, frame_s: f64) {
        for motion in &self.motions {
            let (now, before) = (motion.path.at(time_s), motion.path.at(time_s - frame_s));
            for (index, rest) in motion.instances.iter().zip(&motion.rest) {
                let Some(instance) = self.instances.get_mut(*index) else { continue };
                instance.world_from_object = now * *rest;
                instance.previous_world_from_object = before * *rest;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_start_at_rest_and_come_round() {
        let orbit = Path::Orbit { center: DVec3::new(1.0, 2.0, 3.0), axis: DVec3::Y, period_s: 4.0 };
        let p = DVec3::new(2.0, 2.0, 3.0);
        assert!((orbit.at(0.0).transform_point3(p) - p).length() < 1e-12);
        // A quarter turn about +Y takes +X to −Z.
        assert!((orbit.at(1.0).transform_point3(p) - DVec3::new(1.0, 2.0, 2.0)).length() < 1e-12);
        assert!((orbit.at(4.0).transform_point3(p) - p).length() < 1e-12);
        let sway = Path::Sway { offset_m: DVec3::X, period_s: 2.0 };
        assert!((sway.at(0.5).translation - DVec3::X).length() < 1e-12);
    }
}
