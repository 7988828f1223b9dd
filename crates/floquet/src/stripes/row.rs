//! All stripes of the physical breathers along a line.
//!
//! Thin ones are next to where the frequencies of two modes meet; there each is found by itself, however thin. Wide ones, where more than
//! two modes have to do with each other, need not be. They show in the number of multipliers off the circle from point to point: what the
//! stripes found so far do not explain is halved until one event is left.

use std::f64::consts::PI;

use nalgebra::Complex;

use super::passing::{Passing, passings};
use super::stripe::{NoStripe, Pair, Side, Stripe, StripeEnd, StripeFinder, StripeLine};

/// Halvings of the distance of two points: until an event is taken as alone, and until what is between them is given up.
const ALONE: u32 = 12;
const DEEPEST: u32 = 30;

/// A part of its distance from the circle by which a multiplier may move from point to point without doubt that it stays off.
const CALM: f64 = 0.5;

/// The stripes along a line.
#[derive(Debug, Clone, PartialEq, Default)]
#[must_use]
pub struct StripeRow {
    /// By rising centre.
    pub stripes: Vec<Stripe>,
    /// Between these values something is met that could not be told.
    pub unresolved: Vec<[f64; 2]>,
}

/// How many ν are off the circle: pairs of complex ones, and real ones below −1.
#[derive(Debug, Clone, PartialEq)]
struct Place {
    value: f64,
    sheet: f64,
    complex: Vec<Complex<f64>>,
    below: Vec<Complex<f64>>,
}

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

impl Stripe {
    fn is_doubling(&self) -> bool {
        self.pair.is_some_and(|((k, l), _)| k == l)
    }
}

impl Place {
    /// Each ν off the circle has moved by less than its distance from there, so that none has come back in between.
    fn leads_to(&self, other: &Self) -> bool {
        let lists = [(&self.complex, &other.complex), (&self.below, &other.below)];
        lists.into_iter().all(|(from, to)| {
            let height = |nu: &Complex<f64>| if nu.im > 0.0 { nu.im } else { -1.0 - nu.re };
            from.len() == to.len()
                && from
                    .iter()
                    .all(|nu| to.iter().any(|other| (other - nu).norm() < CALM * height(nu).min(height(other))))
        })
    }
}

impl StripeFinder {
    /// All stripes of physical breathers between two values of the parameter, of which so many points are looked at.
    ///
    /// # Errors
    /// [`NoStripe::NotConservative`], [`NoStripe::Parameter`].
    pub fn along(&mut self, line: &StripeLine, (from, to): (f64, f64), points: usize) -> Result<StripeRow, NoStripe> {
        line.check()?;
        let value = |i: usize| from + (to - from) * i as f64 / points.saturating_sub(1).max(1) as f64;
        let (mut last, mut here) = (Vec::new(), Vec::new());
        let (mut met, mut places) = (Vec::new(), Vec::new());
        for i in 0..points {
            let place = self.place(line, value(i))?;
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
            let Ok(stripe) = self.near(line, modes, harmonic, value) else { continue };
            let same = |other: &Stripe| (other.centre - stripe.centre).abs() <= 4.0 * (other.error + stripe.error);
            if !row.stripes.iter().any(same) {
                row.stripes.push(stripe);
            }
        }
        let (mut edges, mut seen) = (Vec::new(), Vec::new());
        for (i, ends) in places.windows(2).enumerate() {
            let [first, last] = ends else { continue };
            self.unexplained(line, (value(i), first), (value(i + 1), last), &mut row, (&mut edges, &mut seen))?;
        }
        edges.sort_by(|a, b| a.value.total_cmp(&b.value));
        seen.extend(places.iter().flatten().map(|place| (place.value, place.sheet)));
        seen.sort_by(|a, b| a.0.total_cmp(&b.0));
        self.join(line, &seen, edges, &mut row)?;
        row.stripes.sort_by(|a, b| a.centre.total_cmp(&b.centre));
        Ok(row)
    }

    /// What is off the circle; `None` where there is no physical breather, or its multipliers cannot be told.
    fn place(&mut self, line: &StripeLine, value: f64) -> Result<Option<Place>, NoStripe> {
        match self.set(line, value) {
            Err(error @ NoStripe::Parameter(_)) => return Err(error),
            Err(_) => return Ok(None),
            Ok(_) => {}
        }
        let Some(orbit) = self.found.orbits.first() else { return Ok(None) };
        let physical = self.finder.quick_admissibility(orbit).is_ok_and(|answer| answer.is_physical());
        if !physical || self.secular.replace(self.finder.prepared(orbit)?).is_err() {
            return Ok(None);
        }
        let Ok(all) = self.secular.all_nu() else { return Ok(None) };
        let mut place = Place { value, sheet: self.reversal.sheet(), complex: Vec::new(), below: Vec::new() };
        for (nu, _) in all {
            if nu.im > 0.0 {
                place.complex.push(nu.complex());
            } else if nu.im == 0.0 && nu.above < 0.0 {
                place.below.push(nu.complex());
            }
        }
        Ok(Some(place))
    }

    /// What between two points the stripes found so far do not explain.
    fn unexplained(
        &mut self,
        line: &StripeLine,
        (from, first): (f64, &Option<Place>),
        (to, last): (f64, &Option<Place>),
        row: &mut StripeRow,
        (edges, seen): (&mut Vec<Edge>, &mut Vec<(f64, f64)>),
    ) -> Result<(), NoStripe> {
        let mut parts = vec![((from, first.clone()), (to, last.clone()), 0)];
        while let Some((low, high, depth)) = parts.pop() {
            seen.extend([&low.1, &high.1].into_iter().flatten().map(|place| (place.value, place.sheet)));
            let (Some(before), Some(after)) = (&low.1, &high.1) else {
                // On to where physical breathers end.
                if (low.1.is_some() || high.1.is_some()) && depth < ALONE {
                    self.halve(line, low, high, depth, &mut parts)?;
                }
                continue;
            };
            if before.sheet != after.sheet {
                if depth < ALONE {
                    self.halve(line, low, high, depth, &mut parts)?;
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
            // Two beyond −1 may turn complex: nothing happens on the circle.
            let still = complex == 0 && below == 0;
            if still && (depth >= ALONE || before.leads_to(after))
                || depth >= ALONE && (complex.abs(), below) == (1, -2 * complex)
            {
                continue;
            }
            if depth >= ALONE
                && complex.abs() + below.abs() == 1
                && let Some(edge) = self.edge_between(line, before, after)?
                && (edge.error < high.0 - low.0 || depth == DEEPEST)
            {
                edges.push(edge);
                continue;
            }
            if depth < DEEPEST {
                self.halve(line, low, high, depth, &mut parts)?;
            } else {
                row.unresolved.push([low.0, high.0]);
            }
        }
        Ok(())
    }

    #[allow(clippy::type_complexity, reason = "a part of a line: its two ends and its depth")]
    fn halve(
        &mut self,
        line: &StripeLine,
        low: (f64, Option<Place>),
        high: (f64, Option<Place>),
        depth: u32,
        parts: &mut Vec<((f64, Option<Place>), (f64, Option<Place>), u32)>,
    ) -> Result<(), NoStripe> {
        let value = 0.5 * (low.0 + high.0);
        let middle = (value, self.place(line, value)?);
        parts.push((middle.clone(), high, depth + 1));
        parts.push((low, middle, depth + 1));
        Ok(())
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
            (true, _) => vec![(1, self.minus_one())],
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
