//! Real numbers of any precision: a thin layer over `astro-float-num` with operators.

use std::cell::RefCell;
use std::cmp::Ordering;
use std::fmt;
use std::ops::Neg;

use astro_float_num::{BigFloat, Consts, NAN, Radix, RoundingMode};

use crate::binary64::{self, scaled};

const ROUNDING: RoundingMode = RoundingMode::ToEven;

thread_local! {
    /// π and the like, computed once a thread and precision.
    static CONSTANTS: RefCell<Option<Consts>> = RefCell::new(Consts::new().ok());
}

/// Runs `f` with the thread's constants; without memory for them the answer is not a number.
fn with_constants(f: impl FnOnce(&mut Consts) -> BigFloat) -> BigFloat {
    CONSTANTS.with_borrow_mut(|constants| constants.as_mut().map_or(NAN, f))
}

/// A real number that carries its precision: an operation has that of its more precise operand, and each is rounded
/// correctly. An `f64` on the right is taken as exact.
///
/// ```
/// use vibrochain_truth::Real;
/// let third = Real::new(1.0, 192) / 3.0;
/// assert!((&third * 3.0 - 1.0).log10_abs() < -57.0);
/// assert_eq!(third.to_f64(), 1.0 / 3.0);
/// ```
#[derive(Clone)]
pub struct Real {
    value: BigFloat,
    /// Kept beside the value, because a zero has no mantissa to tell it by.
    bits: usize,
}

impl Real {
    /// `x`, exactly, to be calculated with in `bits` binary digits (rounded up to whole words of 64).
    pub fn new(x: f64, bits: usize) -> Self {
        let bits = words(bits);
        let value = binary64::exact(x, bits);
        Self { value, bits }
    }

    /// Zero.
    pub fn zero(bits: usize) -> Self {
        Self::new(0.0, bits)
    }

    /// One.
    pub fn one(bits: usize) -> Self {
        Self::new(1.0, bits)
    }

    /// π.
    pub fn pi(bits: usize) -> Self {
        let bits = words(bits);
        Self { value: with_constants(|constants| constants.pi(bits, ROUNDING)), bits }
    }

    /// A decimal number as text, `None` if it is not one.
    ///
    /// ```
    /// use vibrochain_truth::Real;
    /// assert_eq!(Real::parse("-1.5e-3", 128).map(|x| x.to_f64()), Some(-1.5e-3));
    /// assert!(Real::parse("1,5", 128).is_none());
    /// ```
    pub fn parse(text: &str, bits: usize) -> Option<Self> {
        let bits = words(bits);
        // The library reads as far as it understands.
        text.parse::<f64>().ok()?;
        let value = with_constants(|constants| BigFloat::parse(text, Radix::Dec, bits, ROUNDING, constants));
        (!value.is_nan() && !value.is_inf()).then_some(Self { value, bits })
    }

    /// Binary digits it is calculated with.
    pub fn bits(&self) -> usize {
        self.bits
    }

    /// The same number with another precision, rounded if that is smaller.
    pub fn with_bits(&self, bits: usize) -> Self {
        let bits = words(bits);
        let mut value = self.value.clone();
        if value.set_precision(bits, ROUNDING).is_err() {
            value = NAN;
        }
        Self { value, bits }
    }

    /// Sine and cosine, the argument reduced with as many digits of π as it needs.
    pub fn sin_cos(&self) -> (Self, Self) {
        let sin = with_constants(|constants| self.value.sin(self.bits, ROUNDING, constants));
        let cos = with_constants(|constants| self.value.cos(self.bits, ROUNDING, constants));
        (Self { value: sin, bits: self.bits }, Self { value: cos, bits: self.bits })
    }

    /// Square root; not a number below zero.
    pub fn sqrt(&self) -> Self {
        Self { value: self.value.sqrt(self.bits, ROUNDING), bits: self.bits }
    }

    /// Modulus.
    pub fn abs(&self) -> Self {
        Self { value: self.value.abs(), bits: self.bits }
    }

