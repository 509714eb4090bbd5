//! The G-buffer, read back for the metrics (`Prepared::geometry`). Decodes what `shaders/common/surface.glsl` packs.

use glam::Vec3;

use super::framing::Framing;

/// One eye's pixels, row by row from the top. Where nothing was drawn depth is 0, and the pixel's other values have no meaning.
#[derive(Debug, Clone, Default)]
pub struct EyeGeometry {
    /// Whether the pixel traces a reflection ray.
    pub traced: Vec<bool>,
    /// Raw depth: near plane / distance along the view's axis.
    pub depth: Vec<f32>,
    /// Index into the scene's instances, plus one; 0: nothing was drawn.
    pub instance: Vec<u32>,
    /// Shading normal, world space, unit length.
    pub normal: Vec<Vec3>,
    /// The triangle's normal on the viewer's side, world space, unit length.
    pub face_normal: Vec<Vec3>,
    /// Perceptual.
    pub roughness: Vec<f32>,
    /// 1 / distance from the pixel to what it reflects, 1/m, averaged with the lobe's weights; 0: the sky. Only the reference
    /// has it: −1 where it is unknown, and everywhere for other methods.
    pub inverse_hit_distance: Vec<f32>,
}

/// Both eyes, in layer order.
#[derive(Debug, Clone, Default)]
pub struct Geometry {
    pub eyes: [EyeGeometry; 2],
}

impl Geometry {
    /// Decodes the bytes of the images of depth, surface and instance id, and of the reference's mean, which has inverse
    /// distances in its alpha.
    pub(super) fn decode(
        [depth, surface, instance]: [&[u8]; 3],
        reflection: Option<&[u8]>,
        ray_roughness_limit: f32,
    ) -> Geometry {
        let half = depth.len() / 8;
        let eyes = [0, 1].map(|eye| {
            let mut out = EyeGeometry::default();
            for i in eye * half..(eye + 1) * half {
                let [normal, face_normal, low, high] = [0, 1, 2, 3].map(|k| word(surface, 4 * i + k));
                let roughness = (low >> 24 | (high >> 24) << 8) as f32 * (1.0 / 65535.0);
                let depth = f32::from_bits(word(depth, i));
                let traced = depth > 0.0 && roughness <= ray_roughness_limit;
                out.traced.push(traced);
                out.depth.push(depth);
                out.instance.push(word(instance, i));
                out.normal.push(direction(normal));
                out.face_normal.push(direction(face_normal));
                out.roughness.push(roughness);
                let known = reflection.filter(|_| traced);
                out.inverse_hit_distance.push(known.map_or(-1.0, |r| f32::from_bits(word(r, 4 * i + 3))));
            }
            out
        });
        Geometry { eyes }
    }

    /// Without the guard band.
    pub(super) fn cropped(self, framing: &Framing) -> Geometry {
        let eyes = self.eyes.map(|e| EyeGeometry {
            traced: framing.crop(&e.traced),
            depth: framing.crop(&e.depth),
            instance: framing.crop(&e.instance),
            normal: framing.crop(&e.normal),
            face_normal: framing.crop(&e.face_normal),
            roughness: framing.crop(&e.roughness),
            inverse_hit_distance: framing.crop(&e.inverse_hit_distance),
        });
        Geometry { eyes }
    }
}

fn word(bytes: &[u8], index: usize) -> u32 {
    bytemuck::pod_read_unaligned(&bytes[4 * index..4 * index + 4])
}

/// `unpack_direction` of `math.glsl`: an octahedral unit vector in 2×16 bits, signed and normalised.
fn direction(packed: u32) -> Vec3 {
    let unit = |bits: u16| (f32::from(bits as i16) / 32767.0).max(-1.0);
    let (x, y) = (unit(packed as u16), unit((packed >> 16) as u16));
    let z = 1.0 - x.abs() - y.abs();
    let fold = (-z).max(0.0);
    let toward_axis = |v: f32| if v >= 0.0 { v - fold } else { v + fold };
    Vec3::new(toward_axis(x), toward_axis(y), z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn directions_are_unfolded() {
        let pack = |x: f32, y: f32| {
            let bits = |v: f32| u32::from((v * 32767.0).round() as i16 as u16);
            bits(x) | bits(y) << 16
        };
        for (packed, expected) in [
            (pack(0.0, 0.0), Vec3::Z),
            (pack(1.0, 0.0), Vec3::X),
            (pack(0.0, -1.0), Vec3::NEG_Y),
            (pack(1.0, 1.0), Vec3::NEG_Z),
            (pack(0.5, 0.5), Vec3::new(1.0, 1.0, 0.0).normalize()),
        ] {
            assert!(direction(packed).distance(expected) < 1e-4, "{packed:#x}: {}", direction(packed));
        }
    }
}
