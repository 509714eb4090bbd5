//! Tests baked indirect light. The oracles are the formula for a room whose walls all glow alike, and a small path
//! tracer in this file that shares no code with the renderer. Needs a Vulkan device.
#![cfg(feature = "gpu")]

use std::sync::Arc;

use cyclopean::render::Settings;
use cyclopean::scene::{Eye, Light, LightSource, Material, Primitive, Scene};
use glam::{DAffine3, DQuat, DVec3, Vec3};

use crate::pictures::{self, glowing, gpu, look, material, plane, render, scene, settings};

fn chalk(albedo: [f32; 3]) -> Material {
    Material { metallic: 0.0, dielectric_f0: Vec3::ZERO, base_color: Vec3::from(albedo).extend(1.0), ..material(1.0) }
}

/// A square of side `2·half` about the place `at`. Without a turn it faces +Y.
fn square(half: f64, turn: DQuat, at: DVec3, of: Material) -> (Primitive, Material, DAffine3) {
    (plane(1), of, DAffine3::from_scale_rotation_translation(DVec3::new(2.0 * half, 1.0, 2.0 * half), turn, at))
}

/// The rotation of +Y to the direction of an axis.
fn towards(d: DVec3) -> DQuat {
    if d == DVec3::NEG_Y { DQuat::from_rotation_x(std::f64::consts::PI) } else { DQuat::from_rotation_arc(DVec3::Y, d) }
}

/// The inside of a cube of side 2. `of` gives the material of the wall that faces a direction.
fn cube(of: impl Fn(DVec3) -> Material) -> Vec<(Primitive, Material, DAffine3)> {
    let faces = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    faces.map(|n| square(1.0, towards(n), -n, of(n))).into()
}

fn inside(parts: Vec<(Primitive, Material, DAffine3)>) -> Scene {
    scene(parts, 0.0, look(DVec3::new(0.1, 0.05, 0.9), DVec3::new(-0.1, -0.2, -1.0)))
}

fn with_indirect(width: u32, height: u32) -> Settings {
    Settings { indirect: true, ..settings(width, height) }
}

#[test]
fn a_room_whose_walls_glow_alike_has_the_furnaces_light() {
    let gpu = gpu();
    for albedo in [0.3f32, 0.7] {
        let glow = Material { emissive: Vec3::splat(0.25), ..chalk([albedo; 3]) };
        let room = Arc::new(inside(cube(|_| glow.clone())));
        let rendered = render(&gpu, &room, "sssr", &with_indirect(48, 32));
        // The expected light is E + ρE + ρ²E + … = E/(1 − ρ). The renderer keeps the albedo's square root in eight
        // bits.
        let kept = ((albedo.sqrt() * 255.0).round() / 255.0).powi(2);
        let expected = f64::from(0.25 / (1.0 - kept));
        let pixels = rendered.linear.eyes.iter().flatten().flatten();
        let (mut sum, mut worst, mut n) = (0.0, 0.0f64, 0u32);
        for v in pixels {
            sum += f64::from(*v);
            worst = worst.max((f64::from(*v) / expected - 1.0).abs());
            n += 1;
        }
        let mean = sum / f64::from(n) / expected - 1.0;
        println!("albedo {albedo}: mean off by {:.3} %, worst pixel by {:.3} %", 100.0 * mean, 100.0 * worst);
        assert!(mean.abs() < 0.01 && worst < 0.02, "albedo {albedo}: {mean}, {worst}");
    }
}

/// Half the side of the square lamp below the ceiling.
const LAMP: f64 = 0.35;
/// The box on the floor: its bounds in x, in y and in z.
const BOX: [f64; 6] = [-0.55, -0.05, -1.0, -0.3, -0.5, 0.1];

fn wall_color(n: DVec3) -> [f32; 3] {
    match (n.x, n.y, n.z) {
        (1.0, ..) => [0.63, 0.06, 0.05],
        (-1.0, ..) => [0.14, 0.45, 0.09],
        _ => [0.7; 3],
    }
}

