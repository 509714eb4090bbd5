//! Twin of `shaders/path_trace.comp`: adds samples to the listed pixels, on all cores. Each pixel is processed by one thread and
//! does not depend on its neighbours, so that the sums do not depend on the number of threads.

use bytemuck::{Pod, Zeroable};
use glam::{Mat3A, Vec3A, Vec4};

use super::super::ray_list::RayList;
use super::super::shared::{EyeUniform, FrameUniform};
use super::brdf::Reflector;
use super::inputs::{Inputs, Tally};
use super::math::{MOST_HALF, luminance};
use super::parallel::on_all_cores;
use super::random::{DRAW_LIGHT, Sequence, combine};
use super::shade::{Draws, LightWalk, Shading};
use super::surface::Surface;
use super::tree::Stack;

/// The number of pixels that a thread takes at a time.
const AT_A_TIME: usize = 64;

/// A listed pixel: its surface, and its sums so far.
pub struct Pixel {
    /// x and y in 14 bits each, then the eye, as packed by `pack_pixel` of ray_list.glsl.
    packed: u32,
    depth: f32,
    surface: [u32; 4],
    sum: Vec3A,
    compensation: Vec3A,
    squares: Vec3A,
    /// Σ w/distance and Σ w, where w is the luminance of a sample's weight.
    nearness: [f32; 2],
}

/// A pixel's sums as they are kept between runs.
#[repr(C)]
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
pub struct KeptPixel {
    /// As in [`Pixel`].
    packed: u32,
    sum: [f32; 3],
    compensation: [f32; 3],
    squares: [f32; 3],
    nearness: [f32; 2],
}

/// The sums of a view's listed pixels, from which more samples can be added.
#[derive(Debug, Clone, PartialEq)]
pub struct KeptSums {
    /// Number of samples of each pixel.
    pub samples: u32,
    pub pixels: Vec<KeptPixel>,
}

/// Adds samples `first .. first + count` to every pixel.
pub fn add_samples(inputs: &Inputs<'_>, pixels: &mut [Pixel], (first, count): (u32, u32)) -> Tally {
    let start = || {
        let walk = LightWalk::new(inputs.world);
        let shading = Shading { inputs, stack: Stack::new(), walk, tally: Tally::default() };
        Tracer { shading, light_draws: Vec::new() }
    };
    let each = |tracer: &mut Tracer<'_>, chunk: &mut [Pixel]| {
        chunk.iter_mut().for_each(|pixel| tracer.add(pixel, first, count));
    };
    let mut tally = Tally::default();
    for tracer in on_all_cores(pixels.chunks_mut(AT_A_TIME), start, each) {
        tally.add(&tracer.shading.tally);
        tally.light_rays += tracer.shading.walk.rays;
    }
    tally
}

impl Pixel {
    /// A pixel without samples.
    pub fn new(packed: u32, depth: f32, surface: [u32; 4]) -> Pixel {
        let zero = Vec3A::ZERO;
        Pixel { packed, depth, surface, sum: zero, compensation: zero, squares: zero, nearness: [0.0; 2] }
    }

    pub fn packed(&self) -> u32 {
        self.packed
    }

    pub fn keep(&self) -> KeptPixel {
        KeptPixel {
            packed: self.packed,
            sum: self.sum.to_array(),
            compensation: self.compensation.to_array(),
            squares: self.squares.to_array(),
            nearness: self.nearness,
        }
    }

    /// Continues from kept sums of the same pixel.
    pub fn continue_from(&mut self, kept: &KeptPixel) {
        self.sum = Vec3A::from(kept.sum);
        self.compensation = Vec3A::from(kept.compensation);
        self.squares = Vec3A::from(kept.squares);
        self.nearness = kept.nearness;
    }

    /// The result of n samples: the mean reflection with 1 / the distance of what is reflected (1/m; 0 the sky, −1 unknown), and
    /// the mean's standard error.
    pub fn result(&self, n: u32) -> (Vec4, Vec3A) {
        let n = n as f32;
        let mean = self.sum / n;
        let variance = (self.squares / n - mean * mean).max(Vec3A::ZERO) * (n / (n - 1.0).max(1.0));
        let [near, weight] = self.nearness;
        let nearness = if weight > 0.0 { near / weight } else { -1.0 };
        let error = variance / n;
        (mean.extend(nearness), Vec3A::new(error.x.sqrt(), error.y.sqrt(), error.z.sqrt()))
    }
}

impl KeptPixel {
    pub fn packed(&self) -> u32 {
        self.packed
    }
}

/// A thread's state.
struct Tracer<'a> {
    shading: Shading<'a>,
    /// For the current pixel, one for each light.
    light_draws: Vec<Sequence>,
}

