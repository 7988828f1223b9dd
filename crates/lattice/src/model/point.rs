//! Points of the parameter space: what a model is made from, and its values by name.

use crate::error::{ParameterError, check};
use crate::model::chain::{Chain, Layout};
use crate::model::force::Force;
use crate::model::parameter::{Parameter, parameters};
use crate::model::params::Model;
use crate::modes::row::Ends;

/// A point of the parameter space, not yet checked. A model is made from one, with each value by its name.
///
/// What is not given has the value that the table of parameters has for it, or 0.
///
/// ```
/// use vibrochain_lattice::{Ends, Force, Harmonic, Point};
/// let model = Point::ring(21).gamma1(0.2).gamma2(0.1).omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model()?;
/// assert_eq!((model.omega(), model.chain().gamma2()), (1.5, 0.1));
/// let terms = [(1, 0.1), (3, -0.03)].map(|(number, amplitude)| Harmonic { number, amplitude, phase: 0.0 });
/// assert!((model.point().under(&Force::new(&terms)?).model()?.force_wave().value(0.0) - 0.07).abs() < 1e-16);
/// let pair = Point::ring(1).layers(2, Ends::Free).gamma1(0.2).gamma3(0.03).omega(1.5);
/// assert!(pair.model()?.is_conservative());
/// assert!(pair.restitution(1.1).model().is_err());
/// # Ok::<(), vibrochain_lattice::ParameterError>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Point {
    /// Where the masses stand.
    pub layout: Layout,
    /// Values in the order of [`Parameter::ALL`].
    pub values: [f64; Parameter::ALL.len()],
    /// A force that is not the plain cosine of the amplitude among the values, which is then Σ|A_j|.
    pub force: Option<Force>,
}

