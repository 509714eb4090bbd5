//! The cellar around the table of `wine`: walls, racks of bottles, sideboards. Called by the scene `wine` alone.

use glam::Vec3;

use super::builder::{Builder, Finish, MaterialId, Pose};
use super::furniture::{self, slab};
use super::glasses::Glasses;
use super::noise::unit;
use super::pattern::{self, rgb};
use super::shape::Shape;
use super::solids::{block, rounded_box};
use super::sweep::{cask, disc, tube};
use super::tableware;
use super::texture::Image;

/// Builds the floor, the walls and the beams. Returns the wood that the furniture is made of.
pub(super) fn shell(b: &mut Builder) -> MaterialId {
    let stone = move |u, v| pattern::checker(u, v, 4, rgb(88, 80, 72), rgb(40, 34, 32));
    let floor_map = b.texture("flags", Image::color(512, stone));
    let floor_wear = b.texture("flags-wear", Image::roughness(256, move |u, v| pattern::wear(u, v, 0.5, 2)));
    let floor = b.material(
        Finish::dielectric("flagstones", [1.0; 3], 0.3).ior(1.8).map(floor_map, 0.5).roughness_map(floor_wear),
    );
    let brick_map = b.texture(
        "brick",
        Image::color(512, move |u, v| pattern::tiles(u, v, (6, 14), rgb(176, 134, 110), rgb(150, 142, 130), 0.5)),
    );
    let brick_bump =
        b.texture("brick-bump", Image::normals(512, move |u, v| 0.006 * pattern::tile_height(u, v, (6, 14), 0.5)));
    let brick = b.material(Finish::dielectric("brick", [1.0; 3], 0.86).map(brick_map, 0.7).normal_map(brick_bump));
    let plaster = b.material(Finish::dielectric("lime plaster", rgb(196, 182, 158), 0.9));
    let oak_map =
        b.texture("oak", Image::color(512, move |u, v| pattern::grain(u, v, rgb(150, 106, 66), rgb(84, 56, 34))));
    let oak = b.material(Finish::dielectric("cellar oak", [1.0; 3], 0.59).map(oak_map, 1.0));
    b.add("floor", floor, slab(Vec3::new(8.4, 0.2, 9.0), Vec3::new(0.0, -0.1, 0.0)));
    b.add("ceiling", plaster, slab(Vec3::new(8.4, 0.2, 9.0), Vec3::new(0.0, 3.0, 0.0)));
    b.add("back wall", brick, slab(Vec3::new(8.4, 2.9, 0.2), Vec3::new(0.0, 1.45, -3.5)));
    b.add("left wall", brick, slab(Vec3::new(0.2, 2.9, 9.0), Vec3::new(-3.6, 1.45, 0.0)));
    b.add("right wall", plaster, slab(Vec3::new(0.2, 2.9, 9.0), Vec3::new(3.6, 1.45, 0.0)));
    b.add("front wall", plaster, slab(Vec3::new(8.4, 2.9, 0.2), Vec3::new(0.0, 1.45, 4.6)));
    for k in 0..5 {
        let beam = rounded_box(Vec3::new(0.18, 0.2, 8.0), 0.02, b.segments(3, 1));
        b.add("beam", oak, beam.at(-2.8 + 1.4 * k as f32, 2.79, 0.0));
    }
    oak
}

/// A wall of racked bottles behind the table.
pub(super) fn rack(b: &mut Builder, oak: MaterialId, glasses: &Glasses) {
    let s = b.segments(3, 1);
    let mut lattice = Shape::default();
    let (columns, rows, pitch) = (14usize, 9usize, 0.19f32);
    let left = -(columns as f32) * pitch / 2.0;
    for i in 0..=columns {
        lattice.push(block(0.02, rows as f32 * pitch + 0.02, 0.3, 0.003, s).at(left + i as f32 * pitch, 0.1, -3.2));
    }
    for j in 0..=rows {
        let y = 0.101 + j as f32 * pitch;
        lattice.push(block(columns as f32 * pitch + 0.06, 0.018, 0.28, 0.003, s).at(0.0, y, -3.2));
    }
    b.add("rack", oak, lattice);
    let bottles: Vec<_> = (0..4)
        .map(|k| {
            let parts = tableware::bottle(b, glasses.bottle[k], glasses.labels[k], glasses.foil[(k + 1) % 3], 0.3, 0.5);
            b.mesh("racked bottle", parts)
        })
        .collect();
    for j in 0..rows {
        for i in 0..columns {
            let k = (unit(i as i32, j as i32, 19) * 5.0) as usize;
            if k < 4 {
                let (x, y) = (left + (i as f32 + 0.5) * pitch, 0.12 + j as f32 * pitch + 0.04);
                b.place("racked bottle", bottles[k], Pose::at(x, y, -3.32).pitch(90.0));
            }
        }
    }
}

