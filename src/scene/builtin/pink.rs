//! A pink interior: patterned walls and floor, sweets and toys, a train that circles and balloons that bob.

use glam::Vec3;

use super::builder::{Builder, Finish, MaterialId, Pose};
use super::figures;
use super::furniture::{self, slab};
use super::noise::unit;
use super::pattern::{self, rgb};
use super::shape::{Shape, cos, sin};
use super::solids::{block, rounded_box, sphere, torus};
use super::sweep::{disc, lathe, smooth, smooth3, tube};
use super::tableware::{self, Parts};
use super::texture::Image;

struct Stuff {
    white: MaterialId,
    rose: MaterialId,
    gold: MaterialId,
    candy: Vec<MaterialId>,
}

pub fn build(detail: f64) -> Builder {
    let mut b = Builder::new("pink", detail);
    let stuff = shell(&mut b);
    wall_things(&mut b, &stuff);
    seats(&mut b, &stuff);
    table(&mut b, &stuff);
    train(&mut b, &stuff);
    balloons(&mut b);
    toys(&mut b, &stuff);
    b
}

fn shell(b: &mut Builder) -> Stuff {
    let squares = move |u, v| pattern::checker(u, v, 6, rgb(236, 206, 208), rgb(196, 96, 122));
    let floor_map = b.texture("checker", Image::color(512, squares));
    let floor_wear = b.texture("checker-wear", Image::roughness(512, move |u, v| pattern::wear(u, v, 0.5, 14)));
    let polished = Finish::dielectric("pink checker", [0.5; 3], 0.16).ior(1.9).map(floor_map, 0.33);
    let floor = b.material(polished.roughness_map(floor_wear));
    let paper = move |u, v| pattern::rug(u, v, rgb(226, 160, 172), rgb(210, 128, 148), rgb(240, 200, 200));
    let paper_map = b.texture("wallpaper", Image::color(512, paper));
    let wall = b.material(Finish::dielectric("wallpaper", [1.0; 3], 0.679).map(paper_map, 0.8));
    let panel = b.material(Finish::dielectric("wainscot", rgb(214, 128, 146), 0.55));
    let ceiling = b.material(Finish::dielectric("ceiling", rgb(240, 216, 214), 0.9));
    let white = b.material(Finish::dielectric("white gloss", rgb(238, 230, 228), 0.5));
    b.add("floor", floor, slab(Vec3::new(8.0, 0.2, 9.0), Vec3::new(0.0, -0.1, 0.0)));
    b.add("ceiling", ceiling, slab(Vec3::new(8.0, 0.2, 9.0), Vec3::new(0.0, 3.1, 0.0)));
    b.add("back wall", wall, slab(Vec3::new(8.0, 3.0, 0.2), Vec3::new(0.0, 1.5, -3.6)));
    b.add("left wall", wall, slab(Vec3::new(0.2, 3.0, 9.0), Vec3::new(-3.4, 1.5, 0.0)));
    b.add("right wall", wall, slab(Vec3::new(0.2, 3.0, 9.0), Vec3::new(3.4, 1.5, 0.0)));
    b.add("front wall", wall, slab(Vec3::new(8.0, 3.0, 0.2), Vec3::new(0.0, 1.5, 4.5)));
    let s = b.segments(3, 1);
    let raised = b.mesh("panel", vec![(panel, rounded_box(Vec3::new(0.7, 0.8, 0.05), 0.02, s))]);
    let rail = b.mesh("rail", vec![(white, rounded_box(Vec3::new(6.7, 0.07, 0.07), 0.02, s))]);
    for k in 0..9 {
        let along = -3.0 + 0.75 * k as f32;
        b.place("panel", raised, Pose::at(along, 0.52, -3.485));
        b.place("panel", raised, Pose::at(-3.285, 0.52, along).yaw(90.0));
        b.place("panel", raised, Pose::at(3.285, 0.52, along).yaw(-90.0));
    }
    for y in [0.06f32, 1.0, 2.9] {
        b.place("rail", rail, Pose::at(0.0, y, -3.47));
        b.place("rail", rail, Pose::at(-3.27, y, 0.0).yaw(90.0));
        b.place("rail", rail, Pose::at(3.27, y, 0.0).yaw(90.0));
    }
    let candy = b.palette(
        "candy",
        &[
            ([232, 84, 120], 0.48),
            ([246, 196, 206], 0.56),
            ([120, 200, 196], 0.52),
            ([246, 214, 110], 0.6),
            ([170, 120, 190], 0.58),
            ([250, 244, 236], 0.64),
            ([236, 120, 80], 0.5),
            ([96, 150, 210], 0.66),
            ([190, 30, 70], 0.42),
            ([150, 200, 120], 0.67),
        ],
    );
    Stuff {
        white,
        rose: b.material(Finish::dielectric("rose gloss", rgb(206, 70, 104), 0.14).ior(1.7)),
        gold: b.material(Finish::metal("pale gold", [0.94, 0.76, 0.52], 0.22)),
        candy,
    }
}

