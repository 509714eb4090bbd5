//! An axis of a drawing: it maps values to pixels and says where the ticks are. The drawings of `plot` and `ao` call
//! it.

use cyclopean_analysis::svg;

/// How values are spread along an axis.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Scale {
    Logarithmic,
    Linear,
}

/// An axis that maps the values `low` to `high` to the pixels `from` to `to`.
pub struct Axis {
    scale: Scale,
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    /// A logarithmic axis that holds all values with a little room at both ends. Its end is at least twice its
    /// beginning. `None` where a value is not above 0, or where there are none.
    pub fn around(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Option<Axis> {
        let (low, high) = values.fold((f64::INFINITY, 0.0f64), |(l, h), v| (l.min(v), h.max(v)));
        if !(low > 0.0 && high.is_finite() && low <= high) {
            return None;
        }
        let air = (high / low).powf(0.08).max((2.0 / (high / low)).max(1.0).sqrt()).max(1.1);
        Some(Axis { scale: Scale::Logarithmic, low: low / air, high: high * air, from, to })
    }

    /// A linear axis from 0 to a little above the largest value. `None` where no value is above 0.
    pub fn from_zero(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Option<Axis> {
        let high = values.fold(0.0f64, f64::max);
        (high > 0.0 && high.is_finite()).then_some(Axis { scale: Scale::Linear, low: 0.0, high: 1.08 * high, from, to })
    }

    pub fn at(&self, value: f64) -> f64 {
        let share = match self.scale {
            Scale::Logarithmic => (value / self.low).ln() / (self.high / self.low).ln(),
            Scale::Linear => (value - self.low) / (self.high - self.low),
        };
        self.from + share * (self.to - self.from)
    }

    pub fn holds(&self, value: f64) -> bool {
        (self.low..=self.high).contains(&value)
    }

    /// The ticks, at round values. A logarithmic axis has them at powers of ten, and at multiples of these where it is
    /// shorter than three decades. A linear axis has steps of 1, 2 or 5 times a power of ten and at most nine ticks.
    pub fn ticks(&self) -> Vec<f64> {
        if self.scale == Scale::Linear {
            return svg::ticks(self.low, self.high, 8.0);
        }
        let decades = (self.high / self.low).log10();
        let steps: &[f64] = match decades {
            d if d < 0.7 => &[1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0],
            d if d < 3.0 => &[1.0, 2.0, 5.0],
            _ => &[1.0],
        };
        let first = self.low.log10().floor() as i32;
        let last = self.high.log10().ceil() as i32;
        let all = (first..=last).flat_map(|e| steps.iter().map(move |s| s * 10f64.powi(e)));
        all.filter(|t| self.holds(*t)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_few_and_round() {
        let axis = |low, high| Axis { scale: Scale::Logarithmic, low, high, from: 0.0, to: 100.0 };
        assert_eq!(axis(0.8, 30.0).ticks(), [1.0, 2.0, 5.0, 10.0, 20.0]);
        assert_eq!(axis(1e-6, 2e-1).ticks().len(), 6);
        assert!(axis(3.1, 9.0).ticks().len() >= 3);
        assert_eq!(axis(1.0, 100.0).at(10.0), 50.0);
        assert!(Axis::around([5.0].into_iter(), 0.0, 1.0).expect("one value").ticks().len() > 1);
        assert!(Axis::around([0.0].into_iter(), 0.0, 1.0).is_none());
        assert!(Axis::around(std::iter::empty(), 0.0, 1.0).is_none());
    }

    #[test]
    fn a_linear_axis_begins_at_zero() {
        let axis = Axis::from_zero([0.0, 1.3].into_iter(), 200.0, 100.0).expect("a value above 0");
        assert_eq!((axis.at(0.0), axis.ticks().len()), (200.0, 8));
        assert!((axis.at(1.3) - (200.0 - 100.0 / 1.08)).abs() < 1e-9);
        assert!(Axis::from_zero([0.0].into_iter(), 0.0, 1.0).is_none());
        let ticks = Axis::from_zero([4.0].into_iter(), 0.0, 1.0).expect("a value above 0").ticks();
        assert_eq!(ticks, [0.0, 1.0, 2.0, 3.0, 4.0]);
    }
}
