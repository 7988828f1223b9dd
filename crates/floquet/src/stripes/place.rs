//! What is off the circle at a point of a line.

use nalgebra::Complex;

use super::finder::StripeFinder;
use super::stripe::{NoStripe, Stripe, StripeLine};

/// Parts of the way to the next point at which to look: the first that leaves no doubt. (Doubt is next to edges.)
pub(super) const STARTS: [f64; 4] = [0.0, 0.25, 0.125, 0.375];
pub(super) const MIDDLES: [f64; 5] = [0.5, 0.25, 0.75, 0.375, 0.625];

/// A part of its distance from the circle by which a multiplier may move from point to point without doubt that it stays off.
const CALM: f64 = 0.5;

/// Which ν are off the circle: pairs of complex ones, and real ones below −1.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Place {
    pub(super) value: f64,
    pub(super) sheet: f64,
    pub(super) complex: Vec<Complex<f64>>,
    pub(super) below: Vec<Complex<f64>>,
    /// How many are above 1, where two may turn complex, too.
    pub(super) above: usize,
    /// Rounding leaves open whether two real ones are real.
    pub(super) doubtful: bool,
}

impl Place {
    /// More stripes are about it than multipliers are off the circle.
    pub(super) fn is_over(&self, stripes: &[Stripe]) -> bool {
        let about = stripes.iter().filter(|stripe| stripe.is_about(self.value));
        let told: usize = about.map(|stripe| if stripe.is_doubling() { 1 } else { 2 }).sum();
        told > 2 * self.complex.len() + self.below.len() + self.above && !self.doubtful
    }

    /// Each ν off the circle has moved by less than its distance from there, so that none has come back in between.
    pub(super) fn leads_to(&self, other: &Self) -> bool {
        let lists = [(&self.complex, &other.complex), (&self.below, &other.below)];
        lists.into_iter().all(|(from, to)| {
            let height = |nu: &Complex<f64>| if nu.im > 0.0 { nu.im } else { -1.0 - nu.re };
            from.len() == to.len()
                && from
                    .iter()
                    .all(|nu| to.iter().any(|other| (other - nu).norm() < CALM * height(nu).min(height(other))))
        })
    }
}

impl StripeFinder {
    /// What is off the circle; `None` where there is no physical breather, or its multipliers cannot be told.
    fn place(&mut self, line: &StripeLine, value: f64) -> Result<Option<Place>, NoStripe> {
        match self.set(line, value) {
            Err(error @ NoStripe::Parameter(_)) => return Err(error),
            Err(_) => return Ok(None),
            Ok(_) => {}
        }
        let Some(orbit) = self.found.orbits.first() else { return Ok(None) };
        let physical = self.finder.quick_admissibility(orbit).is_ok_and(|answer| answer.is_physical());
        if !physical || self.secular.replace(self.finder.prepared(orbit)?).is_err() {
            return Ok(None);
        }
        let Ok(all) = self.secular.all_nu() else { return Ok(None) };
        let sheet = self.reversal.sheet();
        let mut place = Place { value, sheet, complex: Vec::new(), below: Vec::new(), above: 0, doubtful: false };
        let mut last = None;
        for (nu, _) in all {
            let here = nu.complex();
            if nu.im > 0.0 {
                place.complex.push(here);
            } else if nu.im == 0.0 {
                // Of two that cannot be told apart the middle is told twice.
                place.doubtful |= last == Some(here);
                if nu.above < 0.0 {
                    place.below.push(here);
                }
                place.above += usize::from(nu.below > 0.0);
            }
            last = Some(here);
        }
        Ok(Some(place))
    }

    /// What is off the circle at the first of some parts of the way between two points where that is without doubt, or at the first of all.
    pub(super) fn place_between(
        &mut self,
        line: &StripeLine,
        (from, to): (f64, f64),
        parts: &[f64],
    ) -> Result<Option<Place>, NoStripe> {
        let mut first = None;
        for part in parts {
            let place = self.place(line, from + part * (to - from))?;
            if place.as_ref().is_none_or(|place| !place.doubtful) {
                return Ok(if first.is_some() && place.is_none() { first } else { place });
            }
            first = first.or(place);
        }
        Ok(first)
    }
}
