//! Exact flight: the Taylor series of every coordinate, from what pulls at it.
//!
//! With d_k the k-th time derivative of the displacements at the origin of a series,
//!
//! ```text
//! d_{k+2} = −M⁻¹ (K d_k + C d_{k+1}) + F_k ,          u_n(s) = Σ_k d_k[n] s^k/k! ,
//! ```
//!
//! for every mass that flies (of a chain: `stencil`); a mass at rest has d_k = 0 for k ≥ 1 and the right-hand side is the force on its
//! barrier. Nothing here knows the modes, so that masses at rest change nothing, and no time step is made: a window
//! is as long as what the series leaves out stays below rounding (`flight::local`).
//!
//! - Derivatives, not Taylor coefficients: the recurrence then has no division, whose constant rounding errors would
//!   add up over a million windows. The divisions are in the weights s^k/k!, the first of them in two words.
//! - Rows hold one order of all masses, with a ghost column on either side: the ring's other end, the last mass itself
//!   (a free end), 0 (a wall), or, for a part, its neighbours' known series. Rings of one and two masses are right without
//!   a special case. Of several layers the neighbours are looked up in a list, in which ghost column 0 is the wall.

pub(crate) mod bound;
pub(crate) mod part;
pub(crate) mod stencil;
pub(crate) mod weights;

use std::ops::Range;

use wide::{f64x4, f64x8};

use crate::series::weights::{TWO_WORDS, Weights};
use crate::units::MAX_ORDER;
use vibrochain_lattice::Ends;

/// Masses handled at once; rows are padded so that the last group may run over the end.
pub(crate) const LANES: usize = 8;

/// Orders below this are corrected for what rounding took from a mass that leaves a barrier.
pub(crate) const CORRECTED: usize = 9;

/// Eight of `all` numbers from `base` on; beyond the last there are zeros.
#[inline(always)]
pub(crate) fn eight(all: &[f64], base: usize) -> [f64; LANES] {
    all[base..].first_chunk().copied().unwrap_or_else(|| {
        let mut some = [0.0; LANES];
        some.iter_mut().zip(&all[base..]).for_each(|(some, one)| *some = *one);
        some
    })
}

/// The same number four times.
fn all(x: f64) -> f64x4 {
    f64x4::splat(x)
}

/// Rows of derivatives, d_0 … d_K.
#[derive(Debug, Clone, Default)]
pub(crate) struct Rows {
    pub(crate) data: Vec<f64>,
    pub(crate) stride: usize,
    pub(crate) order: usize,
    /// Series beyond the first and the last column, where these do not follow from the columns.
    pub(crate) edges: [[f64; MAX_ORDER + 1]; 2],
}

impl Rows {
    /// d_k of column `n`.
    pub(crate) fn get(&self, k: usize, n: usize) -> f64 {
        self.data[k * self.stride + n + 1]
    }

    /// d_k of all columns from `n` on.
    pub(crate) fn row(&self, k: usize, n: usize) -> &[f64] {
        &self.data[k * self.stride + n + 1..(k + 1) * self.stride]
    }

    /// d_k of eight columns from `n` on, the highest of the `orders` first.
    #[inline(always)]
    pub(crate) fn eights(&self, orders: Range<usize>, n: usize) -> impl Iterator<Item = f64x8> {
        let rows = self.data[orders.start * self.stride..orders.end * self.stride].chunks_exact(self.stride);
        rows.rev().filter_map(move |row| row.get(n + 1..)?.first_chunk().copied().map(f64x8::from))
    }

    /// Takes d_1 … d_K of `count` columns of `from`, from `first` there, to the columns from `n` on.
    pub(crate) fn take(&mut self, from: &Rows, first: usize, n: usize, count: usize) {
        match count {
            0..=3 => self.take_groups::<1>(from, first, n, count),
            4..=7 => self.take_groups::<4>(from, first, n, count),
            _ => self.take_groups::<8>(from, first, n, count),
        }
    }

