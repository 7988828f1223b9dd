//! Axes of a sweep.

use std::ops::Range;

use serde::{Deserialize, Serialize, Serializer};
use toml::Spanned;
use vibrochain_lattice::{Parameter, Short};

/// The most points of one axis.
pub const MAX_POINTS: usize = 1_000_000;

/// One axis of a sweep: a parameter and the values it takes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Axis<P = Parameter> {
    /// What is varied.
    pub parameter: P,
    /// Its values.
    #[serde(flatten)]
    pub values: Values,
}

/// The values along an axis.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub enum Values {
    /// One by one, in this order; no two alike and at least one.
    #[serde(rename = "values")]
    List(Vec<f64>),
    /// Equally spaced.
    #[serde(untagged)]
    Linear {
        /// First value.
        from: f64,
        /// Last value, above the first.
        to: f64,
        /// Number of values, at least 2.
        points: usize,
    },
    /// Equal ratios of neighbours.
    #[serde(untagged, serialize_with = "logarithmic")]
    Logarithmic {
        /// First value, above 0.
        from: f64,
        /// Last value, above the first.
        to: f64,
        /// Number of values, at least 2.
        points: usize,
    },
}

/// As linear ones, with the word for it.
fn logarithmic<S: Serializer>(from: &f64, to: &f64, points: &usize, serializer: S) -> Result<S::Ok, S::Error> {
    #[derive(Serialize)]
    struct Spaced {
        from: f64,
        to: f64,
        points: usize,
        spacing: &'static str,
    }
    Spaced { from: *from, to: *to, points: *points, spacing: "log" }.serialize(serializer)
}

/// An axis as a file has it.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct AxisTable {
    pub(crate) parameter: Spanned<String>,
    from: Option<Spanned<f64>>,
    to: Option<Spanned<f64>>,
    points: Option<Spanned<i64>>,
    spacing: Option<Spanned<String>>,
    values: Option<Spanned<Vec<Spanned<f64>>>>,
}

/// What is wrong with an axis, and where; `None`: all of it.
type Wrong = (Option<Range<usize>>, String);

impl AxisTable {
    /// Where the file gives this value.
    pub(crate) fn place(&self, value: f64) -> Option<Range<usize>> {
        let mut values = self.values.iter().flat_map(|list| list.get_ref()).chain(&self.from).chain(&self.to);
        values.find(|given| *given.get_ref() == value).map(Spanned::span)
    }

    /// Its values.
    ///
    /// # Errors
    /// What is wrong with them.
    pub(crate) fn values(&self) -> Result<Values, Wrong> {
        let Self { parameter, from, to, points, spacing, values } = self;
        if let Some(values) = values {
            let ends = from.as_ref().or(to.as_ref()).map(Spanned::span);
            let rest = ends.or(points.as_ref().map(Spanned::span)).or(spacing.as_ref().map(Spanned::span));
            return match rest {
                Some(_) => {
                    Err((rest, "values is given as well: give either values, or from, to and points".to_owned()))
                }
                None => list(values),
            };
        }
        let (Some(from), Some(to), Some(points)) = (from, to, points) else {
            let name = parameter.get_ref();
            return Err((None, format!("{name} has no values yet: give from, to and points, or values")));
        };
        let (place, given) = (Some(points.span()), *points.get_ref());
        let Some(points) = usize::try_from(given).ok().filter(|points| (2..=MAX_POINTS).contains(points)) else {
            let range = format!("points = {given} is out of range: give a whole number from 2 to {MAX_POINTS}");
            return Err((place, range));
        };
        let (begin, from, to) = (Some(from.span()), *from.get_ref(), *to.get_ref());
        if !from.is_finite() || !to.is_finite() || from >= to {
            let message =
                format!("from = {}, to = {} is not a range: give finite values with from < to", Short(from), Short(to));
            return Err((begin, message));
        }
        match spacing.as_ref().map_or("linear", |spacing| spacing.get_ref()) {
            "linear" => Ok(Values::Linear { from, to, points }),
            "log" if from > 0.0 => Ok(Values::Logarithmic { from, to, points }),
            "log" => Err((
                begin,
                format!("from = {} has no logarithm: give a positive one with spacing = \"log\"", Short(from)),
            )),
            other => Err((
                spacing.as_ref().map(Spanned::span),
                format!("`{other}` is not a spacing: give \"linear\" or \"log\""),
            )),
        }
    }
}