    /// Whole power, negative ones too.
    pub fn powi(&self, exponent: i32) -> Self {
        let power = self.value.powi(exponent.unsigned_abs() as usize, self.bits, ROUNDING);
        let power = Self { value: power, bits: self.bits };
        if exponent < 0 { Self::one(self.bits) / power } else { power }
    }

    /// Largest whole number not above.
    pub fn floor(&self) -> Self {
        Self { value: self.value.floor(), bits: self.bits }
    }

    /// Times 2^`power`, exactly.
    pub fn times_power_of_two(&self, power: i32) -> Self {
        Self { value: scaled(&self.value, power), bits: self.bits }
    }

    /// Exactly zero.
    pub fn is_zero(&self) -> bool {
        self.value.is_zero()
    }

    /// Below zero.
    pub fn is_negative(&self) -> bool {
        self.value.is_negative() && !self.value.is_zero()
    }

    /// Neither infinite nor not a number.
    pub fn is_finite(&self) -> bool {
        !self.value.is_nan() && !self.value.is_inf()
    }

    /// The nearest `f64` (ties to even): subnormal, zero or infinite where the number is beyond the normal range.
    pub fn to_f64(&self) -> f64 {
        binary64::nearest(&self.value)
    }

    /// log₁₀|x|, to the accuracy of `f64`, also far beyond its range; −∞ for zero.
    pub fn log10_abs(&self) -> f64 {
        self.log2_abs() * std::f64::consts::LOG10_2
    }

    /// log₂|x|, as [`Real::log10_abs`].
    pub fn log2_abs(&self) -> f64 {
        binary64::log2_abs(&self.value)
    }

    /// An operation of the library with the larger of both precisions.
    pub(crate) fn combine(
        &self,
        other: &Self,
        f: impl FnOnce(&BigFloat, &BigFloat, usize, RoundingMode) -> BigFloat,
    ) -> Self {
        let bits = self.bits.max(other.bits);
        Self { value: f(&self.value, &other.value, bits, ROUNDING), bits }
    }
}

/// Whole words, at least one: the library's unit of precision, and enough for any `f64`.
fn words(bits: usize) -> usize {
    bits.clamp(64, 1 << 24).next_multiple_of(64)
}

impl Neg for Real {
    type Output = Real;
    fn neg(mut self) -> Real {
        self.value.inv_sign();
        self
    }
}

impl Neg for &Real {
    type Output = Real;
    fn neg(self) -> Real {
        -self.clone()
    }
}

impl PartialEq for Real {
    fn eq(&self, other: &Self) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}

impl PartialOrd for Real {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        self.value.cmp(&other.value).map(|order| order.cmp(&0))
    }
}

impl PartialEq<f64> for Real {
    fn eq(&self, other: &f64) -> bool {
        self.partial_cmp(other) == Some(Ordering::Equal)
    }
}

impl PartialOrd<f64> for Real {
    fn partial_cmp(&self, other: &f64) -> Option<Ordering> {
        self.partial_cmp(&Self::new(*other, 64))
    }
}

impl fmt::Display for Real {
    /// Scientific notation with all the digits that `bits` are worth.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let text = CONSTANTS.with_borrow_mut(|constants| {
            constants.as_mut().and_then(|constants| self.value.format(Radix::Dec, ROUNDING, constants).ok())
        });
        f.write_str(&text.ok_or(fmt::Error)?)
    }
}

