//! Tests what the desktop's composer gives each eye in each display mode, pixel by pixel. Needs a Vulkan device, but no
//! window.
#![cfg(feature = "gpu")]

use std::rc::Rc;
use std::time::Instant;

use cyclopean::display::desktop::{Composer, Composition, Mode, Picture, fit};
use cyclopean::gpu::{Buffer, Frame, Gpu, GpuOptions, Image, ImageDesc, OwnDevice};

use ash::vk;

const VIEW: (u32, u32) = (64, 48);

/// The colour of a pixel of a test picture. It depends on the eye and on the place.
fn pixel(eye: u32, x: u32, y: u32) -> [u8; 3] {
    [(eye * 100 + 3 * x) as u8, (5 * y) as u8, (x * y % 251) as u8]
}

fn layers(gpu: &Rc<Gpu>, color: impl Fn(u32, u32, u32) -> [u8; 4], (width, height): (u32, u32)) -> Image {
    let eye = |eye: u32| -> Vec<u8> {
        (0..height).flat_map(|y| (0..width).map(move |x| (x, y))).flat_map(|(x, y)| color(eye, x, y)).collect()
    };
    let usage = vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_DST;
    let desc = ImageDesc { usage, ..ImageDesc::stereo(width, height, vk::Format::R8G8B8A8_SRGB) };
    Image::with_layers(gpu, "test", desc, &[&eye(0), &eye(1)]).unwrap()
}

struct Bench {
    gpu: Rc<Gpu>,
    composer: Composer,
}

impl Bench {
    fn new() -> Bench {
        let gpu = Gpu::open(&OwnDevice::default(), &GpuOptions::from_environment()).unwrap();
        let composer = Composer::new(&gpu).unwrap();
        Bench { gpu, composer }
    }

    fn still(&self) -> Image {
        layers(&self.gpu, |eye, x, y| [pixel(eye, x, y), [0; 3]].concat()[..4].try_into().unwrap(), VIEW)
    }

    fn compose(&self, window: (u32, u32), mode: Mode, picture: Picture<'_>, place: [u32; 4]) -> image::RgbaImage {
        let words = layers(&self.gpu, |_, _, _| [0; 4], mode.view(window));
        let into = self.composer.image(window).unwrap();
        let parts = Composition { mode, picture, place, words: &words, apart_px: 0, ground: 0.2159, patch: None };
        self.composer.compose(&parts, &into).unwrap();
        let buffer = Buffer::readback(&self.gpu, "window", u64::from(window.0 * window.1 * 4)).unwrap();
        let mut frame = Frame::begin(&self.gpu).unwrap();
        frame.copy_image(&into, &buffer);
        frame.finish().unwrap();
        self.gpu.check_validation().unwrap();
        image::RgbaImage::from_raw(window.0, window.1, buffer.read()).unwrap()
    }
}

fn rgb(image: &image::RgbaImage, x: u32, y: u32) -> [u8; 3] {
    image.get_pixel(x, y).0[..3].try_into().unwrap()
}

#[test]
fn at_equal_size_every_pixel_arrives_at_its_own_eye_unchanged() {
    let bench = Bench::new();
    let still = bench.still();
    let picture = Picture::Stereo { image: &still, is_encoded: false };
    let whole = [0, 0, VIEW.0, VIEW.1];
    let (w, h) = VIEW;
    for (mode, halves) in [(Mode::SideBySide, [0, 1]), (Mode::Crossed, [1, 0])] {
        let seen = bench.compose((2 * w, h), mode, picture, whole);
        for (x, y) in (0..h).flat_map(|y| (0..2 * w).map(move |x| (x, y))) {
            assert_eq!(rgb(&seen, x, y), pixel(halves[(x / w) as usize], x % w, y), "{mode:?} {x} {y}");
        }
    }
    for (mode, eye) in [(Mode::LeftEye, 0), (Mode::RightEye, 1)] {
        let seen = bench.compose(VIEW, mode, picture, whole);
        assert!(seen.enumerate_pixels().all(|(x, y, _)| rgb(&seen, x, y) == pixel(eye, x, y)), "{mode:?}");
    }
}

