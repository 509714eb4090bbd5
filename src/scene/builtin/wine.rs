//! The scene `wine`: a laid dining table, with dozens of glasses and bottles in front of each other and a rack of
//! bottles behind.
//!
//! Nothing is transparent here. Glass is drawn as a dark glossy solid, which hides what is behind it: this scene is for
//! dense occlusion.

use glam::Vec3;

use super::builder::{Builder, Finish, MaterialId, Pose};
use super::cellar;
use super::furniture;
use super::glasses::Glasses;
use super::noise::unit;
use super::pattern::{self, rgb};
use super::shape::Shape;
use super::solids::{block, rounded_box};
use super::tableware;
use super::texture::Image;

/// Height of the upper face of the table's top, metres.
const TOP: f32 = 0.76;

pub fn build(detail: f64) -> Builder {
    let mut b = Builder::new("wine", detail);
    let oak = cellar::shell(&mut b);
    let glasses = Glasses::new(&mut b);
    table(&mut b, oak);
    places(&mut b, &glasses);
    centre(&mut b, &glasses);
    cellar::rack(&mut b, oak, &glasses);
    cellar::sides(&mut b, oak, &glasses);
    b
}

fn table(b: &mut Builder, oak: MaterialId) {
    let board_map =
        b.texture("table", Image::color(512, move |u, v| pattern::grain(u, v, rgb(86, 46, 28), rgb(38, 20, 14))));
    let board_wear = b.texture("table-wear", Image::roughness(512, move |u, v| pattern::wear(u, v, 0.4, 12)));
    let polish = Finish::dielectric("table polish", [1.0; 3], 0.16).ior(1.9).map(board_map, 0.7);
    let board = b.material(polish.roughness_map(board_wear));
    let parts = furniture::table(b, board, oak, 2.7, 3.0, TOP);
    let mesh = b.mesh("table", parts);
    b.place("table", mesh, Pose::at(0.0, 0.0, 0.1));
    let seat = b.material(Finish::dielectric("oxblood seat", rgb(96, 26, 26), 0.59));
    let parts = furniture::chair(b, oak, seat);
    let chair = b.mesh("chair", parts);
    for (x, z, yaw) in [
        (-1.65f32, -0.7f32, 90.0f32),
        (-1.65, 0.4, 84.0),
        (1.65, -0.7, -90.0),
        (1.65, 0.4, -96.0),
        (-0.6, -1.75, 4.0),
        (0.6, -1.75, -6.0),
    ] {
        b.place("chair", chair, Pose::at(x, 0.0, z).yaw(yaw));
    }
}

fn places(b: &mut Builder, glasses: &Glasses) {
    let china = b.palette("china", &[([232, 228, 216], 0.45), ([200, 214, 220], 0.55), ([56, 70, 96], 0.5)]);
    let silver = b.material(Finish::metal("table silver", [0.80, 0.79, 0.76], 0.3));
    let napkin_map = b.texture(
        "napkin",
        Image::color(256, move |u, v| pattern::weave(u, v, 64, rgb(190, 176, 150), rgb(150, 60, 56))),
    );
    let napkin = b.material(Finish::dielectric("napkin", [1.0; 3], 0.92).map(napkin_map, 4.0));
    let forms = [
        b.mesh("red wine glass", vec![(glasses.tints[1], tableware::wine_glass(b, 0.24, 0.048))]),
        b.mesh("white wine glass", vec![(glasses.tints[4], tableware::wine_glass(b, 0.21, 0.038))]),
        b.mesh("flute", vec![(glasses.tints[2], tableware::wine_glass(b, 0.26, 0.026))]),
        b.mesh("water glass", vec![(glasses.tints[3], tableware::cup(b, 0.036, 0.12, 0.004))]),
        b.mesh("smoked glass", vec![(glasses.tints[0], tableware::wine_glass(b, 0.23, 0.044))]),
    ];
    let charger = b.mesh("charger", vec![(china[2], tableware::plate(b, 0.155))]);
    let plate = b.mesh("plate", vec![(china[0], tableware::plate(b, 0.125))]);
    let bowl = b.mesh("soup bowl", vec![(china[1], tableware::bowl(b, 0.085))]);
    let pieces: Vec<_> = (0..3).map(|k| b.mesh("cutlery", vec![(silver, tableware::cutlery(b, k))])).collect();
    let cloth = b.mesh("napkin", vec![(napkin, rounded_box(Vec3::new(0.1, 0.02, 0.19), 0.008, b.segments(4, 1)))]);
    // Two long sides, the far end and two settings towards the viewer.
    let seats = [
        (-1.1f32, -0.7f32, 90.0f32),
        (-1.1, 0.35, 90.0),
        (1.1, -0.7, -90.0),
        (1.1, 0.35, -90.0),
        (-0.55, -1.15, 0.0),
        (0.55, -1.15, 0.0),
        (-0.62, 1.28, 180.0),
        (0.66, 1.3, 180.0),
    ];
    for (i, (x, z, yaw)) in seats.into_iter().enumerate() {
        // "Ahead" is the direction in which the guest looks. −X of a setting is at the guest's right.
        let turn = super::shape::turn(Vec3::Y, yaw);
        let put = |right: f32, ahead: f32| {
            let p = Vec3::new(x, TOP, z) + turn * Vec3::new(-right, 0.0, ahead);
            Pose::at(p.x, p.y + 0.0005, p.z).yaw(yaw)
        };
        b.place("charger", charger, put(0.0, 0.0));
        let on = |pose: Pose, up: f32| Pose { position: pose.position + Vec3::Y * up, ..pose };
        b.place("plate", plate, on(put(0.0, 0.0), 0.012));
        if i % 2 == 0 {
            b.place("bowl", bowl, on(put(0.0, 0.0), 0.022));
        } else {
            b.place("napkin", cloth, on(put(0.0, 0.0), 0.036).yaw(20.0));
        }
        for (k, right) in [(1usize, -0.2f32), (2, 0.2), (0, 0.235)] {
            b.place("cutlery", pieces[k], put(right, 0.0).yaw(180.0));
        }
        for k in 0..5 {
            let u = |j| unit((i * 5 + k) as i32, j, 77) - 0.5;
            let (right, ahead) = (-0.18 + 0.115 * k as f32 + 0.03 * u(0), 0.24 + 0.07 * ((k % 2) as f32) + 0.03 * u(1));
            b.place("glass", forms[(k + i) % forms.len()], put(right, ahead));
        }
    }
}

