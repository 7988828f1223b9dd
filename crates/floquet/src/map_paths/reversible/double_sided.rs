//! Residues of two impacts half a period apart, signed impulses P₀ and P₁.
//!
//! Let S̄ be the mean of the two saltations, K = κ'₀+κ'₁, δ = κ'₀−κ'₁, and L half a period's flight. Sums and differences of the two
//! halves split det(w² − LS₁LS₀) into det(w−LS̄)·det(w+LS̄) and a dyad each way; ∂f_h/∂K = −g̃ of the one-impact function f_h of *half* a
//! period gives the dyads' factor:
//!
//! ```text
//! f(ν) = f_h(ρ)f_h(−ρ) − δ² g̃(ρ)g̃(−ρ),   ρ² = (1+ν)/2,   f_h(ρ) = (ρ²−1)σ̃² + g̃(h̃ − K),
//! σ̃ = Σ b²/(ρ−c),   g̃ = Σ b²x/(ρ−c),   h̃ = Σ b²y/(ρ−c),   x = s/Ω,   y = sΩ.
//! ```
//!
//! With f_h = Q − Kg̃ that is QQ⁻ − K(Qg̃⁻ + Q⁻g̃) + Λg̃g̃⁻, Λ = 4κ'₀κ'₁: the squares of κ', which grow without
//! bound as one impact turns to grazing, have cancelled. The orbit's velocities −P/2 and accelerations give, with
//! X = P₁/P₀, K = Σ b²(c+χ)/x, χ = (X+1/X)/2, and Λ = Σ b²(c+X)/x · Σ b²(c+1/X)/x. Then f(1) = 0, F = f/(ν−1), and with
//! dν = 4ρ dρ, d − 1 = −2s²
//!
//! ```text
//! R_k = −(2/s_k²) [ t_k (Φ_k + KΓ_k) − b_k²x_k (KΦ_k + ΛΓ_k) ],    Φ_k = c_k Q(−c_k),   Γ_k = −c_k g̃(−c_k),
//! t_k = b_k² Σ_l b_l² [ 2s_k q_kl + x_k x_l (Ω_k−Ω_l)²/(c_k−c_l) ],   the residue of Q,
//! q_kl = (s_l−s_k)/(c_k−c_l) = (c_k+c_l)/(s_k+s_l),
//! ```
//!
//! l = k again giving the square term by the second form of q. In Φ_k and Γ_k the terms l = k, b_k²/(2c_k), are
//! multiplied out: c_k → 0 is harmless, and so are the double poles, x_k y_k = s_k². Dividing by s_k² is not, for a mode
//! that is very soft or next to resonance: its residue is better known as 1 − ΣR of the others, see [`super::residues::Residues`].

use nalgebra::Complex;
use vibrochain_lattice::simd::lanes::{FOUR, HALF, Lane, Number, ONE, SMALL, TWO, ZERO, all, four, total, totals};
use wide::f64x4;

use crate::map_paths::modes::{Mode, Modes};
use crate::map_paths::reversible::pole::Pole;

type C = Complex<f64>;

/// K, Λ and their errors in units of ε.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Saltations {
    half_kappa: f64,
    half_kappa_error: f64,
    lambda: f64,
    lambda_error: f64,
}

impl Saltations {
    /// From the ratio X = P₁/P₀ and its relative error.
    pub(crate) fn new(modes: &Modes, ratio: f64, ratio_error: f64) -> Self {
        Self::of(modes.list().iter().copied(), ratio, ratio_error)
    }

    /// The same, four modes at a time.
    pub(crate) fn by_fours(modes: &Modes, ratio: f64, ratio_error: f64) -> Self {
        Self::of(modes.groups().iter().map(Mode::four), ratio, ratio_error)
    }

    /// Of modes, one or four at a time: κ'₀ is Σ b²(c + X)/x, κ'₁ is Σ b²(c + 1/X)/x.
    #[inline(always)]
    fn of<T: Number>(modes: impl Iterator<Item = Mode<T>>, ratio: f64, ratio_error: f64) -> Self {
        let off = T::of(ratio_error / f64::EPSILON);
        let chi = 0.5 * (ratio + 1.0 / ratio);
        let mut sums = [T::default(); 6];
        for Mode { weight, inverse, cos, relative, doubt, .. } in modes {
            let stiffness = weight * inverse;
            let (size, own) = (stiffness.modulus(), relative + doubt + T::of(4.0));
            for (i, factor) in [chi, ratio, 1.0 / ratio].into_iter().enumerate() {
                sums[i] = sums[i] + stiffness * (cos + T::of(factor));
                sums[i + 3] = sums[i + 3] + size * (own * cos.modulus() + (own + off) * factor.abs());
            }
        }
        let [half_kappa, kappa0, kappa1, half_kappa_error, kappa0_error, kappa1_error] = sums.map(T::sum);
        let lambda = kappa0 * kappa1;
        let lambda_error = kappa0.abs() * kappa1_error + kappa1.abs() * kappa0_error;
        Self { half_kappa, half_kappa_error, lambda, lambda_error }
    }
}

