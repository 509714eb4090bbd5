//! The scene `temple`: a hall with fluted columns, stone tiles worn smooth, gilded figures and a lantern that swings.

use glam::Vec3;

use super::builder::{Builder, Finish, MaterialId, Pose};
use super::figures;
use super::furniture::{self, slab};
use super::noise::unit;
use super::pattern::{self, rgb};
use super::shape::Shape;
use super::solids::{block, rounded_box, sphere, torus};
use super::sweep::{disc, lathe, smooth, tube};
use super::tableware;
use super::texture::Image;

struct Materials {
    stone: MaterialId,
    marble: MaterialId,
    gold: MaterialId,
    bronze: MaterialId,
    lacquer: MaterialId,
}

pub fn build(detail: f64) -> Builder {
    let mut b = Builder::new("temple", detail);
    let materials = hall(&mut b);
    columns(&mut b, &materials);
    altar(&mut b, &materials);
    guardians(&mut b, &materials);
    offerings(&mut b, &materials);
    lanterns(&mut b, &materials);
    b
}

fn hall(b: &mut Builder) -> Materials {
    let flags = move |u, v| pattern::tiles(u, v, (4, 4), rgb(118, 108, 92), rgb(46, 40, 34), 0.5);
    let floor_map = b.texture("flags", Image::color(512, flags));
    let floor_bump =
        b.texture("flags-bump", Image::normals(512, move |u, v| 0.0011 * pattern::tile_height(u, v, (4, 4), 0.5)));
    let floor_wear = b.texture("flags-wear", Image::roughness(512, move |u, v| pattern::wear(u, v, 0.7, 21)));
    let polished = Finish::dielectric("worn flags", [0.75; 3], 0.15).ior(1.9).map(floor_map, 0.4);
    let floor = b.material(polished.roughness_map(floor_wear).normal_map(floor_bump));
    let ashlar_map = b.texture(
        "ashlar",
        Image::color(512, move |u, v| pattern::tiles(u, v, (4, 8), rgb(168, 150, 122), rgb(110, 98, 80), 0.5)),
    );
    let ashlar_bump =
        b.texture("ashlar-bump", Image::normals(512, move |u, v| 0.004 * pattern::tile_height(u, v, (4, 8), 0.5)));
    let ashlar = b.material(Finish::dielectric("ashlar", [1.0; 3], 0.86).map(ashlar_map, 0.45).normal_map(ashlar_bump));
    let stone_map = b.texture(
        "limestone",
        Image::color(256, move |u, v| pattern::marble(u, v, rgb(190, 174, 146), rgb(140, 122, 96), 33)),
    );
    let marble_map = b.texture(
        "marble",
        Image::color(512, move |u, v| pattern::marble(u, v, rgb(60, 74, 66), rgb(180, 190, 176), 12)),
    );
    let leaf_bump = b.texture("gold-leaf", Image::normals(256, move |u, v| 0.004 * pattern::beads(u, v, 8)));
    let leaf_wear = b.texture("gold-wear", Image::roughness(256, move |u, v| pattern::wear(u, v, 0.5, 8)));
    let beam_map =
        b.texture("cedar", Image::color(256, move |u, v| pattern::grain(u, v, rgb(132, 72, 44), rgb(74, 36, 22))));
    let beam = b.material(Finish::dielectric("cedar", [1.0; 3], 0.6).map(beam_map, 0.8));
    b.add("floor", floor, slab(Vec3::new(9.4, 0.2, 12.0), Vec3::new(0.0, -0.1, -1.0)));
    b.add("back wall", ashlar, slab(Vec3::new(9.4, 4.4, 0.2), Vec3::new(0.0, 2.2, -5.6)));
    b.add("left wall", ashlar, slab(Vec3::new(0.2, 4.4, 12.0), Vec3::new(-4.3, 2.2, -1.0)));
    b.add("right wall", ashlar, slab(Vec3::new(0.2, 4.4, 12.0), Vec3::new(4.3, 2.2, -1.0)));
    b.add("ceiling", beam, slab(Vec3::new(9.4, 0.2, 12.0), Vec3::new(0.0, 4.5, -1.0)));
    for k in 0..6 {
        let across = rounded_box(Vec3::new(8.5, 0.26, 0.22), 0.02, b.segments(3, 1));
        b.add("beam", beam, across.at(0.0, 4.26, -5.0 + 1.7 * k as f32));
    }
    Materials {
        stone: b.material(Finish::dielectric("limestone", [1.0; 3], 0.5).map(stone_map, 1.2)),
        marble: b.material(Finish::dielectric("green marble", [1.0; 3], 0.11).ior(1.7).map(marble_map, 0.7)),
        gold: b.material(
            Finish::metal("gold leaf", [0.95, 0.70, 0.30], 0.34).roughness_map(leaf_wear).normal_map(leaf_bump),
        ),
        bronze: b.material(Finish::metal("temple bronze", [0.60, 0.42, 0.26], 0.44)),
        lacquer: b.material(Finish::dielectric("red lacquer", rgb(132, 20, 18), 0.16).ior(1.7)),
    }
}

