//! The borders of one part of a scene: stripes first, then a coarse look and what it shows.

use std::cell::Cell;

use rayon::prelude::{IntoParallelRefIterator, ParallelIterator};
use vibrochain_floquet::{CurveEnd, Event, Located, StripeFinder, Walk, event_curve};
use vibrochain_lattice::Parameter;

use super::asked::{BorderRequest, Stage};
use super::border::{Border, BorderKind, BorderPoint, Borders, MergedStripes, StripeEdge, UnexplainedChange};
use super::change::trace;
use super::courses::{Courses, is_uncoupled, striped};
use super::grid::{Edge, Grid};
use super::known::Known;
use super::lanes::{Lane, Liner};
use super::meet::{along_one, detuning, meet};
use super::part::{ClassProbe, Part};
use crate::cell::Class;
use crate::regions::Window;
use crate::scene::Scene;

/// The most places of the coarse look. A finer scene is looked at through a coarser grid.
const MOST_PLACES: f64 = 160_000.0;

/// How far on either side of a change a stripe is looked for, and at how many points.
const BESIDE: f64 = 2e-3;
const BESIDE_POINTS: usize = 9;

/// Changes that are looked at side by side, at least so many places of the grid from one another: one border each, as far as can be.
const BATCH: usize = 16;
const APART: usize = 12;

/// Changes in faces that are looked at side by side.
const SOME: usize = 4;

/// A curve lies on a border that is known if it does so for this many points and this part of the window.
const POINTS_ALIKE: u32 = 4;
const ALIKE: f64 = 1e-3;

/// A curve of orbits that are not physical is followed this far: it may come back.
const BEYOND: f64 = 0.02;

/// The search among the breathers of one part.
pub(super) struct Search<'a> {
    pub(super) scene: &'a Scene,
    pub(super) asked: BorderRequest<'a>,
    pub(super) window: Window,
    pub(super) parameters: [Parameter; 2],
    pub(super) plane: vibrochain_floquet::Window,
    pub(super) part: &'a Part,
    pub(super) known: Known,
    pub(super) grid: Grid,
    pub(super) found: Borders,
}

/// What was found at a change.
#[derive(Debug, Default)]
struct Outcome {
    borders: Vec<Border>,
    explained: bool,
}