fn cornell() -> Scene {
    let mut parts = cube(|n| chalk(wall_color(n)));
    parts.push(square(LAMP, towards(DVec3::NEG_Y), DVec3::new(0.0, 0.995, 0.0), glowing(Vec3::new(8.0, 6.0, 4.0))));
    let [x0, x1, y0, y1, z0, z1] = BOX;
    let (middle, half) = (DVec3::new(x0 + x1, y0 + y1, z0 + z1) / 2.0, DVec3::new(x1 - x0, y1 - y0, z1 - z0) / 2.0);
    for n in [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::Z, DVec3::NEG_Z] {
        let turn = towards(n);
        // The lengths of the box's edges along which the sides of the turned unit square lie.
        let along = |v: DVec3| (turn * v).abs().dot(2.0 * half);
        let scale = DVec3::new(along(DVec3::X), 1.0, along(DVec3::Z));
        let at = middle + n * half;
        parts.push((plane(1), chalk([0.7; 3]), DAffine3::from_scale_rotation_translation(scale, turn, at)));
    }
    inside(parts)
}

/// The generator xorshift64*, which the renderer does not use.
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1u64 << 53) as f64
    }
}

/// Where a ray within the room ends: the place, the normal, the albedo, and whether it is the lamp.
fn hit(o: DVec3, d: DVec3) -> (DVec3, DVec3, [f64; 3], bool) {
    let mut t = f64::INFINITY;
    let (mut n, mut lamp) = (DVec3::Y, false);
    for c in 0..3 {
        let reach = (d[c].signum() - o[c]) / d[c];
        if reach < t {
            t = reach;
            n = DVec3::ZERO;
            n[c] = -d[c].signum();
        }
    }
    let ceiling = (0.995 - o.y) / d.y;
    let p = o + d * ceiling;
    if d.y > 0.0 && ceiling > 1e-9 && ceiling < t && p.x.abs() < LAMP && p.z.abs() < LAMP {
        (t, n, lamp) = (ceiling, DVec3::NEG_Y, true);
    }
    let (mut enter, mut leave, mut side) = (f64::NEG_INFINITY, f64::INFINITY, DVec3::ZERO);
    for c in 0..3 {
        let (a, b) = ((BOX[2 * c] - o[c]) / d[c], (BOX[2 * c + 1] - o[c]) / d[c]);
        if a.min(b) > enter {
            enter = a.min(b);
            side = DVec3::ZERO;
            side[c] = -d[c].signum();
        }
        leave = leave.min(a.max(b));
    }
    if enter < leave && enter > 1e-9 && enter < t {
        return (o + d * enter, side, [0.7; 3], false);
    }
    let color = if lamp { [0.0; 3] } else { wall_color(n).map(f64::from) };
    (o + d * t, n, color, lamp)
}

/// An estimate of the radiance that arrives at `o` against the direction `d`, by one path of cosine-weighted bounces.
fn radiance(mut o: DVec3, mut d: DVec3, random: &mut Random) -> [f64; 3] {
    let mut share = [1.0; 3];
    for _ in 0..40 {
        let (p, n, color, lamp) = hit(o, d);
        if lamp {
            return [share[0] * 8.0, share[1] * 6.0, share[2] * 4.0];
        }
        (0..3).for_each(|c| share[c] *= color[c]);
        // Russian roulette.
        let most = share[0].max(share[1]).max(share[2]).min(0.95);
        if random.next() >= most {
            return [0.0; 3];
        }
        share = share.map(|s| s / most);
        let (phi, r) = (std::f64::consts::TAU * random.next(), random.next());
        let (a, b) = if n.x.abs() > 0.5 { (DVec3::Y, DVec3::Z) } else { (n.cross(DVec3::X).normalize(), DVec3::X) };
        d = (a * phi.cos() * r.sqrt() + b * phi.sin() * r.sqrt() + n * (1.0 - r).sqrt()).normalize();
        o = p + n * 1e-9;
    }
    [0.0; 3]
}

