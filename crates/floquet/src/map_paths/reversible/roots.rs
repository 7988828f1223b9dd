//! All roots ν of F: real ones from their brackets, and what is missing then by searches with the known ones divided out.

use nalgebra::Complex;

use crate::map_paths::fast_sums::neighbourhood::Nearby;
use crate::map_paths::fast_sums::off_axis_roots::seek;
use crate::map_paths::reversible::complex_pairs::Suspect;
use crate::map_paths::reversible::gap::{beyond, lowest, lowest_within, root};
use crate::map_paths::reversible::residues::Residues;
use crate::map_paths::reversible::root::{Root, Touching};
use crate::map_paths::reversible::verdict::{Secular, tangency};
use crate::zeros::SecularError;

/// A real root in a gap, from the nearer pole, and its error.
fn bracketed(form: &Residues, scratch: &mut Nearby, gap: usize, (low, high): (f64, f64), rising: bool) -> Root {
    let width = form.distance(gap + 1, gap);
    // On which side of the middle?
    let middle = 0.5 * (low + high);
    let from_left = (form.window(gap, gap, scratch).value(middle) > 0.0) == rising || high < 0.5 * width;
    let (place, low, high, other) = if from_left && low < 0.5 * width {
        (gap, low, high, width)
    } else {
        (gap + 1, low - width, high - width, -width)
    };
    let local = form.window(gap, place, scratch);
    let t = root(local, (low, high), rising, |t| 1.0 / t - 1.0 / (other - t));
    Root { place, t: Complex::new(t, 0.0), error: local.root_error(t).min(width) }
}

