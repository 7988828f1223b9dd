//! Are all residues positive? Signs before magnitudes: most stable orbits have no others, and of these nothing else is asked.
//!
//! The same sums as in `single_sided` and `double_sided`, in their plain form, which loses digits where poles are close, and with one
//! bound of the errors for all terms of a sum instead of one for each: with the largest inverse distance A of a pole from others it is
//!
//! ```text
//! ε (4 + (S + 8)A + 2R) Σ|terms| ,      S, R the largest errors of a pole and of x, see [`crate::map_paths::modes`].
//! ```
//!
//! They are not even begun where modes alone, by the signs of sin Ω_kT, leave hardly a hope.
//!
//! No residue counts that is not beyond several times its bound, and their sum and the trace must be right as far as the bounds tell, which
//! must be small. So a yes here is a yes there; a no says nothing.

use vibrochain_lattice::simd::lanes::{LANES, Lane, ONE, TWO, ZERO, all};
use wide::f64x4;

use crate::map_paths::modes::{Mode, Modes};
use crate::map_paths::reversible::double_sided::{self, Mirror, Own, Saltations};
use crate::map_paths::reversible::single_sided;

/// A residue must exceed its bound this many times: so the mended one of `residues` does, too.
const ROOM: f64 = 4.0;

/// What the bounds of all residues may add up to: far less than what their sum may be off before it proves nothing.
const MOST_DOUBT: f64 = 1e-8;

/// 1 in the place of each of four modes.
const ITSELF: [Lane; LANES] = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]];

/// One of four modes.
struct One<'a> {
    four: &'a Mode<Lane>,
    place: usize,
}

impl One<'_> {
    /// One of its numbers, four times.
    #[inline(always)]
    fn all(&self, number: impl Fn(&Mode<Lane>) -> &Lane) -> f64x4 {
        all(number(self.four)[self.place])
    }
}

/// Four modes, the place of their group, and the largest errors S and R of all.
struct Four<'a> {
    modes: &'a Modes,
    group: Mode<f64x4>,
    place: usize,
    shift: f64x4,
    relative: f64x4,
}

/// Whether all residues of several modes, for one instant or two with this ratio of impulses and its error, are surely positive.
pub(crate) fn all_positive(modes: &Modes, ratio: Option<(f64, f64)>) -> bool {
    if modes.count() < 2 {
        return false;
    }
    let [mut shift, mut relative, mut back, mut forth] = [ZERO; 4];
    for group in modes.groups() {
        let group = group.four();
        (shift, relative) = (shift.fast_max(group.shift), relative.fast_max(group.relative + group.doubt));
        let turn = group.weight * group.sin * group.cos;
        (back, forth) = (back.fast_min(turn), forth.fast_max(turn));
    }
    // Multipliers of modes on both halves of the circle: residues hardly ever have one sign then, and it is not worth the sums to know.
    if back.simd_lt(ZERO).any() && forth.simd_gt(ZERO).any() {
        return false;
    }
    let [shift, relative] = [shift, relative].map(|four| all(four.to_array().into_iter().fold(0.0, f64::max)));
    let saltations = ratio.map(|(ratio, error)| Saltations::by_fours(modes, ratio, error));
    let (mut sum, mut trace, mut doubt) = (ZERO, ZERO, ZERO);
    for (place, group) in modes.groups().iter().enumerate() {
        let group = group.four();
        let four = Four { modes, group, place, shift, relative };
        let (residue, error) = match &saltations {
            Some(saltations) => {
                let (own, mirror) = four.double_sided();
                double_sided::residue(&group, saltations, &own, &mirror)
            }
            None => four.single_sided(),
        };
        // What fills up the last group has no weight and no residue. Not a number is a doubt, too.
        if !(residue.simd_gt(error * all(ROOM)) | group.weight.simd_eq(ZERO)).all() {
            return false;
        }
        sum += residue;
        trace += residue * (group.cos - group.sin) * (group.cos + group.sin);
        doubt += error;
    }
    let [sum, trace, doubt] = [sum, trace, doubt].map(vibrochain_lattice::simd::lanes::total);
    let fours = modes.groups().iter().map(Mode::four);
    let expected = match &saltations {
        Some(saltations) => double_sided::trace(fours, saltations),
        None => single_sided::trace(fours),
    };
    // As the certificate of `residues` has it.
    let allowed = 16.0 * (doubt + f64::EPSILON * (2.0 + expected.abs()));
    (sum - 1.0).abs() <= allowed && (trace - expected).abs() <= allowed && doubt < MOST_DOUBT
}