macro_rules! setters {
    ($($(#[$doc:meta])* $variant:ident $name:ident { $($rest:tt)* })*) => {
        /// The same point with one value changed, by its name.
        impl Point {
            $($(#[$doc])* #[must_use] pub fn $name(self, value: f64) -> Self { self.with(Parameter::$variant, value) })*
        }
    };
}
parameters!(setters);

impl Point {
    /// The point of a layout at which nothing is given.
    pub fn of(layout: Layout) -> Self {
        let values = Parameter::ALL.map(|parameter| parameter.row().default.unwrap_or(0.0));
        Self { layout, values, force: None }
    }

    /// The same of a ring.
    pub fn ring(sites: usize) -> Self {
        Self::of(Layout::ring(sites))
    }

    /// The same point with other ends of its rows.
    #[must_use]
    pub fn ends(self, ends: Ends) -> Self {
        Self { layout: Layout { ends, ..self.layout }, ..self }
    }

    /// The same point with so many layers; `layer_ends` tells whether the last is the first one's neighbour, too.
    #[must_use]
    pub fn layers(self, layers: usize, layer_ends: Ends) -> Self {
        Self { layout: Layout { layers, layer_ends, ..self.layout }, ..self }
    }

    /// Number of masses.
    pub fn sites(&self) -> usize {
        self.layout.length.saturating_mul(self.layout.layers)
    }

    /// Value of a parameter.
    pub fn get(&self, parameter: Parameter) -> f64 {
        self.values[parameter as usize]
    }

    /// Whether its value of a parameter is worth a word ([`Parameter::is_told`]).
    pub fn tells(&self, parameter: Parameter) -> bool {
        parameter.is_told(self.layout.layers, self.get(parameter))
    }

    /// The same point with one value changed.
    #[must_use]
    pub fn with(mut self, parameter: Parameter, value: f64) -> Self {
        self.set(parameter, value);
        self
    }

    /// Changes one value.
    pub fn set(&mut self, parameter: Parameter, value: f64) {
        self.values[parameter as usize] = value;
    }

    /// The same point with another lattice.
    #[must_use]
    pub fn on(self, chain: &Chain) -> Self {
        let point = Self { layout: chain.layout(), ..self };
        point.gamma1(chain.gamma1()).gamma2(chain.gamma2()).gamma3(chain.gamma3())
    }

    /// The same point under `force`.
    #[must_use]
    pub fn under(self, force: &Force) -> Self {
        let plain = force.cosine_amplitude().is_some();
        Self { force: (!plain).then_some(*force), ..self.with(Parameter::Amplitude, force.amplitude()) }
    }

    /// The lattice at this point.
    ///
    /// # Errors
    /// [`ParameterError`] for a value out of range.
    pub fn chain(&self) -> Result<Chain, ParameterError> {
        let [gamma1, gamma2, gamma3] =
            [Parameter::Gamma1, Parameter::Gamma2, Parameter::Gamma3].map(|parameter| self.get(parameter));
        Chain::on(self.layout, gamma1, gamma2, gamma3)
    }

    /// The model at this point.
    ///
    /// # Errors
    /// [`ParameterError`] for a value out of range.
    pub fn model(&self) -> Result<Model, ParameterError> {
        let chain = self.chain()?;
        Parameter::ALL.into_iter().try_for_each(|parameter| parameter.check(self.get(parameter)))?;
        let force = self.force.map_or_else(|| Force::cosine(self.get(Parameter::Amplitude)), Ok)?;
        let uniform = chain.layer_ends() != Ends::Fixed || force.amplitude() == 0.0;
        let told = "0 with walls beside layers: give walls to the ends of rows only";
        check(uniform, "amplitude", force.amplitude(), told)?;
        let [omega, asymmetry, restitution] =
            [Parameter::Omega, Parameter::Asymmetry, Parameter::Restitution].map(|parameter| self.get(parameter));
        // A minus zero would survive the range check and change signs downstream.
        let dashpots = [Parameter::Damping, Parameter::CouplingDamping].map(|parameter| self.get(parameter) + 0.0);
        Ok(Model { chain, omega, asymmetry: asymmetry + 0.0, force, restitution, dashpots })
    }
}

impl Chain {
    /// The point of the parameter space of which it is the lattice; of the rest nothing is given.
    pub fn point(&self) -> Point {
        Point::of(self.layout()).on(self)
    }
}

impl Model {
    /// The point of the parameter space at which it stands.
    pub fn point(&self) -> Point {
        let [damping, coupling_damping] = self.dashpots();
        let point =
            self.chain().point().omega(self.omega()).asymmetry(self.asymmetry()).restitution(self.restitution());
        point.damping(damping).coupling_damping(coupling_damping).under(self.force())
    }

    /// The value of one parameter.
    pub fn get(&self, parameter: Parameter) -> f64 {
        match parameter {
            Parameter::Gamma1 => self.chain().gamma1(),
            Parameter::Gamma2 => self.chain().gamma2(),
            Parameter::Omega => self.omega(),
            Parameter::Asymmetry => self.asymmetry(),
            Parameter::Amplitude => self.amplitude(),
            Parameter::Restitution => self.restitution(),
            Parameter::Gamma3 => self.chain().gamma3(),
            Parameter::Damping => self.dashpots()[0],
            Parameter::CouplingDamping => self.dashpots()[1],
        }
    }

    /// The parameters in which another model differs from this one; `None` where its masses stand elsewhere, or its force is of another shape.
    ///
    /// ```
    /// use vibrochain_lattice::{Parameter, Point};
    /// let model = Point::ring(21).gamma1(0.2).gamma2(0.1).omega(1.5).model()?;
    /// let other = model.with(Parameter::Omega, 1.6)?;
    /// let differ: Vec<Parameter> = model.differs_in(&other).into_iter().flatten().collect();
    /// assert_eq!(differ, [Parameter::Omega]);
    /// # Ok::<(), vibrochain_lattice::ParameterError>(())
    /// ```
    pub fn differs_in(&self, other: &Self) -> Option<impl Iterator<Item = Parameter> + Clone> {
        let is_plain = |model: &Self| model.force().cosine_amplitude().is_some();
        let is_alike = is_plain(self) && is_plain(other)
            || self.force() == other.force()
            || self.force().scaled_to(other.amplitude()).is_ok_and(|force| force == *other.force());
        let (one, other) = (*self, *other);
        let differ = move |parameter: &Parameter| one.get(*parameter) != other.get(*parameter);
        let are_there = one.chain().layout() == other.chain().layout();
        (are_there && is_alike).then(|| Parameter::ALL.into_iter().filter(differ))
    }

    /// The same model with one parameter changed. The amplitude of a force of several harmonics is Σ|A_j|: all of them are
    /// scaled alike.
    ///
    /// # Errors
    /// [`ParameterError`] for a value out of range.
    ///
    /// ```
    /// use vibrochain_lattice::{Parameter, Point};
    /// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
    /// let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model()?;
    /// let softer = model.with(Parameter::Gamma2, 0.05)?;
    /// assert_eq!((softer.chain().gamma2(), softer.get(Parameter::Omega)), (0.05, 1.5));
    /// assert!(model.with(Parameter::Restitution, 1.1).is_err());
    /// # Ok::<(), vibrochain_lattice::ParameterError>(())
    /// ```
    pub fn with(&self, parameter: Parameter, value: f64) -> Result<Self, ParameterError> {
        let force = match parameter {
            Parameter::Amplitude => self.force().scaled_to(value)?,
            _ => *self.force(),
        };
        self.point().with(parameter, value).under(&force).model()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::force::Harmonic;

    #[test]
    fn with_changes_one_value_and_get_reads_it() {
        let chain = Chain::new(5, 0.2, 0.1).unwrap();
        assert!(Model::conservative(chain, 1.5, 0.4).unwrap().with(Parameter::Gamma3, 0.1).is_err());
        let chain = chain.with_ends(Ends::Free).with_layers(3, 0.05, Ends::Closed).unwrap();
        let model = chain.point().omega(1.5).asymmetry(0.4).amplitude(0.3).restitution(0.9).model().unwrap();
        for parameter in Parameter::ALL {
            let changed = model.with(parameter, 0.77).unwrap();
            assert_eq!(changed.chain().layout(), chain.layout());
            for other in Parameter::ALL {
                let expected = if other == parameter { 0.77 } else { model.get(other) };
                assert_eq!(changed.get(other), expected, "{parameter:?} {other:?}");
            }
            assert_eq!(Parameter::from_name(parameter.name()), Some(parameter));
            assert!(parameter.flag().chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-'));
            assert_eq!(model.with(parameter, -1.0).is_err(), !parameter.row().range.contains(-1.0));
            assert!(model.point().with(parameter, f64::NAN).model().is_err(), "{parameter}");
            let row = parameter.row();
            assert_eq!(row.range.contains(row.range.least), !row.range.open[0], "{parameter}");
            assert!(row.slider[..2].iter().all(|value| row.range.contains(*value)), "{parameter}");
        }
    }

    #[test]
    fn a_force_of_several_harmonics_keeps_its_shape() {
        let terms =
            [(1, 0.3, 0.5), (3, -0.1, 0.0)].map(|(number, amplitude, phase)| Harmonic { number, amplitude, phase });
        let force = Force::new(&terms).unwrap();
        let ring = Point::ring(5).gamma1(0.2).gamma2(0.1);
        let model = ring.omega(1.5).asymmetry(0.4).under(&force).restitution(0.9).model().unwrap();
        assert_eq!(*model.with(Parameter::Gamma2, 0.05).unwrap().force(), force);
        let twice = model.with(Parameter::Amplitude, 0.8).unwrap();
        for (harmonic, term) in twice.force().harmonics().iter().zip(terms) {
            assert_eq!((harmonic.number, harmonic.phase), (term.number, term.phase));
            assert!((harmonic.amplitude - 2.0 * term.amplitude).abs() < 1e-15);
        }
        assert!((twice.get(Parameter::Amplitude) - 0.8).abs() < 1e-15);
        assert!(model.with(Parameter::Amplitude, -0.1).is_err() && model.with(Parameter::Amplitude, f64::NAN).is_err());
        assert_eq!(model.with(Parameter::Amplitude, 0.0).unwrap().amplitude(), 0.0);
    }
}
