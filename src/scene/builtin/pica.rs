//! The scene `pica`: a workshop of toy robots on a glossy floor, with many occluders near the view's centre, at many
//! depths.

use glam::Vec3;

use super::builder::{Builder, Finish, MaterialId, Pose};
use super::figures::{self, RobotPaint};
use super::furniture::{self, slab};
use super::noise::unit;
use super::pattern::{self, rgb};
use super::shape::{Shape, sin};
use super::solids::{block, rounded_box, sphere, torus};
use super::sweep::{self, disc, lathe, smooth3, tube};
use super::tableware;
use super::texture::Image;

pub fn build(detail: f64) -> Builder {
    let mut b = Builder::new("pica", detail);
    hall(&mut b);
    let colors = b.palette(
        "enamel",
        &[
            ([226, 92, 40], 0.40),
            ([240, 178, 48], 0.46),
            ([58, 132, 190], 0.42),
            ([232, 232, 226], 0.50),
            ([206, 62, 70], 0.38),
            ([86, 160, 112], 0.55),
            ([120, 92, 160], 0.58),
            ([44, 60, 84], 0.36),
        ],
    );
    robots(&mut b, &colors);
    shelves(&mut b, &colors);
    bench(&mut b, &colors);
    clutter(&mut b, &colors);
    b
}

fn hall(b: &mut Builder) {
    let paint = move |u, v| pattern::tiles(u, v, (4, 4), rgb(44, 100, 116), rgb(26, 66, 78), 0.0);
    let floor_map = b.texture("floor", Image::color(512, paint));
    let worn = b.texture("floor-wear", Image::roughness(512, move |u, v| pattern::wear(u, v, 0.55, 4)));
    let floor =
        b.material(Finish::dielectric("floor paint", [0.7; 3], 0.12).ior(2.2).map(floor_map, 0.4).roughness_map(worn));
    let panel_map = b.texture(
        "panels",
        Image::color(256, move |u, v| pattern::tiles(u, v, (2, 3), rgb(206, 216, 220), rgb(150, 164, 172), 0.5)),
    );
    let wall = b.material(Finish::dielectric("wall panels", [1.0; 3], 0.6).map(panel_map, 0.5));
    let line = b.material(Finish::dielectric("floor marking", rgb(236, 190, 44), 0.36));
    b.add("floor", floor, slab(Vec3::new(9.0, 0.2, 9.0), Vec3::new(0.0, -0.1, 0.0)));
    b.add("back wall", wall, slab(Vec3::new(9.4, 3.4, 0.2), Vec3::new(0.0, 1.7, -3.9)));
    b.add("left wall", wall, slab(Vec3::new(0.2, 3.4, 9.0), Vec3::new(-3.9, 1.7, 0.72)));
    b.add("right wall", wall, slab(Vec3::new(0.2, 3.4, 9.0), Vec3::new(3.9, 1.7, 0.72)));
    for x in [-2.6f32, 2.6] {
        b.add("marking", line, block(0.08, 0.004, 5.6, 0.001, 1).at(x, 0.0, -0.4));
    }
    b.add("marking across", line, block(5.1, 0.004, 0.08, 0.001, 1).at(0.0, 0.0, -3.1));

    let steel = b.material(Finish::metal("brushed steel", [0.62, 0.63, 0.65], 0.38));
    let dark = b.material(Finish::dielectric("rubber", rgb(38, 40, 44), 0.58));
    let n = b.segments(20, 8);
    for (k, y) in [2.9f32, 2.72, 2.5].into_iter().enumerate() {
        let r = 0.06 - 0.012 * k as f32;
        b.add("pipe", steel, tube(&[Vec3::new(-3.6, y, -3.7), Vec3::new(3.6, y, -3.7)], r, n));
        for i in 0..9 {
            let x = -3.2 + 0.8 * i as f32;
            b.add("pipe clamp", dark, torus(r + 0.012, 0.014, n + 8, 8).turned(Vec3::Z, 90.0).at(x, y, -3.7));
        }
    }
    let glow = b.material(Finish::dielectric("lamp glow", [0.9; 3], 0.9).emissive([5.0, 4.6, 4.0]));
    let enamel = b.material(Finish::dielectric("lamp enamel", rgb(34, 92, 88), 0.35));
    let parts = furniture::pendant(b, enamel, glow, 0.75, 0.24);
    let lamp = b.mesh("pendant", parts);
    for (x, z) in [(-1.7f32, -1.6f32), (0.0, -2.2), (1.7, -1.6)] {
        b.place("pendant", lamp, Pose::at(x, 3.4, z));
    }
}

