//! First built-in scene.
use glam::Vec3;

use super::builder::{Builder, Finish, Pose};
use super::pattern::{self, rgb};
use super::texture::Image;
use super::{solids, sweep};

pub fn build(detail: f64) -> Builder {
    let mut b = Builder::new("room", detail);
    let wood =
        b.texture("floor", Image::color(512, |u, v| pattern::planks(u, v, 8, rgb(196, 140, 88), rgb(96, 58, 30))));
    let floor = b.material(Finish::dielectric("floor", [1.0; 3], 0.25).map(wood, 0.5));
    let wall = b.material(Finish::dielectric("wall", rgb(200, 196, 188), 0.9));
    let red = b.material(Finish::dielectric("red", rgb(190, 40, 30), 0.2));
    b.add("floor", floor, solids::rounded_box(Vec3::new(8.0, 0.1, 8.0), 0.01, 1).at(0.0, -0.05, 0.0));
    b.add("wall", wall, solids::rounded_box(Vec3::new(8.0, 3.0, 0.1), 0.01, 1).at(0.0, 1.5, -4.05));
    let n = b.segments(64, 12);
    let m = b.mesh("ball", vec![(red, solids::sphere(0.4, n))]);
    b.place("ball", m, Pose::at(0.5, 0.4, -1.0));
    b.add(
        "vase",
        red,
        sweep::lathe(&sweep::smooth(&[(0.0, 0.0), (0.2, 0.0), (0.3, 0.4), (0.1, 0.8), (0.15, 1.0), (0.0, 0.95)], 6), n)
            .at(-1.0, 0.0, -1.0),
    );
    b
}
