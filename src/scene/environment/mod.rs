//! Light from infinity: a radiance map, and what shading needs of it. Everything is computed once, when the scene
//! loader makes the environment.

pub mod file;
mod prefilter;
pub mod sky;

use glam::{Vec2, Vec3};

use super::{Environment, Equirect};

/// The largest radiance that is kept: the largest value of a 16-bit float.
pub const MOST_RADIANCE: f32 = 65504.0;

impl Environment {
    /// Makes an environment from its radiance map. Values that are not finite become 0; all others are clamped to
    /// 0–65504.
    pub fn from_radiance(mut radiance: Equirect) -> Environment {
        for c in radiance.texels.iter_mut().flatten() {
            *c = if c.is_nan() { 0.0 } else { c.clamp(0.0, MOST_RADIANCE) };
        }
        let irradiance = prefilter::irradiance(&radiance);
        let specular = prefilter::specular(&radiance);
        Environment { radiance, irradiance, specular }
    }

    /// An environment that has the same radiance in every direction.
    pub fn constant(radiance: [f32; 3]) -> Environment {
        Environment::from_radiance(Equirect { width: 8, height: 4, texels: vec![radiance; 32] })
    }
}

impl Equirect {
    /// A map whose texels are `radiance` of the unit direction through their centres.
    pub fn from_fn(width: u32, height: u32, mut radiance: impl FnMut(Vec3) -> Vec3) -> Equirect {
        let mut texels = Vec::with_capacity((width * height) as usize);
        for y in 0..height {
            for x in 0..width {
                texels.push(radiance(Equirect::direction_at(x, y, width, height)).to_array());
            }
        }
        Equirect { width, height, texels }
    }

    /// The unit direction through the centre of a texel.
    pub fn direction(&self, x: u32, y: u32) -> Vec3 {
        Equirect::direction_at(x, y, self.width, self.height)
    }

    fn direction_at(x: u32, y: u32, width: u32, height: u32) -> Vec3 {
        let azimuth = ((x as f32 + 0.5) / width as f32 - 0.5) * std::f32::consts::TAU;
        let polar = (y as f32 + 0.5) / height as f32 * std::f32::consts::PI;
        Vec3::new(polar.sin() * azimuth.sin(), polar.cos(), -polar.sin() * azimuth.cos())
    }

    /// u and v in 0–1 of a unit direction; see [`Environment::radiance`] for the mapping.
    pub fn uv(direction: Vec3) -> Vec2 {
        let u = direction.x.atan2(-direction.z) / std::f32::consts::TAU + 0.5;
        Vec2::new(u, direction.y.clamp(-1.0, 1.0).acos() / std::f32::consts::PI)
    }

