//! The scene `pink`: an interior with patterned walls and floor, sweets and toys, a train that circles and balloons
//! that bob.

use glam::Vec3;

use super::builder::{Builder, Finish, Pose};
use super::furniture::{self, slab};
use super::pattern::{self, rgb};
use super::playthings::{self, Paints};
use super::shape::{Shape, cos, sin};
use super::solids::{rounded_box, sphere};
use super::sweep::{disc, smooth3, tube};
use super::tableware;
use super::texture::Image;

pub fn build(detail: f64) -> Builder {
    let mut b = Builder::new("pink", detail);
    let paints = shell(&mut b);
    wall_things(&mut b, &paints);
    seats(&mut b, &paints);
    table(&mut b, &paints);
    playthings::train(&mut b, &paints);
    playthings::balloons(&mut b);
    playthings::toys(&mut b, &paints);
    b
}

fn shell(b: &mut Builder) -> Paints {
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
    let left = furniture::wall_with_windows(-3.4, 3.0, (-4.5, 4.5), &[-1.5, 0.9], (1.15, 1.12, 2.58));
    b.add("left wall", wall, left);
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
    Paints {
        white,
        rose: b.material(Finish::dielectric("rose gloss", rgb(206, 70, 104), 0.14).ior(1.7)),
        gold: b.material(Finish::metal("pale gold", [0.94, 0.76, 0.52], 0.22)),
        candy,
    }
}

fn wall_things(b: &mut Builder, paints: &Paints) {
    let pane = b.material(Finish::dielectric("evening", [0.95; 3], 0.9).transmitting(0.9).emissive([2.6, 1.9, 1.9]));
    let parts = furniture::window(b, paints.white, pane, 1.2, 1.5, (2, 2));
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
        let moulding = if k % 2 == 0 { paints.gold } else { paints.white };
        let parts = furniture::picture(b, moulding, print, w, h);
        let picture = b.mesh(&format!("print {}", k + 1), parts);
        b.place(&format!("print {}", k + 1), picture, Pose::at(x, y, -3.49));
    }
    // A heart of neon light on the back wall.
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

fn seats(b: &mut Builder, paints: &Paints) {
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
    let parts = furniture::sofa(b, velvet, dotted, paints.gold, 2);
    let sofa = b.mesh("love seat", parts);
    b.place("love seat", sofa, Pose::at(-0.1, 0.0, -2.75));
    let parts = furniture::sofa(b, dotted, velvet, paints.gold, 1);
    let armchair = b.mesh("armchair", parts);
    b.place("armchair left", armchair, Pose::at(-2.3, 0.0, -1.0).yaw(60.0));
    b.place("armchair right", armchair, Pose::at(2.35, 0.0, -1.1).yaw(-62.0));
    let parts = furniture::chair(b, paints.white, velvet);
    let chair = b.mesh("chair", parts);
    b.place("chair left", chair, Pose::at(-1.95, 0.0, 1.15).yaw(70.0));
    b.place("chair right", chair, Pose::at(1.95, 0.0, 1.2).yaw(-75.0));
    let shade = b.material(
        Finish::dielectric("pink shade", rgb(236, 170, 176), 0.85).transmitting(0.5).emissive([2.2, 1.2, 1.2]),
    );
    let parts = furniture::floor_lamp(b, paints.gold, shade, 1.6);
    let lamp = b.mesh("floor lamp", parts);
    b.place("floor lamp", lamp, Pose::at(1.35, 0.0, -2.9));
    b.place("floor lamp", lamp, Pose::at(-1.55, 0.0, -2.95));
}

fn table(b: &mut Builder, paints: &Paints) {
    let mut stand = furniture::turned_foot(b, 0.5, 0.22);
    stand.push(disc(0.46, 0.03, b.segments(96, 16)).at(0.0, 0.5, 0.0));
    b.add("tea table", paints.rose, stand.at(0.1, 0.0, -1.5));
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
        vec![(china, tableware::mug(b, 0.036)), (paints.candy[0], tableware::plate(b, 0.07).at(0.0, -0.011, 0.0))],
    );
    for (k, a) in [20.0f32, 110.0, 200.0, 290.0].into_iter().enumerate() {
        let at = (0.1 + 0.33 * sin(a.to_radians()), -1.5 + 0.33 * cos(a.to_radians()));
        b.place("tea cup", cup, Pose::at(at.0, 0.5425, at.1).yaw(60.0 * k as f32));
    }
}
