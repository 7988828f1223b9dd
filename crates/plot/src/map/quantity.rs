//! Numbers of a cell in pictures: as colours of a map, or against the axis of a sweep over one parameter.

use vibrochain_maps::cell::{Cell, Class};
use vibrochain_maps::scene::Scene;
use vibrochain_maps::table::columns;

use crate::axes::axis::{Axis, Scale, power_of_ten, round_numbers, tick};
use crate::map::palette::Palette;

/// An excess below this is none: multipliers that meet are known to the root of the rounding.
const LEAST_EXCESS: f64 = 1e-8;

/// Excesses whose largest is so many times the smallest span decades: on a linear scale most of them would be zero.
const DECADES: f64 = 100.0;

/// A scale of excesses leaves out the largest one in so many cells: next to grazing an excess has no bound.
const FEW: usize = 100;

/// Ticks beside a bar of colours, at most.
const TICKS: usize = 7;

/// More decades than this have a tick at every second (third …) one.
const MOST_DECADES: usize = 10;

/// So many whole numbers have a patch of colour each; more share a bar.
const PATCHES: u32 = 9;

/// A number that a cell has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Quantity {
    /// Largest modulus of the multipliers.
    SpectralRadius,
    /// Smallest distance to a barrier.
    Margin,
    /// Modulus of the strongest impulse.
    Impulse,
    /// Number of physical breathers.
    Solutions,
}

vibrochain_lattice::names!(Quantity {
    SpectralRadius "spectral_radius", Margin "margin", Impulse "impulse", Solutions "solutions",
});

impl Quantity {
    /// What an axis calls it.
    pub(crate) fn label(self) -> &'static str {
        match self {
            Self::SpectralRadius => "largest |μ|",
            Self::Margin => "margin, the smallest distance to a barrier",
            Self::Impulse => "strongest impulse |P|",
            Self::Solutions => "physical breathers",
        }
    }

    /// What a bar of colours calls it, in lines that stand beside a map.
    fn heading(self) -> &'static str {
        match self {
            Self::Margin => "margin: distance to a barrier",
            other => other.label(),
        }
    }

    /// Whether the cells of a scene have it; if not, the key of the scene that asks for it.
    ///
    /// # Errors
    /// That key, as it stands in `[compute]`.
    pub fn of_scene(self, scene: &Scene) -> Result<(), &'static str> {
        match self {
            Self::SpectralRadius if !scene.task.stability => Err("stability = true"),
            _ if columns(scene).any(|column| column.name == self.name()) => Ok(()),
            _ => Err("impulse = true"),
        }
    }

    /// The cell's, if it has one.
    pub(crate) fn of(self, cell: &Cell) -> Option<f64> {
        match self {
            Self::SpectralRadius => cell.spectral_radius,
            Self::Margin => cell.margin,
            Self::Impulse => cell.impulse.map(f64::abs),
            Self::Solutions => (cell.solutions > 0).then_some(cell.solutions.into()),
        }
    }

    /// Of two cells that share a place of a map, what stands out: the larger excess, impulse or number of breathers, the smaller margin; what
    /// has a number before what has none.
    pub(crate) fn outstanding(self, one: Shade, other: Shade) -> Shade {
        match (one, other) {
            (Shade::Number(a), Shade::Number(b)) => {
                Shade::Number(if self == Self::Margin { a.min(b) } else { a.max(b) })
            }
            (Shade::Number(_), _) | (_, Shade::Nothing) => one,
            _ => other,
        }
    }

    /// How a map shows it.
    pub fn shade(self, cell: &Cell) -> Shade {
        // Of multipliers it is the distance from 1 that says something, and that needs all digits.
        let from = if self == Self::SpectralRadius { 1.0 } else { 0.0 };
        match self.of(cell) {
            Some(value) => Shade::Number((value - from) as f32),
            None if cell.class == Some(Class::None) => Shade::Nothing,
            None => Shade::Unknown,
        }
    }
}

/// What a cell of a map shows of a [`Quantity`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shade {
    /// No breather is there.
    Nothing,
    /// It could not be computed.
    Unknown,
    /// The number; of a spectral radius what it has more than 1.
    Number(f32),
}

