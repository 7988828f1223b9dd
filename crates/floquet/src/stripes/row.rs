//! All stripes of the physical breathers along a line.
//!
//! Thin ones are next to where the frequencies of two modes meet; there each is found by itself, however thin. Wide ones, where more than
//! two modes have to do with each other, need not be. They show in the number of multipliers off the circle from point to point: what the
//! stripes found so far do not explain is halved until one event is left.

use std::f64::consts::PI;

use nalgebra::Complex;

use super::finder::{Pair, Side, StripeFinder};
use super::passing::{Passing, passings};
use super::place::{MIDDLES, Place, STARTS};
use super::stripe::{NoStripe, Stripe, StripeEnd, StripeLine};

/// Halvings of the distance of two points: until an event is taken as alone, and until what is between them is given up.
const ALONE: u32 = 12;
const DEEPEST: u32 = 30;

/// Edges as near as this, relatively, are one.
const SAME: f64 = 1e-12;

/// The stripes along a line. A multiplier that is off the circle wherever there is a breather has no edge, and no stripe.
#[derive(Debug, Clone, PartialEq, Default)]
#[must_use]
pub struct StripeRow {
    /// By rising centre.
    pub stripes: Vec<Stripe>,
    /// Between these values something is met that could not be told.
    pub unresolved: Vec<[f64; 2]>,
}

/// [`StripeFinder::near`] or [`StripeFinder::outline`].
type Told = fn(&mut StripeFinder, &StripeLine, (usize, usize), usize, f64) -> Result<Stripe, NoStripe>;

/// A part of a line: its two ends, and how often it has been halved.
type Part = ((f64, Option<Place>), (f64, Option<Place>), u32);

/// An edge that the lines did not tell.
#[derive(Debug, Clone, Copy)]
struct Edge {
    value: f64,
    error: f64,
    /// Above it there are more multipliers off the circle.
    opens: bool,
    doubling: bool,
    pair: Option<((usize, usize), usize)>,
    nu: Complex<f64>,
}

impl StripeFinder {
    /// As [`Self::along`], with the growth that the local model tells of thin ones, see [`Self::outline`]: where only the edges are asked
    /// for, the largest growth inside is most of the work.
    ///
    /// # Errors
    /// As [`Self::along`].
    pub fn outlines_along(
        &mut self,
        line: &StripeLine,
        range: (f64, f64),
        points: usize,
    ) -> Result<StripeRow, NoStripe> {
        self.row(line, range, points, Self::outline)
    }

    /// All stripes of physical breathers between two values of the parameter, of which so many points are looked at.
    ///
    /// # Errors
    /// [`NoStripe::NotConservative`], [`NoStripe::Parameter`]; [`NoStripe::Breather`] once it was stopped ([`Self::until`]).
    pub fn along(&mut self, line: &StripeLine, range: (f64, f64), points: usize) -> Result<StripeRow, NoStripe> {
        self.row(line, range, points, Self::near)
    }

