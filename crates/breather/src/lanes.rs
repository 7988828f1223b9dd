//! Numbers in groups of four, one vector instruction each where the machine has it.

use wide::f64x4;

/// Numbers in a group.
pub(crate) const LANES: usize = 4;

/// A group.
pub(crate) type Lane = [f64; LANES];

/// Groups in a row of `count` numbers: a few sizes only up to 12, for which there is code of its own.
pub(crate) fn groups(count: usize) -> usize {
    let least = count.div_ceil(LANES);
    [1, 2, 3, 4, 6, 8, 12].into_iter().find(|&groups| groups >= least).unwrap_or(least)
}

/// Sum of the products of two rows.
pub(crate) fn dot(a: &[Lane], b: &[Lane]) -> f64 {
    let products = a.iter().zip(b).map(|(a, b)| f64x4::from(*a) * f64x4::from(*b));
    total(products.fold(f64x4::ZERO, |sum, product| sum + product))
}

/// Sum of a group, in the same order on every machine.
pub(crate) fn total(sum: f64x4) -> f64 {
    let [a, b, c, d] = sum.to_array();
    (a + c) + (b + d)
}

/// Σ factor·row over the rows of `table`, each as long as `out`; rows are added in their order.
pub(crate) fn combine(table: &[Lane], factors: impl Iterator<Item = f64> + Clone, out: &mut [Lane]) {
    let width = out.len();
    let mut from = 0;
    while from < width {
        // As many groups at a time as processors have registers for.
        from += match width - from {
            1 => combine_groups::<1>(table, factors.clone(), from, out),
            2 => combine_groups::<2>(table, factors.clone(), from, out),
            _ => combine_groups::<3>(table, factors.clone(), from, out),
        };
    }
}

fn combine_groups<const N: usize>(
    table: &[Lane],
    factors: impl Iterator<Item = f64>,
    from: usize,
    out: &mut [Lane],
) -> usize {
    let mut sum = [f64x4::ZERO; N];
    for (row, factor) in table.chunks_exact(out.len()).zip(factors) {
        let Some(groups) = row.get(from..).and_then(|row| row.first_chunk::<N>()) else { return N };
        let factor = f64x4::splat(factor);
        for i in 0..N {
            sum[i] += f64x4::from(groups[i]) * factor;
        }
    }
    for (out, sum) in out[from..from + N].iter_mut().zip(sum) {
        *out = sum.to_array();
    }
    N
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sums_of_rows_and_products() {
        for groups in 1..9 {
            let rows = 5;
            let number = |k: usize, i: usize| ((7 * k + 3 * i) % 11) as f64 - 4.0;
            let table: Vec<Lane> =
                (0..rows * groups).map(|r| std::array::from_fn(|i| number(r / groups, 4 * (r % groups) + i))).collect();
            let mut out = vec![[f64::NAN; LANES]; groups];
            combine(&table, (0..rows).map(|k| k as f64 - 1.0), &mut out);
            for (i, sum) in out.as_flattened().iter().enumerate() {
                assert_eq!(*sum, (0..rows).map(|k| (k as f64 - 1.0) * number(k, i)).sum());
            }
            let direct: f64 = (0..4 * groups).map(|i| number(0, i) * number(1, i)).sum();
            assert_eq!(dot(&table[..groups], &table[groups..2 * groups]), direct);
        }
        assert_eq!([1, 4, 5, 11, 12, 17, 33, 48, 49, 60].map(groups), [1, 1, 2, 3, 3, 6, 12, 12, 13, 15]);
    }
}
