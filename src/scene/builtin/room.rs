//! The scene `room`: a living room with a floor that reflects blurrily, and with tall windows and pictures that reach
//! beyond the sides of the view.

use glam::Vec3;

use super::builder::{Builder, Finish, MaterialId, Pose};
use super::furniture::{self, slab};
use super::pattern::{self, rgb};
use super::solids::{block, rounded_box, sphere};
use super::sweep::{disc, tube};
use super::tableware;
use super::texture::Image;

/// Half the room's width; below it, the z coordinate of the back wall. Metres.
const HALF: f32 = 3.3;
const BACK: f32 = -3.4;
/// z coordinates of the middles of the windows in the left wall.
const WINDOWS: [f32; 3] = [-2.1, 0.0, 2.1];
const HEIGHT: f32 = 2.9;

pub fn build(detail: f64) -> Builder {
    let mut b = Builder::new("room", detail);
    shell(&mut b);
    let wood = woods(&mut b);
    windows(&mut b);
    pictures(&mut b, wood[1]);
    seats(&mut b, &wood);
    middle(&mut b, &wood);
    bookcase(&mut b, &wood);
    b
}

fn shell(b: &mut Builder) {
    let boards = move |u, v| pattern::planks(u, v, 7, rgb(132, 92, 62), rgb(60, 40, 28));
    let floor_map = b.texture("parquet", Image::color(512, boards));
    let floor_bump =
        b.texture("parquet-bump", Image::normals(512, move |u, v| 0.0012 * pattern::plank_height(u, v, 7)));
    let floor_wear = b.texture("parquet-wear", Image::roughness(512, move |u, v| pattern::wear(u, v, 0.35, 9)));
    let parquet = Finish::dielectric("parquet", [0.9; 3], 0.3).ior(1.8).map(floor_map, 0.55);
    let floor = b.material(parquet.roughness_map(floor_wear).normal_map(floor_bump));
    let plaster = b.material(Finish::dielectric("plaster", rgb(206, 200, 188), 0.62));
    let accent = b.material(Finish::dielectric("painted wall", rgb(96, 120, 124), 0.55));
    let ceiling = b.material(Finish::dielectric("ceiling", rgb(222, 220, 214), 0.9));
    let trim = b.material(Finish::dielectric("white lacquer", rgb(228, 226, 220), 0.34));
    b.add("floor", floor, slab(Vec3::new(7.0, 0.2, 8.4), Vec3::new(0.0, -0.1, 0.3)));
    b.add("ceiling", ceiling, slab(Vec3::new(7.0, 0.2, 8.4), Vec3::new(0.0, HEIGHT + 0.1, 0.3)));
    b.add("back wall", accent, slab(Vec3::new(7.0, HEIGHT, 0.2), Vec3::new(0.0, HEIGHT / 2.0, BACK - 0.1)));
    let openings = (1.2, 0.5, 2.4);
    let left = furniture::wall_with_windows(-HALF - 0.1, HEIGHT, (-3.9, 4.5), &WINDOWS, openings);
    b.add("left wall", plaster, left);
    b.add("right wall", plaster, slab(Vec3::new(0.2, HEIGHT, 8.4), Vec3::new(HALF + 0.1, HEIGHT / 2.0, 0.3)));
    b.add("front wall", plaster, slab(Vec3::new(7.0, HEIGHT, 0.2), Vec3::new(0.0, HEIGHT / 2.0, 4.4)));
    let s = b.segments(3, 1);
    b.add("skirting back", trim, block(6.5, 0.12, 0.02, 0.005, s).at(0.0, 0.0, BACK + 0.012));
    for x in [-HALF + 0.012, HALF - 0.012] {
        b.add("skirting", trim, block(0.02, 0.12, 7.7, 0.005, s).at(x, 0.0, 0.46));
    }
    for k in 0..3 {
        let z = -2.2 + 1.9 * k as f32;
        b.add("beam", trim, rounded_box(Vec3::new(6.5, 0.16, 0.14), 0.01, s).at(0.0, HEIGHT - 0.085, z));
    }
}

fn woods(b: &mut Builder) -> [MaterialId; 3] {
    let walnut =
        b.texture("walnut", Image::color(256, move |u, v| pattern::grain(u, v, rgb(120, 76, 46), rgb(58, 34, 20))));
    let ash =
        b.texture("ash", Image::color(256, move |u, v| pattern::grain(u, v, rgb(204, 172, 128), rgb(160, 122, 80))));
    [
        b.material(Finish::dielectric("walnut lacquer", [1.0; 3], 0.12).ior(1.7).map(walnut, 1.1)),
        b.material(Finish::dielectric("walnut oil", [0.9; 3], 0.45).map(walnut, 1.6)),
        b.material(Finish::dielectric("ash", [1.0; 3], 0.5).map(ash, 1.3)),
    ]
}

