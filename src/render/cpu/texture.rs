//! Twin of `sample_texture` in `shaders/common/hit_surface.glsl`: level 0, bilinear or nearest, from the scene's own bytes.

use glam::{Vec2, Vec4};

use crate::scene::{Texture, Wrap};

/// Tables of the values of a byte: linear, and decoded from sRGB.
pub struct Decoding {
    linear: [f32; 256],
    srgb: [f32; 256],
}

impl Decoding {
    pub fn new() -> Decoding {
        let linear: [f32; 256] = std::array::from_fn(|i| i as f32 / 255.0);
        let srgb = linear.map(|c| if c <= 0.04045 { c / 12.92 } else { ((c + 0.055) / 1.055).powf(2.4) });
        Decoding { linear, srgb }
    }

    #[inline]
    fn texel(&self, t: &Texture, x: i32, y: i32) -> Vec4 {
        let x = wrap(x, t.width as i32, t.wrap_u);
        let y = wrap(y, t.height as i32, t.wrap_v);
        let first = 4 * (y as usize * t.width as usize + x as usize);
        let &[r, g, b, a] = t.rgba8[first..].first_chunk().expect("four bytes a texel");
        let color = if t.srgb { &self.srgb } else { &self.linear };
        let at = |b: u8| color[usize::from(b)];
        Vec4::new(at(r), at(g), at(b), self.linear[usize::from(a)])
    }

    pub fn sample(&self, t: &Texture, uv: Vec2) -> Vec4 {
        // The clamp is there because a float far outside the first period has no fraction left.
        let p = uv.clamp(Vec2::splat(-1e4), Vec2::splat(1e4)) * Vec2::new(t.width as f32, t.height as f32);
        if t.nearest {
            return self.texel(t, p.x.floor() as i32, p.y.floor() as i32);
        }
        let p = p - 0.5;
        let base = p.floor();
        let f = p - base;
        let (x, y) = (base.x as i32, base.y as i32);
        let row = |y| mix(self.texel(t, x, y), self.texel(t, x + 1, y), f.x);
        mix(row(y), row(y + 1), f.y)
    }
}

#[inline]
fn mix(a: Vec4, b: Vec4, t: f32) -> Vec4 {
    a * (1.0 - t) + b * t
}

#[inline]
fn wrap(i: i32, n: i32, mode: Wrap) -> i32 {
    match mode {
        Wrap::Clamp => i.clamp(0, n - 1),
        Wrap::Repeat if (0..n).contains(&i) => i,
        Wrap::Repeat => i.rem_euclid(n),
        Wrap::Mirror => {
            let k = i.rem_euclid(2 * n);
            if k < n { k } else { 2 * n - 1 - k }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn coordinates_wrap_as_their_mode_says() {
        let at = |mode| (-3..6).map(|i| wrap(i, 3, mode)).collect::<Vec<_>>();
        assert_eq!(at(Wrap::Repeat), [0, 1, 2, 0, 1, 2, 0, 1, 2]);
        assert_eq!(at(Wrap::Mirror), [2, 1, 0, 0, 1, 2, 2, 1, 0]);
        assert_eq!(at(Wrap::Clamp), [0, 0, 0, 0, 1, 2, 2, 2, 2]);
    }
}