    /// The same; of two modes that meet the stripe is what `told` tells.
    fn row(
        &mut self,
        line: &StripeLine,
        (from, to): (f64, f64),
        points: usize,
        told: Told,
    ) -> Result<StripeRow, NoStripe> {
        line.check()?;
        let value = |i: usize| from + (to - from) * i as f64 / points.saturating_sub(1).max(1) as f64;
        let (mut last, mut here) = (Vec::new(), Vec::new());
        let (mut met, mut places) = (Vec::new(), Vec::new());
        for i in 0..points {
            self.heard()?;
            let next = value(if i + 1 < points { i + 1 } else { i.saturating_sub(1) });
            let place = self.place_between(line, (value(i), next), &STARTS)?;
            here.clear();
            let wanted = place.is_some() || places.last().is_some_and(Option::is_some);
            if wanted && let Ok(model) = self.dress(line, value(i)) {
                here.extend(self.dressed.frequencies().map(|w| w.map(|w| w / model.omega())));
            }
            if last.is_empty()
                && place.is_some()
                && i > 0
                && let Ok(model) = self.dress(line, value(i - 1))
            {
                last.extend(self.dressed.frequencies().map(|w| w.map(|w| w / model.omega())));
            }
            passings(&last, &here, self.dressed.is_symmetric(), |passing| {
                if passing.sum {
                    met.push((value(i - 1) + passing.part * (value(i) - value(i - 1)), passing));
                }
            });
            std::mem::swap(&mut last, &mut here);
            places.push(place);
        }
        let mut row = StripeRow::default();
        for (value, Passing { modes, harmonic, .. }) in met {
            self.heard()?;
            let Ok(stripe) = told(self, line, modes, harmonic, value) else { continue };
            let same = |other: &Stripe| (other.centre - stripe.centre).abs() <= 4.0 * (other.error + stripe.error);
            if !row.stripes.iter().any(same) {
                row.stripes.push(stripe);
            }
        }
        let places = places.into_iter().enumerate();
        let mut places: Vec<_> =
            places.map(|(i, place)| (place.as_ref().map_or(value(i), |place| place.value), place)).collect();
        let (mut edges, mut seen) = (Vec::new(), Vec::new());
        loop {
            for ends in places.windows(2) {
                let [first, last] = ends else { continue };
                self.heard()?;
                self.unexplained(line, (first.clone(), last.clone(), 0), &mut row, (&mut edges, &mut seen))?;
            }
            // A wide one may have been told to end where another does: then counts have to tell both.
            self.look_about(line, edges.iter().map(|edge: &Edge| edge.value), &mut places)?;
            let over =
                places.iter().filter_map(|(_, place)| place.as_ref()).filter(|place| place.is_over(&row.stripes));
            let over: Vec<f64> = over.map(|place| place.value).collect();
            let wrong = |stripe: &mut Stripe| over.iter().any(|value| stripe.is_about(*value));
            let wrong: Vec<Stripe> = row.stripes.extract_if(.., wrong).collect();
            if wrong.is_empty() {
                break;
            }
            self.look_about(line, wrong.iter().flat_map(|stripe| stripe.edges), &mut places)?;
            row.unresolved.clear();
            edges.clear();
        }
        edges.sort_by(|a, b| a.value.total_cmp(&b.value));
        seen.extend(places.iter().filter_map(|(_, place)| place.as_ref()).map(|place| (place.value, place.sheet)));
        seen.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.join(line, &seen, edges, &mut row)?;
        row.stripes.sort_by(|a, b| a.centre.total_cmp(&b.centre));
        Ok(row)
    }

    /// More points, between these values and what is next to each.
    fn look_about(
        &mut self,
        line: &StripeLine,
        values: impl Iterator<Item = f64>,
        places: &mut Vec<(f64, Option<Place>)>,
    ) -> Result<(), NoStripe> {
        let (Some(from), Some(to)) = (places.first().map(|(at, _)| *at), places.last().map(|(at, _)| *at)) else {
            return Ok(());
        };
        let values: Vec<f64> = values.filter(|value| from < *value && *value < to).collect();
        let mut all: Vec<f64> = places.iter().map(|(at, _)| *at).chain(values.iter().copied()).collect();
        all.sort_unstable_by(f64::total_cmp);
        for ends in all.windows(2) {
            let [low, high] = ends else { continue };
            if low < high && values.iter().any(|value| value == low || value == high) {
                let place = self.place_between(line, (*low, *high), &MIDDLES)?;
                places.push((place.as_ref().map_or(0.5 * (low + high), |place| place.value), place));
            }
        }
        places.sort_by(|a, b| a.0.total_cmp(&b.0));
        Ok(())
    }

