//! Shapes of robots, statues, columns and lanterns, for the scenes `pica`, `pink` and `temple`.

use glam::{Vec2, Vec3};

use super::builder::{Builder, MaterialId};
use super::shape::{Shape, cos, sin};
use super::solids::{block, rounded_box, sphere, torus};
use super::sweep::{disc, lathe, lathe_with, prism, smooth, smooth3, tapered, tube};
use super::tableware::MeshParts;

/// The materials of a robot.
#[derive(Debug, Clone, Copy)]
pub struct RobotPaint {
    pub body: MaterialId,
    pub trim: MaterialId,
    pub joint: MaterialId,
    pub eye: MaterialId,
}

/// A toy robot, 1 unit tall, that faces +Z. `build` chooses one of three builds; `wave` raises its right arm, degrees.
pub fn robot(b: &Builder, paint: RobotPaint, build: usize, wave: f32) -> MeshParts {
    let (s, n) = (b.segments(6, 2), b.segments(36, 8));
    let (mut body, mut trim, mut joint, mut eye) =
        (Shape::default(), Shape::default(), Shape::default(), Shape::default());
    let wide = [0.34, 0.40, 0.28][build % 3];
    for side in [-1.0f32, 1.0] {
        let x = side * wide * 0.3;
        body.push(block(0.14, 0.07, 0.2, 0.03, s).at(x, 0.0, 0.02));
        joint.push(tube(&[Vec3::new(x, 0.06, 0.0), Vec3::new(x, 0.26, 0.0)], 0.035, n / 2));
        for k in 0..4 {
            trim.push(torus(0.038, 0.01, n, b.segments(10, 5)).at(x, 0.1 + 0.04 * k as f32, 0.0));
        }
        let shoulder = Vec3::new(side * (wide / 2.0 + 0.03), 0.56, 0.0);
        let raise = if side > 0.0 { wave } else { 8.0 };
        let along = Vec3::new(side * sin(raise.to_radians()), -cos(raise.to_radians()), 0.12).normalize();
        joint.push(sphere(0.055, n).at(shoulder.x, shoulder.y, shoulder.z));
        let elbow = shoulder + along * 0.16;
        let hand = elbow + (along + Vec3::new(0.0, 0.25, 0.6)).normalize() * 0.15;
        body.push(tapered(&[shoulder, elbow], |t| 0.045 - 0.008 * t, n / 2));
        joint.push(sphere(0.042, n / 2 + 4).at(elbow.x, elbow.y, elbow.z));
        body.push(tapered(&[elbow, hand], |t| 0.036 + 0.008 * t, n / 2));
        for k in [-1.0f32, 1.0] {
            let grip = [hand, hand + Vec3::new(k * 0.035, 0.0, 0.04), hand + Vec3::new(k * 0.018, 0.0, 0.09)];
            trim.push(tube(&smooth3(&grip, 3), 0.012, b.segments(10, 5)));
        }
    }
    match build % 3 {
        0 => {
            body.push(rounded_box(Vec3::new(wide, 0.36, 0.24), 0.06, s).at(0.0, 0.44, 0.0));
            body.push(rounded_box(Vec3::new(0.3, 0.22, 0.24), 0.07, s).at(0.0, 0.79, 0.0));
        }
        1 => {
            body.push(sphere(0.21, n + 12).scaled(1.0, 0.92, 0.85).at(0.0, 0.44, 0.0));
            body.push(sphere(0.16, n + 12).scaled(1.1, 0.85, 1.0).at(0.0, 0.79, 0.0));
        }
        _ => {
            let profile = smooth(
                &[(0.0, 0.24), (0.12, 0.25), (0.15, 0.4), (0.13, 0.6), (0.07, 0.64), (0.0, 0.645)],
                b.segments(8, 2),
            );
            body.push(lathe(&profile, n + 12));
            let head = smooth(&[(0.0, 0.67), (0.13, 0.68), (0.15, 0.76), (0.13, 0.88), (0.0, 0.93)], b.segments(8, 2));
            body.push(lathe(&head, n + 12));
        }
    }
    joint.push(tube(&[Vec3::new(0.0, 0.6, 0.0), Vec3::new(0.0, 0.7, 0.0)], 0.05, n / 2));
    trim.push(rounded_box(Vec3::new(wide * 0.5, 0.1, 0.02), 0.008, s).at(
        0.0,
        0.46,
        0.128 + if build % 3 == 1 { 0.045 } else { 0.0 },
    ));
    trim.push(tube(&[Vec3::new(0.06, 0.88, 0.0), Vec3::new(0.08, 0.985, 0.0)], 0.006, 6));
    for side in [-1.0f32, 1.0] {
        let z = 0.115 + [0.0, 0.03, 0.015][build % 3];
        trim.push(torus(0.042, 0.012, n, b.segments(12, 5)).turned(Vec3::X, 90.0).at(side * 0.07, 0.8, z));
        eye.push(sphere(0.036, n / 2 + 4).at(side * 0.07, 0.8, z));
        joint.push(disc(0.04, 0.03, n).turned(Vec3::Z, -side * 90.0).at(side * 0.145, 0.79, 0.0));
    }
    eye.push(sphere(0.016, n / 3 + 4).at(0.08, 0.99, 0.0));
    vec![(paint.body, body), (paint.trim, trim), (paint.joint, joint), (paint.eye, eye)]
}