/// Whether excesses span decades, those that are none left out.
fn span_decades(excesses: impl Iterator<Item = f64>) -> bool {
    let (least, most) = ends(excesses.filter(|excess| *excess >= LEAST_EXCESS));
    most >= DECADES * least
}

fn ends(numbers: impl Iterator<Item = f64>) -> (f64, f64) {
    numbers.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), number| (least.min(number), most.max(number)))
}

/// How numbers become colours.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Colours {
    /// In proportion between two ends; ticks have so much more.
    Linear { from: f64, to: f64, more: f64 },
    /// By their logarithms between whole decades, those below in a colour of their own, those above in the last one.
    Logarithmic { low: f64, high: f64 },
    /// 1, 2, … up to a number.
    Whole(u32),
}

/// A bar of colours beside a map.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Bar {
    pub(crate) quantity: Quantity,
    pub(crate) colours: Colours,
    /// What there is besides numbers on the scale.
    pub(crate) above: bool,
    pub(crate) below: bool,
    pub(crate) nothing: bool,
    pub(crate) unknown: bool,
}

impl Bar {
    /// For the cells of a map.
    pub(crate) fn of(quantity: Quantity, shades: &[Shade]) -> Self {
        let numbers = || {
            shades.iter().filter_map(|shade| match shade {
                Shade::Number(number) => Some(f64::from(*number)),
                _ => None,
            })
        };
        let (from, to) = ends(numbers());
        let colours = match quantity {
            Quantity::Solutions => Colours::Whole(to.max(1.0) as u32),
            Quantity::SpectralRadius if span_decades(numbers()) => {
                let mut excesses: Vec<f64> = numbers().filter(|excess| *excess >= LEAST_EXCESS).collect();
                let last = excesses.len() - 1 - excesses.len() / FEW;
                let (below, most, _) = excesses.select_nth_unstable_by(last, f64::total_cmp);
                let low = below.iter().copied().fold(*most, f64::min).log10().floor();
                Colours::Logarithmic { low, high: most.log10().ceil().max(low + 1.0) }
            }
            _ => {
                let more = if quantity == Quantity::SpectralRadius { 1.0 } else { 0.0 };
                // A single number lies in the middle.
                let air = if to > from { 0.0 } else { 0.5 * from.abs().max(1e-9) };
                let (from, to) = if from.is_finite() { (from - air, to + air) } else { (0.0, 1.0) };
                Colours::Linear { from, to, more }
            }
        };
        let below = numbers().any(|number| colours.part(number).is_none());
        let above = matches!(colours, Colours::Logarithmic { high, .. } if to.log10() > high);
        let has = |wanted: Shade| shades.contains(&wanted);
        Self { quantity, colours, above, below, nothing: has(Shade::Nothing), unknown: has(Shade::Unknown) }
    }

    /// The lines above the bar.
    pub(crate) fn heading(&self) -> &'static str {
        match self.colours {
            Colours::Logarithmic { .. } => "excess |μ| − 1 a period",
            _ => self.quantity.heading(),
        }
    }

    /// What the colour of numbers below the scale means.
    pub(crate) fn below_words(&self) -> String {
        match self.colours {
            Colours::Logarithmic { low, .. } => format!("excess below {}", power_of_ten(low)),
            _ => String::new(),
        }
    }

    /// Whole numbers that have a patch each, if they are few.
    pub(crate) fn patches(&self) -> Option<u32> {
        match self.colours {
            Colours::Whole(most) => Some(most).filter(|most| *most <= PATCHES),
            _ => None,
        }
    }

    /// Places along the bar, from 0 to 1, and what stands beside them.
    pub(crate) fn ticks(&self) -> Vec<(f64, String)> {
        match self.colours {
            Colours::Linear { from, to, more } => {
                let ticks = round_numbers(from + more, to + more, TICKS);
                ticks.into_iter().map(|value| ((value - more - from) / (to - from), tick(value))).collect()
            }
            Colours::Logarithmic { low, high } => {
                let decades = Axis { range: low..high, scale: Scale::Decades };
                let ticks: Vec<f64> = decades.ticks(MOST_DECADES).into_iter().map(|(decade, _)| decade).collect();
                let name = |decade: f64| {
                    let more = if self.above && decade == high { "≥ " } else { "" };
                    more.to_owned() + &power_of_ten(decade)
                };
                // The last one, if it means more than itself.
                let last = Some(high).filter(|high| self.above && !ticks.contains(high));
                let ticks = ticks.into_iter().filter(|decade| last.is_none_or(|last| last - decade > 1.0)).chain(last);
                ticks.map(|decade| ((decade - low) / (high - low), name(decade))).collect()
            }
            Colours::Whole(most) => {
                let ticks = round_numbers(1.0, f64::from(most), TICKS);
                let whole = ticks.into_iter().filter(|value| value.fract() == 0.0);
                whole.filter_map(|value| Some((self.colours.part(value)?, tick(value)))).collect()
            }
        }
    }
}