fn columns(b: &mut Builder, materials: &Materials) {
    let shape = figures::column(b, 4.12, 0.24);
    let mut band = torus(0.262, 0.02, b.segments(72, 12), b.segments(12, 5)).at(0.0, 1.1, 0.0);
    band.push(torus(0.262, 0.02, b.segments(72, 12), b.segments(12, 5)).at(0.0, 1.3, 0.0));
    let column = b.mesh("column", vec![(materials.stone, shape), (materials.gold, band)]);
    for (i, z) in [-4.4f32, -2.8, -1.2, 0.4, 2.0].into_iter().enumerate() {
        for x in [-2.15f32, 2.15] {
            b.place(&format!("column {}", 2 * i + usize::from(x > 0.0) + 1), column, Pose::at(x, 0.0, z));
        }
    }
    let banners = [rgb(150, 30, 28), rgb(30, 60, 96), rgb(170, 120, 34), rgb(44, 88, 60)];
    for (k, color) in banners.into_iter().enumerate() {
        let gilt = rgb(206, 170, 90);
        let map = b.texture(
            &format!("banner-{}", k + 1),
            Image::color(256, move |u, v| pattern::rug(u, v, color, rgb(26, 22, 20), gilt)),
        );
        let silk =
            b.material(Finish::dielectric(&format!("silk {}", k + 1), [1.0; 3], 0.5 + 0.03 * k as f32).map(map, 1.0));
        let cloth = furniture::curtain(b, 0.7, 2.3, 2.5).uv_scaled(1.0 / 0.7, 1.0 / 2.3);
        let mesh = b.mesh(&format!("banner {}", k + 1), vec![(silk, cloth)]);
        let x = if k % 2 == 0 { -3.95 } else { 3.95 };
        b.place(
            &format!("banner {}", k + 1),
            mesh,
            Pose::at(x, 1.2, -2.0 + 1.6 * (k / 2) as f32).yaw(if k % 2 == 0 { 90.0 } else { -90.0 }),
        );
    }
}

fn altar(b: &mut Builder, materials: &Materials) {
    let s = b.segments(4, 1);
    for (k, (w, d)) in [(3.2f32, 1.9f32), (2.7, 1.5), (2.2, 1.1)].into_iter().enumerate() {
        b.add("altar step", materials.marble, block(w, 0.15, d, 0.02, s).at(0.0, 0.151 * k as f32, -4.4));
    }
    let figure = figures::seated_figure(b);
    let mesh = b.mesh("great figure", vec![(materials.gold, figure)]);
    b.place("great figure", mesh, Pose::at(0.0, 0.455, -4.45).scale(1.75));
    // A halo behind the head: spikes around a ring.
    let mut halo = torus(0.62, 0.05, b.segments(96, 16), b.segments(20, 6)).turned(Vec3::X, 90.0);
    halo.push(torus(0.48, 0.025, b.segments(96, 16), b.segments(14, 6)).turned(Vec3::X, 90.0));
    for k in 0..24 {
        let ray = rounded_box(Vec3::new(0.03, if k % 2 == 0 { 0.3 } else { 0.2 }, 0.02), 0.006, b.segments(2, 1));
        halo.push(ray.at(0.0, 0.8, 0.0).turned(Vec3::Z, 15.0 * k as f32));
    }
    b.add("halo", materials.bronze, halo.at(0.0, 1.8, -4.95));
    let niche_tile = b.material(Finish::dielectric("niche glaze", rgb(28, 74, 88), 0.26));
    for row in 0..7 {
        for column in 0..9 {
            let tile = rounded_box(Vec3::new(0.29, 0.29, 0.05), 0.015, b.segments(2, 1));
            b.add("niche tile", niche_tile, tile.at(-1.2 + 0.3 * column as f32, 0.65 + 0.3 * row as f32, -5.47));
        }
    }
}