/// What the residue of one mode needs of modes with c_l about c_k: t_k/b_k² and its error.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Own<T = f64> {
    value: T,
    error: T,
}

/// What it needs of modes with c_l about −c_k, itself left out: Σ b²/(c_k+c), Σ b²x/(…), Σ b²y/(…), the size of these and
/// the sum of their errors.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Mirror<T = f64> {
    sigma: T,
    g: T,
    h: T,
    size: T,
    doubted: T,
}

impl Own<f64x4> {
    /// From values and their errors, in units of ε.
    pub(crate) fn known(value: f64x4, error: f64x4) -> Self {
        Self { value, error }
    }

    /// The sums of one mode from their four parts.
    pub(crate) fn total(self) -> Own {
        Own { value: total(self.value), error: total(self.error) }
    }

    /// Those of four modes.
    fn totals(parts: &[Self; 4]) -> Self {
        Self { value: totals(parts.map(|part| part.value)), error: totals(parts.map(|part| part.error)) }
    }
}

impl Mirror<f64x4> {
    /// From the three sums, their size and the sum of their errors.
    pub(crate) fn known([sigma, g, h]: [f64x4; 3], size: f64x4, doubted: f64x4) -> Self {
        Self { sigma, g, h, size, doubted }
    }

    /// The sums of one mode from their four parts.
    pub(crate) fn total(self) -> Mirror {
        let Self { sigma, g, h, size, doubted } = self;
        Mirror { sigma: total(sigma), g: total(g), h: total(h), size: total(size), doubted: total(doubted) }
    }

    /// Those of four modes.
    fn totals(parts: &[Self; 4]) -> Self {
        Self {
            sigma: totals(parts.map(|part| part.sigma)),
            g: totals(parts.map(|part| part.g)),
            h: totals(parts.map(|part| part.h)),
            size: totals(parts.map(|part| part.size)),
            doubted: totals(parts.map(|part| part.doubted)),
        }
    }
}

impl Own {
    pub(crate) fn add_far(&mut self, far: f64) {
        self.value += far;
        self.error += 4.0 * far.abs();
    }
}

impl Mirror {
    pub(crate) fn add_far(&mut self, inverse: f64, [sigma, g, h]: [f64; 3]) {
        self.sigma += sigma;
        self.g += g;
        self.h += h;
        let size = sigma.abs() + (inverse * g).abs();
        self.size += size;
        self.doubted += 8.0 * size;
    }
}

/// Both kinds of sums over `modes`, in four parts each; `masked` are their weights, that of the mode itself set to 0.
#[inline(always)]
pub(crate) fn sums(modes: &Modes, masked: &[Lane], mode: &Mode) -> (Own<f64x4>, Mirror<f64x4>) {
    let (mut own, mut own_error, mut sigma, mut g, mut h) = (ZERO, ZERO, ZERO, ZERO, ZERO);
    let (mut size, mut doubted) = (ZERO, ZERO);
    let (fk, ck, sk, xk) = (all(mode.frequency), all(mode.cos), all(mode.sin), all(mode.sin_over));
    let opposite = sk * sk - ck * ck;
    let (ik, rk, hk) = (all(mode.inverse), all(mode.relative), all(0.5 * mode.shift));
    for (group, masked) in modes.groups().iter().zip(masked) {
        let Mode { weight: w, frequency: f, cos: c, sin: s, sin_over: x, .. } = group.four();
        let Mode { sin_times: y, relative, shift, doubt: of_weight, .. } = group.four();
        let masked = four(*masked);
        let (sum, minus) = (ck + c, ck - c);
        let by_sine = (s - sk) * (s + sk);
        let difference = (c * c - s * s).simd_gt(opposite).select(by_sine, minus * sum);
        // As for one impact: no infinity where modes coincide.
        let difference = difference.simd_eq(ZERO).select(SMALL, difference);
        // Of c_k ± c_l the larger one as it is, the smaller one from the product.
        let same = (ck * c).simd_gt(ZERO);
        let large = same.select(sum, minus);
        let near = (ck * c + sk * s).simd_gt(ZERO);
        let sines = near.select(sk + s, ONE);
        // Three inverses from one division.
        let (left, right) = (difference * large, large * sines);
        let inverse = ONE / (left * sines);
        let (quotient, of_large, of_sines) = (inverse * right, inverse * (difference * sines), inverse * left);
        let of_small = large * quotient;
        let (of_sum, of_difference) = (same.select(of_large, of_small), same.select(of_small, of_large));
        let q = near.select(sum * of_sines, (s - sk) * of_difference);
        let spread = fk - f;
        let bent = xk * x * spread * spread * of_difference;
        let direct = TWO * sk * q;
        own += w * (direct + bent);
        let doubt = (hk + HALF * shift) * quotient.abs();
        let (doubt_of_sum, doubt_of_difference) = (same.select(FOUR, doubt), same.select(doubt, FOUR));
        let direct_doubt = near.select(FOUR, FOUR + doubt_of_difference);
        own_error += w
            * (direct.abs() * (direct_doubt + of_weight)
                + bent.abs() * (doubt_of_difference + rk + relative + of_weight));
        let pole = masked * of_sum;
        sigma += pole;
        g += x * pole;
        h += y * pole;
        let term = pole.abs() * (ONE + (ik * x).abs());
        size += term;
        doubted += term * (doubt_of_sum + relative + rk + of_weight);
    }
    (Own { value: own, error: own_error }, Mirror { sigma, g, h, size, doubted })
}