/// How the numbers of a map become colours, for whoever paints it elsewhere.
#[derive(Debug, Clone, PartialEq)]
pub struct NumberScale {
    /// What stands above the scale.
    pub heading: &'static str,
    /// Whether colours go by the decimal logarithm of a number; one below the lower end then has a colour of its own.
    pub by_logarithm: bool,
    /// The ends, of the numbers of [`Shade`]s or of their logarithms.
    pub ends: [f64; 2],
    /// Places from 0 to 1, and what stands beside them.
    pub ticks: Vec<(f64, String)>,
    /// What numbers below mean, where there are any.
    pub below: Option<String>,
}

/// The scale that a map with these cells has.
pub fn number_scale(quantity: Quantity, shades: &[Shade]) -> NumberScale {
    let bar = Bar::of(quantity, shades);
    let (by_logarithm, ends) = match bar.colours {
        Colours::Linear { from, to, .. } => (false, [from, to]),
        Colours::Logarithmic { low, high } => (true, [low, high]),
        // The only number stands in the middle.
        Colours::Whole(1) => (false, [0.5, 1.5]),
        Colours::Whole(most) => (false, [1.0, f64::from(most)]),
    };
    let ticks = match bar.patches() {
        Some(most) => (1..=most).map(|n| (bar.colours.part(f64::from(n)).unwrap_or(0.5), n.to_string())).collect(),
        None => bar.ticks(),
    };
    NumberScale { heading: bar.heading(), by_logarithm, ends, ticks, below: bar.below.then(|| bar.below_words()) }
}

impl Colours {
    /// The place of a number on the scale, from 0 to 1; none below it.
    pub(crate) fn part(self, number: f64) -> Option<f64> {
        match self {
            Self::Linear { from, to, .. } => Some((number - from) / (to - from)),
            Self::Logarithmic { low, high } => {
                let decade = number.log10();
                (decade >= low).then(|| (decade - low) / (high - low))
            }
            Self::Whole(1) => Some(0.5),
            Self::Whole(most) => Some((number - 1.0) / (f64::from(most) - 1.0)),
        }
    }

