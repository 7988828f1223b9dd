//! Values by their names: what pictures show, which are columns of tables, and those of the library.

use std::fmt;

use clap::ValueEnum;
use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};

/// What a picture shows of a table: cells of a map, or the orbits of a branch.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub enum QuantityName {
    /// Class and mechanism.
    #[default]
    Class,
    /// Largest modulus of the multipliers; of a map the excess beyond 1, by logarithms, where it spans decades.
    #[value(name = "spectral_radius", alias = "spectral-radius")]
    SpectralRadius,
    /// Smallest distance of any mass to a barrier.
    Margin,
    /// Modulus of the impulses, of a map the strongest one's, which needs `impulse = true` in the scene.
    Impulse,
    /// Number of physical breathers.
    Solutions,
    /// Time φ of the second impact, in periods.
    Phi,
    /// Phase ψ of the force, in its periods.
    Psi,
}

use QuantityName::{Class, Impulse, Margin, Phi, Psi, Solutions, SpectralRadius};

/// What maps can show, what branches can, and both.
pub(crate) const OF_MAPS: [QuantityName; 5] = [Class, SpectralRadius, Margin, Impulse, Solutions];
pub(crate) const OF_BRANCHES: [QuantityName; 5] = [Impulse, Phi, Psi, Margin, SpectralRadius];
pub(crate) const ALL: [QuantityName; 7] = [Class, SpectralRadius, Margin, Impulse, Solutions, Phi, Psi];

/// What a bifurcation diagram shows unless it is asked for something else.
pub(crate) const SHOWN: [QuantityName; 2] = [Impulse, SpectralRadius];
pub(super) const SHOWN_NAMES: &str = "impulse,spectral_radius";

/// Those of orbits, by the same names.
pub(crate) fn of_orbits(shown: &[QuantityName]) -> Vec<vibrochain_plot::OrbitQuantity> {
    shown.iter().filter_map(|one| vibrochain_plot::OrbitQuantity::from_name(&one.to_string())).collect()
}

/// The name on the command line, a column's.
impl fmt::Display for QuantityName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.to_possible_value().as_ref().map_or("", |value| value.get_name()))
    }
}

/// Takes the names of these.
pub(super) fn among(known: &'static [QuantityName]) -> impl TypedValueParser<Value = QuantityName> {
    let names = PossibleValuesParser::new(known.iter().filter_map(ValueEnum::to_possible_value));
    names.try_map(|name| QuantityName::from_str(&name, true))
}

/// Values of the library that a flag takes, and what each means.
pub(super) type Meanings<T> = &'static [(T, &'static str)];

/// Takes one of them by its name.
pub(super) fn by_name<T: Copy + Send + Sync + 'static>(
    known: Meanings<T>,
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    let values = known.iter().map(|(value, meaning)| PossibleValue::new(name(*value)).help(*meaning));
    let of = move |text: String| known.iter().map(|(value, _)| *value).find(|value| name(*value) == text);
    PossibleValuesParser::new(values).try_map(move |text| of(text).ok_or("it has no value"))
}
