//! Chooses the parts of a picture that a sheet shows enlarged: those in which two methods differ most. Maps of the
//! change between methods go in and squares come out.

use super::canvas::Rect;

/// The number of regions on a sheet.
pub const COUNT: usize = 3;

/// The possible sides of a region, pixels. All of them divide a sheet's cell. The largest one is used that is at most a
/// quarter of the picture's shorter side.
const SIDES: [usize; 7] = [64, 48, 32, 24, 16, 12, 8];

/// A square in the left eye's picture.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Region {
    /// The index of the map in which it was found.
    pub step: usize,
    pub rect: Rect,
}

/// The side of the regions of a picture. `None`: the picture is too small for any.
pub fn side(width: usize, height: usize) -> Option<usize> {
    SIDES.into_iter().find(|s| 4 * s <= width.min(height))
}

/// The number of pixels that stay free at each border and between two regions.
pub fn margin(side: usize) -> usize {
    side / 8
}

/// Chooses up to [`COUNT`] squares in which the mean of a map is farthest from zero, in either direction. The maps take
/// turns, beginning with the last, and each finds its best square among those that are still free. The result is in the
/// order of the maps, then from top to bottom.
pub fn choose(maps: &[Vec<f32>], width: usize, height: usize, side: usize) -> Vec<Region> {
    let sums: Vec<Sums> = maps.iter().map(|map| Sums::of(map, width)).collect();
    let mut found: Vec<Region> = Vec::new();
    for step in (0..maps.len()).rev().cycle().take(if maps.is_empty() { 0 } else { COUNT }) {
        let best = squares(width, height, side)
            .filter(|rect| found.iter().all(|f| apart(*rect, f.rect, margin(side))))
            .map(|rect| (sums[step].within(rect).abs(), rect))
            // Of equal squares the first is kept.
            .fold(None, |best: Option<(f64, Rect)>, new| match best {
                Some(b) if b.0 >= new.0 => Some(b),
                _ => Some(new),
            });
        found.extend(best.filter(|(change, _)| *change > 0.0).map(|(_, rect)| Region { step, rect }));
    }
    found.sort_by_key(|r| (r.step, r.rect.y, r.rect.x));
    found
}

fn squares(width: usize, height: usize, side: usize) -> impl Iterator<Item = Rect> {
    let margin = margin(side);
    let (right, bottom) = (width.saturating_sub(side + margin), height.saturating_sub(side + margin));
    (margin..=bottom).flat_map(move |y| (margin..=right).map(move |x| Rect { x, y, width: side, height: side }))
}

fn apart(a: Rect, b: Rect, gap: usize) -> bool {
    let clear = |from: usize, size: usize, other: usize| from + size + gap <= other;
    clear(a.x, a.width, b.x) || clear(b.x, b.width, a.x) || clear(a.y, a.height, b.y) || clear(b.y, b.height, a.y)
}

/// The sums of a map over everything to the left of and above each pixel (Crow 1984), which give the sum over any
/// rectangle.
struct Sums {
    stride: usize,
    values: Vec<f64>,
}

impl Sums {
    fn of(map: &[f32], width: usize) -> Sums {
        let stride = width + 1;
        let mut values = vec![0.0; stride];
        for (y, row) in map.chunks_exact(width).enumerate() {
            let mut along = 0.0;
            values.push(0.0);
            for (x, value) in row.iter().enumerate() {
                along += f64::from(*value);
                values.push(values[y * stride + x + 1] + along);
            }
        }
        Sums { stride, values }
    }

    fn within(&self, r: Rect) -> f64 {
        let at = |x: usize, y: usize| self.values[y * self.stride + x];
        at(r.x + r.width, r.y + r.height) - at(r.x, r.y + r.height) - at(r.x + r.width, r.y) + at(r.x, r.y)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SIZE: (usize, usize) = (64, 40);

    /// A map that is zero except in squares of side 8 at (x, y), which have this value.
    fn map(squares: &[(usize, usize, f32)]) -> Vec<f32> {
        let inside = |i: usize, x: usize, y: usize| (x..x + 8).contains(&(i % 64)) && (y..y + 8).contains(&(i / 64));
        (0..64 * 40).map(|i| squares.iter().filter(|s| inside(i, s.0, s.1)).map(|s| s.2).sum()).collect()
    }

    #[test]
    fn every_step_has_its_own_region() {
        let maps = [map(&[(5, 7, 1.0), (40, 20, 9.0)]), map(&[(40, 20, -2.0)]), map(&[(20, 10, 0.5)])];
        let found = choose(&maps, SIZE.0, SIZE.1, 8);
        let corners: Vec<_> = found.iter().map(|r| (r.step, r.rect.x, r.rect.y)).collect();
        assert_eq!(corners, [(0, 5, 7), (1, 40, 20), (2, 20, 10)], "the third found its place taken");
    }

    #[test]
    fn one_step_has_three_regions_that_keep_apart_and_off_the_border() {
        let found = choose(&[map(&[(0, 0, 3.0), (1, 2, 1.0), (30, 10, 2.0), (50, 25, -1.0)])], SIZE.0, SIZE.1, 8);
        assert_eq!(found.len(), 3);
        for (i, a) in found.iter().enumerate() {
            assert!(a.rect.x >= 1 && a.rect.y >= 1 && a.rect.x + 8 < 64 && a.rect.y + 8 < 40, "{a:?}");
            assert!(found[..i].iter().all(|b| apart(a.rect, b.rect, 1)), "{found:?}");
        }
        assert_eq!(choose(&[map(&[])], SIZE.0, SIZE.1, 8), [], "nothing changes");
        assert_eq!(choose(&[], SIZE.0, SIZE.1, 8), []);
        assert_eq!([side(64, 36), side(480, 270), side(1920, 1080), side(20, 20)], [Some(8), Some(64), Some(64), None]);
    }
}