fn wall_things(b: &mut Builder, stuff: &Stuff) {
    let pane = b.material(Finish::dielectric("evening", [0.6; 3], 0.9).emissive([2.6, 1.9, 1.9]));
    let parts = furniture::window(b, stuff.white, pane, 1.2, 1.5, (2, 2));
    let window = b.mesh("window", parts);
    b.place("window left", window, Pose::at(-3.25, 1.85, -1.5).yaw(90.0));
    b.place("window left 2", window, Pose::at(-3.25, 1.85, 0.9).yaw(90.0));
    b.place("window right", window, Pose::at(3.25, 1.85, -0.4).yaw(-90.0));
    let stripes = |u: f32, v: f32| {
        let red = ((u * 8.0).floor() as i32) % 2 == 0;
        Vec3::from_array(if red { rgb(214, 96, 124) } else { rgb(244, 226, 222) }) * (0.9 + 0.1 * cos(v * 60.0))
    };
    let stripe_map = b.texture("stripes", Image::color(256, stripes));
    let cotton = b.material(Finish::dielectric("striped cotton", [1.0; 3], 0.66).map(stripe_map, 1.0));
    let curtain = furniture::curtain(b, 0.5, 1.9, 4.0);
    let curtain = b.mesh("curtain", vec![(cotton, curtain)]);
    for (x, z, yaw) in [
        (-3.15f32, -2.3f32, 90.0f32),
        (-3.15, -0.7, 90.0),
        (-3.15, 0.1, 90.0),
        (-3.15, 1.7, 90.0),
        (3.15, -1.2, -90.0),
        (3.15, 0.4, -90.0),
    ] {
        b.place("curtain", curtain, Pose::at(x, 0.95, z).yaw(yaw));
    }
    for (k, (x, y, w, h)) in
        [(-2.2f32, 1.95f32, 0.7f32, 0.9f32), (-1.2, 2.05, 0.6, 0.6), (1.3, 1.95, 0.8, 0.8), (2.4, 1.9, 0.7, 1.0)]
            .into_iter()
            .enumerate()
    {
        let map = b.texture(
            &format!("print-{}", k + 1),
            Image::color(256, move |u, v| pattern::painting(u, v, 200 + k as u32)),
        );
        let print =
            b.material(Finish::dielectric(&format!("print {}", k + 1), [1.0; 3], 0.48 + 0.05 * k as f32).map(map, 1.0));
        let moulding = if k % 2 == 0 { stuff.gold } else { stuff.white };
        let parts = furniture::picture(b, moulding, print, w, h);
        let picture = b.mesh(&format!("print {}", k + 1), parts);
        b.place(&format!("print {}", k + 1), picture, Pose::at(x, y, -3.49));
    }
    // A heart of light on the back wall.
    let neon = b.material(Finish::dielectric("neon", [0.9; 3], 0.85).emissive([4.5, 0.9, 2.2]));
    let heart: Vec<Vec3> = (0..=40)
        .map(|i| {
            let t = i as f32 / 40.0 * std::f32::consts::TAU;
            let x = 0.36 * sin(t) * sin(t) * sin(t);
            let y = 0.29 * cos(t) - 0.11 * cos(2.0 * t) - 0.045 * cos(3.0 * t) - 0.02 * cos(4.0 * t);
            Vec3::new(x + 0.02, y + 2.1, -3.42)
        })
        .collect();
    b.add("neon heart", neon, tube(&smooth3(&heart[..40], b.segments(4, 1)), 0.02, b.segments(20, 6)));
}