/// The residue from the sums, and its error.
#[inline(always)]
pub(crate) fn residue<T: Number>(mode: &Mode<T>, saltations: &Saltations, own: &Own<T>, mirror: &Mirror<T>) -> (T, T) {
    let Mode { weight: wk, cos: ck, sin: sk, sin_over: xk, sin_times: yk, relative: rk, doubt: dk, .. } = *mode;
    let Saltations { half_kappa, half_kappa_error, lambda, lambda_error } = *saltations;
    let Mirror { sigma, g, h, size, doubted } = *mirror;
    let number = T::of;
    let square = sk * sk;
    let (own, own_error) = (wk * own.value, wk * (own.error + own.value.modulus() * dk));
    let curl = g * h - square * sigma * sigma;
    let cross = ck * curl + wk * 0.5 * (xk * h + yk * g - square * sigma * 2.0);
    let tail = ck * g + wk * xk * 0.5;
    let gamma = wk * xk;
    let (upper, lower) = (cross + tail * half_kappa, cross * half_kappa + tail * lambda);
    let scale = number(-2.0) / square;
    let residue = scale * (own * upper - gamma * lower);
    // Two sums multiplied: their rounding counts twice where they cancel, the errors of their terms do not, since the
    // square terms x_l y_l − s_l² vanish whatever the phases.
    let doubt = doubted / size.at_least(number(f64::MIN_POSITIVE));
    let sums = square * size * size * 4.0 + doubt * (curl.modulus() + square * size);
    let cross_error = ck.modulus() * sums + wk * square * size * (number(4.0) + doubt + dk);
    let tail_error = (ck * xk).modulus() * size * (number(4.0) + doubt) + (wk * xk).modulus() * (rk + dk);
    let upper_error = cross_error + tail_error * half_kappa.abs() + tail.modulus() * half_kappa_error;
    let lower_error = cross_error * half_kappa.abs()
        + cross.modulus() * half_kappa_error
        + tail_error * lambda.abs()
        + tail.modulus() * lambda_error;
    let error = own_error * upper.modulus()
        + own.modulus() * upper_error
        + gamma.modulus() * (lower_error + (rk + dk) * lower.modulus());
    let error = (scale.modulus() * error + residue.modulus() * (rk + number(4.0))) * (2.0 * f64::EPSILON);
    (residue, error)
}

/// Q and g̃ at z with their slopes and errors, these in units of ε.
struct Halves {
    q: [C; 2],
    g: [C; 2],
    errors: [f64; 2],
}

impl Halves {
    fn new(modes: &Modes, z: C, period: f64) -> Self {
        let [mut sigma, mut g, mut h] = [[C::default(); 2]; 3];
        let (mut sigma_error, mut g_error, mut h_error) = (0.0, 0.0, 0.0);
        for mode in modes.list() {
            let inverse = (z - mode.cos).inv();
            let term = inverse * mode.weight;
            // The error of c moves the pole.
            let turned = (mode.frequency + 0.5 * modes.rate_error()) * period * mode.sin.abs();
            let moved = inverse.norm() * (turned + 4.0 * mode.cos.abs()) + 4.0 + mode.doubt;
            let size = term.norm();
            let add = |sum: &mut [C; 2], factor: f64| {
                sum[0] += term * factor;
                sum[1] -= term * inverse * factor;
            };
            add(&mut sigma, 1.0);
            add(&mut g, mode.sin_over);
            add(&mut h, mode.sin_times);
            sigma_error += size * moved;
            g_error += size * mode.sin_over.abs() * (moved + mode.relative);
            h_error += size * mode.sin_times.abs() * (moved + mode.relative + 4.0);
        }
        let spread = z * z - 1.0;
        let square = sigma[0] * sigma[0];
        let q = [
            spread * square + g[0] * h[0],
            z * square * 2.0 + spread * sigma[0] * sigma[1] * 2.0 + g[1] * h[0] + g[0] * h[1],
        ];
        let q_error = spread.norm() * (2.0 * sigma[0].norm() * sigma_error + 8.0 * square.norm())
            + g[0].norm() * h_error
            + h[0].norm() * g_error
            + 4.0 * (g[0] * h[0]).norm();
        Self { q, g, errors: [q_error, g_error] }
    }
}

