//! The zero of a continuous function between two points where its signs differ: Brent's method.

/// Evaluations at most; halving alone needs 60.
const MOST: usize = 120;

/// A point and the function's value there.
pub type Sample = (f64, f64);

/// Where the function vanishes, as closely as its argument can be told; `scale` is the size of the argument whose rounding
/// counts. The function may fail.
///
/// # Errors
/// Those of the function.
pub fn zero<E>(
    from: Sample,
    to: Sample,
    scale: f64,
    mut function: impl FnMut(f64) -> Result<f64, E>,
) -> Result<f64, E> {
    // The best estimate, the one before, and the last on the other side of the zero.
    let (mut best, mut previous, mut opposite) = (to, from, to);
    let (mut step, mut last_step) = (to.0 - from.0, to.0 - from.0);
    for _ in 0..MOST {
        if (best.1 > 0.0) == (opposite.1 > 0.0) {
            opposite = previous;
            step = best.0 - previous.0;
            last_step = step;
        }
        if opposite.1.abs() < best.1.abs() {
            (previous, best, opposite) = (best, opposite, best);
        }
        let tolerance = 2.0 * f64::EPSILON * best.0.abs() + 0.5 * f64::EPSILON * scale;
        let middle = 0.5 * (opposite.0 - best.0);
        if middle.abs() <= tolerance || best.1 == 0.0 {
            break;
        }
        let halve = (middle, middle);
        (last_step, step) = if last_step.abs() >= tolerance && previous.1.abs() > best.1.abs() {
            // Through two points a secant, through three an inverse parabola.
            let s = best.1 / previous.1;
            let (p, q) = if previous.0 == opposite.0 {
                (2.0 * middle * s, 1.0 - s)
            } else {
                let (q, r) = (previous.1 / opposite.1, best.1 / opposite.1);
                let p = s * (2.0 * middle * q * (q - r) - (best.0 - previous.0) * (r - 1.0));
                (p, (q - 1.0) * (r - 1.0) * (s - 1.0))
            };
            let (p, q) = if p > 0.0 { (p, -q) } else { (-p, q) };
            let inside = (3.0 * middle * q - (tolerance * q).abs()).min((last_step * q).abs());
            if 2.0 * p < inside { (step, p / q) } else { halve }
        } else {
            halve
        };
        previous = best;
        best.0 += if step.abs() > tolerance { step } else { tolerance.copysign(middle) };
        best.1 = function(best.0)?;
    }
    Ok(best.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_to_the_last_digit_in_few_evaluations() {
        type Case = (fn(f64) -> f64, f64, f64, f64);
        let cases: [Case; 4] = [
            (|x| x * x - 2.0, 0.0, 5.0, 2f64.sqrt()),
            (|x| x.cos() - x, 0.0, 1.0, 0.739_085_133_215_160_6),
            (|x| (x - 0.25).powi(3), -1.0, 1.0, 0.25),
            // Steep on one side, flat on the other.
            (|x| 1.0 - (-30.0 * (x - 0.1)).exp(), 0.0, 4.0, 0.1),
        ];
        for (i, (f, low, high, expected)) in cases.into_iter().enumerate() {
            for (a, b) in [(low, high), (high, low)] {
                let mut count = 0;
                let found = zero((a, f(a)), (b, f(b)), 1.0, |x| {
                    count += 1;
                    Ok::<f64, ()>(f(x))
                });
                // A triple zero is known to the cube root of rounding, but x³ keeps its sign.
                assert!((found.unwrap() - expected).abs() < if i == 2 { 1e-6 } else { 4e-16 }, "{i}: {found:?}");
                // Secants fail a triple zero, which is left to halving.
                assert!(count <= [12, 12, MOST, 30][i], "{i}: {count}");
            }
        }
        assert_eq!(zero((0.0, -1.0), (1.0, 1.0), 1.0, |_| Err("lost")), Err("lost"));
    }
}
