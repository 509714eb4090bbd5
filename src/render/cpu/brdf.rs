//! Twin of `shaders/common/brdf.glsl` and `reflect.glsl`: GGX, and the reflection rays of a pixel. What all samples of a pixel
//! have in common is computed once, in a [`Reflector`].

use std::f32::consts::PI;

use glam::Vec3A;

use super::math::{Basis, normalize_or, reflect, square};
use super::surface::Surface;

/// D = α²/(π((n·h)²α² + |n×h|²)²).
#[inline]
fn ggx_distribution(n: Vec3A, h: Vec3A, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let c = n.cross(h);
    let d = square(n.dot(h)) * a2 + c.dot(c);
    a2 / (PI * d * d)
}

/// G₂/(4 (n·v)(n·l)).
#[inline]
fn smith_visibility(nv: f32, nl: f32, alpha: f32) -> f32 {
    let a2 = alpha * alpha;
    let v = nl * (nv * nv * (1.0 - a2) + a2).sqrt();
    let l = nv * (nl * nl * (1.0 - a2) + a2).sqrt();
    0.5 / (v + l).max(1e-12)
}

#[inline]
pub fn schlick(f0: Vec3A, vh: f32) -> Vec3A {
    let m = (1.0 - vh).clamp(0.0, 1.0);
    let m2 = m * m;
    f0 + (Vec3A::ONE - f0) * (m2 * m2 * m)
}

/// f·cos θ_l with Fresnel; zero below the horizon.
#[inline]
pub fn ggx_times_cosine(n: Vec3A, v: Vec3A, l: Vec3A, alpha: f32, f0: Vec3A) -> Vec3A {
    let (nv, nl) = (n.dot(v), n.dot(l));
    if nl <= 0.0 || nv <= 0.0 {
        return Vec3A::ZERO;
    }
    let h = normalize_or(v + l, n);
    schlick(f0, v.dot(h)) * (ggx_distribution(n, h, alpha) * smith_visibility(nv, nl, alpha) * nl)
}

fn cap_bound(i: Vec3A, alpha: f32) -> f32 {
    let s = 1.0 + (i.x * i.x + i.y * i.y).sqrt();
    let (a2, s2) = (alpha * alpha, s * s);
    (1.0 - a2) * s2 / (s2 + a2 * i.z * i.z)
}

/// Makes the reflection rays of a pixel's surface.
pub struct Reflector {
    surface: Surface,
    v: Vec3A,
    scattering: Scattering,
}

enum Scattering {
    /// One direction, weighted by Fresnel alone.
    Mirror(Ray),
    Lobe(Lobe),
}

struct Lobe {
    alpha: f32,
    basis: Basis,
    /// `v` in that basis.
    i: Vec3A,
    /// The same, stretched to the unit hemisphere.
    i_std: Vec3A,
    /// The bounded cap's extent: its lowest z is −b.
    b: f32,
    /// 2(k·i_z + t): the density of a direction is D divided by this.
    scale: f32,
}

/// A reflection ray.
#[derive(Debug, Clone, Copy)]
pub struct Ray {
    pub direction: Vec3A,
    /// f·cos/pdf with Fresnel.
    pub weight: Vec3A,
}

impl Reflector {
    /// Surfaces below `delta_roughness` are mirrors.
    pub fn new(surface: Surface, v: Vec3A, delta_roughness: f32) -> Reflector {
        let n = surface.normal;
        let scattering = if surface.roughness < delta_roughness {
            Scattering::Mirror(Ray { direction: reflect(-v, n), weight: schlick(surface.f0, n.dot(v)) })
        } else {
            let alpha = square(surface.roughness);
            let basis = Basis::about(n);
            let i = basis.to_local(v);
            let i_std = Vec3A::new(i.x * alpha, i.y * alpha, i.z).normalize();
            let k = cap_bound(i, alpha);
            let t = Vec3A::new(alpha * i.x, alpha * i.y, i.z).length();
            Scattering::Lobe(Lobe { alpha, basis, i, i_std, b: k * i_std.z, scale: (2.0 * (k * i.z + t)).max(1e-12) })
        };
        Reflector { surface, v, scattering }
    }

    /// The ray that two random numbers choose. `None` below the horizon of the shading normal or of the triangle: such a sample
    /// counts as zero.
    pub fn ray(&self, u: [f32; 2]) -> Option<Ray> {
        let above = |d: Vec3A| d.dot(self.surface.normal) > 0.0 && d.dot(self.surface.face_normal) > 0.0;
        match &self.scattering {
            Scattering::Mirror(ray) => above(ray.direction).then_some(*ray),
            Scattering::Lobe(lobe) => {
                let o = lobe.sample(u);
                let direction = lobe.basis.rotate(o).normalize();
                if !above(direction) {
                    return None;
                }
                let (n, f0) = (self.surface.normal, self.surface.f0);
                let weight = ggx_times_cosine(n, self.v, direction, lobe.alpha, f0) / lobe.density(o);
                Some(Ray { direction, weight })
            }
        }
    }
}

impl Lobe {
    /// Visible normals within the bounded cap (Dupuy & Benyoub 2023; Tokuyoshi & Eto 2023).
    fn sample(&self, u: [f32; 2]) -> Vec3A {
        let (sin, cos) = (2.0 * PI * u[0]).sin_cos();
        // Rounded once, as by `fma`: the product of two single-precision numbers is exact in double precision.
        let z = (f64::from(1.0 - u[1]) * f64::from(1.0 + self.b) - f64::from(self.b)) as f32;
        let r = (1.0 - z * z).clamp(0.0, 1.0).sqrt();
        let m_std = self.i_std + Vec3A::new(r * cos, r * sin, z);
        let m = normalize_or(Vec3A::new(m_std.x * self.alpha, m_std.y * self.alpha, m_std.z), Vec3A::Z);
        m * (2.0 * self.i.dot(m)) - self.i
    }

    /// The density of a direction over solid angle: D/(2(k·i_z + t)).
    #[inline]
    fn density(&self, o: Vec3A) -> f32 {
        let m = normalize_or(self.i + o, Vec3A::Z);
        ggx_distribution(Vec3A::Z, m, self.alpha) / self.scale
    }
}
