//! Roots of a large ring that brackets do not show: complex pairs above all, and the two more that a gap may hold now and
//! then.
//!
//! 1. Searches from the lowest points of |F|.
//! 2. The same from above every neighbourhood, and from above every gap: a gap between equal signs may hold
//!    three roots, where residues differ much in size.
//! 3. What is left anywhere.

use nalgebra::Complex;

use crate::map_paths::fast_sums::zero_search::{Zero, ZeroSearch};
use crate::map_paths::reversible::complex_pairs::Suspect;
use crate::map_paths::reversible::residues::{Middle, Residues};
use crate::map_paths::reversible::root::{Root, Roots};

type C = Complex<f64>;

/// Seeks what `roots` lack of `wanted`.
pub(crate) fn seek(
    search: &mut ZeroSearch,
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