fn windows(b: &mut Builder) {
    let bars = b.material(Finish::dielectric("window lacquer", rgb(236, 234, 228), 0.25));
    let pane = b.material(Finish::dielectric("daylight", [0.95; 3], 0.9).transmitting(0.9).emissive([2.5, 2.9, 3.3]));
    let linen_map = b.texture(
        "linen",
        Image::color(256, move |u, v| pattern::weave(u, v, 40, rgb(206, 194, 170), rgb(186, 172, 146))),
    );
    let linen = b.material(Finish::dielectric("linen", [1.0; 3], 0.85).map(linen_map, 2.0));
    let rod = b.material(Finish::metal("curtain rod", [0.74, 0.6, 0.36], 0.2));
    let parts = furniture::window(b, bars, pane, 1.25, 1.95, (2, 3));
    let window = b.mesh("window", parts);
    let hanging = furniture::curtain(b, 0.5, 2.5, 5.0);
    let curtain = b.mesh("curtain", vec![(linen, hanging)]);
    for (k, z) in WINDOWS.into_iter().enumerate() {
        b.place(&format!("window {}", k + 1), window, Pose::at(-HALF + 0.05, 1.45, z).yaw(90.0));
        for side in [-0.86f32, 0.86] {
            b.place("curtain", curtain, Pose::at(-HALF + 0.15, 0.02, z + side).yaw(90.0));
        }
        let ends = [Vec3::new(-HALF + 0.15, 2.56, z - 1.05), Vec3::new(-HALF + 0.15, 2.56, z + 1.05)];
        b.add("rod", rod, tube(&ends, 0.014, b.segments(16, 6)));
    }
}

fn pictures(b: &mut Builder, wood: MaterialId) {
    let gilt = b.material(Finish::metal("gilt frame", [0.83, 0.62, 0.28], 0.26));
    let black = b.material(Finish::dielectric("black frame", rgb(26, 26, 28), 0.18));
    let hang = [
        (HALF - 0.02, 1.65f32, -1.6f32, -90.0f32, 1.5f32, 1.05f32, gilt),
        (HALF - 0.02, 1.6, 0.45, -90.0, 1.15, 1.5, black),
        (HALF - 0.02, 1.65, 2.2, -90.0, 1.3, 0.9, wood),
        (-2.0, 1.75, BACK + 0.02, 0.0, 0.8, 1.1, black),
        (-0.35, 1.8, BACK + 0.02, 0.0, 1.6, 0.95, gilt),
    ];
    for (k, (x, y, z, yaw, width, height, moulding)) in hang.into_iter().enumerate() {
        let map = b.texture(
            &format!("painting-{}", k + 1),
            Image::color(256, move |u, v| pattern::painting(u, v, 17 + 5 * k as u32)),
        );
        let roughness = 0.3 + 0.07 * k as f32;
        let canvas = b.material(Finish::dielectric(&format!("canvas {}", k + 1), [1.0; 3], roughness).map(map, 1.0));
        let parts = furniture::picture(b, moulding, canvas, width, height);
        let picture = b.mesh(&format!("picture {}", k + 1), parts);
        b.place(&format!("picture {}", k + 1), picture, Pose::at(x, y, z).yaw(yaw));
    }
}

fn seats(b: &mut Builder, wood: &[MaterialId; 3]) {
    let wool_map = b
        .texture("wool", Image::color(256, move |u, v| pattern::weave(u, v, 48, rgb(120, 134, 120), rgb(92, 108, 98))));
    let wool = b.material(Finish::dielectric("wool", [1.0; 3], 0.9).map(wool_map, 2.5));
    let leather = b.material(Finish::dielectric("leather", rgb(126, 62, 34), 0.42));
    let velvet = b.palette("velvet", &[([196, 140, 52], 0.63), ([44, 84, 100], 0.6)]);
    let parts = furniture::sofa(b, wool, velvet[0], wood[1], 3);
    let sofa = b.mesh("sofa", parts);
    b.place("sofa", sofa, Pose::at(-0.35, 0.0, -2.55));
    let parts = furniture::sofa(b, leather, velvet[1], wood[1], 1);
    let armchair = b.mesh("armchair", parts);
    b.place("armchair right", armchair, Pose::at(2.0, 0.0, -0.5).yaw(-68.0));
    b.place("armchair left", armchair, Pose::at(-2.15, 0.0, -0.15).yaw(64.0));
    let cloth = b.material(Finish::dielectric("stool felt", rgb(150, 50, 44), 0.88));
    let parts = furniture::chair(b, wood[2], cloth);
    let chair = b.mesh("chair", parts);
    b.place("chair", chair, Pose::at(2.62, 0.0, 1.35).yaw(-120.0));
    b.place("chair", chair, Pose::at(-2.55, 0.0, 1.55).yaw(130.0));
}