impl Four<'_> {
    /// Shows all modes, one after the other; those that are one of the four with 1 in their own place.
    #[inline(always)]
    fn others(&self, mut add: impl FnMut(One<'_>, Option<f64x4>)) {
        for (i, four) in self.modes.groups().iter().enumerate() {
            let count = self.modes.count() - LANES * i;
            if i == self.place {
                let own = ITSELF.iter().take(count).enumerate();
                own.for_each(|(place, itself)| add(One { four, place }, Some(f64x4::from(*itself))));
            } else if count >= LANES {
                (0..LANES).for_each(|place| add(One { four, place }, None));
            } else {
                (0..count).for_each(|place| add(One { four, place }, None));
            }
        }
    }

    /// The bound of a sum's relative error, by the largest inverse distance.
    #[inline(always)]
    fn doubt(&self, inverse: f64x4) -> f64x4 {
        all(4.0) + (self.shift + all(8.0)) * inverse + TWO * self.relative
    }

    /// The sums of the four, see `double_sided`.
    #[inline(always)]
    fn double_sided(&self) -> (Own<f64x4>, Mirror<f64x4>) {
        let [mut direct, mut bent, mut sigma, mut g, mut h] = [ZERO; 5];
        let [mut direct_size, mut bent_size, mut sigma_size, mut g_size, mut nearest] = [ZERO; 5];
        let Mode { weight, frequency, cos, sin, sin_over, inverse: over, .. } = self.group;
        self.others(
            #[inline(always)]
            |other, itself| {
                let (w, x, c) = (other.all(|o| &o.weight), other.all(|o| &o.sin_over), other.all(|o| &o.cos));
                let (sum, minus) = (cos + c, cos - c);
                let spread = frequency - other.all(|o| &o.frequency);
                let product = minus * sum;
                let inverse = ONE / itself.map_or(product, |itself| product + itself);
                let of_difference = w * sum * inverse;
                let turned = (other.all(|o| &o.sin) - sin) * of_difference;
                let swung = x * spread * spread * of_difference;
                let pole = itself.map_or(w, |itself| w - w * itself) * minus * inverse;
                let in_g = x * pole;
                (direct, bent) = (direct + turned, bent + swung);
                (direct_size, bent_size) = (direct_size + turned.abs(), bent_size + swung.abs());
                (sigma, g, h) = (sigma + pole, g + in_g, h + other.all(|o| &o.sin_times) * pole);
                (sigma_size, g_size) = (sigma_size + pole.abs(), g_size + in_g.abs());
                nearest = nearest.fast_max(inverse.abs());
            },
        );
        let doubt = self.doubt(nearest);
        // The mode itself turns by its cosine.
        let value = TWO * (sin * direct + weight * cos) + sin_over * bent;
        let size = TWO * (sin.abs() * direct_size + weight * cos.abs()) + sin_over.abs() * bent_size;
        // The sines' own difference cancels, too.
        let error = size * doubt + all(4.0) * (ONE + TWO * self.relative) * nearest;
        let size = sigma_size + over.abs() * g_size;
        (Own::known(value, error), Mirror::known([sigma, g, h], size, size * doubt))
    }

    /// The residues of the four and their bounds, see `single_sided`.
    #[inline(always)]
    fn single_sided(&self) -> (f64x4, f64x4) {
        let [mut straight, mut bent, mut straight_size, mut bent_size, mut nearest] = [ZERO; 5];
        let Mode { weight, cos, sin, sin_over, inverse: over, shift, .. } = self.group;
        self.others(
            #[inline(always)]
            |other, itself| {
                let c = other.all(|o| &o.cos);
                let (minus, spread) = (cos - c, sin_over - other.all(|o| &o.sin_over));
                let product = TWO * minus * (cos + c);
                let inverse = ONE / itself.map_or(product, |itself| product + itself);
                let weighed = other.all(|o| &o.weight) * inverse;
                let turned = weighed * minus;
                let swung = weighed * (c * other.all(|o| &o.inverse)) * spread * spread;
                (straight, bent) = (straight + turned, bent + swung);
                (straight_size, bent_size) = (straight_size + turned.abs(), bent_size + swung.abs());
                nearest = nearest.fast_max(inverse.abs());
            },
        );
        let doubt = self.doubt(TWO * nearest);
        // The mode itself counts half its weight.
        let half = all(0.5) * weight;
        let (straight, straight_size) = (TWO * cos * straight + half, TWO * cos.abs() * straight_size + half);
        let (bent, bent_size) = (over * bent, over.abs() * bent_size);
        let phase = shift / sin.abs().fast_max(all(f64::MIN_POSITIVE));
        let error = (straight_size + cos.abs() * bent_size) * doubt + (phase + all(4.0)) * bent_size;
        (TWO * weight * (straight - cos * bent), all(4.0 * f64::EPSILON) * weight * (error + ONE))
    }
}

#[cfg(test)]
mod tests {
    use vibrochain_breather::{Family, Finder, OrbitList};
    use vibrochain_lattice::{Chain, ImpulseResponse, Model, Spectrum};
    use vibrochain_testkit::Random;

    use super::*;
    use crate::map_paths::reversible::residues::Residues;
    use crate::map_paths::reversible::verdict::{Reason, Secular, Standing};

