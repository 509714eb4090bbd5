//! Twin of `shaders/common/surface.glsl`: a surface, and the precision with which the G-buffer stores it.

use glam::Vec3A;

use super::math::{round, through_octahedral, unpack_direction, unpack_unorm};

#[derive(Debug, Clone, Copy)]
pub struct Surface {
    /// Shading normal, bent to the viewer's side.
    pub normal: Vec3A,
    /// Normal of the triangle, on the viewer's side.
    pub face_normal: Vec3A,
    /// Albedo of the diffuse part, linear.
    pub albedo: Vec3A,
    /// Reflectance at normal incidence, linear.
    pub f0: Vec3A,
    /// Perceptual.
    pub roughness: f32,
}

impl Surface {
    /// `unpack_surface`: from the four words of a G-buffer's texel.
    pub fn unpack(words: [u32; 4]) -> Surface {
        let square = |word: u32| {
            let [r, g, b, _] = unpack_unorm(word);
            Vec3A::new(r * r, g * g, b * b)
        };
        Surface {
            normal: unpack_direction(words[0]),
            face_normal: unpack_direction(words[1]),
            albedo: square(words[2]),
            f0: square(words[3]),
            roughness: (words[2] >> 24 | (words[3] >> 24) << 8) as f32 * (1.0 / 65535.0),
        }
    }

    /// Rounds to the G-buffer's precision, as `unpack_surface(pack_surface(…))`, so that the reference sees the same surface as
    /// the screen-space methods.
    #[inline]
    pub fn through_gbuffer(self) -> Surface {
        Surface {
            normal: through_octahedral(self.normal),
            face_normal: through_octahedral(self.face_normal),
            albedo: through_square_root(self.albedo),
            f0: through_square_root(self.f0),
            roughness: (self.roughness.clamp(0.0, 1.0) * 65535.0 + 0.5).floor() * (1.0 / 65535.0),
        }
    }
}

/// Rounds a colour as the G-buffer does, which stores its square root in eight bits.
#[inline]
fn through_square_root(c: Vec3A) -> Vec3A {
    let root = |x: f32| {
        let x = round(x.clamp(0.0, 1.0).sqrt() * 255.0) / 255.0;
        x * x
    };
    Vec3A::new(root(c.x), root(c.y), root(c.z))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_keeps_what_its_precision_holds() {
        let n = Vec3A::new(0.3, -0.5, -0.8).normalize();
        let s = Surface {
            normal: n,
            face_normal: -n,
            albedo: Vec3A::new(0.2, 0.5, 1.0),
            f0: Vec3A::splat(0.04),
            roughness: 0.37,
        };
        let once = s.through_gbuffer();
        assert!(once.normal.distance(n) < 1e-4 && once.face_normal.distance(-n) < 1e-4);
        assert!((once.albedo - s.albedo).abs().max_element() < 5e-3 && (once.roughness - 0.37).abs() < 1e-5);
        // Nothing more is lost the second time.
        let twice = once.through_gbuffer();
        assert_eq!((once.albedo, once.f0, once.roughness), (twice.albedo, twice.f0, twice.roughness));
        assert!(once.normal.distance(twice.normal) < 1e-6);
    }
}
