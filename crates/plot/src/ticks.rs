//! An axis over places: numbers as they are, or their decimal logarithms with ticks at round numbers.

use std::ops::Range;

use plotters::coord::ranged1d::{BoldPoints, KeyPointHint, NoDefaultFormatting, Ranged, ValueFormatter};
use plotters::coord::types::RangedCoordf64;
use vibrochain_maps::scene::{Axis, Values};

/// Fewer ticks than this tell little of a logarithmic axis.
const FEW: usize = 4;

/// Places from one end to the other.
#[derive(Clone)]
pub(crate) struct Places {
    places: RangedCoordf64,
    range: Range<f64>,
    logarithmic: bool,
}

impl Places {
    pub(crate) fn new(range: Range<f64>, logarithmic: bool) -> Self {
        Self { places: range.clone().into(), range, logarithmic }
    }

    /// The logarithms of round numbers between the ends, so many at most: powers of ten, these with 2 and 5 times as much, or, over
    /// less than that, equal steps.
    fn round(&self, most: usize) -> Vec<f64> {
        let Range { start, end } = self.range;
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
        let numbers = RangedCoordf64::from(10f64.powf(start)..10f64.powf(end)).key_points(BoldPoints(most));
        numbers.into_iter().filter(|number| *number > 0.0).map(f64::log10).filter(inside).collect()
    }
}

impl Ranged for Places {
    type FormatOption = NoDefaultFormatting;
    type ValueType = f64;

    fn map(&self, value: &f64, limit: (i32, i32)) -> i32 {
        self.places.map(value, limit)
    }

    fn key_points<Hint: KeyPointHint>(&self, hint: Hint) -> Vec<f64> {
        match self.logarithmic {
            false => self.places.key_points(hint),
            true if hint.weight().allow_light_points() => Vec::new(),
            true => self.round(hint.max_num_points()),
        }
    }

    fn range(&self) -> Range<f64> {
        self.range.clone()
    }
}

impl ValueFormatter<f64> for Places {
    fn format(value: &f64) -> String {
        tick(*value)
    }
}

/// Where the first value of an axis lies on the picture, and the distance of neighbours: their logarithms where the ratio is
/// constant, their numbers in a list.
pub(crate) fn places(axis: &Axis) -> (f64, f64) {
    let part = |from: f64, to: f64, points: usize| (from, (to - from) / (points - 1) as f64);
    match &axis.values {
        Values::Linear { from, to, points } => part(*from, *to, *points),
        Values::Logarithmic { from, to, points } => part(from.log10(), to.log10(), *points),
        Values::List(_) => (0.0, 1.0),
    }
}

/// The tick at a place on the picture.
pub(crate) fn tick_at(axis: &Axis, place: f64) -> String {
    match &axis.values {
        Values::Linear { .. } => tick(place),
        Values::Logarithmic { .. } => power_tick(place),
        Values::List(values) => {
            let whole = place.fract().abs() < 1e-9 && place >= 0.0;
            values.get(place as usize).filter(|_| whole).map_or_else(String::new, |value| tick(*value))
        }
    }
}

/// The tick at a decimal logarithm: three digits, between decades no more is of use.
pub(crate) fn power_tick(place: f64) -> String {
    let value = 10f64.powf(place);
    tick(format!("{value:.2e}").parse().unwrap_or(value))
}

/// A tick in as few digits as it needs; values that are 0 up to rounding are 0.
pub(crate) fn tick(value: f64) -> String {
    let rounded = format!("{value:.6}");
    let trimmed = rounded.trim_end_matches('0').trim_end_matches('.');
    if value != 0.0 && value.abs() < 1e-3 && trimmed.trim_start_matches('-') != "0" || value.abs() >= 1e6 {
        format!("{value:e}")
    } else if trimmed == "-0" {
        "0".to_owned()
    } else {
        trimmed.to_owned()
    }
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
            let axis = Places::new(f64::log10(from)..f64::log10(to), true);
            let ticks: Vec<f64> = axis.key_points(BoldPoints(8)).into_iter().map(|place| 10f64.powf(place)).collect();
            let same = |(a, b): (&f64, &f64)| (a / b - 1.0).abs() < 1e-9;
            assert!(ticks.len() == expected.len() && ticks.iter().zip(&expected).all(same), "{ticks:?} {expected:?}");
        }
        // Others are where they always were.
        let plain = |axis: &dyn Fn(BoldPoints) -> Vec<f64>| axis(BoldPoints(8));
        let (own, theirs) = (Places::new(0.4..3.0, false), RangedCoordf64::from(0.4..3.0));
        assert_eq!(plain(&|hint| own.key_points(hint)), plain(&|hint| theirs.key_points(hint)));
        assert_eq!(own.map(&1.0, (0, 1000)), theirs.map(&1.0, (0, 1000)));
    }

    #[test]
    fn ticks_stand_where_the_values_are() {
        let text = "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
                    x = { parameter = \"omega\", from = 0.01, to = 100, points = 5, spacing = \"log\" }\n\
                    y = { parameter = \"gamma2\", values = [0.3, 0, 0.125] }\n[compute]\nfamilies = [\"double-sided\"]\n";
        let scene = Scene::parse(Path::new("scene.toml"), text).unwrap();
        let [x, y] = scene.plane().unwrap();
        assert_eq!(places(x), (-2.0, 1.0));
        assert_eq!([-2.0, -0.5, 0.0, 2.0].map(|place| tick_at(x, place)), ["0.01", "0.316", "1", "100"]);
        assert_eq!([-1.0, 0.0, 0.5, 1.0, 2.0, 3.0].map(|place| tick_at(y, place)), ["", "0.3", "", "0", "0.125", ""]);
    }
}
