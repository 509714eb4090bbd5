//! The points at which light is gathered, and how the points of the lattice take their light from them. One gathering point
//! serves all lattice points of an instance that are close together and face in similar directions.

use std::collections::HashMap;

use glam::{IVec3, Vec3};

use super::lattice::{Lattice, Point};

/// A point of whose rays a larger share meets the backs of surfaces counts as lying inside matter.
const MOST_BACKS: f32 = 0.25;
/// Factor on the weight of a point inside matter: it counts only where no other point is near.
const HARDLY: f32 = 1e-6;

/// What the lattice points of one gathering point have in common: instance, cell, and the octant and largest axis of the normal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
struct Key {
    instance: u32,
    cell: IVec3,
    facing: u8,
}

/// The gathering points, and the weights with which the lattice points take from them.
#[derive(Debug)]
pub struct Gathering {
    /// Where rays start, and the surface's normal there.
    pub points: Vec<Point>,
    /// The entries of lattice point i in `taken` are those from `ranges[i]` to `ranges[i + 1]`.
    ranges: Vec<u32>,
    /// Index of a gathering point, and its weight.
    taken: Vec<(u32, f32)>,
    /// For each lattice point the gathering point that serves it.
    own: Vec<u32>,
}

fn facing(n: Vec3) -> u8 {
    let a = n.abs();
    let axis = if a.x >= a.y && a.x >= a.z {
        0u8
    } else if a.y >= a.z {
        1
    } else {
        2
    };
    axis << 3 | u8::from(n.x < 0.0) << 2 | u8::from(n.y < 0.0) << 1 | u8::from(n.z < 0.0)
}

fn cell(p: Vec3, size: f32) -> IVec3 {
    (p / size).floor().as_ivec3()
}

impl Gathering {
    /// Makes gathering points with cells of `size` metres.
    pub fn new(lattice: &Lattice, size: f32) -> Gathering {
        let mut numbers: HashMap<Key, u32> = HashMap::new();
        let mut sums: Vec<(Vec3, u32)> = Vec::new();
        let own: Vec<u32> = lattice
            .points
            .iter()
            .map(|p| {
                let key = Key { instance: p.instance, cell: cell(p.position, size), facing: facing(p.normal) };
                let number = *numbers.entry(key).or_insert_with(|| {
                    sums.push((Vec3::ZERO, 0));
                    sums.len() as u32 - 1
                });
                let sum = &mut sums[number as usize];
                sum.0 += p.position;
                sum.1 += 1;
                number
            })
            .collect();
        // The lattice point nearest to the mean of a group becomes its gathering point.
        let mut nearest: Vec<(f32, usize)> = vec![(f32::INFINITY, 0); sums.len()];
        for (i, (p, &number)) in lattice.points.iter().zip(&own).enumerate() {
            let (sum, count) = sums[number as usize];
            let distance = p.position.distance_squared(sum / count as f32);
            if distance < nearest[number as usize].0 {
                nearest[number as usize] = (distance, i);
            }
        }
        let points: Vec<Point> = nearest.iter().map(|&(_, i)| lattice.points[i]).collect();
        let mut cells: HashMap<(u32, IVec3), Vec<u32>> = HashMap::new();
        for (number, p) in points.iter().enumerate() {
            cells.entry((p.instance, cell(p.position, size))).or_default().push(number as u32);
        }
        let (mut ranges, mut taken) = (vec![0], Vec::new());
        for p in &lattice.points {
            let middle = cell(p.position, size);
            for offset in 0..27 {
                let step = IVec3::new(offset % 3 - 1, offset / 3 % 3 - 1, offset / 9 - 1);
                for &number in cells.get(&(p.instance, middle + step)).map_or(&[][..], Vec::as_slice) {
                    let weight = weight(p, &points[number as usize], size);
                    if weight > 0.0 {
                        taken.push((number, weight));
                    }
                }
            }
            ranges.push(taken.len() as u32);
        }
        Gathering { points, ranges, taken, own }
    }

    /// The light of the lattice points (irradiance / π, and 1) from that of the gathering points (irradiance / π, and the
    /// share of rays that met backs).
    pub fn spread(&self, gathered: &[[f32; 4]]) -> Vec<[f32; 4]> {
        let open = |number: u32| gathered[number as usize][3] <= MOST_BACKS;
        self.ranges
            .windows(2)
            .zip(&self.own)
            .map(|(range, &own)| {
                let (mut sum, mut weights) = (Vec3::ZERO, 0.0);
                let own = (own, HARDLY * HARDLY);
                for &(number, weight) in self.taken[range[0] as usize..range[1] as usize].iter().chain([&own]) {
                    let weight = if open(number) { weight } else { weight * HARDLY };
                    sum += weight * Vec3::from_slice(&gathered[number as usize]);
                    weights += weight;
                }
                (sum / weights).extend(1.0).to_array()
            })
            .collect()
    }
}

/// The weight of a gathering point for a lattice point: a tent over the neighbouring cells, less where the normals differ or the
/// points do not lie in one plane.
fn weight(p: &Point, from: &Point, size: f32) -> f32 {
    let d = from.position - p.position;
    let tent = (1.0 - d.abs() / size).max(Vec3::ZERO);
    let alike = p.normal.dot(from.normal).max(0.0);
    let apart = d.dot(p.normal).abs() / size;
    let flat = (1.0 - 3.0 * apart).max(0.0);
    tent.x * tent.y * tent.z * alike.powi(4) * flat
}