/// Sideboards, casks near the edges of the view, lamps and copper.
pub(super) fn sides(b: &mut Builder, oak: MaterialId, glasses: &Glasses) {
    let marble_map = b.texture(
        "marble",
        Image::color(256, move |u, v| pattern::marble(u, v, rgb(206, 200, 190), rgb(90, 86, 84), 6)),
    );
    let marble = b.material(Finish::dielectric("marble", [1.0; 3], 0.14).ior(1.7).map(marble_map, 0.8));
    let copper = b.material(Finish::metal("copper", [0.90, 0.54, 0.40], 0.5));
    for side in [-1.0f32, 1.0] {
        let x = side * 2.75;
        b.add("sideboard", oak, block(0.55, 0.86, 2.2, 0.015, b.segments(3, 1)).at(x, 0.0, -1.2));
        b.add("sideboard top", marble, block(0.62, 0.035, 2.28, 0.01, b.segments(3, 1)).at(x, 0.861, -1.2));
        for k in 0..7 {
            let z = -2.1 + 0.3 * k as f32;
            let form = tableware::wine_glass(b, 0.2 + 0.015 * (k % 3) as f32, 0.04);
            b.add("glass", glasses.tints[k % 5], form.at(x - side * (0.1 + 0.08 * (k % 2) as f32), 0.8965, z));
        }
        let parts = tableware::bottle(b, glasses.bottle[2], glasses.labels[0], glasses.foil[0], 0.42, 1.0);
        let magnum = b.mesh("magnum", parts);
        for k in 0..3 {
            b.place("magnum", magnum, Pose::at(x + side * 0.12, 0.8965, -1.9 + 0.55 * k as f32));
        }
        b.add("bucket", copper, tableware::cup(b, 0.13, 0.24, 0.006).at(x - side * 0.05, 0.8965, 0.12 - 0.15));
    }
    // A cask near each edge of the view.
    let iron = b.material(Finish::metal("hoop iron", [0.36, 0.35, 0.34], 0.58));
    for (x, z) in [(-2.45f32, 0.9f32), (2.4, 1.0)] {
        let (staves, hoops) = cask(b.segments(96, 16), 0.3, 0.9, 6);
        let mesh = b.mesh("cask", vec![(oak, staves), (iron, hoops)]);
        b.place("cask", mesh, Pose::at(x, 0.0, z));
    }
    let shade = b.material(Finish::dielectric("copper shade", rgb(150, 74, 44), 0.56));
    let bulb = b.material(Finish::dielectric("bulb", [0.9; 3], 0.9).emissive([4.0, 3.2, 2.2]));
    let parts = furniture::pendant(b, shade, bulb, 0.7, 0.2);
    let pendant = b.mesh("pendant", parts);
    for x in [-0.7f32, 0.7] {
        b.place("pendant", pendant, Pose::at(x, 2.9, -2.4));
    }
    let rail = tube(&[Vec3::new(-1.4, 2.05, -3.2), Vec3::new(1.4, 2.05, -3.2)], 0.02, b.segments(20, 8));
    b.add("rail", copper, rail);
    let mut row = Shape::default();
    for k in 0..9 {
        row.push(disc(0.12, 0.02, b.segments(48, 10)).turned(Vec3::X, 80.0).at(-1.2 + 0.3 * k as f32, 1.97, -3.12));
    }
    b.add("copper plates", copper, row);
}