impl fmt::Debug for Real {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{self} ({} bits)", self.bits)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    // Digits from an independent library (mpmath).
    // x, sin x, cos x.
    const SINES: [(f64, &str, &str); 10] = [
        (
            0.5,
            "0.479425538604203000273287935215571388081803367940600675188616613125535000288",
            "0.877582561890372716116281582603829651991645197109744052997610868315950763274",
        ),
        (
            3.0,
            "0.141120008059867222100744802808110279846933264252265584151882641232422009967",
            "-0.989992496600445457271572794731261302393679096615588328814085932928329197513",
        ),
        (
            -100.25,
            "0.277282856454851303353672057019435886844255989938579039060797470470070108095",
            "0.960788331276061203442344561362049986123801088610131706112905825064259062405",
        ),
        (
            1e+22,
            "-0.852200849767188801772705893753029368261762150410043656256509326025910311992",
            "0.523214785395138945497594473384709492140919972439387953527211392104298247377",
        ),
        (
            1000000000000000.2,
            "0.704625007925808639767698326118668953260856396481823003757824193730667456735",
            "-0.709579874436665594744765617511844429338731090396769071524835998861962344384",
        ),
        (
            22.0,
            "-0.00885130929040387592169025681577233246328920395133256644233083529808955201463",
            "-0.999960826394637126454174739212693774135988467479419293059382204963773339032",
        ),
        (
            std::f64::consts::PI,
            "0.000000000000000122464679914735317722606593227499799708305390129979194948825771626086960997",
            "-0.999999999999999999999999999999992501201086690712026767621772571619056838289",
        ),
        (
            std::f64::consts::FRAC_PI_2,
            "0.999999999999999999999999999999998125300271672678006691905443142903006960037",
            "0.000000000000000061232339957367658861303296613750014646403777988362830520960549827724863084",
        ),
        (
            1e-30,
            "1.00000000000000008333642060758598535093133602686865450236450961688219584874e-30",
            "0.9999999999999999999999999999999999999999999999999999999999995",
        ),
        (
            5.319372648326541e+255,
            "0.999999999999999999999999999999999999890152377992531312498042888935934441402",
            "-0.000000000000000000468716592425462761112258280196388439877791471897108378325697768916192037409",
        ),
    ];
    const PI_DIGITS: &str =
        "3.141592653589793238462643383279502884197169399375105820974944592307816406286208998628034825342117068";
    const SQRT_2_DIGITS: &str =
        "1.414213562373095048801688724209698078569671875376948073176679737990732478462107038850387534327641573";

    fn real(text: &str, bits: usize) -> Real {
        Real::parse(text, bits).unwrap()
    }

    /// |a − b| ≤ 10^−digits |b|
    #[track_caller]
    fn assert_digits(a: &Real, text: &str, digits: f64) {
        let b = real(text, a.bits() + 64);
        let error = (a - &b).log10_abs() - b.log10_abs();
        assert!(error < -digits, "{a} {b}: 1e{error}");
    }

    #[test]
    fn sines_have_all_their_digits_for_small_and_huge_arguments() {
        for (x, sin, cos) in SINES {
            for bits in [192, 256] {
                let (s, c) = Real::new(x, bits).sin_cos();
                assert_digits(&s, sin, 55.0);
                assert_digits(&c, cos, 55.0);
            }
        }
    }

    #[test]
    fn sines_do_not_depend_on_the_precision_asked_for() {
        let mut x = Real::new(1.0, 192);
        for i in 0..300 {
            x = &x * (if i % 2 == 0 { 1.37 } else { -1.61 });
            let ((s, c), (s2, c2)) = (x.sin_cos(), x.with_bits(512).sin_cos());
            assert!((&s - &s2).log2_abs() <= s2.log2_abs() - 192.0, "{x}");
            assert!((&c - &c2).log2_abs() <= c2.log2_abs() - 192.0, "{x}");
            assert!((&s * &s + &c * &c - 1.0).log2_abs() < -189.0, "{x}");
            assert!((&s2 * &c2 * 2.0 - (x.with_bits(512) * 2.0).sin_cos().0).log2_abs() < -508.0, "{x}");
        }
    }

    #[test]
    fn arguments_next_to_multiples_of_half_pi_keep_relative_accuracy() {
        for n in [1.0, 2.0, 3.0, 4.0, 7.0, 1000.0, 1e9 + 1.0] {
            let x = Real::pi(192) * n / 2.0;
            let ((s, c), (s2, c2)) = (x.sin_cos(), x.with_bits(640).sin_cos());
            assert!((&s - &s2).log2_abs() <= s2.log2_abs() - 191.0, "{n}");
            assert!((&c - &c2).log2_abs() <= c2.log2_abs() - 191.0, "{n}");
        }
    }