fn robots(b: &mut Builder, colors: &[MaterialId]) {
    let joint = b.material(Finish::metal("joint steel", [0.55, 0.56, 0.58], 0.30));
    let chrome = b.material(Finish::metal("chrome", [0.78, 0.79, 0.80], 0.069));
    let eyes = [
        b.material(Finish::dielectric("cyan eye", rgb(40, 120, 130), 0.10).emissive([0.2, 1.8, 2.2])),
        b.material(Finish::dielectric("amber eye", rgb(140, 90, 20), 0.10).emissive([2.4, 1.3, 0.2])),
    ];
    // x, z, height, yaw, angle of the raised arm. They stand in front, in the middle and behind; two reach beyond the
    // sides of the view.
    let stand = [
        (-0.34f32, 1.35f32, 0.62f32, 24.0f32, 120.0f32),
        (0.38, 1.15, 0.5, -30.0, 10.0),
        (0.02, 0.25, 0.86, 4.0, 35.0),
        (-1.02, 0.35, 0.74, 40.0, 8.0),
        (1.08, 0.05, 0.95, -24.0, 145.0),
        (-0.5, -0.85, 1.0, 14.0, 60.0),
        (0.62, -1.1, 0.8, -10.0, 20.0),
        (-1.75, -0.9, 0.9, 50.0, 100.0),
        (1.95, -0.95, 1.05, -50.0, 30.0),
        (-1.62, 1.2, 0.9, 62.0, 30.0),
        (1.66, 1.3, 0.82, -66.0, 70.0),
        (0.1, -2.2, 1.1, 0.0, 130.0),
    ];
    for (i, (x, z, height, yaw, wave)) in stand.into_iter().enumerate() {
        let body = colors[i % colors.len()];
        let trim = if i % 3 == 0 { chrome } else { colors[(i + 3) % colors.len()] };
        let paint = RobotPaint { body, trim, joint: if i % 2 == 0 { joint } else { chrome }, eye: eyes[i % 2] };
        let parts = figures::robot(b, paint, i, wave);
        let mesh = b.mesh(&format!("robot {}", i + 1), parts);
        b.place(&format!("robot {}", i + 1), mesh, Pose::at(x, 0.002, z).yaw(yaw).scale(height));
    }
}

fn shelves(b: &mut Builder, colors: &[MaterialId]) {
    let oak_map =
        b.texture("oak", Image::color(256, move |u, v| pattern::grain(u, v, rgb(206, 168, 118), rgb(150, 106, 62))));
    let oak = b.material(Finish::dielectric("oak", [1.0; 3], 0.48).map(oak_map, 0.9));
    let parts = furniture::shelf(b, oak, 1.5, 0.36, 1.9, 5);
    let shelf = b.mesh("shelf", parts);
    let card = b.palette("carton", &[([196, 150, 100], 0.6), ([176, 128, 84], 0.58)]);
    let tape = b.material(Finish::dielectric("tape", rgb(222, 196, 140), 0.42));
    let ceramics = b.palette("ceramic", &[([236, 230, 218], 0.32), ([62, 96, 140], 0.4), ([170, 60, 50], 0.45)]);
    for (s, x) in [(0usize, -2.2f32), (1, 0.15), (2, 2.4)] {
        b.place("shelf", shelf, Pose::at(x, 0.0, -3.55));
        for board in 0..5 {
            let y = 0.031 + board as f32 * 0.3736;
            for k in 0..4 {
                let u = |i| unit((s * 20 + board * 4 + k) as i32, i, 5);
                let at = Vec3::new(x - 0.54 + 0.36 * k as f32 + 0.04 * u(0), y, -3.52);
                let name = format!("stock {}", s * 20 + board * 4 + k + 1);
                match (u(1) * 4.0) as usize {
                    0 | 1 => {
                        let (w, h) = (0.2 + 0.09 * u(2), 0.14 + 0.14 * u(3));
                        let mut parts = vec![(card[k % 2], block(w, h, 0.24, 0.006, b.segments(3, 1)))];
                        parts.push((
                            tape,
                            rounded_box(Vec3::new(w * 0.2, h + 0.004, 0.245), 0.003, 1).at(0.0, h / 2.0, 0.0),
                        ));
                        let mesh = b.mesh(&name, parts);
                        b.place(&name, mesh, Pose::at(at.x, at.y, at.z).yaw(20.0 * (u(4) - 0.5)));
                    }
                    2 => b.add(
                        &name,
                        ceramics[k % 3],
                        tableware::vase(b, board + k, 0.22 + 0.06 * u(2)).at(at.x, at.y, at.z),
                    ),
                    _ => b.add(
                        &name,
                        colors[(board + k) % colors.len()],
                        sphere(0.1, b.segments(40, 10)).at(at.x, at.y + 0.1, at.z),
                    ),
                }
            }
        }
    }
}

