//! Where a stripe begins and ends, and how strong it is.
//!
//! A stripe ends where one of the two functions of its [`Pencil`](super::pencil::Pencil) vanishes. Both change their sign there, so that
//! either end is known to the rounding of the parameter, and the distance of the two, which is that of two zeros of functions that differ
//! by what couples the modes, to many more digits than the ends themselves.

use std::f64::consts::{FRAC_PI_2, PI};

use nalgebra::Complex;
use vibrochain_breather::{BreatherError, Finder, OrbitList};
use vibrochain_lattice::{Model, Stop};

use super::dressed::DressedModes;
use super::pencil::Meeting;
use super::reversal::{Kept, Reversal};
use super::stripe::{NoStripe, Stripe, StripeEnd, StripeLine};
use crate::bracket::zero;
use crate::map_paths::Secular;
use crate::zeros::Nu;

/// Steps of Newton's method.
const STEPS: usize = 40;

/// A change of ϑ that tells a slope to half the digits.
const SECANT: f64 = 1e-8;

/// A part of the distance of neighbouring modes over which slopes are taken: errors of 1e-8, and of 1e-12 by rounding.
const DIFFERENCE: f64 = 1e-4;

/// ln|μ| from which the multipliers themselves tell the growth, and not the local model: both err by about as much there.
const STRONG: f64 = 1e-5;

/// Points inside a stripe at which its growth is looked at, on either side of the middle, and halvings of their distance.
const LOOKS: usize = 8;

const REFINED: usize = 24;

/// A pencil at a value of the parameter, about where the mean of its two roots is.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sample {
    pub(super) value: f64,
    pub(super) angle: f64,
    sheet: f64,
    meeting: Meeting,
}

impl Sample {
    pub(super) fn at(&self, side: Side) -> f64 {
        match side {
            Side::Alpha => self.meeting.alpha,
            Side::Gamma => self.meeting.gamma,
        }
    }
}

/// Which of the two edges.
#[derive(Debug, Clone, Copy)]
pub(super) enum Side {
    Alpha,
    Gamma,
}

/// A pair of poles that is looked at.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pair {
    /// A mode against itself: ϑ stays where it is.
    pub(super) itself: bool,
    pub(super) harmonic: usize,
    pub(super) kept: Kept,
    /// Mean distance of neighbouring modes.
    pub(super) spacing: f64,
}

/// Finds stripes; keeps the work space.
#[derive(Debug, Clone)]
pub struct StripeFinder {
    pub(super) finder: Finder,
    pub(super) found: OrbitList,
    pub(super) dressed: DressedModes,
    pub(super) reversal: Reversal,
    pub(super) secular: Secular,
}

impl Default for StripeFinder {
    fn default() -> Self {
        Self {
            finder: Finder::new(1),
            found: OrbitList::default(),
            dressed: DressedModes::default(),
            reversal: Reversal::default(),
            secular: Secular::default(),
        }
    }
}

impl StripeFinder {
    /// The same finder, whose work ends with [`BreatherError::Stopped`] soon after `stop` is raised.
    #[must_use]
    pub fn until(stop: &Stop) -> Self {
        Self { finder: Finder::new(1).until(stop), ..Self::default() }
    }

    /// What looks at a place and goes on where nothing is told looks here, too: a search that was stopped tells nothing, either.
    pub(super) fn heard(&self) -> Result<(), NoStripe> {
        Ok(self.finder.stop().heard().map_err(BreatherError::from)?)
    }

    /// The breather at a value of the parameter.
    pub(super) fn set(&mut self, line: &StripeLine, value: f64) -> Result<Model, NoStripe> {
        let model = line.model.with(line.free, value)?;
        self.finder.find_symmetric(&model, line.family, &mut self.found)?;
        let orbit = self.found.orbits.first().ok_or(NoStripe::NoBreather)?;
        if self.reversal.set(self.finder.prepared(orbit)?) { Ok(model) } else { Err(NoStripe::NoBreather) }
    }

    /// The same, and its modes.
    pub(super) fn dress(&mut self, line: &StripeLine, value: f64) -> Result<Model, NoStripe> {
        let model = self.set(line, value)?;
        let orbit = self.found.orbits.first().ok_or(NoStripe::NoBreather)?;
        self.dressed.replace(self.finder.prepared(orbit)?).map_err(|_| NoStripe::NoBreather)?;
        Ok(model)
    }