    #[test]
    fn constants_and_roots() {
        assert_digits(&Real::pi(256), PI_DIGITS, 76.0);
        assert_digits(&Real::new(2.0, 256).sqrt(), SQRT_2_DIGITS, 76.0);
        let x = Real::new(1.7, 256);
        assert!((x.powi(7) * x.powi(-7) - 1.0).log2_abs() < -250.0);
        assert!(Real::new(-1.0, 128).sqrt().to_f64().is_nan());
        assert_eq!(Real::new(-2.5, 128).floor(), -3.0);
    }

    #[test]
    fn every_f64_comes_back() {
        let mut cases = vec![0.0, 1.0, -1.5, 1e-300, 1e300, f64::MAX, f64::MIN_POSITIVE, 5e-324, -5e-324, 1e-310];
        let mut state = 0x9e37_79b9_7f4a_7c15_u64;
        for _ in 0..20_000 {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            cases.push(f64::from_bits(state ^ (state >> 31)));
            // Half of them subnormal.
            cases.push(f64::from_bits((state ^ (state >> 29)) & 0x800f_ffff_ffff_ffff));
        }
        for x in cases.into_iter().filter(|x| x.is_finite()) {
            assert_eq!(Real::new(x, 64).to_f64(), x);
            assert_eq!(Real::new(x, 256).to_f64(), x);
            // A shade more or less than x still rounds to x; half-way cases go to the even neighbour.
            let shade = Real::new(x, 256).abs() * Real::new(1.0, 256).times_power_of_two(-60);
            if x.abs() >= f64::MIN_POSITIVE * 2.0 {
                assert_eq!((Real::new(x, 256) + &shade).to_f64(), x);
                assert_eq!((Real::new(x, 256) - &shade).to_f64(), x);
            }
            let next = f64::from_bits(x.to_bits() + 1);
            if next.is_finite() {
                let middle = (Real::new(x, 256) + next) / 2.0;
                assert_eq!(middle.to_f64(), if x.to_bits() % 2 == 0 { x } else { next }, "{x:e}");
            }
        }
    }

    #[test]
    fn numbers_beyond_the_range_of_f64_are_told_by_their_logarithm() {
        let tiny = Real::new(1e-200, 128).powi(3);
        assert_eq!(tiny.to_f64(), 0.0);
        assert!((tiny.log10_abs() + 600.0).abs() < 1e-12);
        let huge = -Real::new(1e200, 128).powi(3);
        assert_eq!(huge.to_f64(), f64::NEG_INFINITY);
        assert!((huge.log10_abs() - 600.0).abs() < 1e-12);
        assert_eq!(Real::zero(64).log10_abs(), f64::NEG_INFINITY);
        // 2^1024 − 2^970, half-way between the largest f64 and the next power of two, rounds to infinity.
        let edge = Real::one(128).times_power_of_two(1024) - Real::one(128).times_power_of_two(970);
        assert_eq!(edge.to_f64(), f64::INFINITY);
        assert_eq!((edge * 0.999_999_999_999_999_9).to_f64(), f64::MAX);
        let quarter = Real::new(5e-324, 128);
        assert_eq!((&quarter / 2.0).to_f64(), 0.0);
        assert_eq!((&quarter * 0.501).to_f64(), 5e-324);
        assert_eq!((&quarter * 1.5).to_f64(), 1e-323);
    }

    #[test]
    fn arithmetic_is_exact_where_it_can_be_and_precision_travels() {
        let (a, b) = (Real::new(1.0, 64), Real::new(1e-60, 256));
        assert_eq!((&a + &b).bits(), 256);
        assert_eq!(&a + &b - &a, b);
        assert_eq!((Real::zero(320) + 1.0).bits(), 320);
        assert_eq!(Real::new(3.0, 128) * 1.5, 4.5);
        assert!(Real::new(0.1, 192) * 3.0 > 0.3 && Real::new(-1.0, 64) < Real::zero(64));
        let mut sum = Real::zero(128);
        sum += &a;
        sum *= Real::new(5.0, 64);
        sum -= Real::new(2.0, 64);
        assert_eq!(sum, 3.0);
        assert!(!sum.is_negative() && (-&sum).is_negative() && !Real::new(-0.0, 64).is_negative());
    }
}
