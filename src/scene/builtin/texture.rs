//! Textures that are made by code: images, their PNG files, normal maps, and the tangents that fit the normal maps.

use std::io::Cursor;
use std::sync::LazyLock;

use glam::{Vec2, Vec3};
use image::ImageEncoder;

use super::shape::Shape;

/// A square RGB image. Its texels are computed only when its file is made, so that counting a scene's parts costs
/// nothing.
pub struct Image {
    size: u32,
    texel: Box<dyn Fn(f32, f32) -> [u8; 3] + Send + Sync>,
}

impl Image {
    /// A colour map. `color(u, v)` is in linear light and is stored as sRGB.
    pub fn color(size: u32, color: impl Fn(f32, f32) -> Vec3 + Send + Sync + 'static) -> Image {
        let texel = move |u, v| color(u, v).to_array().map(|c| CURVE[(c.clamp(0.0, 1.0) * 4095.0) as usize]);
        Image { size, texel: Box::new(texel) }
    }

    /// A map whose green channel is the roughness factor. The blue channel, the metallic factor, is 1: the material
    /// decides.
    pub fn roughness(size: u32, roughness: impl Fn(f32, f32) -> f32 + Send + Sync + 'static) -> Image {
        Image { size, texel: Box::new(move |u, v| [255, byte(roughness(u, v)), 255]) }
    }

    /// The normal map of a height field. `height` is in units of the tile's side. The map is seamless where `height`
    /// is.
    pub fn normals(size: u32, height: impl Fn(f32, f32) -> f32 + Send + Sync + 'static) -> Image {
        let step = 1.0 / size as f32;
        let wrap = |x: f32| x - x.floor();
        let texel = move |u: f32, v: f32| {
            let du = (height(wrap(u + step), v) - height(wrap(u - step), v)) / (2.0 * step);
            let dv = (height(u, wrap(v + step)) - height(u, wrap(v - step))) / (2.0 * step);
            // v grows downwards in the image, and the green axis points upwards.
            let n = Vec3::new(-du, dv, 1.0).normalize();
            (n * 0.5 + 0.5).to_array().map(byte)
        };
        Image { size, texel: Box::new(texel) }
    }

    /// The image as a PNG file.
    pub fn to_png(&self) -> Result<Vec<u8>, String> {
        use image::codecs::png::{CompressionType, FilterType, PngEncoder};
        let mut rgb = Vec::with_capacity((self.size * self.size * 3) as usize);
        for y in 0..self.size {
            for x in 0..self.size {
                rgb.extend((self.texel)((x as f32 + 0.5) / self.size as f32, (y as f32 + 0.5) / self.size as f32));
            }
        }
        let mut out = Cursor::new(Vec::new());
        PngEncoder::new_with_quality(&mut out, CompressionType::Fast, FilterType::Sub)
            .write_image(&rgb, self.size, self.size, image::ExtendedColorType::Rgb8)
            .map_err(|error| format!("a texture could not be encoded: {error}"))?;
        Ok(out.into_inner())
    }
}

/// The sRGB curve, sampled finely enough that no byte is skipped in dark colours.
static CURVE: LazyLock<Vec<u8>> = LazyLock::new(|| (0..4096).map(|i| encode(i as f32 / 4095.0)).collect());

fn byte(x: f32) -> u8 {
    (x.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
}

fn encode(linear: f32) -> u8 {
    let x = f64::from(linear);
    byte(if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * libm::pow(x, 1.0 / 2.4) - 0.055 } as f32)
}

/// Tangents (x, y, z, sign) for a shape's UVs. A vertex has the mean of its triangles' tangents, made orthogonal to its
/// normal.
pub fn tangents(shape: &Shape) -> Vec<f32> {
    let mut along = vec![(Vec3::ZERO, Vec3::ZERO); shape.positions.len()];
    for t in shape.indices.chunks_exact(3) {
        let [a, b, c] = [t[0], t[1], t[2]].map(|i| i as usize);
        let (p, q) = (shape.positions[b] - shape.positions[a], shape.positions[c] - shape.positions[a]);
        let (s, r): (Vec2, Vec2) = (shape.uvs[b] - shape.uvs[a], shape.uvs[c] - shape.uvs[a]);
        let area = s.perp_dot(r);
        if area == 0.0 {
            continue;
        }
        let (du, dv) = ((p * r.y - q * s.y) * area.signum(), (q * s.x - p * r.x) * area.signum());
        for i in [a, b, c] {
            along[i].0 += du;
            along[i].1 += dv;
        }
    }
    let mut out = Vec::with_capacity(along.len() * 4);
    for ((du, dv), n) in along.into_iter().zip(&shape.normals) {
        let flat = du - *n * n.dot(du);
        let t = flat.try_normalize().unwrap_or_else(|| n.any_orthonormal_vector());
        // The bitangent points up in the image, against v.
        out.extend([t.x, t.y, t.z, if n.cross(t).dot(dv) > 0.0 { -1.0 } else { 1.0 }]);
    }
    out
}