    /// What between two points the stripes found so far do not explain.
    fn unexplained(
        &mut self,
        line: &StripeLine,
        part: Part,
        row: &mut StripeRow,
        (edges, seen): (&mut Vec<Edge>, &mut Vec<(f64, f64)>),
    ) -> Result<(), NoStripe> {
        let mut parts = vec![part];
        while let Some(part) = parts.pop() {
            self.heard()?;
            let (low, high, depth) = &part;
            seen.extend([&low.1, &high.1].into_iter().flatten().map(|place| (place.value, place.sheet)));
            let (Some(before), Some(after)) = (&low.1, &high.1) else {
                // On to where physical breathers end.
                if (low.1.is_some() || high.1.is_some()) && *depth < ALONE {
                    self.halve(line, &part, &mut parts)?;
                }
                continue;
            };
            if before.sheet != after.sheet {
                if *depth < ALONE {
                    self.halve(line, &part, &mut parts)?;
                }
                continue;
            }
            let (mut complex, mut below) = (
                after.complex.len() as isize - before.complex.len() as isize,
                after.below.len() as isize - before.below.len() as isize,
            );
            for stripe in &row.stripes {
                for (edge, sign) in stripe.edges.into_iter().zip([1, -1]) {
                    if low.0 < edge && edge <= high.0 {
                        *(if stripe.is_doubling() { &mut below } else { &mut complex }) -= sign;
                    }
                }
            }
            let still = complex == 0 && below == 0;
            if still && before.leads_to(after) || *depth < ALONE && self.halve(line, &part, &mut parts)? {
                continue;
            }
            // Two beyond −1, or beyond 1, may turn complex: nothing happens on the circle.
            let turned = complex.abs() == 1 && below + after.above as isize - before.above as isize == -2 * complex;
            if still || turned {
                continue;
            }
            let edge = match complex.abs() + below.abs() {
                1 => self.edge_between(line, before, after)?,
                _ => None,
            };
            if edge.is_none_or(|edge| edge.error >= high.0 - low.0)
                && *depth < DEEPEST
                && self.halve(line, &part, &mut parts)?
            {
                continue;
            }
            let (value, error) = edge.map_or((0.5 * (low.0 + high.0), 0.0), |edge| (edge.value, edge.error));
            // Next to an edge rounding decides how many are off the circle.
            let known = |other: f64| (value - other).abs() <= error + SAME * other.abs();
            if row.stripes.iter().flat_map(|stripe| stripe.edges).any(known) {
                continue;
            }
            match edge {
                Some(edge) => edges.push(edge),
                None => row.unresolved.push([low.0, high.0]),
            }
        }
        Ok(())
    }

    /// Both halves of a part; false if all between its ends is in doubt.
    fn halve(&mut self, line: &StripeLine, (low, high, depth): &Part, parts: &mut Vec<Part>) -> Result<bool, NoStripe> {
        let place = self.place_between(line, (low.0, high.0), &MIDDLES)?;
        if place.as_ref().is_some_and(|place| place.doubtful) {
            return Ok(false);
        }
        let middle = (place.as_ref().map_or(0.5 * (low.0 + high.0), |place| place.value), place);
        parts.push((middle.clone(), high.clone(), depth + 1));
        parts.push((low.clone(), middle, depth + 1));
        Ok(true)
    }