fn guardians(b: &mut Builder, materials: &Materials) {
    let jade = b.material(Finish::dielectric("jade", rgb(74, 122, 88), 0.3).ior(1.66));
    let terracotta = b.material(Finish::dielectric("terracotta", rgb(164, 88, 56), 0.61));
    let basalt = b.material(Finish::dielectric("basalt", rgb(48, 48, 52), 0.4));
    let ivory = b.material(Finish::dielectric("ivory", rgb(224, 210, 180), 0.45));
    let figure = figures::seated_figure(b);
    let plinth = {
        let mut shape = block(0.6, 0.1, 0.6, 0.02, b.segments(4, 1));
        shape.push(block(0.48, 0.34, 0.48, 0.015, b.segments(4, 1)).at(0.0, 0.101, 0.0));
        shape.push(block(0.56, 0.06, 0.56, 0.015, b.segments(4, 1)).at(0.0, 0.442, 0.0));
        shape
    };
    let base = b.mesh("plinth", vec![(materials.marble, plinth)]);
    let stand = [
        (-1.35f32, -2.6f32, 25.0f32, jade, 0.62f32),
        (1.35, -2.6, -25.0, terracotta, 0.62),
        (-1.5, -0.3, 55.0, ivory, 0.55),
        (1.5, -0.3, -55.0, basalt, 0.55),
        (-3.2, 0.6, 80.0, terracotta, 0.7),
        (3.2, 0.6, -80.0, jade, 0.7),
    ];
    for (k, (x, z, yaw, material, scale)) in stand.into_iter().enumerate() {
        let mesh = b.mesh("guardian", vec![(material, figure.clone())]);
        b.place("plinth", base, Pose::at(x, 0.0, z).yaw(yaw));
        b.place(&format!("guardian {}", k + 1), mesh, Pose::at(x, 0.503, z).yaw(yaw).scale(scale));
    }
}

