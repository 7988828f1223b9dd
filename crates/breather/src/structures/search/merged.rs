//! Counts the orbits at a place where two zeros of F may have merged.
//!
//! Such places exist where impacts are elastic, nothing damps the structure and the loads are in phase. Reversal of time then turns an orbit into
//! another one of the same φ, if φ is half a period or the word is its own mirror image. At this φ the linear equations leave a line of (c, s),
//! C = S = Δ = 0, and F has a double zero; with a small loss it has two zeros closer than rounding can tell. Where F″ keeps its sign there
//! are two zeros at most, and the two points where the line meets the circle are their orbits.

use vibrochain_lattice::simd::lanes::LANES;

use super::at_times::{Impacts, Start};
use super::two_impacts::Function;
use crate::error::BreatherError;
use crate::roots::bracket;
use crate::roots::interval::Zeros;

/// Radii of the intervals on which F″ is enclosed, as parts of the period: larger than the error of a double zero.
const WIDTHS: [f64; LANES] = [1e-2, 2e-3, 4e-4, 4e-5];

/// Where the line's misfit is larger than this, two zeros are far enough apart to be told apart.
const NEARLY: f64 = 1e-6;

impl Function {
    /// The zero of F′ next to a place, and the distance from it within which F″ keeps its sign; `None` where no such interval holds a zero of F′.
    fn turn(&self, place: f64) -> Option<[f64; 2]> {
        let room = place.min(self.period - place);
        let radii = WIDTHS.map(|width| (width * self.period).min(0.5 * room));
        let bends = self.bends([place; LANES], radii);
        let radius = (0..LANES).find(|&i| bends[i]).map(|i| radii[i])?;
        let slope = |phi: f64| self.slope(phi);
        let [from, to] = [place - radius, place + radius].map(|phi| (phi, slope(phi)));
        if (from.1 > 0.0) == (to.1 > 0.0) {
            return None;
        }
        let at = bracket::zero::<std::convert::Infallible>(from, to, self.period, |phi| Ok(slope(phi))).ok()?;
        Some([at, radius - (at - place).abs()])
    }
}

