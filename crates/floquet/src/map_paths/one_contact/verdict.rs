//! Stable or not, for impacts at one site that are not reversible: by all multipliers, the leading one and its rivals better by the
//! impacts' own equations. The fast path of maps with losses, and that of large rings; a test holds it against `spectrum`.

use nalgebra::Complex;
use smallvec::SmallVec;
use vibrochain_breather::{BlochEquations, Condition, Prepared};

use crate::map_paths::one_contact::multipliers::SecularMultipliers;
use crate::map_paths::reversible::verdict::{Reason, SecularVerdict, Standing};
use crate::sizes::most_refined;
use crate::spectrum::{Refined, SpectralFunction, origins};
use crate::zeros::SecularError;
use crate::zeros::{excess, modulus};

/// Work space for verdicts on orbits with a force or losses, all impacts at one site.
///
/// ```
/// use vibrochain_breather::{Family, Finder, OrbitList};
/// use vibrochain_floquet::{ForcedSecular, Standing};
/// use vibrochain_lattice::Point;
/// let ring = Point::ring(21).gamma1(0.2).gamma2(0.1);
/// let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model()?;
/// let (mut finder, mut found, mut secular) = (Finder::new(21), OrbitList::default(), ForcedSecular::default());
/// finder.find(&model, Family::DoubleSided, &mut found)?;
/// let verdict = secular.verdict(finder.prepared(&found.orbits[0])?)?;
/// assert!(verdict.outcome == Standing::Unstable && (verdict.excess - 0.0016290236374028).abs() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone, Default)]
pub struct ForcedSecular {
    multipliers: SecularMultipliers,
    moved: SecularMultipliers,
    values: Vec<Complex<f64>>,
    errors: Vec<f64>,
    asked: Vec<Refinement>,
    /// A multiplier that is not among the values.
    trivial: Option<Complex<f64>>,
}

/// What the impacts' equations have said of a multiplier.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Refinement {
    Open,
    /// Its error is known by them.
    Done,
    /// They have no answer.
    Refused,
}

/// Errors of the orbit's own data at one impact, with the worst sign.
#[derive(Debug, Clone, Copy)]
struct DataError {
    /// Of κ'.
    kappa: f64,
    /// Of the time since the first impact.
    time: f64,
}

/// A multiplier that no other one surely exceeds.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Leading {
    pub(crate) place: usize,
    /// |μ| − 1
    pub(crate) excess: f64,
    pub(crate) error: f64,
}

impl ForcedSecular {
    /// The verdict. For elastic impacts multipliers stay on the circle, which this form cannot tell from next to it: it then
    /// says undecided where it does not say unstable.
    ///
    /// # Errors
    /// [`SecularError`]; [`SecularError::NotReversible`] also for conservative orbits, whose trivial pair this form does not split off.
    pub fn verdict(&mut self, prepared: Prepared<'_>) -> Result<SecularVerdict, SecularError> {
        if prepared.orbit().model().is_conservative() {
            return Err(SecularError::NotReversible);
        }
        self.solve(prepared)?;
        let Some(leading) = self.leading(prepared, None) else { return Err(SecularError::NotReversible) };
        let Leading { place, excess, error } = leading;
        let leading = self.values[place];
        let real = leading.im.abs() <= error;
        let (outcome, reason) = if excess > error {
            (Standing::Unstable, if real { Reason::RealRoot } else { Reason::ComplexPair })
        } else if excess < -error {
            (Standing::Stable, Reason::NoneOutside)
        } else {
            (Standing::Undecided, Reason::Tangency)
        };
        let leading = Some(if real { Complex::new(leading.re, 0.0) } else { leading });
        Ok(SecularVerdict { outcome, reason, leading, excess, excess_error: error })
    }

    /// The leading multiplier and its error, those that may lead instead counted in; whatever decides on it is
    /// better first. `condition` has the errors of the orbit's own data, where they count.
    pub(crate) fn leading(&mut self, prepared: Prepared<'_>, condition: Option<&Condition>) -> Option<Leading> {
        let known = self.best()?;
        let is_precise = known.error <= PRECISE * (1.0 + known.excess.abs()) && known.excess.abs() > known.error;
        if condition.is_none() && is_precise {
            return Some(known);
        }
        let orbit = prepared.orbit();
        let (equations, _) = BlochEquations::of(orbit, prepared.response());
        let data = condition.map_or(Vec::new(), |condition| origins(&equations, condition));
        let function = SpectralFunction::new(&equations, orbit.model().is_conservative());
        for _ in 0..most_refined(equations.kernel().modes().len()) {
            let best = self.best()?;
            let reach = best.excess + self.errors[best.place];
            // The one that may be the farthest outside decides what there is to gain.
            let rivals = self.values.iter().zip(&self.errors).zip(&self.asked).enumerate();
            let rival = rivals
                .filter(|(place, ((z, error), asked))| {
                    let counts = *place == best.place || excess(**z) + **error > reach;
                    **asked == Refinement::Open && counts
                })
                .map(|(place, ((z, error), _))| (place, excess(*z) + error))
                .max_by(|a, b| a.1.total_cmp(&b.1));
            let Some((place, _)) = rival else { break };
            self.adopt(place, function.refine(self.values[place], &data));
        }
        self.best()
    }

    /// The largest modulus, with room for others that may be larger.
    fn best(&self) -> Option<Leading> {
        let all = || self.values.iter().map(|z| excess(*z)).zip(&self.errors);
        let (place, (excess, &error)) = all().enumerate().max_by(|a, b| a.1.0.total_cmp(&b.1.0))?;
        // Another one that may lead is as good.
        let error = all().map(|(other, error)| other + error - excess).fold(error, f64::max);
        Some(Leading { place, excess, error })
    }