impl Secular {
    /// All m−1 non-trivial ν of the orbit taken over, in no order, with estimates of their errors. Complex ones come in
    /// conjugate pairs.
    ///
    /// # Errors
    /// [`SecularError::Incomplete`].
    ///
    /// ```
    /// use vibrochain_breather::{Family, Finder, OrbitList};
    /// use vibrochain_floquet::Secular;
    /// use vibrochain_lattice::{Chain, Model};
    /// let model = Model::conservative(Chain::new(21, 0.2, 0.1)?, 0.8, 0.4)?;
    /// let (mut finder, mut found, mut secular) = (Finder::new(21), OrbitList::default(), Secular::default());
    /// finder.find(&model, Family::SingleSided, &mut found)?;
    /// secular.replace(finder.prepared(&found.orbits[0])?)?;
    /// let (roots, _) = secular.roots()?;
    /// let largest = roots.iter().map(|nu| nu.re).fold(0.0, f64::max);
    /// // ν = (μ + 1/μ)/2 of μ = 2.7975…
    /// assert!(roots.len() == 10 && (largest - 1.5775134618876).abs() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn roots(&mut self) -> Result<(&[Complex<f64>], &[f64]), SecularError> {
        self.solve()?;
        let Self { residues: form, roots, .. } = self;
        if roots.values.is_empty() {
            roots.values.extend(roots.list.iter().map(|root| form.nu(root.place, root.t).complex()));
            roots.errors.extend(roots.list.iter().map(|root| root.error));
        }
        Ok((&roots.values, &roots.errors))
    }

    pub(crate) fn solve(&mut self) -> Result<(), SecularError> {
        let Self { residues: form, nearby: scratch, suspects, roots, search, .. } = self;
        // A verdict may have asked for them already.
        if roots.edition == Some(form.edition) {
            return Ok(());
        }
        roots.edition = None;
        scratch.forget();
        roots.values.clear();
        roots.errors.clear();
        roots.list.clear();
        roots.gaps.clear();
        roots.touching.clear();
        suspects.clear();
        let signs = form.residues();
        let large = !form.neighbourhoods.is_empty();
        let wanted = form.count().saturating_sub(1);
        roots.list.reserve(wanted);
        roots.gaps.reserve(wanted + 1);
        for gap in 0..wanted {
            roots.gaps.push(roots.list.len() as u32);
            let (left, right) = (signs[gap], signs[gap + 1]);
            let width = form.distance(gap + 1, gap);
            if (left > 0.0) == (right > 0.0) {
                // Coincident modes keep their multiplier.
                if width > 0.0 {
                    roots.list.push(bracketed(form, scratch, gap, (0.0, width), left < 0.0));
                } else {
                    roots.real(gap, 0.0, 4.0 * f64::EPSILON);
                }
                continue;
            }
            let local = form.window(gap, gap, scratch);
            let ends = (left, right);
            // In a large ring some residue is always as good as lost; its roots are those of F as it has been worked out, or
            // their number would not be right.
            let low = if large {
                lowest_within(local, left.signum(), width, ends, |t| local.rounding(Complex::new(t, 0.0)))
            } else {
                lowest(local, left.signum(), width, ends)
            };
            let half = low.half_distance();
            if !low.is_certain() {
                let noise = local.noise(Complex::new(low.t, 0.0));
                let error = if low.bend > 0.0 { (2.0 * (low.value.abs() + noise) / low.bend).sqrt() } else { width };
                roots.real(gap, low.t, error);
                roots.real(gap, low.t, error);
            } else if low.value < 0.0 {
                if large && half < 0.03 * width {
                    // Certain of F as it has been worked out; of F as it is?
                    let low = lowest(local, left.signum(), width, ends);
                    if !low.is_certain() {
                        roots.touching.push(Touching { gap, t: low.t, reach: tangency(&low) });
                    }
                }
                for (bracket, rising) in [((0.0, low.t), left < 0.0), ((low.t, width), left > 0.0)] {
                    roots.list.push(bracketed(form, scratch, gap, bracket, rising));
                }
            } else {
                suspects.push(Suspect { gap, t: low.t, height: half, closeness: half / width });
            }
        }
        roots.gaps.push(roots.list.len() as u32);
        let ends = [(1.0, &form.below_one, signs.last()), (-1.0, &form.above_minus_one, signs.first())];
        for (end, below, outermost) in ends {
            let Some(&outermost) = outermost else { continue };
            let local = form.about(below);
            let at_end = local.value(0.0);
            let (place, room) = if end > 0.0 { (wanted, below) } else { (0, below) };
            let room = room.as_flattened().get(place).copied().unwrap_or_default();
            if (outermost > 0.0) != (at_end > 0.0) {
                let nearest = below.iter().flatten().copied().fold(f64::INFINITY, f64::min);
                let delta = root(local, (-nearest, 0.0), outermost < 0.0, |t| 1.0 / (nearest + t));
                roots.real(place, end * (delta + room), local.root_error(delta));
            }
            if at_end < 0.0 {
                let delta = beyond(local);
                roots.real(place, end * (delta + room), local.root_error(delta));
            }
        }
        if roots.list.len() < wanted {
            seek(search, form, roots, suspects, wanted);
        }
        let found = roots.list.len();
        if found != wanted {
            return Err(SecularError::Incomplete { found, wanted });
        }
        // Σν is known: a root found twice and another missed would show.
        let sum: f64 = roots.list.iter().map(|root| form.nu(root.place, root.t).complex().re).sum();
        let slack: f64 = roots.list.iter().map(|root| root.error).sum::<f64>() + form.errors().iter().sum::<f64>();
        let size: f64 = signs.iter().map(|r| r.abs()).sum::<f64>() + if large { 1.0 } else { wanted as f64 };
        let defect = (sum - form.sum_of_roots()).abs();
        let allowed = 16.0 * (slack + f64::EPSILON * size);
        // Against the roots themselves: residues that cancel would let anything pass.
        let passes = defect <= allowed.max(1e-9 * wanted as f64);
        if !passes {
            return Err(SecularError::Certificate { defect, allowed });
        }
        roots.edition = Some(form.edition);
        Ok(())
    }
}