/// A zero ρ of f next to `start`, and its error: from f itself as a product of sums, where close poles have residues that cancel and
/// know of it by their errors only.
pub(crate) fn refine(modes: &Modes, saltations: &Saltations, period: f64, start: C) -> Option<(C, f64)> {
    let Saltations { half_kappa, half_kappa_error, lambda, lambda_error } = *saltations;
    let mut rho = start;
    for _ in 0..8 {
        let [one, other] = [rho, -rho].map(|z| Halves::new(modes, z, period));
        let [crossed, both] = [one.q[0] * other.g[0] + one.g[0] * other.q[0], one.g[0] * other.g[0]];
        let value = one.q[0] * other.q[0] - crossed * half_kappa + both * lambda;
        // Of the other half z is −ρ.
        let slope = one.q[1] * (other.q[0] - other.g[0] * half_kappa)
            + one.g[1] * (other.g[0] * lambda - other.q[0] * half_kappa)
            - other.q[1] * (one.q[0] - one.g[0] * half_kappa)
            - other.g[1] * (one.g[0] * lambda - one.q[0] * half_kappa);
        let through = |of: &Halves, by: &Halves| {
            of.errors[0] * (by.q[0].norm() + (by.g[0] * half_kappa).norm())
                + of.errors[1] * ((by.q[0] * half_kappa).norm() + (by.g[0] * lambda).norm())
        };
        let sizes = (one.q[0] * other.q[0]).norm() + (crossed * half_kappa).norm() + (both * lambda).norm();
        let noise = through(&one, &other)
            + through(&other, &one)
            + half_kappa_error * crossed.norm()
            + lambda_error * both.norm()
            + 8.0 * sizes;
        let (step, error) = (value / slope, f64::EPSILON * noise / slope.norm());
        rho -= step;
        if !(rho.re.is_finite() && rho.im.is_finite() && error.is_finite()) {
            return None;
        }
        if step.norm() <= error {
            return Some((rho, 2.0 * error));
        }
    }
    None
}

/// Residues into `poles`, one a mode. `masked` is scratch space.
pub(crate) fn residues(modes: &Modes, saltations: &Saltations, masked: &mut Vec<Lane>, poles: &mut Vec<Pole>) {
    poles.clear();
    masked.clear();
    masked.extend(modes.groups().iter().map(|group| group.weight));
    for (i, (group, list)) in modes.groups().iter().zip(modes.list().chunks(4)).enumerate() {
        let (mut own, mut mirror) = ([Own::default(); 4], [Mirror::default(); 4]);
        for (j, mode) in list.iter().enumerate() {
            // Written as a whole, as it is read: the processor need not wait for a part of it.
            let others = f64x4::from(std::array::from_fn(|lane| if lane == j { 0.0 } else { 1.0 }));
            masked[i] = (four(group.weight) * others).to_array();
            (own[j], mirror[j]) = sums(modes, masked, mode);
        }
        masked[i] = group.weight;
        let group = group.four();
        let (residue, error) = residue(&group, saltations, &Own::totals(&own), &Mirror::totals(&mirror));
        Pole::push_group(poles, 4 * i, list.len(), &group, residue, error);
    }
}

/// Σ R_k d_k from the asymptotics of f at infinity, of all modes, one or four at a time.
#[inline(always)]
pub(crate) fn trace<T: Number>(modes: impl Iterator<Item = Mode<T>>, saltations: &Saltations) -> f64 {
    let mut sums = [T::default(); 5];
    for Mode { weight: w, cos: c, sin_over: x, sin_times: y, .. } in modes {
        let terms = [w * c, w * c * c, w * x, w * x * c, w * y];
        (0..5).for_each(|i| sums[i] = sums[i] + terms[i]);
    }
    let [m1, m2, g1, g2, h1] = sums.map(T::sum);
    // Q = 1 + α/ρ + β/ρ² + …, g̃ = g₁/ρ + g₂/ρ² + …, 1/ρ² = 2/ν + …
    let (alpha, beta) = (2.0 * m1, m1 * m1 + 2.0 * m2 - 1.0 + g1 * h1);
    let Saltations { half_kappa, lambda, .. } = *saltations;
    1.0 + 2.0 * (2.0 * beta - alpha * alpha - 2.0 * half_kappa * (g2 - alpha * g1) - lambda * g1 * g1)
}
