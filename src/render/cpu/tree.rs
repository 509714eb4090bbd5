//! The BVH that the processor traverses. It is obvhs' binary tree, collapsed to four children for each node, with the
//! triangles of its leaves in packs of four, so that vector instructions test all four at once.
//!
//! Sources: Wald, Benthin & Boulos 2008 (wide trees); Möller & Trumbore 1997; slab test with the direction's inverse, with the
//! exit moved a few ulps back (Ize 2013). The results equal those of `shaders/common/bvh.glsl`, except for rounding.

use glam::{Vec2, Vec3A, Vec4};
use obvhs::bvh2::Bvh2;

use super::super::bvh::binary_tree;
use super::super::shared::{DOUBLE_SIDED, LEAF, MASKED, TriangleData};
use super::math::FAR;

/// The number of children of a node, and of triangles in a pack.
const WIDTH: usize = 4;
/// The lowest bit of a leaf's number of packs, less one.
const COUNT_SHIFT: u32 = 28;

/// The bounds of four children, coordinate by coordinate.
#[repr(align(64))]
struct Node {
    /// Lower and upper corners.
    bounds: [[Vec4; 3]; 2],
    /// The index of a node, or [`LEAF`] | packs − 1 << [`COUNT_SHIFT`] | first pack. A missing child has a lower corner beyond
    /// its upper one, so that no ray enters it.
    children: [u32; WIDTH],
}

/// Four triangles, coordinate by coordinate; missing ones have no area.
struct Pack {
    v0: [Vec4; 3],
    edge1: [Vec4; 3],
    edge2: [Vec4; 3],
    /// edge1 · (direction × edge2) must exceed this for a triangle to be seen: 0 for single-sided triangles, the most negative
    /// number for double-sided ones.
    facing: Vec4,
    triangles: [u32; WIDTH],
    flags: [u32; WIDTH],
}

/// The nearest hit of a ray.
#[derive(Debug, Clone, Copy)]
pub struct Intersection {
    /// Distance, in lengths of the direction.
    pub t: f32,
    /// Weights of the second and third corner.
    pub uv: Vec2,
    pub triangle: u32,
}

/// A triangle that a ray to a light meets.
#[derive(Debug, Clone, Copy)]
pub struct Obstacle {
    pub triangle: u32,
    /// Weights of the second and third corner.
    pub uv: Vec2,
    /// The triangle's flags.
    pub flags: u32,
    /// The pack that holds it, for [`Tree::every_of_pack`].
    pub pack: u32,
}

/// The nodes and leaves that a traversal has yet to visit, each with the distance at which the ray enters it.
pub type Stack = Vec<(u32, f32)>;

/// See the module's documentation.
pub struct Tree {
    nodes: Vec<Node>,
    packs: Vec<Pack>,
    root: u32,
}

impl Tree {
    /// A tree over triangles in render space, to which hits refer by their index.
    pub fn new(triangles: &[TriangleData]) -> Tree {
        let binary = binary_tree(triangles, WIDTH as u32);
        let mut tree = Tree { nodes: Vec::new(), packs: Vec::new(), root: 0 };
        tree.root = match binary.nodes.is_empty() {
            true => tree.node(&binary, triangles, &[]),
            false => tree.add(&binary, triangles, 0),
        };
        tree
    }

    /// Adds a node of the binary tree with everything below it, and returns its reference for [`Node::children`].
    fn add(&mut self, binary: &Bvh2, triangles: &[TriangleData], at: usize) -> u32 {
        let node = &binary.nodes[at];
        if node.prim_count > 0 {
            let range = node.first_index as usize..(node.first_index + node.prim_count) as usize;
            let first = self.packs.len() as u32;
            self.packs.extend(binary.primitive_indices[range].chunks(WIDTH).map(|c| Pack::new(triangles, c)));
            return LEAF | (self.packs.len() as u32 - first - 1) << COUNT_SHIFT | first;
        }
        // The largest child is replaced by its own children until there are four.
        let mut children = vec![node.first_index as usize, node.first_index as usize + 1];
        while children.len() < WIDTH {
            let inner = children.iter().enumerate().filter(|&(_, &c)| binary.nodes[c].prim_count == 0);
            let area = |c: usize| binary.nodes[c].aabb.half_area();
            let Some((k, &c)) = inner.max_by(|a, b| area(*a.1).total_cmp(&area(*b.1))) else { break };
            children[k] = binary.nodes[c].first_index as usize;
            children.push(binary.nodes[c].first_index as usize + 1);
        }
        self.node(binary, triangles, &children)
    }