/// A keyboard that lies flat: rows of rounded keys on a plate.
pub fn keyboard(b: &Builder, base: MaterialId, keys: MaterialId, width: f32) -> MeshParts {
    let s = b.segments(2, 1);
    let pitch = width / 15.5;
    let mut caps = Shape::default();
    for row in 0..5 {
        for column in 0..15 {
            if row == 4 && (4..9).contains(&column) {
                continue;
            }
            let (x, z) = ((column as f32 - 7.0) * pitch, (row as f32 - 2.0) * pitch);
            caps.push(block(pitch * 0.86, pitch * 0.4, pitch * 0.86, pitch * 0.12, s).at(x, pitch * 0.42, z));
        }
    }
    caps.push(block(pitch * 4.86, pitch * 0.4, pitch * 0.86, pitch * 0.12, s).at(-pitch, pitch * 0.42, 2.0 * pitch));
    vec![(base, block(width, pitch * 0.5, pitch * 5.5, pitch * 0.15, s + 1)), (keys, caps)]
}

/// A fluted column of this height on a square foot, with a capital.
pub fn column(b: &Builder, height: f32, radius: f32) -> Shape {
    let (h, r, s) = (height, radius, b.segments(5, 1));
    let mut shape = block(r * 3.0, r * 0.5, r * 3.0, r * 0.06, s);
    shape.push(torus(r * 1.12, r * 0.2, b.segments(72, 12), b.segments(16, 6)).at(0.0, r * 0.68, 0.0));
    shape.push(torus(r * 1.02, r * 0.13, b.segments(72, 12), b.segments(14, 6)).at(0.0, r * 0.98, 0.0));
    let (low, high) = (r * 0.9, h - r * 1.1);
    let mut profile = vec![(0.0, low)];
    profile.extend((0..=b.segments(14, 4)).map(|k| {
        let t = k as f32 / b.segments(14, 4) as f32;
        (r * (1.0 - 0.12 * t * t), low + (high - low) * t)
    }));
    profile.push((0.0, high));
    // Twenty flutes: scallops cut into the drum.
    let flutes = |angle: f32, _: f32| 1.0 - 0.055 * sin(angle * 10.0).abs();
    shape.push(lathe_with(&profile, b.segments(160, 40), flutes).smoothed_sides());
    let bell =
        smooth(&[(r * 0.85, 0.0), (r * 0.92, r * 0.2), (r * 1.15, r * 0.5), (r * 1.45, r * 0.62)], b.segments(8, 2));
    let mut capital = vec![(0.0, 0.0)];
    capital.extend(bell);
    capital.push((0.0, r * 0.63));
    shape.push(lathe(&capital, b.segments(72, 12)).at(0.0, high - r * 0.05, 0.0));
    shape.push(block(r * 3.0, r * 0.45, r * 3.0, r * 0.06, s).at(0.0, h - r * 0.46, 0.0));
    shape
}

/// A lantern that hangs below (0, 0, 0): a chain of the length `chain`, a roof, bars and a glowing core. About 0.5 m
/// long with its chain.
pub fn lantern(b: &Builder, metal: MaterialId, glow: MaterialId, chain: f32) -> MeshParts {
    let n = b.segments(40, 8);
    let mut shape = Shape::default();
    let links = (chain / 0.05) as usize;
    for k in 0..links {
        let link = torus(0.017, 0.005, b.segments(20, 8), b.segments(8, 5)).scaled(0.8, 1.0, 1.5).turned(Vec3::X, 90.0);
        shape.push(link.turned(Vec3::Y, 90.0 * (k % 2) as f32).at(0.0, -0.025 - 0.05 * k as f32, 0.0));
    }
    let y = -chain;
    let roof = [(0.0, y - 0.1), (0.17, y - 0.1), (0.175, y - 0.09), (0.08, y - 0.03), (0.03, y), (0.0, y)];
    shape.push(lathe_with(&roof, n, |a, _| 1.0 + 0.06 * cos(a * 6.0)));
    shape.push(disc(0.13, 0.03, n).at(0.0, y - 0.4, 0.0));
    for k in 0..6 {
        let (x, z) =
            (sin(k as f32 * std::f32::consts::FRAC_PI_3) * 0.115, cos(k as f32 * std::f32::consts::FRAC_PI_3) * 0.115);
        shape.push(tube(&[Vec3::new(x, y - 0.38, z), Vec3::new(x, y - 0.09, z)], 0.007, b.segments(10, 5)));
    }
    for k in 0..2 {
        shape.push(torus(0.116, 0.006, n, b.segments(8, 5)).at(0.0, y - 0.18 - 0.12 * k as f32, 0.0));
    }
    vec![(metal, shape), (glow, sphere(0.085, n).scaled(1.0, 1.35, 1.0).at(0.0, y - 0.24, 0.0))]
}