fn bench(b: &mut Builder, colors: &[MaterialId]) {
    let top = b.material(Finish::dielectric("bench laminate", rgb(214, 208, 196), 0.3));
    let legs = b.material(Finish::metal("bench steel", [0.5, 0.52, 0.54], 0.45));
    let parts = furniture::table(b, top, legs, 1.5, 0.7, 0.62);
    let table = b.mesh("bench", parts);
    let tint = b.material(Finish::dielectric("screen", rgb(16, 20, 26), 0.08).emissive([0.10, 0.26, 0.34]));
    let plastic = b.material(Finish::dielectric("grey plastic", rgb(92, 96, 104), 0.55));
    let keys = b.material(Finish::dielectric("key plastic", rgb(226, 222, 210), 0.58));
    let wood = b.material(Finish::dielectric("pencil wood", rgb(214, 176, 124), 0.6));
    for (side, x) in [(0usize, -1.9f32), (1, 1.95)] {
        let turn = if side == 0 { 32.0f32 } else { -34.0 };
        let group = |dx: f32, dy: f32, dz: f32| {
            let (s, c) = (sin(turn.to_radians()), sin((90.0 - turn).to_radians()));
            Pose::at(x + dx * c + dz * s, 0.62 + dy, -2.1 - dx * s + dz * c).yaw(turn)
        };
        b.place("bench", table, Pose::at(x, 0.0, -2.1).yaw(turn));
        let parts = figures::keyboard(b, plastic, keys, 0.46);
        let board = b.mesh("keyboard", parts);
        b.place("keyboard", board, group(-0.2, 0.0, 0.16));
        let mut screen = rounded_box(Vec3::new(0.56, 0.36, 0.04), 0.015, b.segments(4, 1)).at(0.0, 0.33, 0.0);
        screen.push(block(0.05, 0.2, 0.03, 0.006, 2).at(0.0, 0.0, -0.03));
        screen.push(disc(0.12, 0.015, b.segments(40, 10)));
        let face = rounded_box(Vec3::new(0.52, 0.32, 0.01), 0.003, 1).at(0.0, 0.33, 0.018);
        let monitor = b.mesh("monitor", vec![(plastic, screen), (tint, face)]);
        b.place("monitor", monitor, group(-0.2, 0.0, -0.15));
        for k in 0..3 {
            let mug = b.mesh("mug", vec![(colors[(k * 2 + side) % colors.len()], tableware::mug(b, 0.045))]);
            b.place("mug", mug, group(0.22 + 0.14 * k as f32, 0.0, 0.12 - 0.1 * k as f32).yaw(70.0 * k as f32));
        }
        for k in 0..6 {
            let parts = tableware::pencil(b, colors[k % colors.len()], wood, 0.19);
            let pencil = b.mesh("pencil", parts);
            let lean = 8.0 * (unit(k as i32, 1, 9) - 0.5) + 6.0;
            b.place("pencil", pencil, group(0.5, 0.02, 0.0).yaw(60.0 * k as f32).pitch(lean));
        }
        b.add("pencil cup", legs, {
            let at = group(0.5, 0.0, 0.0).position;
            tableware::cup(b, 0.045, 0.1, 0.006).at(at.x, at.y, at.z)
        });
    }
}