    /// The same by groups of `W` columns, of which the last may overlap the one before it: rows of a few columns each are shorter than
    /// a call for copying them.
    fn take_groups<const W: usize>(&mut self, from: &Rows, first: usize, n: usize, count: usize) {
        for at in (0..count).step_by(W).map(|at| at.min(count - W)) {
            let to = self.data.chunks_exact_mut(self.stride);
            for (to, from) in to.zip(from.data.chunks_exact(from.stride)).skip(1).take(self.order) {
                let to = to[n + 1 + at..].first_chunk_mut::<W>();
                if let (Some(to), Some(from)) = (to, from[first + 1 + at..].first_chunk()) {
                    *to = *from;
                }
            }
        }
    }

    /// The column that a ghost beside the mass `own` repeats; `None` if it has a series of its own, as a wall has.
    fn echo(&mut self, side: usize, ends: Option<Ends>, own: usize, far: usize) -> Option<usize> {
        match ends {
            None => None,
            Some(Ends::Closed) => Some(far),
            Some(Ends::Free) => Some(own),
            Some(Ends::Fixed) => {
                self.edges[side] = [0.0; MAX_ORDER + 1];
                None
            }
        }
    }

    /// Room for `columns` masses, reusing the memory there is.
    pub(crate) fn reset(&mut self, columns: usize) {
        self.reset_to(columns, MAX_ORDER);
    }

    /// The same for derivatives up to `order`.
    pub(crate) fn reset_to(&mut self, columns: usize, order: usize) {
        // As far as the widest group may run over the end.
        self.stride = (columns + 2).next_multiple_of(LANES) + 3 * LANES;
        let needed = self.stride * (order + 1);
        if self.data.len() < needed {
            self.data.resize(needed, 0.0);
        }
    }

    /// Fills the rows 2 … `order` from the rows 0 and 1: `advance(k, [d_k, d_{k+1}], d_{k+2})`, ghosts counted.
    #[inline(always)]
    pub(crate) fn expand(
        &mut self,
        columns: usize,
        beyond: [Option<Ends>; 2],
        order: usize,
        mut advance: impl FnMut(usize, [&[f64]; 2], &mut [f64]),
    ) {
        self.order = order;
        let echoes = [self.echo(0, beyond[0], 1, columns), self.echo(1, beyond[1], columns, 1)];
        let Self { data, stride, edges, .. } = self;
        let close = |row: &mut [f64], k: usize| {
            row[0] = echoes[0].map_or(edges[0][k], |column| row[column]);
            row[columns + 1] = echoes[1].map_or(edges[1][k], |column| row[column]);
        };
        let mut rows = data.chunks_exact_mut(*stride);
        let (Some(mut from), Some(mut next)) = (rows.next(), rows.next()) else { return };
        close(from, 0);
        close(next, 1);
        for (k, to) in rows.take(order - 1).enumerate() {
            advance(k, [from, next], to);
            close(to, k + 2);
            (from, next) = (next, to);
        }
    }

    /// Displacement (relative to the reference) and velocity of column `n`, whose displacement at the origin is `x`
    /// and to whose derivatives `lost` is added.
    pub(crate) fn at(&self, n: usize, x: f64, weights: &Weights, lost: Option<&[f64; CORRECTED]>) -> (f64, f64) {
        let (w, low) = (&weights.high, &weights.low);
        let (mut u, mut v) = (0.0, 0.0);
        if let Some(lost) = lost {
            // Least first: what is lost would vanish beside the whole.
            for k in 2..CORRECTED {
                u += w[k] * lost[k];
                v += w[k - 1] * lost[k];
            }
            for k in 2..TWO_WORDS {
                let d = self.get(k, n);
                u += low[k] * d;
                v += low[k - 1] * d;
            }
        }
        for k in (2..=self.order).rev() {
            let d = self.get(k, n);
            u += w[k] * d;
            v += w[k - 1] * d;
        }
        let first = self.get(1, n);
        (x + (w[1] * first + u), first + v)
    }

    /// The same for all columns, written to `x_out` and `v_out`.
    pub(crate) fn at_all(&self, x: &[f64], weights: &Weights, x_out: &mut [f64], v_out: &mut [f64]) {
        // Weights are fetched once for as many columns as processors have registers for.
        let mut base = 0;
        while base < x.len() {
            let rest = base..x.len();
            let (x, x_out, v_out) = (&x[rest.clone()], &mut x_out[rest.clone()], &mut v_out[rest.clone()]);
            base += match rest.len() {
                0..=8 => self.at_some::<2>(base, x, weights, x_out, v_out),
                9..=16 => self.at_some::<4>(base, x, weights, x_out, v_out),
                _ => self.at_some::<6>(base, x, weights, x_out, v_out),
            };
        }
    }

