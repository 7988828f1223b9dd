//! An axis: what it spans, where its ticks are and what they say.

use std::ops::Range;

use vibrochain_maps::scene::Values;

/// Fewer ticks than this tell little of a logarithmic axis.
const FEW: usize = 4;

/// Decades that `tick` writes as plain numbers.
const WRITTEN_OUT: Range<f64> = -3.0..6.0;

/// What lies along an axis.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Scale {
    /// Numbers.
    Numbers,
    /// Decimal logarithms of numbers.
    Powers,
    /// Decimal logarithms, with ticks at whole decades alone.
    Decades,
    /// Decimal logarithms of moduli, with ticks at round numbers and marks between them.
    Moduli,
    /// Places 0, 1, … of a list of values.
    List(Vec<f64>),
}

impl Scale {
    /// Where a number lies along a vertical axis.
    pub(crate) fn place(&self, number: f64) -> f64 {
        match self {
            Self::Decades | Self::Moduli => number.log10(),
            Self::Numbers | Self::Powers | Self::List(_) => number,
        }
    }
}

/// The least and the largest modulus that an axis shows: next to a grazing impact multipliers grow without bound, and such ends leave the picture.
const MODULI: [f64; 2] = [1e-2, 1e2];

/// An axis of moduli reaches this far from 1 in any case, so that rounding does not look like growth.
const LEAST: f64 = 1.01;

/// Air beyond the moduli, as a part of the axis.
const AIR: f64 = 0.07;

/// An axis from one end to the other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Axis {
    pub(crate) range: Range<f64>,
    pub(crate) scale: Scale,
}

impl Axis {
    pub(crate) fn numbers(range: Range<f64>) -> Self {
        Self { range, scale: Scale::Numbers }
    }

    /// Of a sweep, over what a picture spans of it.
    pub(crate) fn swept(values: &Values, range: Range<f64>) -> Self {
        let scale = match values {
            Values::Linear { .. } => Scale::Numbers,
            Values::Logarithmic { .. } => Scale::Powers,
            Values::List(values) => Scale::List(values.clone()),
        };
        Self { range, scale }
    }

    /// The decades that hold all of these logarithms with a little air, at least two.
    pub(crate) fn decades(logarithms: impl Iterator<Item = f64>) -> Self {
        let (low, high) = logarithms.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
        if low > high {
            return Self { range: -2.0..0.0, scale: Scale::Decades };
        }
        let low = (low - 0.1).floor();
        Self { range: low..(high + 0.1).ceil().max(low + 2.0), scale: Scale::Decades }
    }

    /// The axis that holds these moduli of multipliers, and 1: one logarithmic scale for all pictures of them.
    pub(crate) fn moduli(values: impl Iterator<Item = f64>) -> Self {
        let [least, largest] = MODULI.map(f64::log10);
        let places = values.filter(|modulus| *modulus > 0.0 && modulus.is_finite()).map(f64::log10);
        let near = LEAST.log10();
        let (low, high) = places
            .map(|place| place.clamp(least, largest))
            .fold((-near, near), |(low, high), place| (low.min(place), high.max(place)));
        let air = AIR * (high - low);
        Self { range: low - air..high + air, scale: Scale::Moduli }
    }

    /// The part of the axis that lies below a place.
    pub(crate) fn part(&self, place: f64) -> f64 {
        (place - self.range.start) / (self.range.end - self.range.start)
    }