    pub(super) fn sample(
        &mut self,
        line: &StripeLine,
        pair: &Pair,
        value: f64,
        start: f64,
    ) -> Result<Sample, NoStripe> {
        self.set(line, value)?;
        let (mut angle, mut last, mut slope) = (start, (start, 0.0), 1.0);
        let longest = 0.5 * pair.spacing * self.reversal.time();
        for _ in 0..STEPS {
            let pencil = self.reversal.pencil(angle, pair.kept, pair.harmonic);
            let meeting = pencil.and_then(|pencil| pencil.meeting()).ok_or(NoStripe::Passes)?;
            if pair.itself || meeting.beta.abs() <= 2.0 * f64::EPSILON * (1.0 + angle.abs()) {
                return Ok(Sample { value, angle, sheet: self.reversal.sheet(), meeting });
            }
            // 1 where two modes meet alone. (Differences of a few roundings tell no slope.)
            if (angle - last.0).abs() > SECANT {
                slope = (meeting.beta - last.1) / (angle - last.0);
            }
            last = (angle, meeting.beta);
            angle -= (meeting.beta / slope).clamp(-longest, longest);
        }
        Err(NoStripe::Elsewhere)
    }

    /// The stripe of a pair of modes at a harmonic next to a value of the parameter, as where Ω̃_k + Ω̃_l = jω.
    ///
    /// # Errors
    /// [`NoStripe`].
    pub fn near(
        &mut self,
        line: &StripeLine,
        modes: (usize, usize),
        harmonic: usize,
        value: f64,
    ) -> Result<Stripe, NoStripe> {
        let mut stripe = self.outline(line, modes, harmonic, value)?;
        if stripe.resolved {
            self.set_growth(line, &mut stripe)?;
        }
        Ok(stripe)
    }

    /// The same for a fraction of the work, with the growth that the local model tells: it errs by about its own size, as a part of 1.
    ///
    /// # Errors
    /// [`NoStripe`].
    pub fn outline(
        &mut self,
        line: &StripeLine,
        modes: (usize, usize),
        harmonic: usize,
        value: f64,
    ) -> Result<Stripe, NoStripe> {
        line.check()?;
        let omega = self.dress(line, value)?.omega();
        if self.dressed.is_symmetric() && !harmonic.is_multiple_of(2) {
            return Err(NoStripe::Passes);
        }
        let [low, high] = [modes.0, modes.1].map(|mode| self.dressed.frequency(mode).ok_or(NoStripe::NoMode { mode }));
        let (time, both, itself) = (self.reversal.time(), harmonic as f64 * omega, modes.0 == modes.1);
        let start = if itself { self.minus_one(harmonic) } else { 0.5 * time * (low? + both - high?) };
        let kept = self.reversal.kept([start / time, both - start / time]).ok_or(NoStripe::NoBreather)?;
        let pair = Pair { itself, harmonic, kept, spacing: self.dressed.spacing() };
        let stripe = self.refine(line, &pair, value, start)?;
        let apart = (stripe.centre - value).abs();
        if apart > stripe.half_width + pair.spacing {
            return Err(NoStripe::Elsewhere);
        }
        Ok(Stripe { pair: Some((modes, harmonic)), ..stripe })
    }

    /// ϑ of a mode that meets itself at an odd harmonic: with two impacts −1 has two roots.
    pub(super) fn minus_one(&self, harmonic: usize) -> f64 {
        harmonic as f64 * if self.reversal.is_double() { FRAC_PI_2 } else { PI }
    }

    /// Newton's method for the middle and the half width, from a guess at the middle.
    fn refine(&mut self, line: &StripeLine, pair: &Pair, value: f64, start: f64) -> Result<Stripe, NoStripe> {
        let mut here = self.sample(line, pair, value, start)?;
        let reach = DIFFERENCE * pair.spacing.min(value.abs());
        for _ in 0..STEPS {
            let low = self.sample(line, pair, here.value - reach, here.angle)?;
            let high = self.sample(line, pair, here.value + reach, here.angle)?;
            let slopes =
                [Side::Alpha, Side::Gamma].map(|side| (high.at(side) - low.at(side)) / (high.value - low.value));
            let (one, other) = (-here.at(Side::Alpha) / slopes[0], -here.at(Side::Gamma) / slopes[1]);
            let (step, half_width) = (0.5 * (one + other), 0.5 * (one - other).abs());
            if !step.is_finite() || slopes[0] * slopes[1] <= 0.0 {
                return Err(NoStripe::Elsewhere);
            }
            if step.abs() <= 1e-3 * half_width || step.abs() <= 2.0 * f64::EPSILON * here.value.abs() {
                return self.stripe(line, pair, here, slopes, [one, other]);
            }
            let next = here.value + step.clamp(-pair.spacing, pair.spacing);
            here = self.sample(line, pair, next, here.angle)?;
        }
        Err(NoStripe::Elsewhere)
    }

