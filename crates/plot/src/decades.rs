//! A logarithmic axis: drawn over decimal logarithms, with ticks at whole decades alone.

use std::ops::Range;

use plotters::coord::ranged1d::{KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};

/// More decades than this have a tick at every second (third …) one.
const MANY: i32 = 10;

/// Whole decades from 10^low to 10^high; positions on the axis are decimal logarithms.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Decades {
    low: i32,
    high: i32,
}

impl Decades {
    /// The decades that hold all of these logarithms with a little air, at least two.
    pub fn holding(logarithms: impl Iterator<Item = f64>) -> Self {
        let (low, high) = logarithms.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        if low > high {
            return Self { low: -2, high: 0 };
        }
        let (low, high) = ((low - 0.1).floor() as i32, (high + 0.1).ceil() as i32);
        Self { low, high: high.max(low + 2) }
    }

    /// From one to another; at least one.
    pub fn between(low: i32, high: i32) -> Self {
        Self { low, high: high.max(low + 1) }
    }

    /// One more at the lower end.
    pub fn with_one_below(self) -> Self {
        Self { low: self.low - 1, ..self }
    }

    /// The logarithm at the lower end.
    pub fn low(self) -> f64 {
        f64::from(self.low)
    }
}

impl Ranged for Decades {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, (from, to): (i32, i32)) -> i32 {
        let part = (value - f64::from(self.low)) / f64::from(self.high - self.low);
        from + (part * f64::from(to - from)).round() as i32
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        if hint.weight().allow_light_points() {
            return Vec::new();
        }
        // At least 1: the axis has a decade or more.
        let stride = (self.high - self.low + MANY - 1) / MANY;
        (self.low..=self.high).filter(|decade| decade % stride == 0).map(f64::from).collect()
    }

    fn range(&self) -> Range<f64> {
        f64::from(self.low)..f64::from(self.high)
    }
}

impl ValueFormatter<f64> for Decades {
    fn format(value: &f64) -> String {
        power_of_ten(*value)
    }
}

/// 10 to a whole power, with a raised exponent.
pub fn power_of_ten(exponent: f64) -> String {
    let raised = |digit: char| match digit {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        // ⁰ and ⁴ … ⁹ follow each other in Unicode; ¹, ² and ³ are older.
        digit => digit.to_digit(10).and_then(|value| char::from_u32(0x2070 + value)).unwrap_or(digit),
    };
    let digits = format!("{exponent:.0}");
    if digits == "0" || digits == "-0" {
        return "1".to_owned();
    }
    "10".chars().chain(digits.chars().map(raised)).collect()
}

#[cfg(test)]
mod tests {
    use plotters::coord::ranged1d::BoldPoints;

    use super::*;

    #[test]
    fn decades_hold_all_values_and_ticks_are_whole() {
        let decades = Decades::holding([-15.3, -2.05].into_iter());
        assert_eq!(decades, Decades { low: -16, high: -1 });
        assert_eq!(decades.key_points(BoldPoints(3)), [-16.0, -14.0, -12.0, -10.0, -8.0, -6.0, -4.0, -2.0]);
        assert_eq!((decades.map(&-16.0, (0, 300)), decades.map(&-8.5, (300, 0))), (0, 150));
        assert_eq!(Decades::holding([-3.0].into_iter()).key_points(BoldPoints(3)), [-4.0, -3.0, -2.0]);
        assert_eq!(Decades::holding(std::iter::empty()).with_one_below().range(), -3.0..0.0);
    }

    #[test]
    fn exponents_are_raised() {
        assert_eq!([-16.0, -3.0, 0.0, 2.0, 1.0].map(power_of_ten), ["10⁻¹⁶", "10⁻³", "1", "10²", "10¹"]);
    }
}