    /// At most about so many ticks: their places, and what they say.
    pub(crate) fn ticks(&self, most: usize) -> Vec<(f64, String)> {
        let Range { start, end } = self.range;
        match &self.scale {
            Scale::Numbers => {
                let places = round_numbers(start, end, most);
                let digits = places.windows(2).next().map_or(6, |pair| digits(pair[1] - pair[0]));
                places.into_iter().map(|place| (place, tick_in(place, digits))).collect()
            }
            Scale::Powers => {
                let places = logarithms(start, end, most);
                // 10⁻⁴ beside 0.001 would be two ways to say one thing.
                let is_whole = |place: &f64| *place == place.round();
                let far = places.iter().any(|place| !WRITTEN_OUT.contains(place)) && places.iter().all(is_whole);
                let words = if far { power_of_ten } else { power_tick };
                places.into_iter().map(|place| (place, words(place))).collect()
            }
            Scale::Decades => {
                let stride = (((end - start) / most.max(1) as f64).ceil() as i32).max(1);
                let inside = (start.ceil() as i32)..=(end.floor() as i32);
                let whole = inside.filter(|decade| decade.rem_euclid(stride) == 0).map(f64::from);
                whole.map(|decade| (decade, power_of_ten(decade))).collect()
            }
            Scale::Moduli => {
                let places = logarithms(start, end, most).into_iter();
                places.map(|place| (place, tick(10f64.powf(place)))).collect()
            }
            Scale::List(values) => {
                let stride = values.len().div_ceil(most.max(1)).max(1);
                let places = values.iter().enumerate().step_by(stride);
                let inside = |place: &(f64, String)| place.0 >= start && place.0 <= end;
                places.map(|(i, value)| (i as f64, tick(*value))).filter(inside).collect()
            }
        }
    }
}

impl Axis {
    /// Places of marks without words between so many ticks: steps of a logarithmic axis are not alike, and without them it is read as a linear one.
    pub(crate) fn marks(&self, most: usize) -> Vec<f64> {
        if self.scale != Scale::Moduli {
            return Vec::new();
        }
        let Range { start, end } = self.range;
        let decades = (start.floor() as i32)..=(end.ceil() as i32);
        let all: Vec<f64> = if end - start > 1.0 {
            decades.flat_map(|decade| (1..10).map(move |times| f64::from(decade) + f64::from(times).log10())).collect()
        } else {
            round_numbers(10f64.powf(start), 10f64.powf(end), 5 * most).into_iter().map(f64::log10).collect()
        };
        let ticks = logarithms(start, end, most);
        let is_between =
            |place: &f64| (start..=end).contains(place) && ticks.iter().all(|tick| (tick - place).abs() > 1e-9);
        all.into_iter().filter(is_between).collect()
    }
}

/// An axis of moduli in numbers: its ends, its ticks with their words, and the marks between them.
pub type ModulusAxis = ([f64; 2], Vec<(f64, String)>, Vec<f64>);

/// The axis that pictures have which show these moduli, with at most about so many ticks.
///
/// ```
/// let (ends, ticks, marks) = vibrochain_plot::modulus_axis([0.699, 0.97], 8);
/// assert!(ends[0] < 0.699 && ends[1] > 1.0);
/// assert_eq!(ticks.iter().map(|(_, words)| words.as_str()).collect::<Vec<_>>(), ["0.7", "0.75", "0.8", "0.85", "0.9", "0.95", "1"]);
/// assert!(marks.len() > 10);
/// ```
#[must_use]
pub fn modulus_axis(moduli: impl IntoIterator<Item = f64>, most: usize) -> ModulusAxis {
    let axis = Axis::moduli(moduli.into_iter());
    let number = |place: f64| 10f64.powf(place);
    let ticks = axis.ticks(most).into_iter().map(|(place, words)| (number(place), words)).collect();
    ([axis.range.start, axis.range.end].map(number), ticks, axis.marks(most).into_iter().map(number).collect())
}

/// At most about so many numbers between the ends, in steps of 1, 2 or 5 times a power of ten.
pub(crate) fn round_numbers(start: f64, end: f64, most: usize) -> Vec<f64> {
    let (low, high) = (start.min(end), start.max(end));
    let length = high - low;
    if !(length.is_finite() && length > 0.0) {
        return if low.is_finite() { vec![low] } else { Vec::new() };
    }
    let least = length / most.max(1) as f64;
    let decade = 10f64.powf(least.log10().floor());
    // Seven of them are less than the length of a range that has seven of the next.
    let step = [1.0, 2.0, 5.0, 10.0].map(|times| times * decade).into_iter().find(|step| *step >= least * (1.0 - 1e-9));
    let step = step.unwrap_or(10.0 * decade);
    let air = 1e-9 * length;
    let (first, last) = (((low - air) / step).ceil(), ((high + air) / step).floor());
    // By division where the step is a fraction: 3/10 is closer to 0.3 than 3·0.1.
    let inverse = 1.0 / step;
    let number = |k: f64| if step < 1.0 { k / inverse.round() } else { k * step };
    let exact = step >= 1.0 || (inverse - inverse.round()).abs() < 1e-6 * inverse;
    let count = (last - first).clamp(0.0, 1e4) as usize;
    if last < first {
        return Vec::new();
    }
    (0..=count).map(|i| first + i as f64).map(|k| if exact { number(k) } else { k * step }).collect()
}