    /// The stripe about a point in its middle, from there `steps` to its edges.
    fn stripe(
        &mut self,
        line: &StripeLine,
        pair: &Pair,
        here: Sample,
        slopes: [f64; 2],
        steps: [f64; 2],
    ) -> Result<Stripe, NoStripe> {
        let error = self.error(&here, slopes[0].abs().min(slopes[1].abs()));
        let half_width = 0.5 * (steps[0] - steps[1]).abs();
        let centre = here.value + 0.5 * (steps[0] + steps[1]);
        let turns = if self.reversal.is_double() { 2.0 } else { 1.0 };
        let growth = turns * (slopes[0] * slopes[1]).sqrt() * half_width;
        let mut stripe = Stripe {
            pair: None,
            centre,
            error,
            half_width,
            edges: [centre - half_width, centre + half_width],
            ends: [StripeEnd::Edge; 2],
            growth,
            multiplier: Complex::from_polar(growth.exp(), turns * here.angle),
            resolved: half_width > 4.0 * error,
        };
        if stripe.resolved {
            let one = self.edge(line, pair, here, Side::Alpha, steps[0])?;
            let other = self.edge(line, pair, here, Side::Gamma, steps[1])?;
            stripe.set_edges([one.min(other), one.max(other)]);
            // Two ends next to each other know less of their distance than the local model, which errs by the square of its share.
            if half_width * half_width < error * pair.spacing {
                stripe.half_width = half_width;
            }
        }
        Ok(stripe)
    }

    /// Error of a zero of one of the two functions, of this slope: by rounding of the parameter, and of phases.
    pub(super) fn error(&self, at: &Sample, slope: f64) -> f64 {
        8.0 * f64::EPSILON * (at.value.abs() + (1.0 + at.angle.abs()) / slope)
    }

    /// Where one of the two functions vanishes, about `step` from a point.
    fn edge(&mut self, line: &StripeLine, pair: &Pair, from: Sample, side: Side, step: f64) -> Result<f64, NoStripe> {
        let (mut near, mut length) = (from, 1.25 * step);
        for _ in 0..STEPS {
            let far = self.sample(line, pair, near.value + length, near.angle)?;
            if far.sheet != from.sheet {
                break;
            }
            if (far.at(side) > 0.0) != (near.at(side) > 0.0) {
                return self.between(line, pair, side, [&near, &far]);
            }
            (near, length) = (far, 1.5 * length);
        }
        Err(NoStripe::Elsewhere)
    }

    /// The zero of a function between two points where its signs differ.
    pub(super) fn between(
        &mut self,
        line: &StripeLine,
        pair: &Pair,
        side: Side,
        [one, other]: [&Sample; 2],
    ) -> Result<f64, NoStripe> {
        let mut angle = one.angle;
        zero((one.value, one.at(side)), (other.value, other.at(side)), one.value.abs(), |value| {
            let sample = self.sample(line, pair, value, angle)?;
            angle = sample.angle;
            Ok(sample.at(side))
        })
    }

    /// The largest growth inside a stripe that has it about its middle at the multiplier told so far.
    pub(super) fn set_growth(&mut self, line: &StripeLine, stripe: &mut Stripe) -> Result<(), NoStripe> {
        if stripe.growth < STRONG {
            return Ok(());
        }
        let told = 0.5 * (stripe.multiplier + stripe.multiplier.inv());
        let Some(middle) = self.off_circle(line, stripe.centre, told)? else { return Ok(()) };
        let (mut best, mut at) = (middle, stripe.centre);
        let part = stripe.half_width / (LOOKS + 1) as f64;
        for sign in [-1.0, 1.0] {
            let mut nu = middle;
            for i in 1..=LOOKS {
                let value = stripe.centre + sign * part * i as f64;
                let Some(next) = self.off_circle(line, value, nu.complex())? else { break };
                nu = next;
                if nu.excess() > best.excess() {
                    (best, at) = (nu, value);
                }
            }
        }
        let mut reach = 0.5 * part;
        for _ in 0..REFINED {
            for value in [at - reach, at + reach] {
                if let Some(nu) = self.off_circle(line, value, best.complex())?
                    && nu.excess() > best.excess()
                {
                    (best, at) = (nu, value);
                }
            }
            reach *= 0.6;
        }
        stripe.growth = best.excess().ln_1p();
        [stripe.multiplier, _] = best.multipliers();
        Ok(())
    }

    /// The ν off the circle nearest to this one, above the real axis.
    pub(super) fn off_circle(
        &mut self,
        line: &StripeLine,
        value: f64,
        near: Complex<f64>,
    ) -> Result<Option<Nu>, NoStripe> {
        self.set(line, value)?;
        let orbit = self.found.orbits.first().ok_or(NoStripe::NoBreather)?;
        if self.secular.replace(self.finder.prepared(orbit)?).is_err() {
            return Ok(None);
        }
        let Ok(all) = self.secular.all_nu() else { return Ok(None) };
        let near = Complex::new(near.re, near.im.abs());
        let off = all.map(|(nu, _)| nu).filter(|nu| nu.im >= 0.0 && nu.excess() > 0.0);
        let distance = |nu: &Nu| (nu.complex() - near).norm_sqr();
        Ok(off.min_by(|a, b| distance(a).total_cmp(&distance(b))))
    }
}