    /// Bilinear lookup, which wraps around horizontally and is clamped at the poles.
    pub fn sample(&self, direction: Vec3) -> Vec3 {
        let uv = Equirect::uv(direction);
        let (x, y) = (uv.x * self.width as f32 - 0.5, uv.y * self.height as f32 - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let (fx, fy) = (x - x0, y - y0);
        let column = |i: i64| i.rem_euclid(i64::from(self.width)) as usize;
        let row = |j: i64| j.clamp(0, i64::from(self.height) - 1) as usize * self.width as usize;
        let (left, right) = (column(x0 as i64), column(x0 as i64 + 1));
        let (top, bottom) = (row(y0 as i64), row(y0 as i64 + 1));
        let at = |i: usize| Vec3::from_array(self.texels[i]);
        let upper = at(top + left) * (1.0 - fx) + at(top + right) * fx;
        let lower = at(bottom + left) * (1.0 - fx) + at(bottom + right) * fx;
        upper * (1.0 - fy) + lower * fy
    }

    /// The exact solid angle of a texel of row `y`, steradian.
    pub fn solid_angle(&self, y: u32) -> f32 {
        let edge = |y: u32| (f64::from(y) / f64::from(self.height) * std::f64::consts::PI).cos();
        ((edge(y) - edge(y + 1)) * std::f64::consts::TAU / f64::from(self.width)) as f32
    }

    /// A smaller map: each texel is the mean, weighted by solid angle, of what it covers. A map that is no larger than
    /// what is asked for is returned as it is.
    pub fn downsample(&self, width: u32, height: u32) -> Equirect {
        if width >= self.width || height >= self.height {
            return self.clone();
        }
        let columns = overlaps(self.width, width);
        let rows = overlaps(self.height, height);
        let mut texels = Vec::with_capacity((width * height) as usize);
        for row in &rows {
            for column in &columns {
                let (mut sum, mut total) = (Vec3::ZERO, 0.0f32);
                for (y, part_y) in row {
                    let band = self.solid_angle(*y) * part_y;
                    for (x, part_x) in column {
                        sum += Vec3::from_array(self.texels[(y * self.width + x) as usize]) * (band * part_x);
                        total += band * part_x;
                    }
                }
                texels.push((sum / total).to_array());
            }
        }
        Equirect { width, height, texels }
    }

    /// The map turned about +Y: what was at azimuth a is then at a + `radians`, counted from −Z towards +X.
    pub fn rotated(&self, radians: f64) -> Equirect {
        let shift = radians / std::f64::consts::TAU * f64::from(self.width);
        let whole = shift.floor();
        let part = (shift - whole) as f32;
        let width = i64::from(self.width);
        let mut texels = Vec::with_capacity(self.texels.len());
        for row in self.texels.chunks_exact(self.width as usize) {
            for x in 0..width {
                let near = Vec3::from_array(row[(x - whole as i64).rem_euclid(width) as usize]);
                let far = Vec3::from_array(row[(x - whole as i64 - 1).rem_euclid(width) as usize]);
                texels.push((near * (1.0 - part) + far * part).to_array());
            }
        }
        Equirect { width: self.width, height: self.height, texels }
    }
}

/// For each of `to` cells along an axis: which of the `from` cells it covers, and how much of each.
fn overlaps(from: u32, to: u32) -> Vec<Vec<(u32, f32)>> {
    let scale = f64::from(from) / f64::from(to);
    (0..to)
        .map(|cell| {
            let (low, high) = (f64::from(cell) * scale, f64::from(cell + 1) * scale);
            (low.floor() as u32..(high.ceil() as u32).min(from))
                .map(|i| (i, (high.min(f64::from(i) + 1.0) - low.max(f64::from(i))) as f32))
                .filter(|(_, part)| *part > 0.0)
                .collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mapping_is_the_documented_one() {
        assert!((Equirect::uv(Vec3::NEG_Z) - Vec2::new(0.5, 0.5)).length() < 1e-6);
        assert!((Equirect::uv(Vec3::X) - Vec2::new(0.75, 0.5)).length() < 1e-6);
        assert!(Equirect::uv(Vec3::Y).y < 1e-6);
        let map = Equirect::from_fn(16, 8, |d| d);
        for (x, y) in [(0, 0), (5, 3), (15, 7)] {
            let d = map.direction(x, y);
            assert!((map.sample(d) - d).length() < 1e-5);
        }
    }

    #[test]
    fn solid_angles_add_up_and_averages_keep_the_power() {
        let map = Equirect::from_fn(60, 30, |d| Vec3::new(1.0, d.y.max(0.0), d.x * d.x));
        let power = |m: &Equirect| -> Vec3 {
            (0..m.height)
                .flat_map(|y| (0..m.width).map(move |x| (x, y)))
                .map(|(x, y)| Vec3::from_array(m.texels[(y * m.width + x) as usize]) * m.solid_angle(y))
                .sum()
        };
        assert!((power(&map).x - 4.0 * std::f32::consts::PI).abs() < 1e-3);
        let small = map.downsample(16, 8);
        assert_eq!((small.width, small.height), (16, 8));
        // A row that is cut weighs a little differently than its exact solid angle.
        assert!((power(&small) - power(&map)).length() < 2e-2 * power(&map).length());
    }

    #[test]
    fn rotation_moves_the_front_to_the_right() {
        let map = Equirect::from_fn(64, 32, |d| Vec3::splat((-d.z).max(0.0)));
        let turned = map.rotated(std::f64::consts::FRAC_PI_2);
        assert!((turned.sample(Vec3::X) - map.sample(Vec3::NEG_Z)).length() < 1e-5);
    }
}
