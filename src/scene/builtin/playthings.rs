//! The train, the balloons and the toys of `pink`, which alone calls this.

use glam::Vec3;

use super::builder::{Builder, Finish, MaterialId, Pose};
use super::figures;
use super::furniture;
use super::noise::unit;
use super::pattern::rgb;
use super::shape::{Shape, sin};
use super::solids::{block, sphere, torus};
use super::sweep::{disc, lathe, smooth, smooth3, tube};
use super::tableware::{self, MeshParts};

/// The paints that toys share with the room.
pub(super) struct Paints {
    pub(super) white: MaterialId,
    pub(super) rose: MaterialId,
    pub(super) gold: MaterialId,
    pub(super) candy: Vec<MaterialId>,
}

/// Six wagons on a ring of rails around the middle of the floor. They are one mesh, so that they all circle together.
pub(super) fn train(b: &mut Builder, paints: &Paints) {
    let (radius, s) = (0.85, b.segments(4, 1));
    let rail = b.material(Finish::metal("tin rail", [0.72, 0.72, 0.74], 0.32));
    let tie = b.material(Finish::dielectric("sleeper", rgb(120, 72, 60), 0.6));
    let n = b.segments(160, 32);
    let mut rails = torus(radius - 0.045, 0.008, n, 8).at(0.0, 0.024, 0.12);
    rails.push(torus(radius + 0.045, 0.008, n, 8).at(0.0, 0.024, 0.12));
    b.add("rails", rail, rails);
    let mut ties = Shape::default();
    for k in 0..48 {
        let bar = block(0.03, 0.015, 0.15, 0.004, 1).at(0.0, 0.0, radius).turned(Vec3::Y, 7.5 * k as f32);
        ties.push(bar.at(0.0, 0.0, 0.12));
    }
    b.add("sleepers", tie, ties);
    let mut parts = MeshParts::new();
    for k in 0..6 {
        let place = |shape: Shape| shape.at(0.0, 0.033, radius).turned(Vec3::Y, -17.0 * k as f32 + 130.0);
        let paint = paints.candy[[8usize, 3, 2, 0, 7, 4][k]];
        let mut wheels = Shape::default();
        for (x, z) in [(-0.06f32, -0.05f32), (0.06, -0.05), (-0.06, 0.05), (0.06, 0.05)] {
            wheels.push(disc(0.03, 0.014, b.segments(40, 10)).turned(Vec3::X, 90.0).at(x, 0.03, z - 0.007));
        }
        parts.push((paints.gold, place(wheels)));
        let mut body = block(0.2, 0.03, 0.1, 0.01, s).at(0.0, 0.035, 0.0);
        if k == 0 {
            body.push(disc(0.045, 0.14, b.segments(56, 12)).turned(Vec3::Z, -90.0).at(-0.06, 0.115, 0.0));
            body.push(block(0.07, 0.13, 0.1, 0.012, s).at(-0.068, 0.066, 0.0));
            let chimney = lathe(
                &smooth(&[(0.0, 0.0), (0.015, 0.0), (0.015, 0.05), (0.028, 0.07), (0.0, 0.071)], 3),
                b.segments(36, 8),
            );
            parts.push((paints.gold, place(chimney.at(0.05, 0.158, 0.0))));
        } else {
            body.push(block(0.19, 0.07, 0.1, 0.016, s).at(0.0, 0.067, 0.0));
            for i in 0..5 {
                let ball = sphere(0.024, b.segments(28, 8));
                parts.push((
                    paints.candy[(k + i * 3) % 10],
                    place(ball.at(-0.07 + 0.035 * i as f32, 0.146, 0.012 - 0.024 * (i % 2) as f32)),
                ));
            }
        }
        parts.push((paint, place(body)));
    }
    let mesh = b.mesh("train", parts);
    b.place("train", mesh, Pose::at(0.0, 0.0, 0.12));
}