impl Tracer<'_> {
    fn add(&mut self, pixel: &mut Pixel, first: u32, count: u32) {
        let Inputs { world, frame, .. } = *self.shading.inputs;
        let [x, y, eye] = RayList::place(pixel.packed);
        let view = View::of(frame, eye);
        let surface = Surface::unpack(pixel.surface);
        let position = view.position([x as f32 + 0.5, y as f32 + 0.5], pixel.depth);
        let v = (view.eye - position).normalize();
        let origin = view.ray_origin(position, surface.face_normal, pixel.depth);
        let reflector = Reflector::new(surface, v, frame.delta_roughness);
        let (seed, token) = (combine(frame.seed, frame.frame), frame.eyes[eye as usize].stream[0]);
        let directions = Sequence::new(seed, token, [x, y]);
        self.light_draws.clear();
        let lights = if self.shading.inputs.shadows { world.lights.len() as u32 } else { 0 };
        let draws = |i| Sequence::of_purpose(seed, DRAW_LIGHT + i, token, [x, y]);
        self.light_draws.extend((0..lights).map(draws));
        for index in first..first + count {
            let x = match reflector.ray(directions.sample(index)) {
                None => {
                    self.shading.tally.below_horizon += 1;
                    Vec3A::ZERO
                }
                Some(ray) => {
                    let weight = luminance(ray.weight);
                    pixel.nearness[1] += weight;
                    let (radiance, distance) = self.radiance(origin, ray.direction, index);
                    if let Some(distance) = distance {
                        pixel.nearness[0] += weight / distance.max(1e-6);
                    }
                    ray.weight * radiance
                }
            };
            // Compensated summation (Kahan 1965).
            let y = x - pixel.compensation;
            let t = pixel.sum + y;
            pixel.compensation = (t - pixel.sum) - y;
            pixel.sum = t;
            pixel.squares += x * x;
        }
    }

    /// The radiance that a ray sees, and the distance of its hit; `None`: the sky.
    fn radiance(&mut self, origin: Vec3A, direction: Vec3A, index: u32) -> (Vec3A, Option<f32>) {
        let world = self.shading.inputs.world;
        let uncut = |triangle, uv| world.uncut(triangle, uv);
        let Some(hit) = world.tree.nearest(origin, direction, &mut self.shading.stack, uncut) else {
            self.shading.tally.sky += 1;
            return (world.content.environment.radiance(direction), None);
        };
        self.shading.tally.hits += 1;
        let (surface, emission) = world.hit_surface(&hit, -direction);
        let at = (origin + direction * hit.t, -direction);
        let draws = Draws { lights: &self.light_draws, index };
        let radiance = self.shading.shade_hit((&surface, emission), &hit, at, &draws);
        let tally = &mut self.shading.tally;
        tally.nan += u64::from(radiance.is_nan());
        tally.clamped += u64::from(radiance.cmpge(MOST_HALF).any());
        // Limited to what fp16 holds, because the screen-space methods cannot see more.
        (radiance.min(MOST_HALF), Some(hit.t))
    }
}

/// Twin of `shaders/common/camera.glsl`: an eye's pixels in render space.
pub struct View {
    eye: Vec3A,
    first: Vec3A,
    across: Vec3A,
    down: Vec3A,
    near: f32,
    view_from_render: Mat3A,
}

impl View {
    pub fn of(frame: &FrameUniform, eye: u32) -> View {
        let EyeUniform { view_from_render: m, ray_first, ray_across, ray_down, position_near, .. } =
            &frame.eyes[eye as usize];
        let xyz = |v: &[f32; 4]| Vec3A::new(v[0], v[1], v[2]);
        View {
            eye: xyz(position_near),
            first: xyz(ray_first),
            across: xyz(ray_across),
            down: xyz(ray_down),
            near: position_near[3],
            view_from_render: Mat3A::from_cols(
                Vec3A::new(m[0], m[1], m[2]),
                Vec3A::new(m[4], m[5], m[6]),
                Vec3A::new(m[8], m[9], m[10]),
            ),
        }
    }

    pub fn eye(&self) -> Vec3A {
        self.eye
    }

    /// The position in render space of a point of the image (in pixels) with a raw depth.
    pub fn position(&self, [x, y]: [f32; 2], depth: f32) -> Vec3A {
        self.eye + (self.first + self.across * x + self.down * y) * (self.near / depth)
    }

    /// Where a reflection ray starts: lifted off the surface by as much as the surface's plane can rise, within half a pixel,
    /// above the depth at the pixel's centre.
    fn ray_origin(&self, position: Vec3A, face_normal: Vec3A, depth: f32) -> Vec3A {
        let n = self.view_from_render * face_normal;
        let pixel_size = self.across.length().max(self.down.length());
        let rise = pixel_size * (0.5 * (n.x.abs() + n.y.abs()) + 0.05);
        position + face_normal * ((self.near / depth) * rise)
    }
}