    fn node(&mut self, binary: &Bvh2, triangles: &[TriangleData], children: &[usize]) -> u32 {
        let index = self.nodes.len();
        let nothing = [[Vec4::splat(f32::MAX); 3], [Vec4::splat(f32::MIN); 3]];
        self.nodes.push(Node { bounds: nothing, children: [LEAF; WIDTH] });
        for (k, &c) in children.iter().enumerate() {
            let reference = self.add(binary, triangles, c);
            let bounds = &binary.nodes[c].aabb;
            let node = &mut self.nodes[index];
            node.children[k] = reference;
            for axis in 0..3 {
                node.bounds[0][axis][k] = bounds.min[axis];
                node.bounds[1][axis][k] = bounds.max[axis];
            }
        }
        index as u32
    }

    /// The nearest triangle that a ray sees: front faces, both faces of double-sided triangles, and of cut-out triangles only
    /// points for which `uncut` holds.
    #[inline]
    pub fn nearest(
        &self,
        origin: Vec3A,
        direction: Vec3A,
        stack: &mut Stack,
        uncut: impl Fn(u32, Vec2) -> bool,
    ) -> Option<Intersection> {
        let ray = Ray::new(origin, direction);
        let mut best: Option<Intersection> = None;
        let mut t_max = FAR;
        stack.clear();
        let mut at = self.root;
        loop {
            if at & LEAF == 0 {
                let node = &self.nodes[at as usize];
                let (near, mut hits) = ray.enter(&node.bounds, t_max);
                if hits.is_power_of_two() {
                    at = node.children[hits.trailing_zeros() as usize & 3];
                    continue;
                }
                let near = near.to_array();
                let bottom = stack.len();
                while hits != 0 {
                    let lane = hits.trailing_zeros() as usize & 3;
                    hits &= hits - 1;
                    stack.push((node.children[lane], near[lane]));
                    // Sorted so that the nearest child is on top.
                    let mut k = stack.len() - 1;
                    while k > bottom && stack[k - 1].1 < stack[k].1 {
                        stack.swap(k - 1, k);
                        k -= 1;
                    }
                }
            } else {
                for pack in &self.packs[Tree::leaf_range(at)] {
                    let m = ray.meets(pack, t_max);
                    let mut seen = m.hits & m.facing.cmpgt(pack.facing).bitmask();
                    while seen != 0 {
                        let lane = seen.trailing_zeros() as usize & 3;
                        seen &= seen - 1;
                        let (t, uv) = (m.t[lane], Vec2::new(m.u[lane], m.v[lane]));
                        let triangle = pack.triangles[lane];
                        if t < t_max && (pack.flags[lane] & MASKED == 0 || uncut(triangle, uv)) {
                            t_max = t;
                            best = Some(Intersection { t, uv, triangle });
                        }
                    }
                }
            }
            loop {
                match stack.pop() {
                    None => return best,
                    Some((child, near)) if near <= t_max => {
                        at = child;
                        break;
                    }
                    Some(_) => {}
                }
            }
        }
    }

    /// Calls `see` for every triangle that the ray meets before `t_max`, from either side and in no particular order. The
    /// traversal ends when `see` returns false.
    #[inline]
    pub fn every(
        &self,
        origin: Vec3A,
        direction: Vec3A,
        t_max: f32,
        stack: &mut Stack,
        mut see: impl FnMut(Obstacle) -> bool,
    ) {
        let ray = Ray::new(origin, direction);
        stack.clear();
        let mut at = self.root;
        loop {
            if at & LEAF == 0 {
                let node = &self.nodes[at as usize];
                let (_, mut hits) = ray.enter(&node.bounds, t_max);
                if hits != 0 {
                    at = node.children[hits.trailing_zeros() as usize & 3];
                    hits &= hits - 1;
                    while hits != 0 {
                        stack.push((node.children[hits.trailing_zeros() as usize & 3], 0.0));
                        hits &= hits - 1;
                    }
                    continue;
                }
            } else {
                for pack in Tree::leaf_range(at) {
                    if !self.show(&ray, pack as u32, t_max, &mut see) {
                        return;
                    }
                }
            }
            match stack.pop() {
                None => return,
                Some((child, _)) => at = child,
            }
        }
    }