fn middle(b: &mut Builder, wood: &[MaterialId; 3]) {
    let rug_map = b.texture(
        "rug",
        Image::color(512, move |u, v| pattern::rug(u, v, rgb(110, 34, 36), rgb(38, 50, 78), rgb(206, 182, 132))),
    );
    let rug = b.material(Finish::dielectric("rug", [1.0; 3], 0.95).map(rug_map, 1.0));
    b.add("rug", rug, furniture::rug(b, 2.3, 1.2).at(-0.3, 0.0, -1.45));
    let brass = b.material(Finish::metal("brass", [0.80, 0.62, 0.30], 0.15));
    let parts = furniture::table(b, wood[0], brass, 1.15, 0.62, 0.42);
    let table = b.mesh("low table", parts);
    b.place("low table", table, Pose::at(-0.1, 0.0, -0.75).yaw(6.0));
    let glaze =
        b.palette("glaze", &[([36, 86, 96], 0.06), ([206, 196, 176], 0.3), ([156, 74, 44], 0.22), ([60, 66, 60], 0.5)]);
    b.add("vase", glaze[0], tableware::vase(b, 1, 0.34).at(0.22, 0.42, -0.8));
    b.add("bowl", glaze[2], tableware::bowl(b, 0.15).at(-0.18, 0.42, -0.62));
    let skin = b.palette("apple", &[([170, 36, 30], 0.32), ([150, 160, 50], 0.36)]);
    for k in 0..4 {
        let at = [(-0.23f32, -0.64f32), (-0.13, -0.66), (-0.17, -0.56), (-0.19, -0.62)][k];
        let y = if k == 3 { 0.52 } else { 0.455 };
        b.add("apple", skin[k % 2], tableware::apple(b, 0.042).at(at.0, y, at.1));
    }
    let covers = b.palette(
        "cover",
        &[([140, 40, 40], 0.4), ([40, 70, 110], 0.44), ([200, 180, 130], 0.54), ([50, 90, 66], 0.48)],
    );
    let paper = b.material(Finish::dielectric("paper", rgb(226, 218, 198), 0.9));
    for (k, cover) in covers.iter().take(3).enumerate() {
        let parts = tableware::book(b, *cover, paper, Vec3::new(0.24 - 0.02 * k as f32, 0.032, 0.17));
        let book = b.mesh("book", parts);
        b.place("book", book, Pose::at(-0.48, 0.421 + 0.033 * k as f32, -0.82).yaw(14.0 - 17.0 * k as f32));
    }
    // Tall things whose reflections run down the floor towards the viewer.
    let shade = b.material(
        Finish::dielectric("lamp shade", rgb(220, 200, 160), 0.85).transmitting(0.5).emissive([2.2, 1.6, 0.9]),
    );
    let parts = furniture::floor_lamp(b, brass, shade, 1.75);
    let lamp = b.mesh("floor lamp", parts);
    b.place("floor lamp", lamp, Pose::at(1.55, 0.0, -2.3));
    b.place("floor lamp", lamp, Pose::at(-2.62, 0.0, -2.6));
    let leaf = b.material(Finish::dielectric("leaf", rgb(58, 104, 48), 0.38));
    let parts = furniture::plant(b, glaze[1], leaf, 1.35, 34, 3);
    let plant = b.mesh("plant", parts);
    b.place("plant", plant, Pose::at(2.75, 0.0, -2.5));
    b.place("plant", plant, Pose::at(-2.75, 0.0, 0.9).yaw(100.0).scale(0.7));
    // Near the middle of the view: a side table with a globe.
    let foot = furniture::turned_foot(b, 0.55, 0.16);
    let mut stand = foot.at(0.55, 0.0, 0.75);
    stand.push(disc(0.2, 0.025, b.segments(64, 12)).at(0.55, 0.55, 0.75));
    b.add("side table", wood[1], stand);
    let pearl = b.material(Finish::dielectric("pearl", rgb(214, 208, 200), 0.1).ior(1.8));
    b.add("globe", pearl, sphere(0.12, b.segments(72, 14)).at(0.55, 0.695, 0.75));
    b.add("candlestick", brass, furniture::turned_foot(b, 0.3, 0.06).at(-0.62, 0.0, 0.45));
    let steel = b.material(Finish::metal("steel ball", [0.7, 0.7, 0.72], 0.03));
    b.add("ball", steel, sphere(0.13, b.segments(72, 14)).at(-0.3, 0.13, 0.62));
}

fn bookcase(b: &mut Builder, wood: &[MaterialId; 3]) {
    let covers = b.palette(
        "spine",
        &[
            ([120, 30, 34], 0.35),
            ([30, 56, 92], 0.42),
            ([188, 160, 100], 0.5),
            ([44, 80, 58], 0.46),
            ([90, 60, 100], 0.55),
            ([34, 34, 38], 0.28),
            ([190, 96, 40], 0.52),
            ([210, 206, 196], 0.6),
        ],
    );
    let paper = b.material(Finish::dielectric("page", rgb(220, 212, 190), 0.9));
    let parts = furniture::shelf(b, wood[2], 1.3, 0.3, 2.1, 6);
    let shelf = b.mesh("bookcase", parts);
    b.place("bookcase", shelf, Pose::at(1.05 + 1.3, 0.0, BACK + 0.16));
    for board in 0..6 {
        let parts = tableware::book_row(b, &covers, paper, 1.12, 0.3, 40 + board as u32);
        let row = b.mesh(&format!("books {}", board + 1), parts);
        b.place(&format!("books {}", board + 1), row, Pose::at(1.78, 0.031 + 0.3447 * board as f32, BACK + 0.27));
    }
}
