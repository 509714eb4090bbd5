//! Solids of revolution, tubes along curves and extruded outlines.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::shape::{Shape, cos, grid, sin};
use super::solids;

/// Adjoining pieces of a profile share a normal where the cosine between their normals is above this. At larger angles
/// (from about 35 degrees on) the edge between them stays sharp.
const SHARP: f32 = 0.82;

/// Turns a profile of (radius, height), from bottom to top, about the y axis. It must start and end at radius 0 for the
/// solid to be closed.
pub fn lathe(profile: &[(f32, f32)], segments: usize) -> Shape {
    lathe_with(profile, segments, |_, _| 1.0)
}

/// As [`lathe`], with the radius multiplied by `swell(angle, height)`, for flutes and petals. The normals are still
/// those without `swell`.
pub fn lathe_with(profile: &[(f32, f32)], segments: usize, swell: impl Fn(f32, f32) -> f32) -> Shape {
    let segments = segments.max(6);
    let mut shape = Shape::default();
    let piece = |k: usize| {
        let (a, b) = (profile[k], profile[k + 1]);
        Vec2::new(b.1 - a.1, a.0 - b.0).normalize_or(Vec2::X)
    };
    let pieces = profile.len().saturating_sub(1);
    let mut run = 0.0;
    for k in 0..pieces {
        let length = Vec2::new(profile[k + 1].0 - profile[k].0, profile[k + 1].1 - profile[k].1).length();
        let own = piece(k);
        let blend = |other: Option<Vec2>| match other {
            Some(n) if n.dot(own) > SHARP => (n + own).normalize_or(own),
            _ => own,
        };
        let ends = [blend(k.checked_sub(1).map(piece)), blend((k + 1 < pieces).then(|| piece(k + 1)))];
        shape.push(grid(segments, 1, |i, j| {
            let (r, y) = profile[k + j];
            let angle = (i % segments) as f32 / segments as f32 * TAU;
            let r = r * swell(angle, y);
            let n = Vec3::new(ends[j].x * sin(angle), ends[j].y, ends[j].x * cos(angle));
            let v = run + length * j as f32;
            (Vec3::new(r * sin(angle), y, r * cos(angle)), n, Vec2::new(i as f32 / segments as f32, -v))
        }));
        run += length;
    }
    shape
}

/// A smooth curve through the points (Catmull–Rom), with `steps` pieces between neighbours.
pub fn smooth(points: &[(f32, f32)], steps: usize) -> Vec<(f32, f32)> {
    let p: Vec<Vec3> = points.iter().map(|(x, y)| Vec3::new(*x, *y, 0.0)).collect();
    smooth3(&p, steps).into_iter().map(|p| (p.x.max(0.0), p.y)).collect()
}

/// As [`smooth`], for points in space.
pub fn smooth3(p: &[Vec3], steps: usize) -> Vec<Vec3> {
    let steps = steps.max(1);
    let mut out = Vec::new();
    for k in 0..p.len().saturating_sub(1) {
        let (a, b, c, d) = (p[k.saturating_sub(1)], p[k], p[k + 1], p[(k + 2).min(p.len() - 1)]);
        for s in 0..steps {
            let t = s as f32 / steps as f32;
            let cubic = (b * 2.0)
                + (c - a) * t
                + (a * 2.0 - b * 5.0 + c * 4.0 - d) * (t * t)
                + (b * 3.0 - a - c * 3.0 + d) * (t * t * t);
            out.push(if s == 0 { b } else { cubic * 0.5 });
        }
    }
    out.extend(p.last());
    out
}

/// A round tube along `path` with closed, rounded ends.
pub fn tube(path: &[Vec3], radius: f32, across: usize) -> Shape {
    tapered(path, |_| radius, across)
}