    /// The one edge between two points: to the rounding of the parameter, or their middle.
    fn edge_between(&mut self, line: &StripeLine, before: &Place, after: &Place) -> Result<Option<Edge>, NoStripe> {
        let opens = after.complex.len() + after.below.len() > before.complex.len() + before.below.len();
        let (fewer, more) = if opens { (before, after) } else { (after, before) };
        let doubling = more.below.len() > fewer.below.len();
        let (off, on) = if doubling { (&more.below, &fewer.below) } else { (&more.complex, &fewer.complex) };
        // The one that has no partner on the other side.
        let lonely = |nu: &Complex<f64>| on.iter().map(|other| (other - nu).norm()).fold(f64::INFINITY, f64::min);
        let Some(nu) = off.iter().copied().max_by(|a, b| lonely(a).total_cmp(&lonely(b))) else { return Ok(None) };
        let omega = self.dress(line, more.value)?.omega();
        let turn = if doubling { PI } else { nu.re.clamp(-1.0, 1.0).acos() };
        let multiplier = Complex::new(turn.cos(), if doubling { 0.0 } else { turn.sin() });
        let pair = self.dressed.collision(multiplier).map(|collision| (collision.modes, collision.harmonic));
        let apart = after.value - before.value;
        let (middle, error) = (before.value + 0.5 * apart, apart);
        let edge = Edge { value: middle, error, opens, doubling, pair, nu };
        let time = self.reversal.time();
        // Which of the two impacts' poles they are next to, whatever modes they are named by.
        let starts = match (doubling, self.reversal.is_double()) {
            (true, false) => vec![(1, PI)],
            (true, true) => vec![(1, self.minus_one(1)), (3, self.minus_one(3))],
            (false, false) => vec![(1, turn)],
            (false, true) => vec![(1, 0.5 * turn), (2, 0.5 * turn), (2, 0.5 * turn + PI)],
        };
        for (harmonic, start) in starts {
            let w = start / time;
            let Some(kept) = self.reversal.kept([w, harmonic as f64 * omega - w]) else { continue };
            let poles = Pair { itself: doubling, harmonic, kept, spacing: self.dressed.spacing() };
            let ends = [before, after].map(|place| self.sample(line, &poles, place.value, start));
            let [Ok(low), Ok(high)] = ends else { continue };
            for side in [Side::Alpha, Side::Gamma] {
                if (low.at(side) > 0.0) != (high.at(side) > 0.0)
                    && let Ok(value) = self.between(line, &poles, side, [&low, &high])
                {
                    let slope = (high.at(side) - low.at(side)).abs() / apart;
                    return Ok(Some(Edge { value, error: self.error(&low, slope), ..edge }));
                }
            }
        }
        Ok(Some(edge))
    }

    /// Stripes from their edges; what is open at the end of a run of breathers ends there.
    fn join(
        &mut self,
        line: &StripeLine,
        runs: &[(f64, f64)],
        edges: Vec<Edge>,
        row: &mut StripeRow,
    ) -> Result<(), NoStripe> {
        let mut open: Vec<Edge> = Vec::new();
        let mut edges = edges.into_iter().peekable();
        for run in runs.chunk_by(|a, b| a.1 == b.1) {
            let ([first, ..], [.., last]) = (run, run) else { continue };
            while let Some(edge) = edges.next_if(|edge| edge.value <= last.0) {
                if edge.opens {
                    open.push(edge);
                    continue;
                }
                let like = |other: &Edge| other.doubling == edge.doubling;
                let named = open.iter().rposition(|other| like(other) && other.pair == edge.pair);
                let which = named.or_else(|| open.iter().rposition(like));
                let begun = which.map(|which| open.remove(which));
                self.joined(line, (begun, first.0), (Some(edge), last.0), row)?;
            }
            for edge in open.drain(..) {
                self.joined(line, (Some(edge), first.0), (None, last.0), row)?;
            }
        }
        // Between the last point of a run and its end.
        for edge in edges.chain(open) {
            self.joined(line, (Some(edge), edge.value), (None, edge.value), row)?;
        }
        Ok(())
    }

    fn joined(
        &mut self,
        line: &StripeLine,
        (low, least): (Option<Edge>, f64),
        (high, largest): (Option<Edge>, f64),
        row: &mut StripeRow,
    ) -> Result<(), NoStripe> {
        let Some(edge) = low.or(high) else { return Ok(()) };
        let end = |edge: Option<Edge>| if edge.is_some() { StripeEnd::Edge } else { StripeEnd::Open };
        let mut stripe = Stripe {
            pair: edge.pair,
            centre: edge.value,
            error: low.map_or(0.0, |edge| edge.error).max(high.map_or(0.0, |edge| edge.error)),
            half_width: 0.0,
            edges: [edge.value; 2],
            ends: [end(low), end(high)],
            growth: f64::INFINITY,
            multiplier: edge.nu,
            resolved: true,
        };
        stripe.set_edges([low.map_or(least, |edge| edge.value), high.map_or(largest, |edge| edge.value)]);
        // From the edge inwards: the middle may be another stripe's.
        let root = (edge.nu * edge.nu - 1.0).sqrt();
        stripe.multiplier = edge.nu + root;
        self.set_growth(line, &mut stripe)?;
        if stripe.growth.is_finite() {
            row.stripes.push(stripe);
        } else {
            row.unresolved.push(stripe.edges);
        }
        Ok(())
    }
}