/// A seated figure, about 1 unit high, that faces +Z: a robe, folded hands and a head with a crown, on a lotus.
pub fn seated_figure(b: &Builder) -> Shape {
    let n = b.segments(72, 12);
    let mut shape = lotus(b, 0.46, 0.16);
    let robe = smooth(
        &[
            (0.0, 0.15),
            (0.42, 0.16),
            (0.43, 0.22),
            (0.3, 0.3),
            (0.2, 0.42),
            (0.21, 0.56),
            (0.17, 0.66),
            (0.07, 0.7),
            (0.0, 0.705),
        ],
        b.segments(8, 2),
    );
    let folds = |a: f32, y: f32| 1.0 + 0.03 * sin(a * 13.0 + y * 9.0) * (0.75 - y).max(0.0);
    shape.push(lathe_with(&robe, n + 24, folds).smoothed_sides().scaled(1.0, 1.0, 0.78));
    for side in [-1.0f32, 1.0] {
        let arm = [
            Vec3::new(side * 0.17, 0.62, 0.0),
            Vec3::new(side * 0.26, 0.48, 0.05),
            Vec3::new(side * 0.2, 0.36, 0.2),
            Vec3::new(side * 0.03, 0.33, 0.3),
        ];
        shape.push(tapered(&smooth3(&arm, b.segments(6, 2)), |t| 0.062 - 0.022 * t, b.segments(24, 8)));
        shape.push(sphere(0.1, n / 2).scaled(1.7, 0.75, 1.2).at(side * 0.24, 0.225, 0.16));
        shape.push(sphere(0.022, n / 3).scaled(0.7, 1.8, 1.0).at(side * 0.098, 0.79, 0.0));
    }
    shape.push(tube(&[Vec3::new(0.0, 0.68, 0.0), Vec3::new(0.0, 0.74, 0.0)], 0.045, b.segments(24, 8)));
    shape.push(sphere(0.1, n).scaled(0.95, 1.15, 0.98).at(0.0, 0.81, 0.01));
    shape.push(sphere(0.022, n / 3).scaled(0.7, 1.3, 1.0).at(0.0, 0.8, 0.11));
    for k in 0..3 {
        shape.push(torus(0.085 - 0.02 * k as f32, 0.018, n / 2, b.segments(12, 5)).at(
            0.0,
            0.885 + 0.028 * k as f32,
            0.0,
        ));
    }
    shape.push(sphere(0.03, n / 3).scaled(1.0, 1.6, 1.0).at(0.0, 0.97, 0.0));
    shape
}

/// A ring of petals around a drum. `radius` is the ring's radius and `height` its height.
pub fn lotus(b: &Builder, radius: f32, height: f32) -> Shape {
    let mut shape = disc(radius * 0.85, height, b.segments(64, 12));
    for row in 0..2 {
        for k in 0..14 {
            let petal = sphere(1.0, b.segments(24, 8)).scaled(radius * 0.17, height * 0.55, radius * 0.07);
            let tilted = petal.turned(Vec3::X, if row == 0 { 28.0 } else { 10.0 });
            let out = tilted.at(0.0, height * (0.35 + 0.2 * row as f32), radius * (0.95 - 0.09 * row as f32));
            shape.push(out.turned(Vec3::Y, (k as f32 + 0.5 * row as f32) * 360.0 / 14.0));
        }
    }
    shape
}

/// A five-pointed star standing in the xy-plane.
pub fn star(radius: f32, depth: f32) -> Shape {
    let outline: Vec<Vec2> = (0..10)
        .map(|k| {
            let r = if k % 2 == 0 { radius } else { radius * 0.42 };
            let a = k as f32 * std::f32::consts::PI / 5.0 + std::f32::consts::FRAC_PI_2;
            Vec2::new(cos(a), sin(a)) * r
        })
        .collect();
    prism(&outline, depth).turned(Vec3::X, 90.0)
}