    /// As [`Tree::every`], for the triangles of one pack. Returns false if `see` has returned false.
    #[inline]
    pub fn every_of_pack(
        &self,
        pack: u32,
        (origin, direction, t_max): (Vec3A, Vec3A, f32),
        mut see: impl FnMut(Obstacle) -> bool,
    ) -> bool {
        self.show(&Ray::new(origin, direction), pack, t_max, &mut see)
    }

    #[inline(always)]
    fn show(&self, ray: &Ray, index: u32, t_max: f32, see: &mut impl FnMut(Obstacle) -> bool) -> bool {
        let pack = &self.packs[index as usize];
        let m = ray.meets(pack, t_max);
        let mut hits = m.hits;
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize & 3;
            hits &= hits - 1;
            let (triangle, flags) = (pack.triangles[lane], pack.flags[lane]);
            if !see(Obstacle { triangle, uv: Vec2::new(m.u[lane], m.v[lane]), flags, pack: index }) {
                return false;
            }
        }
        true
    }

    /// The packs of a leaf.
    #[inline]
    fn leaf_range(at: u32) -> std::ops::Range<usize> {
        let first = (at & ((1 << COUNT_SHIFT) - 1)) as usize;
        first..first + (at >> COUNT_SHIFT & 7) as usize + 1
    }
}

impl Pack {
    fn new(triangles: &[TriangleData], members: &[u32]) -> Pack {
        let nothing = [Vec4::ZERO; 3];
        let mut pack = Pack {
            v0: nothing,
            edge1: nothing,
            edge2: nothing,
            facing: Vec4::ZERO,
            triangles: [0; WIDTH],
            flags: [0; WIDTH],
        };
        for (k, &member) in members.iter().enumerate() {
            let t = &triangles[member as usize];
            for axis in 0..3 {
                pack.v0[axis][k] = t.v0[axis];
                pack.edge1[axis][k] = t.edge1[axis];
                pack.edge2[axis][k] = t.edge2[axis];
            }
            pack.facing[k] = if t.flags & DOUBLE_SIDED != 0 { f32::MIN } else { 0.0 };
            (pack.triangles[k], pack.flags[k]) = (member, t.flags);
        }
        pack
    }
}

/// A ray, coordinate by coordinate, each in all four lanes.
struct Ray {
    origin: [Vec4; 3],
    direction: [Vec4; 3],
    inverse: [Vec4; 3],
    /// For each axis, which of a box's bounds the ray meets first: 0 the lower, 1 the upper.
    near: [usize; 3],
}

/// Where a ray meets four triangles.
struct PackHits {
    t: Vec4,
    u: Vec4,
    v: Vec4,
    /// Above 0: the ray meets the front.
    facing: Vec4,
    /// One bit for each triangle, set if the ray meets it.
    hits: u32,
}

impl Ray {
    #[inline(always)]
    fn new(origin: Vec3A, direction: Vec3A) -> Ray {
        let splat = |v: Vec3A| [Vec4::splat(v.x), Vec4::splat(v.y), Vec4::splat(v.z)];
        let inverse = |x: f32| {
            if x.abs() > 1e-20 { 1.0 / x } else { 1e20f32.copysign(x) }
        };
        let inverse = Vec3A::new(inverse(direction.x), inverse(direction.y), inverse(direction.z));
        let near = |x: f32| usize::from(x < 0.0);
        Ray {
            origin: splat(origin),
            direction: splat(direction),
            inverse: splat(inverse),
            near: [near(inverse.x), near(inverse.y), near(inverse.z)],
        }
    }

    /// The distance at which the ray enters each box, and one bit for each box, set if it is entered before `t_max`.
    #[inline(always)]
    fn enter(&self, bounds: &[[Vec4; 3]; 2], t_max: f32) -> (Vec4, u32) {
        let [x, y, z] = self.near;
        let at = |side: usize, axis: usize| (bounds[side & 1][axis] - self.origin[axis]) * self.inverse[axis];
        let near = at(x, 0).max(at(y, 1)).max(at(z, 2).max(Vec4::ZERO));
        let far = at(1 - x, 0).min(at(1 - y, 1)).min(at(1 - z, 2).min(Vec4::splat(t_max)));
        (near, near.cmple(far * 1.000_000_4).bitmask())
    }