/// The logarithms of round numbers between two logarithms: powers of ten, these with 2 and 5 times as much, or, over less than that,
/// equal steps.
fn logarithms(start: f64, end: f64, most: usize) -> Vec<f64> {
    let inside = |place: &f64| *place >= start - 1e-9 && *place <= end + 1e-9;
    let decades = || (start.floor() as i32 - 1)..=(end.ceil() as i32);
    let powers: Vec<f64> = decades().map(f64::from).filter(inside).collect();
    if powers.len() >= FEW {
        let stride = powers.len().div_ceil(most.max(1)) as i32;
        return powers.into_iter().filter(|power| *power as i32 % stride == 0).collect();
    }
    let steps = |decade: i32| [1.0, 2.0, 5.0].map(|times: f64| f64::from(decade) + times.log10());
    let steps: Vec<f64> = decades().flat_map(steps).filter(inside).collect();
    if steps.len() >= FEW && steps.len() <= most {
        return steps;
    }
    if steps.len() > most {
        return powers;
    }
    let numbers = round_numbers(10f64.powf(start), 10f64.powf(end), most);
    numbers.into_iter().filter(|number| *number > 0.0).map(f64::log10).filter(inside).collect()
}

/// Where the first value of a swept axis lies on the picture, and the distance of neighbours: their logarithms where the ratio is
/// constant, their numbers in a list.
pub(crate) fn places(values: &Values) -> (f64, f64) {
    let part = |from: f64, to: f64, points: usize| (from, (to - from) / (points - 1) as f64);
    match values {
        Values::Linear { from, to, points } => part(*from, *to, *points),
        Values::Logarithmic { from, to, points } => part(from.log10(), to.log10(), *points),
        Values::List(_) => (0.0, 1.0),
    }
}

/// Whether equal steps along a swept axis are equal ratios.
pub(crate) fn is_logarithmic(values: &Values) -> bool {
    matches!(values, Values::Logarithmic { .. })
}

/// Where a value of a swept axis lies on panels of curves: its logarithm where equal steps are equal ratios.
pub fn place(values: &Values, value: f64) -> f64 {
    if is_logarithmic(values) { value.log10() } else { value }
}

/// What the first `points` values of a swept axis span, with so many steps of air at either end.
pub(crate) fn spanned(values: &Values, points: usize, air: f64) -> Range<f64> {
    let (from, step) = places(values);
    from - air * step..from - air * step + step * (points as f64 - 1.0 + 2.0 * air)
}

/// Digits behind the point that tell multiples of a step apart.
fn digits(step: f64) -> usize {
    (-step.abs().log10().floor()).clamp(0.0, 15.0) as usize
}

/// The tick at a decimal logarithm: three digits, between decades no more is of use.
pub(crate) fn power_tick(place: f64) -> String {
    let value = 10f64.powf(place);
    tick(format!("{value:.2e}").parse().unwrap_or(value))
}

/// A tick in as few digits as it needs; values that are 0 up to rounding are 0.
pub(crate) fn tick(value: f64) -> String {
    tick_in(value, 6)
}

/// The same with at least six digits behind the point, and more where a step needs them.
fn tick_in(value: f64, digits: usize) -> String {
    let rounded = format!("{value:.0$}", digits.max(6));
    let trimmed = if rounded.contains('.') { rounded.trim_end_matches('0').trim_end_matches('.') } else { &rounded };
    if value != 0.0 && value.abs() < 1e-3 && trimmed.trim_start_matches('-') != "0" || value.abs() >= 1e6 {
        // Rounded to the digits of its step, or its own noise would show.
        let short = trimmed.parse().unwrap_or(value);
        scientific(short)
    } else if trimmed == "-0" {
        "0".to_owned()
    } else {
        trimmed.replace('-', "−")
    }
}