fn seats(b: &mut Builder, stuff: &Stuff) {
    let velvet_map = b.texture(
        "velvet",
        Image::color(256, move |u, v| pattern::weave(u, v, 56, rgb(206, 84, 116), rgb(180, 60, 96))),
    );
    let velvet = b.material(Finish::dielectric("pink velvet", [1.0; 3], 0.64).map(velvet_map, 2.2));
    let dots = |u: f32, v: f32| {
        let (x, y) = ((u * 6.0).fract() - 0.5, (v * 6.0).fract() - 0.5);
        Vec3::from_array(if x * x + y * y < 0.07 { rgb(250, 240, 236) } else { rgb(120, 196, 190) })
    };
    let dot_map = b.texture("dots", Image::color(256, dots));
    let dotted = b.material(Finish::dielectric("dotted satin", [1.0; 3], 0.45).map(dot_map, 2.4));
    let parts = furniture::sofa(b, velvet, dotted, stuff.gold, 2);
    let sofa = b.mesh("love seat", parts);
    b.place("love seat", sofa, Pose::at(-0.1, 0.0, -2.75));
    let parts = furniture::sofa(b, dotted, velvet, stuff.gold, 1);
    let armchair = b.mesh("armchair", parts);
    b.place("armchair left", armchair, Pose::at(-2.3, 0.0, -1.0).yaw(60.0));
    b.place("armchair right", armchair, Pose::at(2.35, 0.0, -1.1).yaw(-62.0));
    let parts = furniture::chair(b, stuff.white, velvet);
    let chair = b.mesh("chair", parts);
    b.place("chair left", chair, Pose::at(-1.95, 0.0, 1.15).yaw(70.0));
    b.place("chair right", chair, Pose::at(1.95, 0.0, 1.2).yaw(-75.0));
    let shade = b.material(Finish::dielectric("pink shade", rgb(236, 170, 176), 0.85).emissive([2.2, 1.2, 1.2]));
    let parts = furniture::floor_lamp(b, stuff.gold, shade, 1.6);
    let lamp = b.mesh("floor lamp", parts);
    b.place("floor lamp", lamp, Pose::at(1.35, 0.0, -2.9));
    b.place("floor lamp", lamp, Pose::at(-1.55, 0.0, -2.95));
}

fn table(b: &mut Builder, stuff: &Stuff) {
    let mut stand = furniture::turned_foot(b, 0.5, 0.22);
    stand.push(disc(0.46, 0.03, b.segments(96, 16)).at(0.0, 0.5, 0.0));
    b.add("tea table", stuff.rose, stand.at(0.1, 0.0, -1.5));
    let china = b.material(Finish::dielectric("tea china", rgb(244, 236, 230), 0.4));
    let icing = b.material(Finish::dielectric("icing", rgb(250, 214, 222), 0.6));
    let cake = {
        let mut cake = disc(0.15, 0.1, b.segments(80, 14));
        cake.push(disc(0.1, 0.08, b.segments(72, 14)).at(0.0, 0.101, 0.0));
        cake.push(disc(0.06, 0.06, b.segments(64, 14)).at(0.0, 0.182, 0.0));
        cake
    };
    b.add("cake", icing, cake.at(0.1, 0.59, -1.55));
    let mut dish = furniture::turned_foot(b, 0.05, 0.06);
    dish.push(disc(0.19, 0.009, b.segments(80, 14)).at(0.0, 0.05, 0.0));
    b.add("cake stand", china, dish.at(0.1, 0.53, -1.55));
    let berry = b.material(Finish::dielectric("berries", rgb(190, 24, 44), 0.054));
    let mut berries = Shape::default();
    for k in 0..24 {
        let a = k as f32 * std::f32::consts::TAU / 12.0;
        let (r, y) = if k < 12 { (0.125, 0.704) } else { (0.08, 0.785) };
        berries.push(sphere(0.014, b.segments(24, 6)).at(0.1 + r * sin(a), y, -1.55 + r * cos(a)));
    }
    b.add("berries", berry, berries);
    let cup = b.mesh(
        "tea cup",
        vec![(china, tableware::mug(b, 0.036)), (stuff.candy[0], tableware::plate(b, 0.07).at(0.0, -0.011, 0.0))],
    );
    for (k, a) in [20.0f32, 110.0, 200.0, 290.0].into_iter().enumerate() {
        let at = (0.1 + 0.33 * sin(a.to_radians()), -1.5 + 0.33 * cos(a.to_radians()));
        b.place("tea cup", cup, Pose::at(at.0, 0.5425, at.1).yaw(60.0 * k as f32));
    }
}