    /// The same of the first `4 V` columns from `base` on, or fewer if there are no more; their number.
    fn at_some<const V: usize>(
        &self,
        base: usize,
        x: &[f64],
        weights: &Weights,
        x_out: &mut [f64],
        v_out: &mut [f64],
    ) -> usize {
        let (mut u, mut v) = ([all(0.0); V], [all(0.0); V]);
        // Σ_{k≥2}, smallest terms first.
        if weights.low[3] != 0.0 {
            for k in 2..TWO_WORDS {
                self.accumulate(k, base, weights.low[k], weights.low[k - 1], &mut u, &mut v);
            }
        }
        for k in (2..=self.order).rev() {
            self.accumulate(k, base, weights.high[k], weights.high[k - 1], &mut u, &mut v);
        }
        let (u, v) = (u.map(f64x4::to_array), v.map(f64x4::to_array));
        let (first, s) = (self.row(1, base), weights.high[1]);
        for ((x_out, x), (first, u)) in x_out.iter_mut().zip(x).zip(first.iter().zip(u.as_flattened())) {
            *x_out = x + (s * first + u);
        }
        for (v_out, (first, v)) in v_out.iter_mut().zip(first.iter().zip(v.as_flattened())) {
            *v_out = first + v;
        }
        4 * V
    }

    /// Adds the derivatives of order `k`, weighted, to sums of four columns each. Inlined, so that the sums stay in registers.
    #[inline(always)]
    fn accumulate<const V: usize>(
        &self,
        k: usize,
        base: usize,
        w_u: f64,
        w_v: f64,
        u: &mut [f64x4; V],
        v: &mut [f64x4; V],
    ) {
        let (w_u, w_v) = (all(w_u), all(w_v));
        if let Some(row) = self.data[k * self.stride + base + 1..].as_chunks::<4>().0.first_chunk::<V>() {
            for i in 0..V {
                let d = f64x4::from(row[i]);
                u[i] += w_u * d;
                v[i] += w_v * d;
            }
        }
    }

    /// The same at `s` where the series of some columns have `origins` of their own, not 0; the weights are those of the others.
    #[inline(always)]
    pub(crate) fn all_at(
        &self,
        (s, origins): (f64, &[f64]),
        x: &[f64],
        (weights, inverse): (&Weights, &[f64; MAX_ORDER + 1]),
        [x_out, v_out]: [&mut [f64]; 2],
    ) {
        self.at_all(x, weights, x_out, v_out);
        let groups = x_out.chunks_mut(LANES).zip(v_out.chunks_mut(LANES)).zip((0..).step_by(LANES));
        for ((x_out, v_out), base) in groups {
            let of_group = &origins[base..base + x_out.len()];
            if of_group.iter().all(|origin| *origin == 0.0) {
                continue;
            }
            let (x_then, v_then) = self.eight_at(base, (s, origins), x, inverse);
            for (i, origin) in of_group.iter().enumerate() {
                if *origin != 0.0 {
                    (x_out[i], v_out[i]) = (x_then[i], v_then[i]);
                }
            }
        }
    }

    /// Eight columns at `s`, whatever the origins of their series.
    #[inline(always)]
    pub(crate) fn eight_at(
        &self,
        base: usize,
        (s, origins): (f64, &[f64]),
        x: &[f64],
        inverse: &[f64; MAX_ORDER + 1],
    ) -> ([f64; LANES], [f64; LANES]) {
        let lapses = eight(origins, base).map(|origin| s - origin);
        self.each_at(base, &eight(x, base), &lapses, inverse)
    }