impl Impacts<'_> {
    /// Removes merged pairs from the zeros of F, and adds to `starts` one start of Newton's method for each orbit of a pair.
    pub(super) fn take_merged(
        &self,
        function: &Function,
        zeros: &mut Zeros,
        starts: &mut Vec<Start>,
    ) -> Result<(), BreatherError> {
        let near = |phi: &f64, [at, radius]: [f64; 2]| (phi - at).abs() < radius;
        let mut taken: Vec<[f64; 2]> = Vec::new();
        for place in std::mem::take(&mut zeros.unresolved) {
            if taken.iter().any(|turn| near(&place, *turn)) {
                continue;
            }
            let turn = function.turn(place).filter(|turn| near(&place, *turn));
            let line = match turn {
                Some([at, _]) => self.line(&[0.0, at])?,
                None => None,
            };
            match (turn, line) {
                (Some(turn), Some(line)) if line.misfit <= NEARLY && line.is_decided() => {
                    zeros.simple.retain(|phi| !near(phi, turn));
                    taken.push(turn);
                    let points = line.on_the_circle();
                    starts.extend(points.iter().map(|x| Start::zero(self.point(&[0.0, turn[0]], x))));
                }
                _ => zeros.unresolved.push(place),
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use vibrochain_lattice::{Barrier, Complex, Contact, LinearMode, ModalStructure, ModeShape};
    use vibrochain_testkit::Random;

    use super::*;
    use crate::structures::equations::Equations;
    use crate::structures::model::LoadedStructure;
    use crate::structures::orbit::ContactOrbit;

    /// Modes without losses under a load in phase; of two contacts that are each other's mirror image, or of any two.
    fn model(random: &mut Random, mirrored: bool) -> LoadedStructure {
        let odd = random.chance(0.5);
        let modes = (0..1 + random.below(4)).map(|number| {
            let (one, other) = (random.between(-1.0, 1.0), random.between(-1.0, 1.0));
            let is_odd = number % 2 == 1;
            let image = if is_odd { -one } else { one };
            let shape = ModeShape {
                contacts: vec![one, if mirrored { image } else { other }],
                coordinates: Vec::new(),
                still: 0.0,
            };
            let load = if mirrored && is_odd != odd { 0.0 } else { random.between(-1.0, 1.0) };
            LinearMode::oscillator(0.0, random.log(0.1, 9.0), &shape, &[Complex::new(load, 0.0)])
        });
        let modes = modes.collect();
        let lower = -random.log(0.1, 1.0);
        let upper = if random.chance(0.3) { -lower } else { random.log(0.1, 1.0) };
        // At e = 1 F has double zeros; at a little less each is two zeros closer than rounding can tell.
        let lost = if random.chance(0.5) { 0.0 } else { random.log(1e-14, 1e-9) };
        let stops = Contact { lower: Some(lower), upper: Some(upper), restitution: 1.0 - lost };
        let structure = Arc::new(ModalStructure::new(vec![stops; 2], vec![1], modes).unwrap());
        LoadedStructure::new(structure, random.between(0.5, 3.0)).unwrap()
    }

    /// Where a load moves the contacts by less than the motion is rounded, the list stays open: that no orbit was found does not show that there is none.
    #[test]
    fn a_load_below_rounding_proves_nothing() {
        let shape = ModeShape { contacts: vec![1.0], coordinates: Vec::new(), still: 0.0 };
        let (mut open, mut listed) = (0, 0);
        for force in [1e-30, 1e-20, 1e-6] {
            let mode = LinearMode::oscillator(0.0, 0.2, &shape, &[Complex::new(force, 0.0)]);
            let stops = Contact { lower: Some(-0.92), upper: Some(1.08), restitution: 1.0 };
            let structure = Arc::new(ModalStructure::new(vec![stops], vec![1], vec![mode]).unwrap());
            let model = LoadedStructure::new(structure, 0.42).unwrap();
            for word in ["0-", "0+,0-"] {
                let found = model.orbits(&word.parse().unwrap(), 1).unwrap();
                assert!(force > 1e-10 || !found.completeness.is_established(), "{force} {word} {found:?}");
                open += usize::from(!found.completeness.is_established());
                listed += found.orbits.len();
            }
        }
        assert!(open == 4 && listed >= 8, "{open} {listed}");
    }

    /// Every complete list holds all orbits that Newton's method finds from starts spread over times and phase; these starts do not depend on F.
    #[test]
    fn lists_of_elastic_impacts_are_complete() {
        let mut random = Random(131);
        let (mut lists, mut complete, mut orbits, mut pairs, mut sought) = (0, 0, 0, 0, 0);
        for round in 0..80 {
            let model = model(&mut random, round % 2 == 0);
            for (word, periods) in [("0-,0+", 1), ("0-,0-", 1), ("0-,0-", 2), ("0+,1-", 1), ("0+,1+", 1)] {
                let word: crate::word::Word = word.parse().unwrap();
                let Ok(found) = model.orbits(&word, periods) else { continue };
                let phis: Vec<f64> = found.orbits.iter().map(|orbit| orbit.impacts()[1].time).collect();
                let one = |pair: &&[f64]| pair[1] - pair[0] < 1e-8 * model.period();
                (lists, orbits) = (lists + 1, orbits + phis.len());
                pairs += phis.windows(2).filter(one).count();
                if !found.completeness.is_established() {
                    continue;
                }
                complete += 1;
                let letters: smallvec::SmallVec<[(usize, Barrier); 4]> =
                    word.letters().map(|letter| (letter.site, letter.barrier)).collect();
                let equations = Equations::new(&model, periods, letters.iter().map(|letter| letter.0)).unwrap();
                let impacts = Impacts { equations: &equations, letters };
                for start in impacts.starts().unwrap().0.into_iter().step_by(10) {
                    let orbit = equations.solve(start.point);
                    let Ok(orbit) = orbit.and_then(|point| ContactOrbit::new(&equations, periods, point)) else {
                        continue;
                    };
                    let apart = orbit.impacts()[1].time.min(orbit.period() - orbit.impacts()[1].time);
                    if !orbit.has_its_instants()
                        || !orbit.has_impulses()
                        || orbit.repeats_sooner()
                        || apart < 1e-4 * orbit.period()
                    {
                        continue;
                    }
                    let is_listed = found.contacts().any(|listed| listed.begun_at(&orbit).is_some());
                    assert!(is_listed, "{round} {word} {:?}: {orbit:?}", found.completeness);
                    sought += 1;
                }
            }
        }
        let told = format!("{lists} {complete} {orbits} {pairs} {sought}");
        assert!(lists > 380 && complete > 370 && orbits > 1600 && pairs > 300 && sought > 3500, "{told}");
    }
}
