//! What is drawn where a method draws more than it shows, or with other random numbers than the settings say.

use crate::scene::{Eye, Fov, StereoCamera};

use super::method::{Method, Reuse};
use super::settings::{Firefly, Settings, Streams};

/// A method's view of a view.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Framing {
    /// Pixels at each side (x, y) that are drawn and never shown.
    pub guard: [u32; 2],
    shared_noise: bool,
    reuse: Reuse,
    firefly: Firefly,
    shown: [u32; 2],
}

impl Framing {
    pub fn of(method: &Method, settings: &Settings) -> Framing {
        let parts = method.parts();
        let shown = [settings.width, settings.height];
        // Even: a device takes derivatives, and from them the level of a texture, in squares of two by two pixels, which
        // an odd band would place otherwise.
        let band = |pixels: u32| {
            let wanted = (u64::from(pixels) * u64::from(parts.guard_band)).div_ceil(1000) as u32;
            wanted.next_multiple_of(2)
        };
        let (reuse, firefly) = (settings.reuse(method), settings.firefly(method));
        Framing { guard: shown.map(band), shared_noise: parts.shared_noise, reuse, firefly, shown }
    }

    /// The settings of what is drawn.
    pub fn settings(&self, shown: &Settings) -> Settings {
        let [x, y] = self.guard;
        let streams = if self.shared_noise { Streams::Shared } else { shown.streams };
        let (width, height) = (shown.width + 2 * x, shown.height + 2 * y);
        // As many pixels as without a band: what is beyond the view fades there, not what is in it.
        let edge_fade = shown.edge_fade * shown.width as f32 / width as f32;
        Settings { width, height, streams, edge_fade, reuse: self.reuse, firefly: Some(self.firefly), ..shown.clone() }
    }

    /// The eyes of what is drawn: pixels as large as those shown.
    pub fn camera(&self, shown: &StereoCamera) -> StereoCamera {
        if self.guard == [0, 0] {
            return *shown;
        }
        let wider = |eye: Eye| {
            let mut camera = *shown.eye(eye);
            let Fov { left_rad, right_rad, down_rad, up_rad } = camera.fov;
            let [left, right, down, up] = [left_rad, right_rad, down_rad, up_rad].map(f64::tan);
            let across = (right - left) * f64::from(self.guard[0]) / f64::from(self.shown[0]);
            let upwards = (up - down) * f64::from(self.guard[1]) / f64::from(self.shown[1]);
            camera.fov = Fov {
                left_rad: (left - across).atan(),
                right_rad: (right + across).atan(),
                down_rad: (down - upwards).atan(),
                up_rad: (up + upwards).atan(),
            };
            camera
        };
        StereoCamera { left: wider(Eye::Left), right: wider(Eye::Right) }
    }

    /// What is shown of tightly packed texels of one eye.
    pub fn crop<T: Copy>(&self, drawn: &[T]) -> Vec<T> {
        let ([x, y], [width, height]) = (self.guard.map(|n| n as usize), self.shown.map(|n| n as usize));
        let stride = width + 2 * x;
        (y..y + height).flat_map(|row| &drawn[row * stride + x..row * stride + x + width]).copied().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_band_is_cut_off_again() {
        let settings = Settings { width: 3, height: 2, ..Settings::default() };
        let method = Method::parse("sssr-guardband").expect("known");
        let framing = Framing::of(&method, &settings);
        let drawn = framing.settings(&settings);
        assert_eq!((framing.guard, drawn.width, drawn.height), ([2, 2], 7, 6));
        let texels: Vec<u32> = (0..42).collect();
        assert_eq!(framing.crop(&texels), [16, 17, 18, 23, 24, 25]);
    }
}
