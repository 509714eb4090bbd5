//! How far a reference is from its limit, in one number.

use glam::Vec3;

/// The least luminance by which an error is divided, as a share of the reflecting pixels' mean luminance.
const DARK: f64 = 0.01;

/// The relative error of [`super::Prepared::set_until`] over pixels given as mean and standard error of linear RGB. The
/// iterator is made twice. 0 where nothing reflects.
pub fn relative_error<I: Iterator<Item = (Vec3, Vec3)>>(pixels: impl Fn() -> I) -> f64 {
    let luminance = |c: Vec3| f64::from(c.dot(Vec3::new(0.2126, 0.7152, 0.0722)));
    let (sum, count) = pixels().fold((0.0, 0u64), |(sum, n), (mean, _)| (sum + luminance(mean), n + 1));
    let dark = (DARK * sum / count.max(1) as f64).max(f64::MIN_POSITIVE);
    pixels().map(|(mean, error)| luminance(error) / luminance(mean).max(dark)).sum::<f64>() / count.max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_relative_error_is_of_luminance_and_bounded_in_the_dark() {
        let pixels = [(Vec3::splat(2.0), Vec3::splat(0.1)), (Vec3::ZERO, Vec3::splat(0.001))];
        let error = relative_error(|| pixels.into_iter());
        // 5 %, and 0.001 over 1 % of the mean 1.
        assert!((error - (0.05 + 0.1) / 2.0).abs() < 1e-6, "{error}");
        assert_eq!(relative_error(std::iter::empty), 0.0);
    }
}
