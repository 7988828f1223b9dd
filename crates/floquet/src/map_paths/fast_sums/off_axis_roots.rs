//! Roots of a large ring that brackets do not show: complex pairs above all, and the two more that a gap may hold now and
//! then.
//!
//! 1. Searches from the lowest points of |F|.
//! 2. The same from above every neighbourhood, and from above every gap: a gap between equal signs may hold
//!    three roots, where residues differ much in size.
//! 3. What is left anywhere.

use nalgebra::Complex;
use smallvec::{SmallVec, smallvec};
use vibrochain_lattice::simd::lanes::{ONE, TWO, ZERO, all, four, total};

use crate::map_paths::fast_sums::evaluate::Local;
use crate::map_paths::fast_sums::neighbourhood::Nearby;
use crate::map_paths::fast_sums::zero_search::{Near, Poles, Zero, ZeroSearch};
use crate::map_paths::reversible::complex_pairs::Suspect;
use crate::map_paths::reversible::residues::{Middle, Residues};
use crate::map_paths::reversible::root::{Root, Roots};

type C = Complex<f64>;

/// Seeks what `roots` lack of `wanted`.
pub(crate) fn seek(
    search: &mut ZeroSearch<2>,
    form: &Residues,
    roots: &mut Roots,
    suspects: &mut [Suspect],
    wanted: usize,
) {
    search.begin(form);
    for Root { place, t, error } in &roots.list {
        search.note(form, Zero { place: *place, offset: *t, error: *error, real: true });
    }
    let early = search.zeros.len();
    suspects.sort_unstable_by(|a, b| a.closeness.total_cmp(&b.closeness));
    let lowest = suspects.iter().map(|suspect| (suspect.gap, C::new(suspect.t, suspect.height)));
    let above_neighbourhoods = (0..form.neighbourhoods.len()).flat_map(|neighbourhood| {
        let Middle { gap, offset, half_width } = form.middle(neighbourhood);
        [0.4, 0.15].map(|part| (gap, C::new(offset, part * half_width)))
    });
    let above_gaps = (0..wanted).filter_map(|gap| {
        let width = form.distance(gap + 1, gap);
        (width > 0.0).then_some((gap, C::new(0.5 * width, width)))
    });
    for (gap, start) in lowest.chain(above_neighbourhoods).chain(above_gaps) {
        if search.found >= wanted {
            break;
        }
        search.nearby(form, gap, start);
    }
    search.anywhere(form, wanted);
    for &Zero { place, offset, error, real } in &search.zeros[early..] {
        let both = [offset, offset.conj()].into_iter().take(if real { 1 } else { 2 });
        roots.list.extend(both.map(|t| Root { place, t, error }));
    }
}

impl Poles<2> for Residues {
    type Near<'a> = Local<'a>;

    fn count(&self) -> usize {
        Residues::count(self)
    }

    fn distance(&self, place: usize, from: usize) -> f64 {
        self.distance(place, from)
    }

    fn place_at(&self, from: usize, offset: f64) -> usize {
        let last = Residues::count(self) - 1;
        let mut place = from.min(last);
        while place > 0 && offset < self.distance(place, from) {
            place -= 1;
        }
        while place < last && offset > self.distance(place + 1, from) {
            place += 1;
        }
        place
    }

    fn images(&self, _: usize, offset: C, is_pole: bool) -> SmallVec<[C; 2]> {
        if is_pole { SmallVec::new() } else { smallvec![offset.conj()] }
    }

    fn kept(&self, _: usize, offset: C) -> C {
        C::new(offset.re, offset.im.abs().max(f64::MIN_POSITIVE))
    }

    fn near<'a>(&'a self, place: usize, whole: bool, scratch: &'a mut Nearby<2>) -> Option<Local<'a>> {
        if !whole {
            return Some(self.window(place.min(Residues::count(self).saturating_sub(2)), place, scratch));
        }
        self.distances(place, &mut scratch.distances);
        Some(self.about(&scratch.distances))
    }

    fn variable(&self, zero: &Zero) -> C {
        self.nu(zero.place, zero.offset).complex()
    }

    fn find(&self, nu: C) -> (usize, C) {
        let place = self.poles().partition_point(|pole| *pole <= nu.re).saturating_sub(1);
        (place, nu - self.poles()[place])
    }

    fn logarithmic(&self, nu: C) -> (C, C) {
        let (x, y) = (all(nu.re), all(nu.im));
        let mut sums = [ZERO; 10];
        for (residue, pole) in self.whole.charges[0].iter().zip(&self.poles) {
            let (u, residue) = (x - four(*pole), four(*residue));
            let scale = ONE / (u * u + y * y);
            // 1/(ν−d), its square and cube
            let (a, b) = (u * scale, -y * scale);
            let (a2, b2) = (a * a - b * b, TWO * a * b);
            let (a3, b3) = (a2 * a - b2 * b, a2 * b + b2 * a);
            let terms =
                [residue * a, residue * b, residue * a2, residue * b2, residue * a3, residue * b3, a, b, a2, b2];
            // What pads a group is far away, but not to be counted among the poles.
            sums.iter_mut().zip(terms).for_each(|(sum, term)| *sum += term);
        }
        let sum = |i: usize| C::new(total(sums[i]), total(sums[i + 1]));
        let (value, slope, half_bend) = (sum(0), -sum(2), sum(4));
        let ratio = slope / value;
        (ratio + sum(6), half_bend * 2.0 / value - ratio * ratio - sum(8))
    }

    fn start(&self, attempt: u32, known: &[C], missing: usize) -> C {
        let rest: f64 = known.iter().map(|nu| nu.re).sum();
        C::from_polar(0.5, 1.5 + f64::from(attempt)) + (self.sum_of_roots() - rest) / missing as f64
    }

    fn close_enough(&self, nu: C) -> f64 {
        1e-6 * nu.im.abs().max(1e-6)
    }
}

impl Near for Local<'_> {
    fn value(&self, t: C) -> Option<(C, C)> {
        self.holds(t).then(|| self.complex(t))
    }

    fn errors(&self, t: C) -> (f64, f64) {
        (self.rounding(t), self.noise(t))
    }

    fn axis(&self, t: C) -> (C, C) {
        (C::new(t.re, 0.0), C::new(1.0, 0.0))
    }

    fn resolution(&self, t: C) -> f64 {
        f64::EPSILON * t.norm()
    }
}