/// Two bunches of balloons; one of them bobs.
pub(super) fn balloons(b: &mut Builder) {
    let rubber = b.palette("balloon", &[([226, 60, 100], 0.2), ([250, 190, 200], 0.4), ([130, 200, 210], 0.36)]);
    let skin = smooth(
        &[(0.0, -0.02), (0.016, -0.015), (0.02, 0.0), (0.11, 0.12), (0.15, 0.25), (0.11, 0.37), (0.0, 0.41)],
        b.segments(8, 2),
    );
    for (k, (x, y, z)) in
        [(0.62f32, 1.02f32, 0.55f32), (0.86, 1.25, 0.35), (0.72, 1.48, 0.62), (-1.1, 1.2, -0.4), (-1.3, 1.45, -0.55)]
            .into_iter()
            .enumerate()
    {
        let mut shape = lathe(&skin, b.segments(80, 14));
        let string: Vec<Vec3> =
            (0..8).map(|i| Vec3::new(0.015 * sin(i as f32 * 1.4), -0.02 - 0.1 * i as f32, 0.0)).collect();
        shape.push(tube(&smooth3(&string, b.segments(4, 1)), 0.0022, 6));
        let mesh = b.mesh("balloon", vec![(rubber[k % 3], shape)]);
        let name = if k < 3 { "moving balloon" } else { "balloon" };
        b.place(name, mesh, Pose::at(x, y, z));
    }
}

/// Dolls inside the ring of rails, toys around them, and shelves of books and jars.
pub(super) fn toys(b: &mut Builder, paints: &Paints) {
    let eye = b.material(Finish::dielectric("doll eye", rgb(30, 30, 34), 0.06));
    let paint = |k: usize| figures::RobotPaint {
        body: paints.candy[k],
        trim: paints.candy[(k + 3) % 10],
        joint: paints.gold,
        eye,
    };
    for (k, (x, z, h, yaw)) in
        [(-0.32f32, 0.3f32, 0.42f32, 20.0f32), (0.3, -0.1, 0.5, -12.0), (0.02, 0.62, 0.3, 4.0)].into_iter().enumerate()
    {
        let parts = figures::robot(b, paint([0, 2, 4][k]), k + 1, 40.0 + 40.0 * k as f32);
        let mesh = b.mesh("doll", parts);
        b.place(&format!("doll {}", k + 1), mesh, Pose::at(x, 0.002, z).yaw(yaw).scale(h));
    }
    for k in 0..26 {
        let u = |i| unit(k, i, 91);
        let (x, z) = (-2.0 + 4.0 * u(0), -1.0 + 2.9 * u(1));
        let from_ring = ((x * x + (z - 0.12) * (z - 0.12)).sqrt() - 0.85).abs();
        if from_ring < 0.22 || z > 1.75 {
            continue;
        }
        let size = 0.07 + 0.08 * u(2);
        let material = paints.candy[(u(3) * 9.99) as usize];
        let shape = match k % 5 {
            0 => block(size, size, size, size * 0.14, b.segments(5, 1)),
            1 => sphere(size * 0.6, b.segments(56, 10)).at(0.0, size * 0.6, 0.0),
            2 => torus(size * 0.6, size * 0.24, b.segments(60, 12), b.segments(24, 6)).at(0.0, size * 0.24, 0.0),
            3 => figures::star(size * 0.9, size * 0.4).at(0.0, size * 0.74, -size * 0.2),
            _ => {
                let mut stack = disc(size * 0.7, size * 0.3, b.segments(56, 10));
                stack.push(disc(size * 0.52, size * 0.3, b.segments(56, 10)).at(0.0, size * 0.301, 0.0));
                stack.push(sphere(size * 0.34, b.segments(40, 8)).at(0.0, size * 0.93, 0.0));
                stack
            }
        };
        let mesh = b.mesh("toy", vec![(material, shape)]);
        b.place(&format!("toy {}", k + 1), mesh, Pose::at(x, 0.003, z).yaw(72.0 * u(4)));
    }
    let parts = furniture::shelf(b, paints.white, 0.9, 0.28, 1.7, 4);
    let shelf = b.mesh("toy shelf", parts);
    b.place("toy shelf", shelf, Pose::at(2.55, 0.0, -3.28));
    b.place("toy shelf", shelf, Pose::at(-2.6, 0.0, -3.28));
    let covers = &paints.candy[..];
    let page = b.material(Finish::dielectric("page", rgb(240, 230, 216), 0.9));
    for (k, x) in [2.55f32, -2.6].into_iter().enumerate() {
        for board in 0..4 {
            let y = 0.031 + 0.417 * board as f32;
            if (board + k) % 2 == 0 {
                let parts = tableware::book_row(b, covers, page, 0.78, 0.3, 300 + (board * 2 + k) as u32);
                let row = b.mesh("picture books", parts);
                b.place("picture books", row, Pose::at(x - 0.4, y, -3.17));
            } else {
                for i in 0..3 {
                    let form = tableware::vase(b, i + board, 0.24);
                    b.add("jar", paints.candy[(i * 3 + board) % 10], form.at(x - 0.27 + 0.27 * i as f32, y, -3.25));
                }
            }
        }
    }
}