    #[inline(always)]
    fn meets(&self, pack: &Pack, t_max: f32) -> PackHits {
        let p = cross(&self.direction, &pack.edge2);
        let facing = dot(&pack.edge1, &p);
        let inv = Vec4::ONE / facing;
        let s: [Vec4; 3] = std::array::from_fn(|k| self.origin[k] - pack.v0[k]);
        let u = dot(&s, &p) * inv;
        let q = cross(&s, &pack.edge1);
        let v = dot(&self.direction, &q) * inv;
        let t = dot(&pack.edge2, &q) * inv;
        let inside = u.cmpge(Vec4::ZERO) & v.cmpge(Vec4::ZERO) & (u + v).cmple(Vec4::ONE);
        // The NaN of a triangle without area fails every comparison.
        let hits = (inside & t.cmpgt(Vec4::ZERO) & t.cmplt(Vec4::splat(t_max))).bitmask();
        PackHits { t, u, v, facing, hits }
    }
}

#[inline(always)]
fn cross(a: &[Vec4; 3], b: &[Vec4; 3]) -> [Vec4; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
fn dot(a: &[Vec4; 3], b: &[Vec4; 3]) -> Vec4 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[cfg(test)]
mod tests {
    use super::super::random::Sequence;
    use super::*;

    fn triangle(flags: u32, corners: [Vec3A; 3]) -> TriangleData {
        let [v0, v1, v2] = corners;
        let (edge1, edge2) = ((v1 - v0).to_array(), (v2 - v0).to_array());
        TriangleData { v0: v0.to_array(), instance: 0, edge1, first_index: 0, edge2, flags }
    }

    /// Points in [−1, 1]³.
    fn points(seed: u32) -> impl Fn(u32) -> Vec3A {
        let (a, b) = (Sequence::new(seed, 0, [0, 0]), Sequence::new(seed, 1, [0, 0]));
        move |i| {
            let ([x, y], [z, _]) = (a.sample(i), b.sample(i));
            Vec3A::new(x, y, z) * 2.0 - 1.0
        }
    }

    #[test]
    fn the_nearest_of_a_thousand_triangles_is_found() {
        let (at, shape) = (points(1), points(2));
        let triangles: Vec<TriangleData> = (0..1000)
            .map(|i| {
                let corner = |k| at(i) + shape(3 * i + k) * 0.2;
                triangle([0, DOUBLE_SIDED, MASKED][i as usize % 3], [corner(0), corner(1), corner(2)])
            })
            .collect();
        let tree = Tree::new(&triangles);
        // One at a time, each in a tree of its own.
        let alone: Vec<Tree> = triangles.iter().map(|t| Tree::new(&[*t])).collect();
        let uncut = |_, uv: Vec2| uv.x < 0.5;
        let (from, to) = (points(3), points(4));
        let (mut stack, mut met) = (Stack::new(), 0);
        for i in 0..500 {
            let (origin, direction) = (from(i) * 2.0, to(i) - from(i) * 2.0);
            let found = tree.nearest(origin, direction, &mut stack, uncut).map(|h| (h.t, h.triangle));
            let each = |(k, t): (usize, &Tree)| {
                t.nearest(origin, direction, &mut Stack::new(), uncut).map(|h| (h.t, k as u32))
            };
            let expected = alone.iter().enumerate().filter_map(each).min_by(|a, b| a.0.total_cmp(&b.0));
            assert_eq!(found, expected);
            met += usize::from(found.is_some());
            let mut seen = Vec::new();
            tree.every(origin, direction, 1.0, &mut stack, |met| {
                seen.push(met.triangle);
                // The pack that it names shows it again.
                let mut again = Vec::new();
                tree.every_of_pack(met.pack, (origin, direction, 1.0), |met| {
                    again.push(met.triangle);
                    true
                });
                assert!(again.contains(&met.triangle));
                true
            });
            seen.sort_unstable();
            let mut expected = Vec::new();
            for (k, t) in alone.iter().enumerate() {
                t.every(origin, direction, 1.0, &mut Stack::new(), |_| {
                    expected.push(k as u32);
                    true
                });
            }
            assert_eq!(seen, expected);
        }
        assert!(met > 250, "{met}");
    }

    #[test]
    fn an_empty_scene_is_met_nowhere() {
        let tree = Tree::new(&[]);
        let mut stack = Stack::new();
        assert!(tree.nearest(Vec3A::ZERO, Vec3A::X, &mut stack, |_, _| true).is_none());
        tree.every(Vec3A::ZERO, Vec3A::X, FAR, &mut stack, |_| panic!("nothing is there"));
    }
}