/// "2·10⁻⁵".
fn scientific(value: f64) -> String {
    let text = format!("{value:e}");
    let Some((number, exponent)) = text.split_once('e') else { return text };
    let power = power_of_ten(exponent.parse().unwrap_or(0.0));
    match number {
        "1" => power,
        "-1" => format!("−{power}"),
        _ => format!("{}·{power}", number.replace('-', "−")),
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
    if digits == "1" {
        return "10".to_owned();
    }
    "10".chars().chain(digits.chars().map(raised)).collect()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use vibrochain_maps::scene::Scene;

    use super::*;

    #[test]
    fn logarithmic_axes_have_ticks_at_round_numbers() {
        for (from, to, expected) in [
            (1e-3, 10.0, vec![1e-3, 1e-2, 0.1, 1.0, 10.0]),
            (1e-12, 1e3, vec![1e-12, 1e-10, 1e-8, 1e-6, 1e-4, 1e-2, 1.0, 1e2]),
            (0.02, 0.9, vec![0.02, 0.05, 0.1, 0.2, 0.5]),
            (0.6, 3.0, vec![1.0, 1.5, 2.0, 2.5, 3.0]),
        ] {
            let axis = Axis { range: f64::log10(from)..f64::log10(to), scale: Scale::Powers };
            let ticks: Vec<f64> = axis.ticks(8).into_iter().map(|(place, _)| 10f64.powf(place)).collect();
            let same = |(a, b): (&f64, &f64)| (a / b - 1.0).abs() < 1e-9;
            assert!(ticks.len() == expected.len() && ticks.iter().zip(&expected).all(same), "{ticks:?} {expected:?}");
        }
    }

    #[test]
    fn decades_of_an_axis_are_written_in_one_way() {
        let words = |from: f64, to: f64| {
            let axis = Axis { range: from..to, scale: Scale::Powers };
            axis.ticks(8).into_iter().map(|tick| tick.1).collect::<Vec<_>>()
        };
        assert_eq!(words(-3.0, 0.0), ["0.001", "0.01", "0.1", "1"]);
        assert_eq!(words(-4.0, 0.0), ["10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "1"]);
        assert_eq!(words(3.0, 6.0), ["10³", "10⁴", "10⁵", "10⁶"]);
    }

    #[test]
    fn round_numbers_are_as_many_as_there_is_room_for() {
        assert_eq!(round_numbers(0.4, 3.0, 8), [0.5, 1.0, 1.5, 2.0, 2.5, 3.0]);
        assert_eq!(round_numbers(0.0, 1.0, 10), [0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0]);
        assert_eq!(round_numbers(-0.6, 1.4, 5), [-0.5, 0.0, 0.5, 1.0]);
        assert_eq!(round_numbers(1.0, 1.0, 5), [1.0]);
        let mut seen = 0;
        for k in 0..2000 {
            let (low, length) = (f64::from(k % 37) * 0.31 - 5.0, 10f64.powf(f64::from(k % 61) / 4.0 - 7.0));
            for most in 2..12 {
                let ticks = round_numbers(low, low + length, most);
                assert!(ticks.len() <= most + 1, "{low} {length} {most} {ticks:?}");
                assert!(ticks.len() * 5 + 5 >= most * 2, "{low} {length} {most} {ticks:?}");
                assert!(ticks.iter().all(|t| *t >= low - 1e-8 * length && *t <= low + length * (1.0 + 1e-8)));
                seen += ticks.len();
            }
        }
        assert!(seen > 50_000);
    }

    #[test]
    fn neighbouring_ticks_say_different_things() {
        let axis = Axis::numbers(0.123_456_7..0.123_456_9);
        let words: Vec<String> = axis.ticks(5).into_iter().map(|tick| tick.1).collect();
        assert!(words.len() > 2 && words.windows(2).all(|pair| pair[0] != pair[1]), "{words:?}");
        let small = Axis::numbers(0.0..3e-5).ticks(4);
        assert_eq!(small.iter().map(|tick| tick.1.as_str()).collect::<Vec<_>>(), ["0", "10⁻⁵", "2·10⁻⁵", "3·10⁻⁵"]);
        assert_eq!([-0.25, 2.5e6, -1e-4, 1e-17].map(tick), ["−0.25", "2.5·10⁶", "−10⁻⁴", "0"]);
    }

    #[test]
    fn ticks_stand_where_the_values_are() {
        let text = "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
                    x = { parameter = \"omega\", from = 0.01, to = 100, points = 5, spacing = \"log\" }\n\
                    y = { parameter = \"gamma2\", values = [0.3, 0, 0.125] }\n[compute]\nfamilies = [\"double-sided\"]\n";
        let scene = Scene::parse(Path::new("scene.toml"), text).unwrap();
        let [x, y] = scene.plane().unwrap();
        assert_eq!(places(&x.values), (-2.0, 1.0));
        assert_eq!([-2.0, -0.5, 0.0, 2.0].map(power_tick), ["0.01", "0.316", "1", "100"]);
        let list = Axis::swept(&y.values, -0.5..2.5).ticks(8);
        assert_eq!(list, [(0.0, "0.3".to_owned()), (1.0, "0".to_owned()), (2.0, "0.125".to_owned())]);
        assert_eq!(Axis::swept(&x.values, -2.0..2.0).ticks(8).len(), 5);
    }

    #[test]
    fn decades_hold_all_values_and_ticks_are_whole() {
        let decades = Axis::decades([-15.3, -2.05].into_iter());
        assert_eq!(decades.range, -16.0..-1.0);
        let places = |axis: &Axis, most| axis.ticks(most).into_iter().map(|tick| tick.0).collect::<Vec<_>>();
        assert_eq!(places(&decades, 10), [-16.0, -14.0, -12.0, -10.0, -8.0, -6.0, -4.0, -2.0]);
        assert_eq!(decades.part(-8.5), 0.5);
        assert_eq!(places(&Axis::decades([-3.0].into_iter()), 3), [-4.0, -3.0, -2.0]);
        assert_eq!(Axis::decades(std::iter::empty()).range, -2.0..0.0);
    }

    #[test]
    fn moduli_lie_by_their_logarithms_and_marks_tell_so() {
        let axis = |moduli: &[f64]| Axis::moduli(moduli.iter().copied());
        let words = |axis: &Axis, most| axis.ticks(most).into_iter().map(|tick| tick.1).collect::<Vec<_>>();
        assert_eq!(words(&axis(&[0.2, 30.0]), 10), ["0.2", "0.5", "1", "2", "5", "10", "20"]);
        assert_eq!(words(&axis(&[0.5, 5e4]), 10), ["0.5", "1", "2", "5", "10", "20", "50", "100"]);
        assert_eq!(words(&axis(&[1.0, 1.0 + 1e-9]), 10), ["0.99", "0.995", "1", "1.005", "1.01"]);
        let mut checked = 0;
        for moduli in [&[0.699, 0.97][..], &[0.2, 30.0], &[1e-9, 0.0, 1e9], &[1.003], &[], &[f64::NAN, 4.0]] {
            let axis = axis(moduli);
            let (low, high) = (axis.range.start, axis.range.end);
            assert!(low < 0.0 && high > 0.0 && low >= -3.5 && high <= 3.5, "{moduli:?} {axis:?}");
            let shown = moduli.iter().filter(|modulus| (1e-2..=1e2).contains(*modulus));
            assert!(shown.into_iter().all(|modulus| (low..=high).contains(&modulus.log10())), "{moduli:?}");
            for most in [3, 5, 10] {
                let (ticks, marks) = (axis.ticks(most), axis.marks(most));
                assert!((2..=most + 1).contains(&ticks.len()), "{moduli:?} {most} {ticks:?}");
                // What a tick says is where it is.
                for (place, words) in &ticks {
                    let number: f64 = words.parse().unwrap();
                    assert!((number.log10() - place).abs() < 1e-6, "{words} {place}");
                    checked += 1;
                }
                assert!(marks.len() > ticks.len() / 2 && marks.iter().all(|place| (low..=high).contains(place)));
            }
        }
        assert!(checked > 50);
    }

    #[test]
    fn exponents_are_raised() {
        assert_eq!([-16.0, -3.0, 0.0, 2.0, 1.0].map(power_of_ten), ["10⁻¹⁶", "10⁻³", "1", "10²", "10"]);
    }
}