    /// Replaces a multiplier and its complex conjugate by the value that J(z) has refined.
    fn adopt(&mut self, place: usize, refined: Option<Refined>) {
        let z = self.values[place];
        let Some(Refined { z: better, error }) = refined else {
            self.asked[place] = Refinement::Refused;
            return;
        };
        self.asked[place] = Refinement::Done;
        let moved = modulus(better - z);
        let nearest_to = |w: Complex<f64>| {
            let others = self.values.iter().enumerate().filter(|(other, _)| *other != place);
            others.map(|(other, value)| (other, modulus(value - w))).min_by(|a, b| a.1.total_cmp(&b.1))
        };
        // To first order only if no other one is near.
        let distance = nearest_to(better).map_or(f64::INFINITY, |(_, distance)| distance);
        let distance = self.trivial.map_or(distance, |trivial| distance.min(modulus(trivial - better)));
        let alone = ALONE * error.max(moved) < distance;
        let partner = nearest_to(z.conj()).filter(|(_, distance)| *distance < z.im.abs());
        if alone {
            (self.values[place], self.errors[place]) = (better, error);
        } else {
            self.errors[place] = self.errors[place].max(error + moved);
        }
        // The same holds of its mirror image.
        if let Some((partner, _)) = partner {
            (self.values[partner], self.errors[partner]) = (self.values[place].conj(), self.errors[place]);
            self.asked[partner] = Refinement::Done;
        }
    }

    /// All multipliers of the even subspace but a conservative orbit's trivial pair.
    pub(crate) fn solve(&mut self, prepared: Prepared<'_>) -> Result<(), SecularError> {
        self.multipliers.replace(prepared)?;
        // A conservative orbit's trivial pair is known.
        let trivial = self.multipliers.trivial;
        let (values, errors) = self.multipliers.multipliers()?;
        self.values.clear();
        self.values.extend(values.iter().skip(trivial));
        self.errors.clear();
        self.errors.extend(errors.iter().skip(trivial));
        self.trivial = (trivial > 0).then_some(Complex::new(1.0, 0.0));
        self.asked.clear();
        self.asked.resize(self.values.len(), Refinement::Open);
        Ok(())
    }

    /// The multipliers last solved for, and their errors.
    pub(crate) fn multipliers(&self) -> (&[Complex<f64>], &[f64]) {
        (&self.values, &self.errors)
    }

    /// Adds what the errors of the orbit's own data, of its saltations and times, do to each multiplier, to first order, each
    /// error with the worst sign: by difference quotients of the secular function.
    ///
    /// # Errors
    /// Of the function next to the orbit's.
    pub(crate) fn add_errors_of(&mut self, prepared: Prepared<'_>, condition: &Condition) -> Result<(), SecularError> {
        let Self { multipliers: form, moved, values, errors, .. } = self;
        let impacts = prepared.orbit().impacts();
        // κ' = −v̈/P, and both it and the time are rounded; only differences of times count.
        let mut worst: SmallVec<[DataError; 2]> = form
            .kappas
            .iter()
            .enumerate()
            .map(|(i, kappa)| DataError {
                kappa: 4.0 * f64::EPSILON * kappa.abs(),
                time: if i == 0 { 0.0 } else { f64::EPSILON * prepared.orbit().period() },
            })
            .collect();
        for origin in &condition.origins {
            for (i, known) in origin.iter().enumerate() {
                let kappa = (known.acceleration + form.kappas[i] * known.impulse) / impacts[i].impulse;
                worst[i].kappa += kappa.abs();
                worst[i].time += if i == 0 { 0.0 } else { known.time.abs() };
            }
        }
        let response = prepared.response();
        let top = response.frequencies().iter().copied().fold(response.omega(), f64::max);
        for (i, DataError { kappa, time }) in worst.iter().enumerate() {
            let kappa_step = STEP * (form.kappas[i].abs() + response.omega());
            for (error, step, of_time) in [(*kappa, kappa_step, false), (*time, STEP / top, true)] {
                if error == 0.0 {
                    continue;
                }
                moved.times.clone_from(&form.times);
                moved.kappas.clone_from(&form.kappas);
                (if of_time { &mut moved.times } else { &mut moved.kappas })[i] += step;
                // The certificate is the orbit's own business; here a derivative is all.
                match moved.assemble(prepared) {
                    Ok(()) | Err(SecularError::Certificate { .. }) => {}
                    Err(doubt) => return Err(doubt),
                }
                let scale = error / step;
                if form.is_large() {
                    let moves = form.large.moved(&moved.large).into_iter().skip(form.trivial);
                    errors.iter_mut().zip(moves).for_each(|(total, by)| *total += by * scale);
                    continue;
                }
                for (z, total) in values.iter().zip(errors.iter_mut()) {
                    let (here, there) = (form.form.evaluate(*z), moved.form.evaluate(*z));
                    *total += (there.f - here.f).norm() / here.slope.norm() * scale;
                }
            }
        }
        if form.is_large() {
            // It takes as much room as all multipliers of the orbit.
            *moved = SecularMultipliers::default();
        }
        Ok(())
    }
}

/// Errors of an excess, in units of the multiplier, that nobody would want to have smaller.
const PRECISE: f64 = 1e-12;

/// An error this many times smaller than the distance to the next multiplier is one of first order.
const ALONE: f64 = 8.0;

/// Step of a difference quotient, relative to the natural size: error and rounding balance.
const STEP: f64 = 1e-7;