/// A tube whose radius is a function of the share of its length that lies behind a point (0–1).
pub fn tapered(path: &[Vec3], radius: impl Fn(f32) -> f32, across: usize) -> Shape {
    let across = across.max(5);
    let last = path.len().saturating_sub(1);
    if last == 0 {
        return Shape::default();
    }
    let tangent = |i: usize| (path[(i + 1).min(last)] - path[i.saturating_sub(1)]).normalize_or(Vec3::Y);
    // A frame that is carried along the path without twisting about it.
    let mut side = tangent(0).any_orthonormal_vector();
    let mut frames = Vec::new();
    for i in 0..=last {
        let t = tangent(i);
        side = (side - t * t.dot(side)).normalize_or(t.any_orthonormal_vector());
        frames.push((side, t.cross(side), t));
    }
    // Rings across the tube: a cap of three rings at each end, and the path between them.
    let caps = 3;
    let rings = last + 2 * caps;
    grid(across, rings, |i, j| {
        let (at, lean) = if j < caps {
            (0, j as f32 / caps as f32 - 1.0)
        } else if j > last + caps {
            (last, (j - last - caps) as f32 / caps as f32)
        } else {
            (j - caps, 0.0)
        };
        let (s, b, t) = frames[at];
        let angle = (i % across) as f32 / across as f32 * TAU;
        let r = radius(at as f32 / last as f32);
        let ring = if lean.abs() == 1.0 { 0.0 } else { cos(lean * TAU / 4.0) };
        let n = (s * cos(angle) + b * sin(angle)) * ring + t * sin(lean * TAU / 4.0);
        (path[at] + n * r, n, Vec2::new(i as f32 / across as f32, j as f32 / rings as f32))
    })
}

/// An upright prism over a star-shaped outline (x, z), counter-clockwise seen from above. It stands on y = 0.
pub fn prism(outline: &[Vec2], height: f32) -> Shape {
    let n = outline.len();
    let mut shape = Shape::default();
    let middle = outline.iter().sum::<Vec2>() / n.max(1) as f32;
    let place = |p: Vec2, y: f32| Vec3::new(p.x, y, -p.y);
    for k in 0..n {
        let (a, b) = (outline[k], outline[(k + 1) % n]);
        let edge = b - a;
        let out = place(Vec2::new(edge.y, -edge.x).normalize_or(Vec2::X), 0.0);
        let uv = |u: f32, v: f32| Vec2::new(u * edge.length(), (1.0 - v) * height);
        let [p, q, r, s] = [(a, 0.0, 0.0), (b, 0.0, 1.0), (b, height, 1.0), (a, height, 0.0)]
            .map(|(at, y, u)| shape.vertex(place(at, y), out, uv(u, y / height)));
        shape.quad(p, q, r, s);
        for (y, normal) in [(0.0, Vec3::NEG_Y), (height, Vec3::Y)] {
            let [m, i, j] = [middle, a, b].map(|at| shape.vertex(place(at, y), normal, at));
            shape.indices.extend(if y == 0.0 { [m, j, i] } else { [m, i, j] });
        }
    }
    shape
}

/// A disc with a rounded rim that lies on y = 0: a coaster, a lid, a coin.
pub fn disc(radius: f32, height: f32, segments: usize) -> Shape {
    let e = (height * 0.3).min(radius * 0.2);
    lathe(
        &[(0.0, 0.0), (radius - e, 0.0), (radius, e), (radius, height - e), (radius - e, height), (0.0, height)],
        segments,
    )
}

/// A frame around an opening of `width` × `height` in the xy-plane, centred on the origin. Its bars are `bar` wide and
/// `depth` deep.
pub fn frame(width: f32, height: f32, bar: f32, depth: f32, steps: usize) -> Shape {
    let mut shape = Shape::default();
    let long = Vec3::new(width + 2.0 * bar, bar, depth);
    let side = Vec3::new(bar, height - 0.002, depth * 0.96);
    for sign in [-1.0, 1.0] {
        shape.push(solids::rounded_box(long, bar * 0.2, steps).at(0.0, sign * (height + bar) / 2.0, 0.0));
        shape.push(solids::rounded_box(side, bar * 0.2, steps).at(sign * (width + bar) / 2.0, 0.0, 0.0));
    }
    shape
}

/// A standing cask and its `count` hoops: (staves, hoops). `radius` is the radius at its ends.
pub fn cask(segments: usize, radius: f32, height: f32, count: usize) -> (Shape, Shape) {
    let belly = |t: f32| radius * (1.0 + 0.22 * sin(t * std::f32::consts::PI));
    let steps = (segments / 6).max(4);
    let mut profile = vec![(0.0, 0.0)];
    profile.extend((0..=steps).map(|k| (belly(k as f32 / steps as f32), k as f32 / steps as f32 * height)));
    profile.extend([(radius * 0.93, height), (radius * 0.92, height - 0.03), (0.0, height - 0.03)]);
    let mut hoops = Shape::default();
    for k in 0..count {
        let t = (k as f32 + 0.5) / count as f32;
        let ring = solids::torus(belly(t), 0.014, segments, 8).scaled(1.0, 1.6, 1.0);
        hoops.push(ring.at(0.0, t * height, 0.0));
    }
    (lathe(&profile, segments), hoops)
}
