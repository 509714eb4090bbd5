//! A page of 8-bit sRGB pixels that sheets are drawn on, and pictures brought to another size.

/// An 8-bit sRGB colour.
pub type Color = [u8; 3];

/// RGB bytes, rows from the top. What is drawn outside the page is ignored.
#[derive(Debug, Clone)]
pub struct Canvas {
    pub width: u32,
    pub height: u32,
    pub rgb: Vec<u8>,
}

/// A rectangle by its upper left corner and its size, pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Rect {
    pub x: usize,
    pub y: usize,
    pub width: usize,
    pub height: usize,
}

impl Rect {
    /// The rectangle with `by` more pixels on each side.
    pub fn grown(self, by: usize) -> Rect {
        let (x, y) = (self.x.saturating_sub(by), self.y.saturating_sub(by));
        Rect { x, y, width: self.width + 2 * by, height: self.height + 2 * by }
    }
}

impl Canvas {
    pub fn new(width: usize, height: usize, ground: Color) -> Canvas {
        Canvas { width: width as u32, height: height as u32, rgb: ground.repeat(width * height) }
    }

    /// Blends `color` over a pixel with this coverage, 0 to 1.
    pub fn blend(&mut self, x: usize, y: usize, color: Color, coverage: f32) {
        if x < self.width as usize && y < self.height as usize {
            let at = 3 * (y * self.width as usize + x);
            for (old, new) in self.rgb[at..at + 3].iter_mut().zip(color) {
                *old = (f32::from(*old) + (f32::from(new) - f32::from(*old)) * coverage).round() as u8;
            }
        }
    }

    pub fn fill(&mut self, rect: Rect, color: Color) {
        for y in rect.y..rect.y + rect.height {
            for x in rect.x..rect.x + rect.width {
                self.blend(x, y, color, 1.0);
            }
        }
    }

    /// Draws a frame of this thickness around the rectangle, outside of it.
    pub fn frame(&mut self, rect: Rect, thickness: usize, color: Color) {
        let outer = rect.grown(thickness);
        let (wide, tall) = (Rect { height: thickness, ..outer }, Rect { width: thickness, ..outer });
        for side in [wide, Rect { y: rect.y + rect.height, ..wide }, tall, Rect { x: rect.x + rect.width, ..tall }] {
            self.fill(side, color);
        }
    }

    /// Draws `pixels`, of which `width` make a row. Each becomes `zoom`×`zoom` pixels large.
    pub fn picture(&mut self, (x, y): (usize, usize), pixels: &[Color], width: usize, zoom: usize) {
        for (i, color) in pixels.iter().enumerate() {
            let (px, py) = (x + i % width * zoom, y + i / width * zoom);
            self.fill(Rect { x: px, y: py, width: zoom, height: zoom }, *color);
        }
    }
}

/// An sRGB colour in [0, 1] as bytes.
pub fn bytes(color: [f32; 3]) -> Color {
    color.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8)
}

/// Brings a picture to another size. Each new pixel is the mean of what it covers in the old picture.
pub fn resized<const N: usize>(
    pixels: &[[f32; N]],
    (width, height): (usize, usize),
    (to_width, to_height): (usize, usize),
) -> Vec<[f32; N]> {
    let columns: Vec<_> = (0..to_width).map(|x| covered(x, width, to_width)).collect();
    let mut out = Vec::with_capacity(to_width * to_height);
    for y in 0..to_height {
        let rows = covered(y, height, to_height);
        for columns in &columns {
            let (mut sum, mut weight) = ([0.0; N], 0.0);
            for &(sy, wy) in &rows {
                for &(sx, wx) in columns {
                    let w = wx * wy;
                    weight += w;
                    sum.iter_mut().zip(pixels[sy * width + sx]).for_each(|(s, p)| *s += w * p);
                }
            }
            out.push(sum.map(|s| s / weight));
        }
    }
    out
}

/// The old pixels that the new pixel `i` covers along an axis, each with the length of it that is covered.
fn covered(i: usize, from: usize, to: usize) -> Vec<(usize, f32)> {
    let (start, end) = (i * from, (i + 1) * from);
    let overlap = |s: usize| ((s + 1) * to).min(end) - (s * to).max(start);
    (start / to..end.div_ceil(to)).map(|s| (s, overlap(s) as f32 / to as f32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_picture_keeps_its_mean_in_every_size() {
        let picture: Vec<[f32; 1]> = (0..12).map(|i| [i as f32]).collect();
        for to in [(2, 1), (4, 3), (3, 2), (9, 7)] {
            let out = resized(&picture, (4, 3), to);
            let mean = out.iter().map(|p| p[0]).sum::<f32>() / out.len() as f32;
            assert!((mean - 5.5).abs() < 1e-4, "{to:?}: {mean}");
        }
        assert_eq!(resized(&picture, (4, 3), (4, 3)), picture);
    }

    #[test]
    fn a_frame_leaves_what_it_frames() {
        let mut canvas = Canvas::new(6, 5, [255; 3]);
        let rect = Rect { x: 2, y: 2, width: 2, height: 1 };
        canvas.frame(rect, 1, [0; 3]);
        let dark: Vec<usize> = (0..30).filter(|i| canvas.rgb[3 * i] == 0).collect();
        assert_eq!(dark, [7, 8, 9, 10, 13, 16, 19, 20, 21, 22]);
    }
}