#[test]
fn a_mirrored_pair_stands_side_by_side_without_a_gap() {
    let bench = Bench::new();
    let reference = bench.still();
    let test = layers(&bench.gpu, |eye, x, y| [pixel(eye, y, x), [0; 3]].concat()[..4].try_into().unwrap(), VIEW);
    let (w, h) = VIEW;
    for eye in 0..2 {
        let picture = Picture::Pair { reference: &reference, test: &test, eye: eye as usize };
        let seen = bench.compose((2 * w, h), Mode::LeftEye, picture, [0, 0, 2 * w, h]);
        for (x, y) in (0..h).flat_map(|y| (0..w).map(move |x| (x, y))) {
            assert_eq!(rgb(&seen, x, y), pixel(eye, x, y), "reference {x} {y}");
            assert_eq!(rgb(&seen, 2 * w - 1 - x, y), pixel(eye, y, x), "mirrored {x} {y}");
        }
    }
}

#[test]
fn grey_stays_grey_through_red_and_cyan_and_colours_part() {
    let bench = Bench::new();
    let flat = |color: [u8; 3]| layers(&bench.gpu, move |_, _, _| [color[0], color[1], color[2], 0], VIEW);
    let whole = [0, 0, VIEW.0, VIEW.1];
    let seen = |color| {
        let image = flat(color);
        let picture = Picture::Stereo { image: &image, is_encoded: false };
        rgb(&bench.compose(VIEW, Mode::Anaglyph, picture, whole), 9, 9)
    };
    // Each row of the two anaglyph matrices sums to about one over both eyes, so that grey stays grey.
    for v in [0, 64, 128, 200, 255] {
        let [r, g, b] = seen([v; 3]);
        assert!([r, g, b].iter().all(|c| c.abs_diff(v) <= 2), "{v}: {r} {g} {b}");
    }
    // White that only the left eye sees becomes red, and white that only the right eye sees becomes cyan.
    let eyes = layers(
        &bench.gpu,
        |eye, x, _| {
            [if (x < 32) == (eye == 0) { 255 } else { 0 }; 3]
                .map(|v: u8| v)
                .into_iter()
                .chain([0])
                .collect::<Vec<_>>()
                .try_into()
                .unwrap()
        },
        VIEW,
    );
    let both = bench.compose(VIEW, Mode::Anaglyph, Picture::Stereo { image: &eyes, is_encoded: false }, whole);
    let (left, right) = (rgb(&both, 9, 9), rgb(&both, 50, 9));
    assert!(left[0] > 240 && left[1] < 40 && left[2] < 40, "{left:?}");
    assert!(right[0] < 40 && right[1] > 240 && right[2] > 240, "{right:?}");
}

#[test]
fn shrinking_keeps_the_mean_and_half_width_keeps_the_eyes() {
    let bench = Bench::new();
    // A checkerboard of black and white emits half the light of white, which is 188 of 255 in sRGB.
    let board = layers(&bench.gpu, |_, x, y| [[0, 255][((x + y) % 2) as usize]; 4], VIEW);
    let picture = Picture::Stereo { image: &board, is_encoded: false };
    let seen = bench.compose((32, 24), Mode::LeftEye, picture, [0, 0, 32, 24]);
    assert!(seen.pixels().all(|p| p.0[0].abs_diff(188) <= 1), "{:?}", seen.get_pixel(3, 3));
    let still = bench.still();
    let seen = bench.compose(
        VIEW,
        Mode::HalfSideBySide,
        Picture::Stereo { image: &still, is_encoded: false },
        [0, 0, VIEW.0, VIEW.1],
    );
    let (left, right) = (rgb(&seen, 10, 20), rgb(&seen, 42, 20));
    assert!(left[0].abs_diff(pixel(0, 20, 20)[0]) <= 3 && right[0].abs_diff(pixel(1, 20, 20)[0]) <= 3);
}

#[test]
fn a_window_is_composed_in_every_mode() {
    let bench = Bench::new();
    let still =
        layers(&bench.gpu, |eye, x, y| [pixel(eye, x, y), [0; 3]].concat()[..4].try_into().unwrap(), (320, 180));
    for mode in Mode::ALL {
        let window = (1280, 720);
        let words = layers(&bench.gpu, |_, _, _| [0; 4], mode.view(window));
        let into = bench.composer.image(window).unwrap();
        let place = fit(mode.view(window), (320, 180), 5000, 0);
        let picture = Picture::Stereo { image: &still, is_encoded: false };
        let parts = Composition { mode, picture, place, words: &words, apart_px: 0, ground: 0.2159, patch: None };
        let mut best = f64::INFINITY;
        for _ in 0..4 {
            let began = Instant::now();
            bench.composer.compose(&parts, &into).unwrap();
            best = best.min(began.elapsed().as_secs_f64() * 1e3);
        }
        println!("{}: {best:.1} ms", mode.name());
    }
    bench.gpu.check_validation().unwrap();
}
