//! Verdicts on words of several sites on lattices too large for a matrix: all multipliers counted by the inertia of the secular matrix,
//! those outside the circle settled by the impacts' equations.
//!
//! What the count leaves open are complex ν. A breather's own multipliers hardly know how long the rows are: short rows with the same
//! word tell where to look, the count whether these are all.

use nalgebra::Complex;
use vibrochain_breather::{Condition, Finder, Found, Letter, Orbit, Wanted, Word};
use vibrochain_lattice::{Chain, Ends, Layout, Model};

use crate::analyser::{Analyser, Failure};
use crate::by_secular::check;
use crate::dense::Dense;
use crate::error::FloquetError;
use crate::saltation::saltations;
use crate::secular::{Count, SecularError, excess};
use crate::verdict::{Question, Verdict};

/// Masses of the short rows on either side of the word.
const MARGIN: usize = 60;

/// The farthest sites of a word may be apart along the rows for short ones to be short.
const FARTHEST: usize = 200;

/// Growth from which on a multiplier of the short rows is a start: below it, it may belong to a wave that has no place in the long ones.
const GROWING: f64 = 1e-7;

impl Analyser {
    /// The verdict; multipliers on the circle are only counted.
    pub(crate) fn by_inertia(
        &mut self,
        question: Question<'_>,
        finder: &mut Finder,
    ) -> Result<(Verdict, Vec<Complex<f64>>), Failure> {
        let Question { orbit, tolerance, .. } = question;
        let _ = saltations(orbit)?;
        let condition = finder.condition(orbit)?;
        self.inertia.set(finder.prepared(orbit)?, &condition);
        let count = self.inertia.count()?;
        let mut starts: Vec<Complex<f64>> = count.real.iter().map(|real| real.multiplier).collect();
        if count.missing > 0 {
            starts.extend(self.on_short_rows(orbit)?);
        }
        let (leading, growth, error) = match self.outside(&starts, &count, orbit, &condition, finder)? {
            None => return Ok((Verdict::on_circle(None), Vec::new())),
            Some(leading) => leading,
        };
        check(growth, error, question)?;
        Ok((Verdict::of_growth(leading, growth, error, tolerance), Vec::new()))
    }

    /// The leading one of all multipliers outside the circle, with growth and error; a doubt if more are missing than were found.
    fn outside(
        &mut self,
        starts: &[Complex<f64>],
        count: &Count,
        orbit: &Orbit,
        condition: &Condition,
        finder: &mut Finder,
    ) -> Result<Option<(Complex<f64>, f64, f64)>, Failure> {
        self.forced.adopt(orbit, condition, starts.iter().map(|start| (*start, 0.0)), None);
        self.forced.settle_apart(finder.prepared(orbit)?);
        let (values, errors) = self.forced.multipliers();
        let mut leading: Vec<_> = count.real.iter().map(|real| (real.multiplier, real.growth, real.error)).collect();
        let mut complex = 0;
        for (place, (&value, &error)) in values.iter().zip(errors).enumerate() {
            let growth = excess(value);
            if !self.forced.is_settled(place) || growth <= error {
                continue;
            }
            match leading.get_mut(place).filter(|_| place < count.real.len()) {
                // Within its bracket it is the same, and better known.
                Some(real) if error < real.2 && (growth - real.1).abs() <= real.2 + error => {
                    *real = (Complex::new(value.re, 0.0), growth, error);
                }
                Some(_) => {}
                None if value.im > error => {
                    complex += 1;
                    leading.push((value, growth, error));
                }
                None => {}
            }
        }
        // Each comes with its conjugate.
        if 2 * complex != count.missing {
            let found = count.wanted - count.missing + 2 * complex;
            return Err(SecularError::Incomplete { found, wanted: count.wanted }.into());
        }
        Ok(leading.into_iter().max_by(|a, b| a.1.total_cmp(&b.1)))
    }

    /// Complex multipliers outside the circle, of the upper half-plane, of the same word on short rows.
    fn on_short_rows(&mut self, orbit: &Orbit) -> Result<Vec<Complex<f64>>, FloquetError> {
        let Some((model, word)) = shortened(orbit) else { return Ok(Vec::new()) };
        let (mut finder, mut found) = (Finder::new(model.chain().sites()), Found::default());
        finder.find_word(&model, &word, Wanted::All, &mut found)?;
        let Some(short) = found.orbits.first() else { return Ok(Vec::new()) };
        let mut dense = Dense::default();
        dense.solve(short, &mut finder)?;
        let multipliers = dense.multipliers(short);
        Ok(multipliers.into_iter().filter(|value| value.im > 0.0 && value.norm() > 1.0 + GROWING).collect())
    }
}

/// The word of an orbit on a lattice whose rows are hardly longer than the word: ends that are far are nearer, and the rest of a ring is
/// left out.
fn shortened(orbit: &Orbit) -> Option<(Model, Word)> {
    let (model, word) = (orbit.model(), Word::of(orbit));
    let (chain, length) = (model.chain(), model.chain().length());
    let sites: Vec<usize> = word.places().into_iter().map(|(_, site)| site % length).collect();
    let closed = chain.ends() == Ends::Closed;
    let first = if closed {
        // The first site after the longest free arc.
        let mut along = sites.clone();
        along.sort_unstable();
        along.dedup();
        let arc = |i: usize| (along[i] + length - along[(i + along.len() - 1) % along.len()] - 1) % length;
        along[(0..along.len()).max_by_key(|&i| arc(i))?]
    } else {
        *sites.iter().min()?
    };
    let place = |site: usize| (site % length + length - first) % length;
    let span = sites.iter().map(|&site| place(site)).max()?;
    let (before, behind) =
        if closed { (0, 2 * MARGIN) } else { (first.min(MARGIN), (length - 1 - first - span).min(MARGIN)) };
    let short = before + span + 1 + behind;
    if span > FARTHEST || short >= length {
        return None;
    }
    let site = |site: usize| before + place(site) + site / length * short;
    let letter = |letter: &Letter| Letter { site: site(letter.site), ..*letter };
    let instants = word.instants().iter().map(|letters| letters.iter().map(letter).collect()).collect();
    let layout = Layout { length: short, ..chain.layout() };
    let chain = Chain::on(layout, chain.gamma1(), chain.gamma2(), chain.gamma3()).ok()?;
    Some((Model::conservative(chain, model.omega(), model.asymmetry()).ok()?, Word::new(instants).ok()?))
}