    /// The colour of pixel (x, y) of a cell.
    pub(crate) fn pixel(self, palette: Palette, shade: Shade, x: u32, y: u32) -> [u8; 3] {
        match shade {
            Shade::Nothing => palette.nothing(),
            Shade::Unknown => palette.unknown(x, y),
            Shade::Number(number) => match self.part(f64::from(number)) {
                Some(part) => palette.scale(part),
                None => palette.below(),
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bar(quantity: Quantity, numbers: &[f32]) -> Bar {
        Bar::of(quantity, &numbers.iter().map(|number| Shade::Number(*number)).collect::<Vec<_>>())
    }

    #[test]
    fn excesses_that_span_decades_are_drawn_by_their_logarithms() {
        let wide = bar(Quantity::SpectralRadius, &[0.0, -0.5, 1e-16, 3e-5, 0.02, 4.0]);
        assert_eq!(wide.colours, Colours::Logarithmic { low: -5.0, high: 1.0 });
        assert!(wide.below && !wide.nothing && !wide.unknown);
        assert_eq!((wide.heading(), wide.below_words()), ("excess |μ| − 1 a period", "excess below 10⁻⁵".to_owned()));
        let ticks = wide.ticks();
        let words: Vec<&str> = ticks.iter().map(|(_, word)| word.as_str()).collect();
        assert_eq!(words, ["10⁻⁵", "10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "1", "10"]);
        assert!(ticks.iter().zip(0..).all(|((place, _), i)| (place - f64::from(i) / 6.0).abs() < 1e-12));
        // A few beyond all others have no colours to themselves.
        let many: Vec<f32> = (0..500).map(|i| 2e-4 * (i as f32 / 100.0).exp()).chain([1e6]).collect();
        let most = bar(Quantity::SpectralRadius, &many);
        assert_eq!(most.colours, Colours::Logarithmic { low: -4.0, high: -1.0 });
        assert_eq!(most.ticks().last().unwrap(), &(1.0, "≥ 10⁻¹".to_owned()));
        assert!(most.above && !wide.above && most.colours.part(1e6).unwrap() > 1.0);
        // One decade is no matter for logarithms; ticks tell the modulus.
        let narrow = bar(Quantity::SpectralRadius, &[-0.1, 0.0, 0.02, 0.1]);
        assert!(matches!(narrow.colours, Colours::Linear { more: 1.0, .. }) && !narrow.below);
        let ticks = narrow.ticks();
        assert!(ticks.len() > 3 && ticks.iter().any(|(place, word)| word == "1" && (place - 0.5).abs() < 1e-6));
    }

    #[test]
    fn whole_numbers_have_patches_while_they_are_few() {
        let few = bar(Quantity::Solutions, &[1.0, 2.0, 4.0]);
        assert_eq!((few.colours, few.patches()), (Colours::Whole(4), Some(4)));
        let many = bar(Quantity::Solutions, &[1.0, 40.0]);
        assert_eq!(many.patches(), None);
        let ticks = many.ticks();
        assert!(ticks.len() > 2 && ticks.iter().all(|(_, word)| word.parse::<u32>().is_ok()), "{ticks:?}");
        assert_eq!(bar(Quantity::Solutions, &[1.0]).colours.part(1.0), Some(0.5));
    }

    #[test]
    fn what_has_no_number_is_told_apart() {
        let cell = Cell { spectral_radius: Some(1.5), margin: None, solutions: 2, impulse: Some(-0.25), ..Cell::EMPTY };
        assert_eq!(Quantity::SpectralRadius.shade(&cell), Shade::Number(0.5));
        assert_eq!(Quantity::Impulse.shade(&cell), Shade::Number(0.25));
        assert_eq!(Quantity::Solutions.shade(&cell), Shade::Number(2.0));
        assert_eq!(Quantity::Margin.shade(&Cell::EMPTY), Shade::Nothing);
        assert_eq!(Quantity::Solutions.shade(&Cell::EMPTY), Shade::Nothing);
        let unknown = Cell { class: None, ..Cell::EMPTY };
        assert_eq!(Quantity::Margin.shade(&unknown), Shade::Unknown);
        let bar = Bar::of(Quantity::Margin, &[Shade::Nothing, Shade::Unknown]);
        assert!(bar.nothing && bar.unknown && bar.colours == Colours::Linear { from: 0.0, to: 1.0, more: 0.0 });
    }

    /// Each quantity is the column of that name: the same number, apart from its sign.
    #[test]
    fn quantities_are_the_columns_of_their_names() {
        let text = "[model]\nsites = 3\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
                    x = { parameter = \"omega\", from = 1, to = 3, points = 3 }\n\
                    y = { parameter = \"gamma2\", from = 0, to = 1, points = 3 }\n\
                    [compute]\nfamilies = [\"double-sided\"]\n";
        let parse = |text: &str| Scene::parse(std::path::Path::new("scene.toml"), text).unwrap();
        let (bare, full) = (parse(text), parse(&format!("{text}stability = true\nimpulse = true\n")));
        let refused = Quantity::ALL.map(|quantity| quantity.of_scene(&bare).err());
        assert_eq!(refused, [Some("stability = true"), None, Some("impulse = true"), None]);
        let cell =
            Cell { spectral_radius: Some(1.5), margin: Some(0.1), impulse: Some(-2.0), solutions: 3, ..Cell::EMPTY };
        for quantity in Quantity::ALL {
            assert_eq!(quantity.of_scene(&full), Ok(()));
            let column = columns(&full).find(|column| column.name == quantity.name()).unwrap();
            let value = match (column.get)(&cell).unwrap() {
                vibrochain_maps::table::Value::Number(number) => number.abs(),
                vibrochain_maps::table::Value::Count(count) => count as f64,
                value => panic!("{value:?}"),
            };
            assert_eq!(quantity.of(&cell), Some(value));
        }
    }
}