fn offerings(b: &mut Builder, materials: &Materials) {
    // In the middle, close to the viewer: a burner, vessels and lotus lamps at several depths.
    let n = b.segments(72, 14);
    let body = smooth(
        &[
            (0.0, 0.22),
            (0.1, 0.22),
            (0.24, 0.3),
            (0.28, 0.42),
            (0.22, 0.5),
            (0.25, 0.54),
            (0.23, 0.55),
            (0.2, 0.5),
            (0.0, 0.46),
        ],
        b.segments(8, 2),
    );
    let mut burner = lathe(&body, n);
    for k in 0..3 {
        let a = 120.0 * k as f32;
        let leg = tube(
            &[Vec3::new(0.0, 0.02, 0.24), Vec3::new(0.0, 0.16, 0.2), Vec3::new(0.0, 0.3, 0.18)],
            0.035,
            b.segments(20, 6),
        );
        burner.push(leg.turned(Vec3::Y, a));
        let ear = torus(0.07, 0.016, b.segments(36, 10), b.segments(12, 5)).turned(Vec3::X, 90.0);
        burner.push(ear.at(0.0, 0.62, 0.24).turned(Vec3::Y, a + 60.0));
    }
    let burner = b.mesh("burner", vec![(materials.bronze, burner)]);
    b.place("burner", burner, Pose::at(0.12, 0.0, -0.9).yaw(20.0));
    let ash = b.material(Finish::dielectric("incense", rgb(120, 60, 40), 0.624));
    let mut sticks = Shape::default();
    for k in 0..9 {
        let u = |i| unit(k, i, 61);
        let foot = Vec3::new(0.12 + 0.12 * (u(0) - 0.5), 0.46, -0.9 + 0.12 * (u(1) - 0.5));
        sticks.push(tube(
            &[foot, foot + Vec3::new(0.1 * (u(2) - 0.5), 0.42, 0.1 * (u(3) - 0.5))],
            0.004,
            b.segments(8, 5),
        ));
    }
    b.add("incense", ash, sticks);
    let glazes = b.palette(
        "celadon",
        &[
            ([120, 160, 140], 0.2),
            ([60, 96, 120], 0.36),
            ([200, 190, 160], 0.5),
            ([150, 60, 40], 0.46),
            ([40, 40, 46], 0.28),
            ([180, 130, 60], 0.55),
        ],
    );
    let flame = b.material(Finish::dielectric("flame", [0.9; 3], 0.9).emissive([2.6, 1.6, 0.7]));
    let wax = b.palette("candle wax", &[([226, 210, 176], 0.56), ([150, 30, 26], 0.54)]);
    for k in 0..26 {
        let u = |i| unit(k, i, 71);
        let (x, z) = (-1.25 + 2.5 * u(0), 0.9 - 3.0 * u(1));
        if (x - 0.12) * (x - 0.12) + (z + 0.9) * (z + 0.9) < 0.16 {
            continue;
        }
        let material = glazes[(u(2) * 5.99) as usize];
        let size = 0.16 + 0.22 * u(3);
        match k % 4 {
            0 => b.add("vessel", material, tableware::vase(b, k as usize / 4, size).at(x, 0.002, z)),
            1 => {
                let lamp = figures::lotus(b, size * 0.5, size * 0.3);
                let parts = vec![
                    (materials.gold, lamp),
                    (flame, sphere(0.03, b.segments(24, 8)).scaled(0.8, 1.8, 0.8).at(0.0, size * 0.3 + 0.045, 0.0)),
                ];
                let mesh = b.mesh("lotus lamp", parts);
                b.place("lotus lamp", mesh, Pose::at(x, 0.002, z));
            }
            2 => {
                let parts = tableware::candle(b, wax[k as usize / 4 % 2], flame, 0.025, size);
                let candle = b.mesh("candle", parts);
                b.place("candle", candle, Pose::at(x, 0.002, z));
            }
            _ => b.add("bowl", material, tableware::bowl(b, size * 0.45).at(x, 0.002, z)),
        }
    }
    let carpet_map = b.texture(
        "runner",
        Image::color(512, move |u, v| pattern::rug(u, v, rgb(120, 24, 26), rgb(36, 30, 64), rgb(206, 160, 76))),
    );
    let carpet = b.material(Finish::dielectric("runner", [1.0; 3], 0.93).map(carpet_map, 1.0));
    b.add("runner", carpet, furniture::rug(b, 0.9, 1.3).at(0.0, 0.0, -2.7));
    // Beads that turn. They are the first of the hall's two moving things.
    let colors = b.palette(
        "bead",
        &[([200, 60, 40], 0.036), ([40, 110, 150], 0.3), ([220, 180, 70], 0.32), ([230, 226, 214], 0.42)],
    );
    let mut parts: Vec<(MaterialId, Shape)> = vec![(materials.lacquer, disc(0.17, 0.03, n).at(0.0, 0.3, 0.0))];
    parts.push((materials.lacquer, furniture::turned_foot(b, 0.3, 0.12)));
    for k in 0..12 {
        let a = k as f32 * std::f32::consts::PI / 6.0;
        let at = Vec3::new(super::shape::sin(a) * 0.14, 0.37, super::shape::cos(a) * 0.14);
        parts.push((colors[k % 4], sphere(0.034, b.segments(32, 8)).at(at.x, at.y, at.z)));
    }
    parts.push((materials.gold, figures::star(0.1, 0.02).at(0.0, 0.46, -0.01)));
    let wheel = b.mesh("bead wheel", parts);
    b.place("bead wheel", wheel, Pose::at(-0.48, 0.001, 0.35));
    for (k, x) in [-1.0f32, 1.0].into_iter().enumerate() {
        let drum = lathe(
            &smooth(&[(0.0, 0.0), (0.2, 0.0), (0.26, 0.2), (0.26, 0.36), (0.2, 0.56), (0.0, 0.56)], b.segments(8, 2)),
            n,
        );
        b.add("drum", if k == 0 { materials.lacquer } else { glazes[5] }, drum.at(x * 1.62, 0.0, 1.15));
    }
}

fn lanterns(b: &mut Builder, materials: &Materials) {
    let paper =
        b.material(Finish::dielectric("lantern glow", [0.8; 3], 0.85).transmitting(0.8).emissive([4.5, 2.9, 1.2]));
    let cold = b.material(Finish::dielectric("blue glow", [0.7; 3], 0.85).transmitting(0.8).emissive([0.9, 2.0, 2.8]));
    let parts = figures::lantern(b, materials.bronze, paper, 1.9);
    let warm = b.mesh("lantern", parts);
    let parts = figures::lantern(b, materials.gold, cold, 1.6);
    let blue = b.mesh("blue lantern", parts);
    b.place("moving lantern", warm, Pose::at(0.45, 4.1, -0.2));
    for (x, z) in [(-1.1f32, -1.9f32), (1.1, -1.9), (-1.1, 1.2), (1.15, 1.4)] {
        b.place("lantern", blue, Pose::at(x, 4.1, z));
    }
    for (x, z) in [(-0.9f32, -3.6f32), (0.9, -3.6)] {
        b.place("altar lantern", warm, Pose::at(x, 4.1, z));
    }
}