    /// Displacements and velocities of eight neighbouring columns, each at a time since its own origin, where its displacement is
    /// `x`: by Horner's rule, as there would be eight sets of weights.
    pub(crate) fn each_at(
        &self,
        base: usize,
        x: &[f64; LANES],
        lapses: &[f64; LANES],
        inverse: &[f64; MAX_ORDER + 1],
    ) -> ([f64; LANES], [f64; LANES]) {
        let (lapses, zero) = (f64x8::from(*lapses), f64x8::ZERO);
        let (mut u, mut v, mut above) = (zero, zero, zero);
        for (row, inverse) in self.eights(1..self.order + 1, base).zip(inverse[1..=self.order].iter().rev()) {
            let part = lapses * f64x8::splat(*inverse);
            u = row + above * u;
            v = row + part * v;
            above = part;
        }
        ((f64x8::from(*x) + lapses * u).to_array(), v.to_array())
    }

    /// Derivatives of column `n` at the time of the `weights`, as far as the series reaches. `u` is the displacement
    /// at the origin.
    pub(crate) fn shifted(&self, n: usize, u: f64, weights: &Weights, out: &mut [f64; MAX_ORDER + 1]) {
        if self.order < 16 {
            self.shifted_groups::<4>(n, u, weights, out);
        } else {
            self.shifted_groups::<7>(n, u, weights, out);
        }
    }

    /// The same of `4 G` derivatives, those beyond the order being 0. (Inlined: their number is known then.)
    #[inline(always)]
    fn shifted_groups<const G: usize>(&self, n: usize, u: f64, weights: &Weights, out: &mut [f64; MAX_ORDER + 1]) {
        let mut own = [0.0; 2 * MAX_ORDER + 8];
        let column = self.data[n + 1..].iter().step_by(self.stride);
        own.iter_mut().zip(column).take(self.order + 1).for_each(|(own, d)| *own = *d);
        own[0] = u;
        let mut sums = [all(0.0); G];
        for j in (0..=self.order).rev() {
            let w = all(weights.high[j]);
            if let Some(own) = own[j..].as_chunks::<4>().0.first_chunk::<G>() {
                for i in 0..G {
                    sums[i] += w * f64x4::from(own[i]);
                }
            }
        }
        let sums = sums.map(f64x4::to_array);
        out.iter_mut().zip(sums.as_flattened()).for_each(|(out, sum)| *out = *sum);
    }
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// Rows of zeros.
    pub(crate) fn empty(columns: usize) -> Rows {
        let mut rows = Rows::default();
        rows.reset(columns);
        rows
    }

    /// Rows of `order` whose entries are all different, between −1 and 1.
    pub(crate) fn filled(columns: usize, order: usize) -> Rows {
        let mut rows = Rows { order, ..empty(columns) };
        let mut seed = columns as u64;
        rows.data.iter_mut().for_each(|d| *d = crate::units::spread(&mut seed));
        rows
    }

    #[test]
    fn columns_are_taken_whole_and_others_left_alone() {
        for count in 0..=30 {
            let (from, before) = (filled(40, 12), filled(53, 12));
            let mut to = before.clone();
            to.take(&from, 5, 11, count);
            for (k, n) in (0..=MAX_ORDER).flat_map(|k| (0..53).map(move |n| (k, n))) {
                let taken = (1..=12).contains(&k) && (11..11 + count).contains(&n);
                let expected = if taken { from.get(k, n - 11 + 5) } else { before.get(k, n) };
                assert_eq!(to.get(k, n), expected, "{count} columns, order {k}, column {n}");
            }
        }
    }

    #[test]
    fn eight_columns_are_each_where_their_series_are_at_times_of_their_own() {
        let inverse = std::array::from_fn(|k| 1.0 / k.max(1) as f64);
        for order in [10, 24] {
            let rows = filled(19, order);
            let (x, lapses) = (std::array::from_fn(|i| 0.1 * i as f64), std::array::from_fn(|i| 1.3 - 0.17 * i as f64));
            let (u, v) = rows.each_at(6, &x, &lapses, &inverse);
            for i in 0..LANES {
                let mut weights = Weights::zero();
                weights.plain(lapses[i], order, &crate::units::inverse_factorials());
                let (u_alone, v_alone) = rows.at(6 + i, x[i], &weights, None);
                assert!((u[i] - u_alone).abs() < 4e-15 && (v[i] - v_alone).abs() < 4e-15, "order {order}, column {i}");
            }
        }
    }
}
