//! What shading needs of an environment map: irradiance for each normal, and radiance blurred by GGX for each
//! roughness. Called when an environment is made.

use std::thread;

use glam::Vec3;

use crate::scene::Equirect;

const IRRADIANCE_SIZE: (u32, u32) = (32, 16);
/// Size of the map that irradiance is computed from. A cosine lobe does not show any finer detail.
const IRRADIANCE_SOURCE: (u32, u32) = (128, 64);
const SPECULAR_SIZE: (u32, u32) = (128, 64);
const SPECULAR_LEVELS: u32 = 8;
/// Size of the map that the blurred levels are computed from. The sharpest blurred level (r = 1/7) resolves about a
/// degree, so the source need not be finer.
const SPECULAR_SOURCE: (u32, u32) = (512, 256);
const SAMPLES: u32 = 64;

/// Irradiance / π: the cosine-weighted mean over a coarse map. The weights are normalised, so that a constant map stays
/// constant.
pub fn irradiance(radiance: &Equirect) -> Equirect {
    let source = radiance.downsample(IRRADIANCE_SOURCE.0, IRRADIANCE_SOURCE.1);
    let lights: Vec<(Vec3, f32, Vec3)> = (0..source.height)
        .flat_map(|y| (0..source.width).map(move |x| (x, y)))
        .map(|(x, y)| {
            let texel = source.texels[(y * source.width + x) as usize];
            (source.direction(x, y), source.solid_angle(y), Vec3::from_array(texel))
        })
        .collect();
    parallel(IRRADIANCE_SIZE, |normal| {
        let (mut sum, mut total) = (Vec3::ZERO, 0.0f32);
        for (direction, solid_angle, radiance) in &lights {
            let weight = normal.dot(*direction).max(0.0) * solid_angle;
            sum += *radiance * weight;
            total += weight;
        }
        sum / total
    })
}

/// Level i of n is the radiance blurred by the GGX lobe of roughness i/(n−1), seen head-on (view = normal).
///
/// Importance-sampled half vectors, each looked up in the mip whose texels match its share of the
/// lobe (filtered importance sampling, Křivánek & Colbert 2008), so that 64 samples are smooth.
pub fn specular(radiance: &Equirect) -> Vec<Equirect> {
    let mips = mips(radiance);
    let (width, height) = SPECULAR_SIZE;
    let mut levels = vec![if radiance.width > width {
        radiance.downsample(width, height)
    } else {
        Equirect::from_fn(width, height, |d| radiance.sample(d))
    }];
    for level in 1..SPECULAR_LEVELS {
        let lobe = lobe(level as f32 / (SPECULAR_LEVELS - 1) as f32, &mips[0]);
        levels.push(parallel(SPECULAR_SIZE, |normal| {
            let (tangent, bitangent) = normal.any_orthonormal_pair();
            let (mut sum, mut total) = (Vec3::ZERO, 0.0f32);
            for sample in &lobe {
                let l = sample.direction;
                let direction = tangent * l.x + bitangent * l.y + normal * l.z;
                sum += trilinear(&mips, sample.mip, direction) * l.z;
                total += l.z;
            }
            sum / total
        }));
    }
    levels
}

/// A direction about +Z, and the mip level to read it from.
struct LobeSample {
    direction: Vec3,
    mip: f32,
}

fn lobe(roughness: f32, finest: &Equirect) -> Vec<LobeSample> {
    let alpha2 = roughness.powi(4);
    let texel = 4.0 * std::f32::consts::PI / (finest.width * finest.height) as f32;
    (0..SAMPLES)
        .filter_map(|i| {
            // Hammersley points: i/n and the radical inverse of i.
            let (u, v) = ((i as f32 + 0.5) / SAMPLES as f32, i.reverse_bits() as f32 / 4_294_967_296.0);
            let cos2 = (1.0 - u) / (1.0 + (alpha2 - 1.0) * u);
            let (cos, sin) = (cos2.sqrt(), (1.0 - cos2).max(0.0).sqrt());
            let phi = std::f32::consts::TAU * v;
            let half = Vec3::new(sin * phi.cos(), sin * phi.sin(), cos);
            let direction = half * (2.0 * cos) - Vec3::Z;
            // D, the GGX distribution, in its numerically stable form. With view = normal the density of the direction
            // is D/4.
            let denominator = cos2 * alpha2 + sin * sin;
            let density = alpha2 / (std::f32::consts::PI * denominator * denominator) / 4.0;
            let share = 1.0 / (SAMPLES as f32 * density.max(1e-6));
            (direction.z > 0.0).then(|| LobeSample { direction, mip: (0.5 * (share / texel).log2() + 1.0).max(0.0) })
        })
        .collect()
}