    /// Against the residues with an error of their own each.
    #[test]
    fn yes_is_a_yes_with_all_errors_and_is_said_of_many_stable_orbits() {
        let mut random = Random(19);
        let (mut finder, mut found) = (Finder::new(1), OrbitList::default());
        let (mut residues, mut secular) = (Residues::default(), Secular::default());
        let (mut yes, mut equal, mut others) = ([0; 2], [0; 2], 0);
        for _ in 0..6000 {
            let sites = random.of(&[2, 3, 6, 11, 21, 40, 64]);
            let gamma1 = random.of(&[0.0, 1e-3, 0.2, 0.2, 0.2]);
            let gamma2 = random.of(&[1e-9, 1e-3, 0.3, 0.3, 0.3, 3.0]) * random.between(0.01, 1.0);
            let chain = Chain::new(sites, gamma1, gamma2).unwrap();
            let model = Model::conservative(chain, random.between(0.3, 3.3), random.between(0.0, 0.8)).unwrap();
            for (i, family) in [Family::DoubleSided, Family::SingleSided].into_iter().enumerate() {
                if finder.find(&model, family, &mut found).is_err() {
                    continue;
                }
                for orbit in found.orbits.iter().filter(|orbit| orbit.is_reversible()) {
                    let ratio_error = 4.0 * f64::EPSILON;
                    let prepared = finder.prepared(orbit).unwrap();
                    let Some(ratio) = residues.take_over(prepared, ratio_error) else { continue };
                    let quick = residues.all_positive(ratio);
                    let prepared = finder.prepared(orbit).unwrap();
                    let told = secular.residues.replace_within(prepared, ratio_error).and_then(|()| secular.verdict());
                    let stable = told.is_ok_and(|verdict| {
                        (verdict.outcome, verdict.reason) == (Standing::Stable, Reason::EqualResidueSigns)
                    });
                    assert!(stable || !quick, "{model:?} {family:?} {told:?}");
                    yes[i] += usize::from(quick);
                    equal[i] += usize::from(stable);
                    others += usize::from(!stable);
                }
            }
        }
        let many = |i: usize| 3 * yes[i] > equal[i] && yes[i] > 500;
        assert!(many(0) && many(1) && others > 500, "{yes:?} {equal:?} {others}");
    }

    /// Residues of rings and their errors, plain ones and careful ones, as lists of (residue, error).
    fn both(modes: &Modes, ratio: Option<f64>) -> [Vec<(f64, f64)>; 2] {
        let (mut shift, mut relative) = (0.0_f64, 0.0_f64);
        for mode in modes.list() {
            (shift, relative) = (shift.max(mode.shift), relative.max(mode.relative));
        }
        let saltations = ratio.map(|ratio| Saltations::by_fours(modes, ratio, 0.0));
        let mut plain = Vec::new();
        for (place, group) in modes.groups().iter().enumerate() {
            let group = group.four();
            let four = Four { modes, group, place, shift: all(shift), relative: all(relative) };
            let (residue, error) = match &saltations {
                Some(saltations) => {
                    let (own, mirror) = four.double_sided();
                    double_sided::residue(&group, saltations, &own, &mirror)
                }
                None => four.single_sided(),
            };
            plain.extend(residue.to_array().into_iter().zip(error.to_array()));
        }
        plain.truncate(modes.count());
        let (mut masked, mut poles) = (Vec::new(), Vec::new());
        match ratio {
            Some(ratio) => {
                double_sided::residues(modes, &Saltations::new(modes, ratio, 0.0), &mut masked, &mut poles);
            }
            None => single_sided::residues(modes, &mut poles),
        }
        [plain, poles.iter().map(|pole| (pole.residue, pole.error)).collect()]
    }

    /// Plain residues are careful ones to the errors of both, and what is beyond several times its own error is beyond the careful one.
    #[test]
    fn plain_residues_are_careful_ones_and_have_no_smaller_errors() {
        let (mut random, mut checked) = (Random(71), [0; 2]);
        for round in 0..400 {
            let (sites, gamma1, gamma2) = (2 + random.below(30), random.log(1e-2, 1.0), random.log(1e-2, 1.0));
            let ratio = if round % 2 == 0 { None } else { Some(random.of(&[1.0, -1.0]) * random.log(0.3, 3.0)) };
            let spectrum = Spectrum::new(Chain::new(sites, gamma1, gamma2).unwrap());
            let Ok(response) = ImpulseResponse::new(&spectrum, random.between(0.3, 3.0)) else { continue };
            let mut modes = Modes::default();
            modes.set(&response);
            let [plain, careful] = both(&modes, ratio);
            for (k, (plain, careful)) in plain.iter().zip(&careful).enumerate() {
                let off = (plain.0 - careful.0).abs();
                assert!(off <= plain.1 + careful.1, "{round} {k}: {plain:?} {careful:?}");
                assert!(careful.1 <= ROOM * plain.1, "{round} {k}: {plain:?} {careful:?}");
                checked[usize::from(ratio.is_some())] += 1;
            }
        }
        assert!(checked.iter().all(|count| *count > 500), "{checked:?}");
    }
}