fn clutter(b: &mut Builder, colors: &[MaterialId]) {
    let s = b.segments(5, 1);
    // Near the eyes: blocks, balls, a cone and giant pencils, each of which covers what stands behind it in one eye
    // only.
    for k in 0..22 {
        let u = |i| unit(k, i, 31);
        let (x, z) = (-2.3 + 4.6 * u(0), -0.7 + 2.5 * u(1));
        let side = 0.09 + 0.12 * u(2);
        let color = colors[(u(3) * 7.99) as usize];
        let shape = match k % 4 {
            0 => block(side, side, side, side * 0.12, s),
            1 => sphere(side * 0.6, b.segments(56, 10)).at(0.0, side * 0.6, 0.0),
            2 => torus(side * 0.6, side * 0.2, b.segments(56, 12), b.segments(24, 6)).at(0.0, side * 0.2, 0.0),
            _ => lathe(
                &[
                    (0.0, 0.0),
                    (side * 0.7, 0.0),
                    (side * 0.7, side * 0.1),
                    (side * 0.45, side * 0.12),
                    (side * 0.05, side * 1.7),
                    (0.0, side * 1.7),
                ],
                b.segments(48, 10),
            ),
        };
        let mesh = b.mesh("toy", vec![(color, shape)]);
        b.place(&format!("toy {}", k + 1), mesh, Pose::at(x, 0.003, z).yaw(90.0 * u(4)));
    }
    let cable = b.material(Finish::dielectric("cable", rgb(30, 32, 36), 0.57));
    for k in 0..5 {
        let x = -1.5 + 0.75 * k as f32;
        let path: Vec<Vec3> = (0..9)
            .map(|i| Vec3::new(x + 0.25 * sin(i as f32 * 1.3 + k as f32), 0.014, 1.7 - 0.42 * i as f32))
            .collect();
        b.add("cable", cable, tube(&smooth3(&path, b.segments(8, 2)), 0.011, b.segments(12, 5)));
    }
    // A portal behind the middle. It is tall, so that its reflection reaches far down the floor.
    let arch = b.material(Finish::metal("arch bronze", [0.72, 0.50, 0.30], 0.34));
    let path: Vec<Vec3> = (0..=16)
        .map(|i| {
            let a = i as f32 / 16.0 * std::f32::consts::PI;
            Vec3::new(-1.25 * sin(std::f32::consts::FRAC_PI_2 - a), 1.1 + 0.9 * sin(a), -2.85)
        })
        .collect();
    let mut gate = tube(&smooth3(&path, b.segments(6, 2)), 0.09, b.segments(32, 8));
    for x in [-1.25f32, 1.25] {
        gate.push(sweep::disc(0.09, 1.1, b.segments(32, 8)).at(x, 0.0, -2.85));
        gate.push(sweep::disc(0.16, 0.12, b.segments(32, 8)).at(x, 0.001, -2.85));
    }
    b.add("arch", arch, gate);
    let clock = b.material(Finish::dielectric("clock face", rgb(240, 238, 230), 0.55));
    let rim = b.material(Finish::dielectric("clock rim", rgb(196, 40, 44), 0.4));
    let n = b.segments(64, 12);
    b.add("clock", clock, disc(0.26, 0.03, n).turned(Vec3::X, 90.0).at(1.35, 2.1, -3.79));
    let mut dial = torus(0.27, 0.03, n, b.segments(16, 6)).turned(Vec3::X, 90.0).at(1.35, 2.1, -3.76);
    for (length, angle) in [(0.2f32, 40.0f32), (0.13, -70.0)] {
        let hand: Shape = block(0.016, length, 0.008, 0.002, 1).turned(Vec3::Z, angle);
        dial.push(hand.at(1.35, 2.1, -3.745));
    }
    b.add("clock rim", rim, dial);
    // Barrels at the sides of the view.
    let zinc = b.material(Finish::metal("zinc", [0.66, 0.68, 0.70], 0.28));
    for (k, (x, z)) in [(-2.75f32, -0.2f32), (-2.9, -1.3), (2.8, -0.1), (2.95, 0.7)].into_iter().enumerate() {
        let mut barrel = disc(0.27, 0.78, n);
        for i in 0..4 {
            barrel.push(torus(0.272, 0.014, n, 8).at(0.0, 0.1 + 0.19 * i as f32, 0.0));
        }
        b.add("barrel", if k % 2 == 0 { zinc } else { colors[k + 1] }, barrel.at(x, 0.0, z));
    }
}
