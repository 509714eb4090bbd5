//! Twin of `shaders/common/random.glsl`: the same numbers to the bit. What depends only on the pixel and the purpose is hashed
//! once for all samples of a [`Sequence`], and the second Sobol dimension is looked up in a table.

/// Purpose of the random rotation of the rays to a light's rim.
pub const DRAW_RIM: u32 = 5;
/// The numbers that choose a point on the disc of light i have the purpose `DRAW_LIGHT` + i.
pub const DRAW_LIGHT: u32 = 16;

#[inline]
fn mix_bits(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

#[inline]
pub fn combine(seed: u32, x: u32) -> u32 {
    mix_bits(seed.wrapping_mul(0x9e37_79b9).wrapping_add(x).wrapping_add(0x85eb_ca6b))
}

/// An Owen scramble of bit-reversed x.
#[inline]
fn laine_karras(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul(seed >> 16 | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// What each byte of an index contributes to the bit reversal of the second Sobol dimension, which is linear over GF(2).
static SECOND_REVERSED: [[u32; 256]; 4] = second_reversed();

const fn second_reversed() -> [[u32; 256]; 4] {
    let mut table = [[0; 256]; 4];
    let mut place = 0;
    while place < 4 {
        let mut byte = 0;
        while byte < 256 {
            table[place][byte] = sobol_second((byte as u32) << (8 * place)).reverse_bits();
            byte += 1;
        }
        place += 1;
    }
    table
}

const fn sobol_second(mut index: u32) -> u32 {
    let (mut v, mut result) = (1u32 << 31, 0);
    while index != 0 {
        if index & 1 != 0 {
            result ^= v;
        }
        index >>= 1;
        v ^= v >> 1;
    }
    result
}

/// A number in [0, 1) from the upper 24 bits.
#[inline]
fn unit_float(x: u32) -> f32 {
    (x >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// `draw_1d`: a number in [0, 1) of a pixel's sample for one purpose.
pub fn draw_1d(seed: u32, token: u32, pixel: [u32; 2], index: u32, purpose: u32) -> f32 {
    let h = combine(combine(combine(combine(0, seed), token), pixel[0]), pixel[1]);
    unit_float(combine(combine(h, purpose), index))
}

/// The points of a pixel: `sample_2d` for every index.
#[derive(Debug, Clone, Copy)]
pub struct Sequence {
    order: u32,
    first: u32,
    second: u32,
}

impl Sequence {
    /// `token` is the eye's stream.
    pub fn new(seed: u32, token: u32, pixel: [u32; 2]) -> Sequence {
        let order = combine(combine(combine(combine(0, seed), token), pixel[0]), pixel[1]);
        Sequence { order, first: combine(order, 1), second: combine(order, 2) }
    }

    /// The points for one purpose, as `draw_2d`.
    pub fn of_purpose(seed: u32, purpose: u32, token: u32, pixel: [u32; 2]) -> Sequence {
        Sequence::new(combine(seed, purpose), token, pixel)
    }

    /// Two numbers in [0, 1).
    #[inline]
    pub fn sample(&self, index: u32) -> [f32; 2] {
        let shuffled = laine_karras(index.reverse_bits(), self.order).reverse_bits();
        let [a, b, c, d] = shuffled.to_le_bytes().map(usize::from);
        let [ta, tb, tc, td] = &SECOND_REVERSED;
        let second = ta[a] ^ tb[b] ^ tc[c] ^ td[d];
        // The first dimension is the bit reversal of the index, which the scramble reverses again.
        let x = laine_karras(shuffled, self.first).reverse_bits();
        let y = laine_karras(second, self.second).reverse_bits();
        [unit_float(x), unit_float(y)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// `owen` and `sample_2d` as the shader writes them.
    fn sample_2d(seed: u32, token: u32, pixel: [u32; 2], index: u32) -> [f32; 2] {
        let owen = |x: u32, seed| laine_karras(x.reverse_bits(), seed).reverse_bits();
        let h = combine(combine(combine(combine(0, seed), token), pixel[0]), pixel[1]);
        let shuffled = owen(index, h);
        let x = owen(shuffled.reverse_bits(), combine(h, 1));
        let y = owen(sobol_second(shuffled), combine(h, 2));
        [unit_float(x), unit_float(y)]
    }

    #[test]
    fn a_sequence_holds_the_points_of_the_shader() {
        for (seed, token, pixel) in [(1, 0, [0, 0]), (1_000_001, 1, [639, 359]), (u32::MAX, 1, [16_383, 7])] {
            let sequence = Sequence::new(seed, token, pixel);
            for index in [0, 1, 2, 3, 63, 1000, 65_535, u32::MAX] {
                assert_eq!(sequence.sample(index), sample_2d(seed, token, pixel, index));
            }
        }
    }

    #[test]
    fn sixty_four_points_are_stratified() {
        // A (0, 2)-sequence in base 2: one point in every cell of an 8×8 grid, whatever the scramble.
        let sequence = Sequence::new(3, 1, [20, 30]);
        let mut cells = [false; 64];
        for index in 0..64 {
            let [x, y] = sequence.sample(index);
            cells[(x * 8.0) as usize + 8 * (y * 8.0) as usize] = true;
        }
        assert!(cells.iter().all(|c| *c));
    }
}
