//! How a method changes the settings and the cameras of a view: it may draw a guard band that is not shown, share the random
//! numbers between the eyes, and fix how taps are weighted.

use crate::scene::{Eye, Fov, StereoCamera};

use super::method::{Method, Reuse};
use super::settings::{Firefly, Settings, Streams};

/// What a method draws for a view: size, cameras and settings. Made by `prepared` and `Renderer::prepare`.
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
        let technique = method.technique();
        let shown = [settings.width, settings.height];
        // The band is even, because a device computes derivatives, and from them a texture's mip level, in squares of 2×2 pixels.
        // An odd band would shift these squares.
        let band = |pixels: u32| {
            let wanted = (u64::from(pixels) * u64::from(technique.guard_band)).div_ceil(1000) as u32;
            wanted.next_multiple_of(2)
        };
        let (reuse, firefly) = (settings.reuse(method), settings.firefly(method));
        Framing { guard: shown.map(band), shared_noise: technique.shared_noise, reuse, firefly, shown }
    }

    /// The settings of what is drawn, from those of what is shown.
    pub fn settings(&self, shown: &Settings) -> Settings {
        let [x, y] = self.guard;
        let streams = if self.shared_noise { Streams::Shared } else { shown.streams };
        let (width, height) = (shown.width + 2 * x, shown.height + 2 * y);
        // The fade is as many pixels wide as without a band. It then lies in the band and not in the part that is shown.
        let edge_fade = shown.edge_fade * shown.width as f32 / width as f32;
        Settings { width, height, streams, edge_fade, reuse: self.reuse, firefly: Some(self.firefly), ..shown.clone() }
    }

    /// The cameras of what is drawn: wider by the guard band, so that the pixels stay as large as without it.
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

    /// Cuts the guard band off one eye's tightly packed texels.
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