/// Values one by one.
fn list(given: &Spanned<Vec<Spanned<f64>>>) -> Result<Values, Wrong> {
    let values: Vec<f64> = given.get_ref().iter().map(|value| *value.get_ref()).collect();
    let place = |at: usize| Some(given.get_ref()[at].span());
    let count = values.len();
    if !(1..=MAX_POINTS).contains(&count) {
        return Err((Some(given.span()), format!("values has {count} numbers: give 1 to {MAX_POINTS}")));
    }
    if let Some(at) = values.iter().position(|value| !value.is_finite()) {
        return Err((place(at), format!("{} is out of range: give finite values", Short(values[at]))));
    }
    let mut order: Vec<usize> = (0..count).collect();
    // Equal ones in the order of the file, so that the second is the one pointed at.
    order.sort_by(|&a, &b| (values[a] + 0.0).total_cmp(&(values[b] + 0.0)));
    if let Some(pair) = order.windows(2).find(|pair| values[pair[0]] == values[pair[1]]) {
        return Err((place(pair[1]), format!("{} is listed twice: remove one", Short(values[pair[1]]))));
    }
    Ok(Values::List(values))
}

impl Values {
    /// Number of values.
    pub fn points(&self) -> usize {
        match self {
            Self::Linear { points, .. } | Self::Logarithmic { points, .. } => *points,
            Self::List(values) => values.len(),
        }
    }

    /// Value number `i` < [`points`](Self::points), by index: steps never add up.
    pub fn value(&self, i: usize) -> f64 {
        match self {
            Self::Linear { to, points, .. } | Self::Logarithmic { to, points, .. } if i + 1 == *points => *to,
            Self::Logarithmic { from, .. } if i == 0 => *from,
            Self::Linear { from, to, points } => from + i as f64 * (to - from) / (points - 1) as f64,
            Self::Logarithmic { from, to, points } => {
                let part = i as f64 / (points - 1) as f64;
                let ratio = to / from;
                // Over hundreds of decades the ratio overflows, its logarithm does not.
                let value = if ratio.is_finite() {
                    from * ratio.powf(part)
                } else {
                    (from.ln() + part * (to.ln() - from.ln())).exp()
                };
                value.clamp(*from, *to)
            }
            Self::List(values) => values[i],
        }
    }
}

impl<P> Axis<P> {
    /// Number of values.
    pub fn points(&self) -> usize {
        self.values.points()
    }

    /// Value number `i` < [`points`](Self::points), by index: steps never add up.
    pub fn value(&self, i: usize) -> f64 {
        self.values.value(i)
    }

    /// The first value.
    pub fn first(&self) -> f64 {
        self.value(0)
    }

    /// The last value.
    pub fn last(&self) -> f64 {
        self.value(self.points() - 1)
    }

    /// Least and largest value.
    pub fn limits(&self) -> [f64; 2] {
        match &self.values {
            Values::Linear { from, to, .. } | Values::Logarithmic { from, to, .. } => [*from, *to],
            Values::List(values) => values
                .iter()
                .fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], &value| [least.min(value), most.max(value)]),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(values: Values) -> Axis {
        Axis { parameter: Parameter::Omega, values }
    }

    #[test]
    fn both_ends_are_met_exactly_and_the_middle_is_the_mean_of_its_kind() {
        let linear = axis(Values::Linear { from: 0.1, to: 0.7, points: 3 });
        assert_eq!((linear.value(0), linear.value(2)), (0.1, 0.7));
        assert!((linear.value(1) - 0.4).abs() < 1e-15);
        for (from, to, middle) in [(0.01, 100.0, 1.0), (2.0, 8.0, 4.0), (1e-300, 1e300, 1.0)] {
            let log = axis(Values::Logarithmic { from, to, points: 3 });
            assert_eq!((log.first(), log.last(), log.limits()), (from, to, [from, to]));
            assert!((log.value(1) / middle - 1.0).abs() < 1e-12, "{}", log.value(1));
        }
        let list = axis(Values::List(vec![3.0, -1.0, 2.0]));
        assert_eq!((list.points(), list.value(1), list.first(), list.last()), (3, -1.0, 3.0, 2.0));
        assert_eq!(list.limits(), [-1.0, 3.0]);
    }

    #[test]
    fn logarithmic_values_rise_by_one_ratio() {
        let log = axis(Values::Logarithmic { from: 1e-3, to: 1.0, points: 31 });
        for i in 0..30 {
            assert!((log.value(i + 1) / log.value(i) - 10f64.powf(0.1)).abs() < 1e-13);
        }
    }
}