fn mips(radiance: &Equirect) -> Vec<Equirect> {
    let mut mips = vec![radiance.downsample(SPECULAR_SOURCE.0, SPECULAR_SOURCE.1)];
    while let Some(last) = mips.last().filter(|m| m.width > 4 && m.height > 2) {
        let next = last.downsample(last.width / 2, last.height / 2);
        mips.push(next);
    }
    mips
}

fn trilinear(mips: &[Equirect], level: f32, direction: Vec3) -> Vec3 {
    let level = level.min((mips.len() - 1) as f32);
    let (low, part) = (level.floor() as usize, level.fract());
    let fine = mips[low].sample(direction);
    if part < 0.02 || low + 1 >= mips.len() {
        return fine;
    }
    fine.lerp(mips[low + 1].sample(direction), part)
}

/// Evaluates `value` in the direction of every texel. The rows are shared out among the machine's threads.
fn parallel(size: (u32, u32), value: impl Fn(Vec3) -> Vec3 + Sync) -> Equirect {
    let (width, height) = size;
    let mut texels = vec![[0.0f32; 3]; (width * height) as usize];
    let map = Equirect { width, height, texels: Vec::new() };
    let threads = thread::available_parallelism().map_or(1, |n| n.get()).min(height as usize);
    let rows = height.div_ceil(threads as u32) as usize;
    thread::scope(|scope| {
        for (part, chunk) in texels.chunks_mut(rows * width as usize).enumerate() {
            let (map, value) = (&map, &value);
            scope.spawn(move || {
                for (i, texel) in chunk.iter_mut().enumerate() {
                    let (x, y) = (i as u32 % width, (part * rows) as u32 + i as u32 / width);
                    *texel = value(map.direction(x, y)).to_array();
                }
            });
        }
    });
    Equirect { texels, ..map }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_stays_constant() {
        let map = Equirect { width: 64, height: 32, texels: vec![[0.25, 1.0, 4.0]; 64 * 32] };
        for level in specular(&map).iter().chain([&irradiance(&map)]) {
            for t in &level.texels {
                assert!(
                    (Vec3::from_array(*t) / Vec3::new(0.25, 1.0, 4.0) - Vec3::ONE).abs().max_element() < 1e-4,
                    "{t:?}"
                );
            }
        }
    }

    #[test]
    fn irradiance_of_a_cosine_sky() {
        // L = max(d.y, 0): E/π is 2/3 upwards, 0 downwards, and 2/(3π) for a horizontal normal.
        let map = Equirect::from_fn(256, 128, |d| Vec3::splat(d.y.max(0.0)));
        let e = irradiance(&map);
        assert!((e.sample(Vec3::Y).x - 2.0 / 3.0).abs() < 5e-3, "{}", e.sample(Vec3::Y).x);
        assert!(e.sample(Vec3::NEG_Y).x < 5e-3);
        let side = e.sample(Vec3::X).x;
        assert!((side - 2.0 / (3.0 * std::f32::consts::PI)).abs() < 5e-3, "{side}");
    }

    #[test]
    fn blur_grows_with_roughness_and_keeps_the_mean() {
        let map = Equirect::from_fn(512, 256, |d| Vec3::splat(if d.y > 0.98 { 50.0 } else { 0.1 }));
        let levels = specular(&map);
        let peaks: Vec<f32> = levels.iter().map(|l| l.sample(Vec3::Y).x).collect();
        assert!(peaks.windows(2).all(|p| p[1] <= p[0] * 1.05), "{peaks:?}");
        let mean = |m: &Equirect| -> f32 {
            (0..m.height)
                .map(|y| (0..m.width).map(|x| m.texels[(y * m.width + x) as usize][0]).sum::<f32>() * m.solid_angle(y))
                .sum()
        };
        for level in &levels[..4] {
            assert!((mean(level) / mean(&map) - 1.0).abs() < 0.08, "{}", mean(level) / mean(&map));
        }
    }
}