/// Six wagons on a ring of rails around the middle of the floor, one mesh, so that all circle together.
fn train(b: &mut Builder, stuff: &Stuff) {
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
    let mut parts = Parts::new();
    for k in 0..6 {
        let place = |shape: Shape| shape.at(0.0, 0.033, radius).turned(Vec3::Y, -17.0 * k as f32 + 130.0);
        let paint = stuff.candy[[8usize, 3, 2, 0, 7, 4][k]];
        let mut wheels = Shape::default();
        for (x, z) in [(-0.06f32, -0.05f32), (0.06, -0.05), (-0.06, 0.05), (0.06, 0.05)] {
            wheels.push(disc(0.03, 0.014, b.segments(40, 10)).turned(Vec3::X, 90.0).at(x, 0.03, z - 0.007));
        }
        parts.push((stuff.gold, place(wheels)));
        let mut body = block(0.2, 0.03, 0.1, 0.01, s).at(0.0, 0.035, 0.0);
        if k == 0 {
            body.push(disc(0.045, 0.14, b.segments(56, 12)).turned(Vec3::Z, -90.0).at(-0.06, 0.115, 0.0));
            body.push(block(0.07, 0.13, 0.1, 0.012, s).at(-0.068, 0.066, 0.0));
            let chimney = lathe(
                &smooth(&[(0.0, 0.0), (0.015, 0.0), (0.015, 0.05), (0.028, 0.07), (0.0, 0.071)], 3),
                b.segments(36, 8),
            );
            parts.push((stuff.gold, place(chimney.at(0.05, 0.158, 0.0))));
        } else {
            body.push(block(0.19, 0.07, 0.1, 0.016, s).at(0.0, 0.067, 0.0));
            for i in 0..5 {
                let ball = sphere(0.024, b.segments(28, 8));
                parts.push((
                    stuff.candy[(k + i * 3) % 10],
                    place(ball.at(-0.07 + 0.035 * i as f32, 0.146, 0.012 - 0.024 * (i % 2) as f32)),
                ));
            }
        }
        parts.push((paint, place(body)));
    }
    let mesh = b.mesh("train", parts);
    b.place("train", mesh, Pose::at(0.0, 0.0, 0.12));
}

fn balloons(b: &mut Builder) {
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

fn toys(b: &mut Builder, stuff: &Stuff) {
    let eye = b.material(Finish::dielectric("doll eye", rgb(30, 30, 34), 0.06));
    let paint = |k: usize| figures::RobotPaint {
        body: stuff.candy[k],
        trim: stuff.candy[(k + 3) % 10],
        joint: stuff.gold,
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
        let material = stuff.candy[(u(3) * 9.99) as usize];
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
    let parts = furniture::shelf(b, stuff.white, 0.9, 0.28, 1.7, 4);
    let shelf = b.mesh("toy shelf", parts);
    b.place("toy shelf", shelf, Pose::at(2.55, 0.0, -3.28));
    b.place("toy shelf", shelf, Pose::at(-2.6, 0.0, -3.28));
    let covers = &stuff.candy[..];
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
                    b.add("jar", stuff.candy[(i * 3 + board) % 10], form.at(x - 0.27 + 0.27 * i as f32, y, -3.25));
                }
            }
        }
    }
}