impl Search<'_> {
    pub(super) fn stopped(&mut self) -> bool {
        self.found.interrupted |= self.asked.stop.is_raised();
        self.found.interrupted
    }

    fn told(&self, stage: Stage, done: usize, all: usize) {
        (self.asked.told)(&self.part.name, stage, done, all);
    }

    fn probe(&self) -> ClassProbe<'_> {
        ClassProbe::new(self.scene, self.window, self.asked.stop)
    }

    fn parts_of(&self, border: &Border) -> Vec<[f64; 2]> {
        border.points.iter().map(|point| self.window.part(point.values)).collect()
    }

    fn add(&mut self, border: Border) {
        let line = self.parts_of(&border);
        self.grid.mark(&line);
        self.known.add(&line);
        self.found.borders.push(border);
    }

    /// The coarse look.
    pub(super) fn look(&mut self) {
        let points = [0, 1].map(|i| self.scene.axes[i].points().max(2) as f64);
        let share = (MOST_PLACES / (points[0] * points[1])).sqrt().min(1.0);
        let size = points.map(|points| ((points * share) as usize).max(2));
        let places: Vec<[f64; 2]> = Grid::places(size).collect();
        self.told(Stage::Places, 0, places.len());
        let part = self.part;
        let stop = self.asked.stop;
        let classes: Vec<Option<Class>> = places
            .par_iter()
            .map_init(
                || self.probe(),
                |probe, &place| {
                    let skipped = is_uncoupled(self.scene, place) || stop.is_raised();
                    if skipped { None } else { probe.class(part, place) }
                },
            )
            .collect();
        self.found.places = places.len();
        self.grid = Grid::new(size, classes);
    }

    /// Stripes by themselves.
    pub(super) fn stripes(&mut self) {
        let Some(family) = striped(self.scene, self.part) else { return };
        if self.stopped() {
            return;
        }
        let BorderRequest { tolerance, stop, .. } = self.asked;
        let courses = Courses { scene: self.scene, window: self.window, part: self.part, family, tolerance, stop };
        let (lanes, unresolved) = courses.lanes(&|done, all| self.told(Stage::Rows, done, all));
        let value = |y: f64| self.window.point([0.0, y])[1];
        let of_part =
            |(y, range): (f64, [f64; 2])| MergedStripes { family: self.part.name.clone(), range, at: value(y) };
        self.found.unresolved = unresolved.into_iter().map(of_part).collect();
        for lane in &lanes {
            for upper in [false, true] {
                self.add(self.edge(lane, upper));
            }
        }
    }

    fn edge(&self, lane: &Lane, upper: bool) -> Border {
        let Lane { modes, harmonic, points, ends } = lane;
        let kind = if modes.0 == modes.1 { BorderKind::PeriodDoubling } else { BorderKind::NeimarkSacker };
        let line = lane.line(upper);
        let point = |(place, point): (&[f64; 2], &super::lanes::LanePoint)| BorderPoint {
            values: self.window.point(*place),
            error: point.error,
            half_width: Some(point.half_width),
        };
        Border {
            family: self.part.name.clone(),
            kind,
            stripe: Some(StripeEdge { modes: *modes, harmonic: *harmonic, upper }),
            points: line.iter().zip(points).map(point).collect(),
            special: Vec::new(),
            ends: ends.map(str::to_owned),
        }
    }

    /// What the coarse look shows, one border after the other.
    pub(super) fn changes(&mut self) {
        loop {
            let runs = self.grid.unexplained();
            let left: usize = runs.iter().map(Vec::len).sum();
            self.told(Stage::Changes, self.found.borders.len(), self.found.borders.len() + left);
            if runs.is_empty() || self.stopped() {
                return;
            }
            let mut chosen: Vec<Edge> = Vec::new();
            // One of a run: it may be one border's.
            for edge in runs.iter().map(|run| run[run.len() / 2]) {
                let far =
                    |other: &Edge| other.column.abs_diff(edge.column) >= APART || other.row.abs_diff(edge.row) >= APART;
                if chosen.len() < BATCH && chosen.iter().all(far) {
                    chosen.push(edge);
                }
            }
            let outcomes: Vec<Outcome> = chosen
                .par_iter()
                .map_init(
                    || self.probe(),
                    |probe, &edge| self.explain(probe, usize::from(!edge.across), self.grid.ends(edge)),
                )
                .collect();
            for (edge, outcome) in chosen.into_iter().zip(outcomes) {
                // Looked at once: what is not explained now will not be later.
                let ends = self.grid.ends(edge);
                self.grid.pass(edge);
                self.take(outcome, ends);
            }
        }
    }

    /// Adds what was found at a change.
    fn take(&mut self, outcome: Outcome, ends: [[f64; 2]; 2]) {
        if !outcome.explained {
            let between = ends.map(|place| self.window.point(place));
            self.found.unexplained.push(UnexplainedChange { family: self.part.name.clone(), between });
        }
        for border in outcome.borders {
            // Two changes looked at side by side may be one border's.
            let reach = 2.0 * self.asked.tolerance;
            let new: Vec<bool> = self.parts_of(&border).iter().map(|place| !self.known.holds(*place, reach)).collect();
            for border in border.pieces(&new) {
                self.add(border);
            }
        }
    }

    /// At the end: whether it was stopped, and no change is told twice, nor one that has a border by now.
    pub(super) fn finish(&mut self) {
        let _ = self.stopped();
        let reach = 2.0 * self.asked.tolerance;
        let (window, known) = (self.window, &self.known);
        let place = |ends: &[[f64; 2]; 2]| window.part([0, 1].map(|i| 0.5 * (ends[0][i] + ends[1][i])));
        let mut told: Vec<[f64; 2]> = Vec::new();
        self.found.unexplained.retain(|change| {
            let place = place(&change.between);
            let new = !known.holds(place, reach) && !told.contains(&place);
            told.push(place);
            new
        });
    }

    /// The borders between pairs of places, as far as they are this part's. Whether there are any.
    pub(super) fn explain_all(&mut self, changes: &[[[f64; 2]; 2]]) -> bool {
        let before = self.found.borders.len();
        // A few at a time: some are one border's.
        for some in changes.chunks(SOME) {
            let outcomes: Vec<Option<(Outcome, [[f64; 2]; 2])>> = some
                .par_iter()
                .map_init(
                    || self.probe(),
                    |probe, &ends| {
                        let (axis, ends) = along_one(probe, self.part, ends)?;
                        Some((self.explain(probe, axis, ends), ends))
                    },
                )
                .collect();
            for (outcome, ends) in outcomes.into_iter().flatten() {
                self.take(outcome, ends);
            }
        }
        self.found.borders.len() > before
    }

    /// The borders between two places along one parameter.
    fn explain(&self, probe: &mut ClassProbe<'_>, axis: usize, ends: [[f64; 2]; 2]) -> Outcome {
        if self.asked.stop.is_raised() {
            return Outcome::default();
        }
        let reach = 2.0 * self.asked.tolerance;
        let is_known = |place| self.known.holds(place, reach);
        let Some(met) = meet(probe, self.part, (axis, ends), is_known) else { return Outcome::default() };
        let mut outcome = Outcome { explained: met.known, ..Outcome::default() };
        if met.known {
            return outcome;
        }
        let spectral = |located: &Located| matches!(located.event, Event::NeimarkSacker | Event::PeriodDoubling);
        // A stripe that no row has shown: by its modes it is known to its end, however thin.
        if met.resonance.is_none() && met.events.iter().all(spectral) {
            outcome.borders = self.stripe_at(probe, met.ends[0]);
            outcome.explained = !outcome.borders.is_empty();
            if outcome.explained {
                return outcome;
            }
        }
        for located in &met.events {
            let Some(model) = located.orbit.model() else { continue };
            let place = self.window.part(self.parameters.map(|parameter| model.get(parameter)));
            if self.known.holds(place, reach) {
                outcome.explained = true;
            } else if let Some(border) = self.follow(located) {
                outcome.borders.push(border);
                outcome.explained = true;
            }
        }
        if outcome.explained {
            return outcome;
        }
        let tolerance = self.asked.tolerance;
        let alike: Cell<u32> = Cell::new(0);
        let stopped = |_| self.asked.stop.is_raised();
        let until = |place| {
            alike.set(if self.known.holds(place, reach) { alike.get() + 1 } else { 0 });
            let same = alike.get() >= POINTS_ALIKE;
            if same {
                alike.set(0);
            }
            same || stopped(place)
        };
        let traced = match met.resonance {
            Some(resonance) => {
                trace(&mut |place| detuning(probe, resonance, place).map(|x| x > 0.0), met.ends, tolerance, &stopped)
            }
            None => trace(&mut |place| probe.class(self.part, place), met.ends, tolerance, &until),
        };
        if let Some(traced) = traced {
            let point = |&(place, error): &([f64; 2], f64)| BorderPoint {
                values: self.window.point(place),
                error,
                half_width: None,
            };
            outcome.explained = true;
            outcome.borders.push(Border {
                family: self.part.name.clone(),
                kind: met.end,
                stripe: None,
                points: traced.points.iter().map(point).collect(),
                special: Vec::new(),
                ends: traced.ends.map(str::to_owned),
            });
        }
        outcome
    }

    /// Both edges of the stripe that has one of them at a place.
    fn stripe_at(&self, probe: &mut ClassProbe<'_>, [x, y]: [f64; 2]) -> Vec<Border> {
        let Some(family) = striped(self.scene, self.part) else { return Vec::new() };
        let (part, tolerance) = (self.part, self.asked.tolerance);
        let mut liner = Liner { probe, part, finder: &mut StripeFinder::until(self.asked.stop), family, tolerance };
        let row = liner.row(y, ((x - BESIDE).max(0.0), (x + BESIDE).min(1.0)), BESIDE_POINTS);
        let value = |x: f64| self.window.point([x, y])[0];
        let [low, high] = [x - 2.0 * tolerance, x + 2.0 * tolerance].map(value);
        let here = |edge: &f64| low <= *edge && *edge <= high;
        let Some(stripe) = row.stripes.iter().find(|stripe| stripe.edges.iter().any(here)) else { return Vec::new() };
        liner.lane(y, stripe).map_or(Vec::new(), |lane| [false, true].map(|upper| self.edge(&lane, upper)).into())
    }

    /// The curve of an event.
    fn follow(&self, located: &Located) -> Option<Border> {
        let alike: Cell<(u32, Option<[f64; 2]>)> = Cell::new((0, None));
        let beyond: Cell<Option<[f64; 2]>> = Cell::new(None);
        let apart = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
        let until = |values: [f64; 2], physical: Option<bool>| {
            let place = self.window.part(values);
            let (mut count, mut first) = alike.get();
            if self.known.holds(place, 2.0 * self.asked.tolerance) {
                count += 1;
                first = first.or(Some(place));
            } else {
                (count, first) = (0, None);
            }
            let same = count >= POINTS_ALIKE && first.is_some_and(|first| apart(first, place) > ALIKE);
            let outside = match (physical, beyond.get()) {
                (Some(false), None) => Some(place),
                (Some(false), first) => first,
                _ => None,
            };
            let gone = outside.is_some_and(|first| apart(first, place) > BEYOND);
            let enough = same || gone;
            alike.set(if enough { (0, None) } else { (count, first) });
            beyond.set(if enough { None } else { outside });
            enough
        };
        let walk = Walk {
            special: self.asked.special,
            until: &until,
            stop: self.asked.stop.clone(),
            ..Walk::new(self.plane, self.asked.tolerance)
        };
        let numbers = located.orbit.lattice().ok()?.numbers(&self.parameters, self.asked.stop);
        let curve = event_curve(&located.orbit, located.event, located.evidence, &numbers, &walk).ok()?;
        let point = |point: &vibrochain_floquet::CurvePoint| BorderPoint {
            values: point.values,
            error: point.error,
            half_width: None,
        };
        let end = |end: &CurveEnd| match end {
            CurveEnd::Halted => "where it is known, or not physical".to_owned(),
            end => end.to_string(),
        };
        let border = Border {
            family: self.part.name.clone(),
            kind: curve.event.into(),
            stripe: None,
            points: curve.points.iter().map(point).collect(),
            special: curve.special,
            ends: [end(&curve.ends[0]), end(&curve.ends[1])],
        };
        (border.points.len() > 1).then_some(border)
    }
}