#[test]
fn a_cornell_box_has_the_light_of_an_independent_path_tracer() {
    let gpu = gpu();
    let (width, height) = (32u32, 24u32);
    let room = Arc::new(cornell());
    let rendered = render(&gpu, &room, "sssr", &with_indirect(width, height));
    let camera = room.views[0].stereo_camera(f64::from(width) / f64::from(height));
    let paths = 3000;
    let mut random = Random(88_172_645_463_325_252);
    let e = camera.eye(Eye::Left);
    let [left, right, down, up] = [e.fov.left_rad, e.fov.right_rad, e.fov.down_rad, e.fov.up_rad].map(f64::tan);
    // The rendered and the expected light are compared over blocks of 4×4 pixels, for each channel.
    let blocks = (width / 4) as usize;
    let (mut found, mut expected) = (vec![[0.0f64; 3]; blocks * 6], vec![[0.0f64; 3]; blocks * 6]);
    for y in 0..height {
        for x in 0..width {
            let (u, v) = ((f64::from(x) + 0.5) / f64::from(width), (f64::from(y) + 0.5) / f64::from(height));
            let view = DVec3::new(left + (right - left) * u, up + (down - up) * v, -1.0);
            let d = (e.world_from_view * view).normalize();
            if hit(e.position, d).3 {
                continue;
            }
            let block = (y / 4) as usize * blocks + (x / 4) as usize;
            for _ in 0..paths {
                let path = radiance(e.position, d, &mut random);
                (0..3).for_each(|c| expected[block][c] += path[c] / f64::from(paths));
            }
            let here = rendered.linear.eyes[0][(y * width + x) as usize];
            (0..3).for_each(|c| found[block][c] += f64::from(here[c]));
        }
    }
    let total = |of: &[[f64; 3]], c: usize| of.iter().map(|b| b[c]).sum::<f64>();
    let off = [0, 1, 2].map(|c| total(&found, c) / total(&expected, c) - 1.0);
    let apart = found.iter().flatten().zip(expected.iter().flatten()).map(|(a, b)| (a - b).abs()).sum::<f64>();
    let apart = apart / expected.iter().flatten().sum::<f64>();
    println!("the mean light is off by {off:.4?}; blocks of 4×4 pixels differ by {apart:.4} of the mean");
    assert!(off.iter().all(|o| o.abs() < 0.02), "the mean light is off by {off:?}");
    // The noise of the test's own path tracer is about 0.01.
    assert!(apart < 0.03, "blocks differ by {apart} of the mean");
}

#[test]
fn no_light_leaks_into_a_closed_room() {
    let gpu = gpu();
    let mut room = inside(cube(|_| chalk([0.7; 3])));
    room.environment = pictures::constant_environment(10.0);
    let sun =
        LightSource::Directional { direction: Vec3::new(0.3, -1.0, 0.2).normalize(), irradiance: Vec3::splat(50.0) };
    room.lights = vec![Light { size: 0.01, ..sun.into() }];
    let rendered = render(&gpu, &Arc::new(room), "path-traced@4", &with_indirect(48, 32));
    let most = rendered.linear.eyes.iter().flatten().flatten().fold(0.0f32, |a, &b| a.max(b));
    assert!(most <= 1e-4, "light of {most} came in from outside");
}

#[test]
fn a_mirror_shows_the_corner_as_lit_as_it_is() {
    let gpu = gpu();
    let glow = Material { emissive: Vec3::splat(0.25), ..chalk([0.5; 3]) };
    let mut parts = cube(|_| glow.clone());
    let turn = DQuat::from_rotation_x(1.2);
    parts.push((
        plane(1),
        material(0.0),
        DAffine3::from_scale_rotation_translation(DVec3::splat(0.8), turn, DVec3::new(0.0, -0.3, -0.4)),
    ));
    let room = Arc::new(inside(parts));
    let rendered = render(&gpu, &room, "path-traced@1", &with_indirect(48, 32));
    let mirrored: Vec<f32> = rendered.reflection.eyes.iter().flatten().map(|t| t[0]).filter(|v| *v > 0.0).collect();
    assert!(mirrored.len() > 100, "{}", mirrored.len());
    let mean = mirrored.iter().sum::<f32>() / mirrored.len() as f32;
    // The walls' light would be 0.5. It is a little less because the mirror absorbs a part of it.
    assert!((mean - 0.5).abs() < 0.02, "{mean}");
}

#[test]
fn without_indirect_light_nothing_is_gathered() {
    let gpu = gpu();
    let room = Arc::new(cornell());
    let rendered = render(&gpu, &room, "sssr", &settings(48, 32));
    assert!(rendered.left_out.iter().any(|p| p.name == "indirect"));
    assert!(!rendered.passes.iter().any(|p| p.name == "indirect"));
}
