//! All orbits of an impact word.
//!
//! A word that is a family's name is searched for as the family. One of one or two instants without force and losses has its
//! impacts at 0 and T/2, where K′ vanishes and Newton's law holds by itself: one linear system, as the closed forms of one site are.
//! All others are followed from masses without coupling (`uncoupled`), or with hardly any where no force tells when each hits
//! (`free_phases`).

use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::{Barrier, ImpulseResponse, Model};

use crate::completeness::{Completeness, Proof};
use crate::equations::System;
use crate::error::{BreatherError, NoBreather};
use crate::finder::{Finder, Found, Wanted};
use crate::free_phases;
use crate::linear::{Matrix, USUAL, Vector, dot};
use crate::orbit::{Draft, Family, Hit, Orbit};
use crate::polish::{STEPS, polish};
use crate::uncoupled;
use crate::word::Word;

/// Beyond this reciprocal condition rounding of the kernels leaves no digit of the impulses.
const SINGULAR: f64 = 16.0 * f64::EPSILON;

/// Residuals beyond this are improved: a sound orbit stays below.
const IMPROVED: f64 = 1e-14;

impl Finder {
    /// All orbits of a word at a point, into `found`; under a force or with losses those that [`Completeness`] speaks of. Times
    /// count from the first instant of the word. `wanted` is as for families; of a family's name the impacts are at site 0.
    ///
    /// # Errors
    /// [`BreatherError::Word`] for a site that does not exist; [`BreatherError::Resonance`].
    ///
    /// ```
    /// use vibrochain_breather::{Finder, Found, Wanted};
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(21, 0.2, 0.05)?, 1.5, 0.2)?;
    /// let (mut finder, mut found) = (Finder::new(21), Found::default());
    /// finder.find_word(&model, &"0+1+,0-1-".parse()?, Wanted::All, &mut found)?;
    /// // Neighbours in phase hit alike.
    /// let impacts = found.orbits[0].impacts();
    /// assert!((impacts[0].impulse - impacts[1].impulse).abs() < 1e-14 && impacts[0].impulse < 0.0);
    /// assert!(finder.admissibility(&found.orbits[0])?.is_physical());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn find_word(
        &mut self,
        model: &Model,
        word: &Word,
        wanted: Wanted,
        found: &mut Found,
    ) -> Result<(), BreatherError> {
        let layout = model.chain().layout();
        word.check(&layout)?;
        let word = &*word.in_one_row(&layout);
        if let Some(family) = word.family()
            && (model.chain().is_ring() || !model.is_conservative() || family == Family::PeriodDoubled)
        {
            let home = if model.chain().is_ring() { 0 } else { word.places()[0].1 };
            return self.search_at(model, family, home, wanted, found);
        }
        *found = Found { orbits: std::mem::take(&mut found.orbits), ..Found::default() };
        found.orbits.clear();
        let answer = if !model.is_conservative() && model.amplitude() == 0.0 {
            Err(NoBreather::LossWithoutForce)
        } else if !model.is_conservative() {
            return uncoupled::find(self, model, (word, 1), found);
        } else if word.instants().len() <= 2 {
            self.reversible(model, word, wanted, found)?
        } else {
            return free_phases::find(self, model, word, found);
        };
        found.completeness = match answer {
            Ok(()) => Completeness::All(Proof::Reversible),
            Err(reason) => {
                let known = matches!(reason, NoBreather::LossWithoutForce | NoBreather::NetImpulse);
                Completeness::None { reason, by: known.then_some(Proof::ClosedForm) }
            }
        };
        Ok(())
    }

    /// All orbits of a word whose period is that of so many periods of the force, into `found`. `0-,0-` in two is the doubled family.
    /// Masses may repeat what they do within the word, as one that keeps the period of the force beside one that has doubled it.
    ///
    /// # Errors
    /// As [`Finder::find_word`].
    ///
    /// ```
    /// use vibrochain_breather::{Finder, Found};
    /// use vibrochain_lattice::{Chain, Model};
    /// // Either site may have doubled its period, or both.
    /// let model = Model::forced(Chain::new(9, 0.2, 0.01)?, 1.07, 0.6, 0.3, 0.9)?;
    /// let mut found = Found::default();
    /// Finder::new(9).find_word_over(&model, &"0-,3-,0-,3-".parse()?, 2, &mut found)?;
    /// let orbit = &found.orbits[0];
    /// assert!(orbit.force_periods() == 2 && orbit.residual() < 1e-13);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn find_word_over(
        &mut self,
        model: &Model,
        word: &Word,
        force_periods: u32,
        found: &mut Found,
    ) -> Result<(), BreatherError> {
        if force_periods <= 1 || force_periods == 2 && word.family() == Some(Family::PeriodDoubled) {
            return self.find_word(model, word, Wanted::All, found);
        }
        let layout = model.chain().layout();
        word.check(&layout)?;
        found.orbits.clear();
        found.ended.clear();
        let reason = match model {
            model if model.is_conservative() => NoBreather::NeedsForce,
            model if model.amplitude() == 0.0 => NoBreather::LossWithoutForce,
            _ => return uncoupled::find(self, model, (&word.in_one_row(&layout), force_periods), found),
        };
        found.completeness = Completeness::None { reason, by: Some(Proof::ClosedForm) };
        Ok(())
    }

    fn reversible(
        &mut self,
        model: &Model,
        word: &Word,
        wanted: Wanted,
        found: &mut Found,
    ) -> Result<Result<(), NoBreather>, BreatherError> {
        self.prepare(model, model.omega())?;
        let draft = match reversible(model, &self.response, word) {
            Ok(draft) => draft,
            Err(none) => return Ok(Err(none)),
        };
        if !matches!(wanted, Wanted::All | Wanted::Symmetric) && !draft.is_right_signed() {
            return Ok(Ok(()));
        }
        let mut orbit = Orbit::assemble(model, &self.response, &mut self.motion, draft)?;
        if orbit.residual() > IMPROVED {
            polish(&mut orbit, STEPS, &self.response, &mut self.motion);
        }
        if !orbit.residual().is_finite() {
            return Ok(Err(NoBreather::Singular));
        }
        found.orbits.push(orbit);
        Ok(Ok(()))
    }
}

