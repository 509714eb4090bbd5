//! Twin of `shaders/common/math.glsl`: octahedral directions and bases.

use glam::{Vec2, Vec3A};

/// The largest finite number, which is the length of an unbounded ray.
pub const FAR: f32 = f32::MAX;
/// The largest finite number in half precision.
pub const MOST_HALF: Vec3A = Vec3A::splat(65504.0);

#[inline]
pub fn luminance(c: Vec3A) -> f32 {
    c.dot(Vec3A::new(0.2126, 0.7152, 0.0722))
}

#[inline]
pub fn square(x: f32) -> f32 {
    x * x
}

/// Rounds to the nearest whole number, for magnitudes below 2²²: the sum has no bits left for a fraction.
#[inline]
pub fn round(x: f32) -> f32 {
    const NO_FRACTION: f32 = 12_582_912.0;
    (x + NO_FRACTION) - NO_FRACTION
}

/// Two tangents and the normal itself (Duff et al. 2017).
#[derive(Debug, Clone, Copy)]
pub struct Basis {
    pub x: Vec3A,
    pub y: Vec3A,
    pub z: Vec3A,
}

impl Basis {
    #[inline]
    pub fn about(n: Vec3A) -> Basis {
        let s = if n.z >= 0.0 { 1.0 } else { -1.0 };
        let a = -1.0 / (s + n.z);
        let b = n.x * n.y * a;
        Basis {
            x: Vec3A::new(1.0 + s * n.x * n.x * a, s * b, -s * n.x),
            y: Vec3A::new(b, s + n.y * n.y * a, -n.y),
            z: n,
        }
    }

    /// A vector's coordinates in this basis.
    #[inline]
    pub fn to_local(self, v: Vec3A) -> Vec3A {
        Vec3A::new(v.dot(self.x), v.dot(self.y), v.dot(self.z))
    }

    #[inline]
    pub fn rotate(self, v: Vec3A) -> Vec3A {
        self.x * v.x + self.y * v.y + self.z * v.z
    }
}

/// The first vector, normalised; the second one when the first is too short or too long to normalise.
#[inline]
pub fn normalize_or(v: Vec3A, otherwise: Vec3A) -> Vec3A {
    let l = v.dot(v);
    if l > 1e-30 && l < 1e30 { v * (1.0 / l.sqrt()) } else { otherwise }
}

/// `d` mirrored in the plane with normal `n`, as GLSL's `reflect`: `d` points towards the surface.
#[inline]
pub fn reflect(d: Vec3A, n: Vec3A) -> Vec3A {
    d - n * (2.0 * n.dot(d))
}

/// Octahedral encoding of a unit vector (Meyer et al. 2010).
#[inline]
pub fn octahedral(n: Vec3A) -> Vec2 {
    let p = Vec2::new(n.x, n.y) / (n.x.abs() + n.y.abs() + n.z.abs());
    if n.z >= 0.0 {
        return p;
    }
    let sign = |x: f32| if x >= 0.0 { 1.0 } else { -1.0 };
    Vec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y))
}

#[inline]
pub fn from_octahedral(p: Vec2) -> Vec3A {
    let z = 1.0 - p.x.abs() - p.y.abs();
    let fold = (-z).max(0.0);
    let toward_axis = |v: f32| if v >= 0.0 { v - fold } else { v + fold };
    Vec3A::new(toward_axis(p.x), toward_axis(p.y), z).normalize()
}

/// Rounds a number in [−1, 1] to 16 bits, as `packSnorm2x16` and `unpackSnorm2x16` do.
#[inline]
fn through_snorm16(x: f32) -> f32 {
    (round(x.clamp(-1.0, 1.0) * 32767.0) / 32767.0).clamp(-1.0, 1.0)
}

/// Rounds a unit vector to the G-buffer's precision.
#[inline]
pub fn through_octahedral(n: Vec3A) -> Vec3A {
    let p = octahedral(n);
    from_octahedral(Vec2::new(through_snorm16(p.x), through_snorm16(p.y)))
}

/// `unpack_direction`.
pub fn unpack_direction(word: u32) -> Vec3A {
    let unit = |bits: u32| (f32::from(bits as u16 as i16) / 32767.0).clamp(-1.0, 1.0);
    from_octahedral(Vec2::new(unit(word & 0xffff), unit(word >> 16)))
}

/// `unpackUnorm4x8`.
#[inline]
pub fn unpack_unorm(word: u32) -> [f32; 4] {
    word.to_le_bytes().map(|b| f32::from(b) / 255.0)
}