fn centre(b: &mut Builder, glasses: &Glasses) {
    let bottles: Vec<_> = (0..4)
        .map(|k| {
            let parts = tableware::bottle(
                b,
                glasses.bottle[k],
                glasses.labels[k],
                glasses.foil[k % 3],
                0.31 + 0.012 * k as f32,
                (k % 2) as f32,
            );
            b.mesh("bottle", parts)
        })
        .collect();
    for (i, (x, z)) in [
        (-0.28f32, 0.05f32),
        (0.14, -0.42),
        (-0.1, -0.72),
        (0.42, 0.28),
        (0.05, 0.62),
        (-0.46, 0.58),
        (-0.38, -0.36),
        (0.36, -0.1),
    ]
    .into_iter()
    .enumerate()
    {
        b.place(&format!("bottle {}", i + 1), bottles[i % 4], Pose::at(x, TOP + 0.0005, z).yaw(50.0 * i as f32));
    }
    // Glasses that were set down between the guests. The two eyes see different ones through the gaps.
    let forms: Vec<_> = (0..5)
        .map(|k| {
            let form = tableware::wine_glass(b, 0.2 + 0.02 * k as f32, 0.036 + 0.003 * (k % 3) as f32);
            b.mesh("set-down glass", vec![(glasses.tints[k], form)])
        })
        .collect();
    for k in 0..30 {
        let u = |i| unit(k as i32, i, 123);
        let (column, row) = ((k % 6) as f32 - 2.5, (k / 6) as f32);
        let (x, z) = (0.24 * column + 0.1 * (u(0) - 0.5), 1.02 - 0.42 * row + 0.16 * (u(1) - 0.5));
        b.place("set-down glass", forms[k % 5], Pose::at(x, TOP + 0.0005, z));
    }
    let brass = b.material(Finish::metal("candle brass", [0.82, 0.64, 0.32], 0.4));
    let wax = b.material(Finish::dielectric("wax", rgb(232, 220, 190), 0.59));
    let flame = b.material(Finish::dielectric("flame", [0.9; 3], 0.9).emissive([2.6, 1.7, 0.8]));
    for (x, z, h) in [(-0.08f32, -0.1f32, 0.2f32), (0.22, 0.02, 0.14), (-0.16, 0.32, 0.1), (0.0, -1.0, 0.16)] {
        b.add("candlestick", brass, furniture::turned_foot(b, 0.12, 0.05).at(x, TOP + 0.0005, z));
        let parts = tableware::candle(b, wax, flame, 0.016, h);
        let candle = b.mesh("candle", parts);
        b.place("candle", candle, Pose::at(x, TOP + 0.1205, z));
    }
    let glaze = b.material(Finish::dielectric("fruit bowl", rgb(70, 84, 74), 0.5));
    b.add("fruit bowl", glaze, tableware::bowl(b, 0.17).at(0.28, TOP + 0.0005, 0.82));
    let skins = b.palette("fruit", &[([150, 30, 34], 0.55), ([186, 150, 40], 0.58), ([70, 96, 30], 0.57)]);
    for k in 0..9 {
        let a = k as f32 * 0.9;
        let ring = if k < 6 { 0.085 } else { 0.04 };
        let y = TOP + if k < 6 { 0.055 } else { 0.11 };
        let at = (0.28 + ring * super::shape::sin(a), 0.82 + ring * super::shape::cos(a));
        b.add("fruit", skins[k % 3], tableware::apple(b, 0.036).at(at.0, y, at.1));
    }
    let grape = b.material(Finish::dielectric("grapes", rgb(60, 24, 64), 0.54));
    let mut bunch = Shape::default();
    for k in 0..46 {
        let u = |i| unit(k, i, 3);
        let fall = u(2);
        let spread = 0.055 * (1.0 - 0.6 * fall);
        let ball = super::solids::sphere(0.013, b.segments(20, 6));
        bunch.push(ball.at(
            spread * (2.0 * u(0) - 1.0) - 0.5,
            TOP + 0.014 + 0.05 * u(1) * (1.0 - fall),
            0.92 + spread * (2.0 * u(3) - 1.0) + 0.05 * fall,
        ));
    }
    b.add("grapes", grape, bunch);
    let board = b.material(Finish::dielectric("olive board", rgb(140, 98, 58), 0.53));
    b.add("cheese board", board, block(0.34, 0.02, 0.22, 0.008, b.segments(4, 1)).at(-0.5, TOP + 0.0005, 0.94));
}