/// Impulses P and static displacement s from Σ_j P_j K̂_ij + s = a ± 1 and Σ P = g s.
fn reversible(model: &Model, response: &ImpulseResponse, word: &Word) -> Result<Draft, NoBreather> {
    let half = 0.5 * response.period();
    let hits: SmallVec<[(Hit, bool); USUAL]> = (word.instants().iter().zip([false, true]))
        .flat_map(|(letters, late)| letters.iter().map(move |letter| (letter, late)))
        .map(|(letter, late)| (Hit::new(letter.site, letter.barrier, if late { half } else { 0.0 }, 0.0), late))
        .collect();
    let (n, g) = (hits.len(), response.static_stiffness());
    if g == 0.0 && [Barrier::Lower, Barrier::Upper].iter().any(|&b| hits.iter().all(|(hit, _)| hit.barrier == b)) {
        return Err(NoBreather::NetImpulse);
    }
    // Each pair of sites once: K̂ is symmetric, and a site is hit at both instants as a rule.
    let mut sites: SmallVec<[usize; USUAL]> = hits.iter().map(|(hit, _)| hit.site).collect();
    sites.sort_unstable();
    sites.dedup();
    let places: SmallVec<[usize; USUAL]> =
        hits.iter().map(|(hit, _)| sites.partition_point(|&site| site < hit.site)).collect();
    let mut kernels: SmallVec<[Option<[f64; 2]>; USUAL]> = smallvec![None; sites.len() * sites.len()];
    let mut kernel = |i: usize, j: usize| {
        let (low, high) = (places[i].min(places[j]), places[i].max(places[j]));
        let known = &mut kernels[low * sites.len() + high];
        known.get_or_insert_with(|| response.dynamics_between(sites[high], sites[low]))
            [usize::from(hits[i].1 != hits[j].1)]
    };
    let matrix = Matrix::from_fn(n + 1, |i, j| match (i < n, j < n) {
        (true, true) => kernel(i, j),
        (true, false) | (false, true) => 1.0,
        (false, false) => -g,
    });
    // Impulses are like those of a mass that crosses the gap in half a period.
    let mut units: Vector = (0..n).map(|_| model.omega()).collect();
    units.push(1.0);
    let system = System::new(matrix.clone(), units);
    if system.reciprocal_condition <= SINGULAR {
        return Err(NoBreather::Singular);
    }
    let mut rows: Vector = hits.iter().map(|(hit, _)| model.barrier(hit.barrier)).collect();
    rows.push(0.0);
    let mut solution = system.solve(&rows);
    // An inverse leaves its condition times the rounding of the terms; once more, and it is the rounding alone.
    for (i, row) in rows.iter_mut().enumerate() {
        *row -= dot(matrix.row(i), &solution);
    }
    solution.iter_mut().zip(system.solve(&rows)).for_each(|(x, change)| *x += change);
    if !solution.iter().all(|x| x.is_finite()) {
        return Err(NoBreather::Singular);
    }
    let impacts = hits.iter().zip(&solution).map(|((hit, _), &impulse)| Hit { impulse, ..*hit }).collect();
    Ok(Draft::new(response, (Family::Word, 1), 0.0, impacts, solution[n]))
}
