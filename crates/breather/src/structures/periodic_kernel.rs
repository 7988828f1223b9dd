//! The periodic kernel: what contacts do after an impulse that repeats every period.
//!
//! A regular mode has ξ(t) = e^{At}(1−R)⁻¹c, R = e^{AT}. A rigid one has none: its kernel here is that of the impulse together with a
//! constant pull −1/T that balances it, and the condition that all impulses balance the static load makes the pulls cancel against it.
//!
//! ```text
//! rigid:                k = t/2 − t²/2T
//! with a dashpot c:     k = [ ½ − t/T − e^{−ct}/(1−e^{−cT}) ]/c
//! ```

use std::sync::Arc;

use vibrochain_lattice::simd::lanes::{LANES, Lane, ZERO, all, four};
use vibrochain_lattice::{LinearMode, ParticipatingModes, Turn, Turned};
use wide::f64x4;

/// From here on 1 − R is rounding: the period is a whole number of the mode's own.
const RESONANT: f64 = 1e14;

/// From 1 − R = 1e-3 on the error of (1−R)⁻¹ is kept apart from that of terms: it is the same in all of them, as if the frequency of the mode
/// were another one, and an orbit next to a resonance feels it far less than errors of its terms one by one.
const NEAR: f64 = 1e-3;

/// A part of a contact's mobility that is rounding: a contact at a node of the mode.
const UNSEEN: f64 = 1e-12;

/// The unit that errors of sums over modes are counted in: each term is a product of four rounded numbers.
pub(super) const UNIT: f64 = 4.0 * f64::EPSILON;

/// What a regular mode adds up to over all periods.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Sum {
    /// (1−R)⁻¹
    sum: Turned,
    /// How much its errors are larger than the unit of rounding: next to a resonance, and where the mode's own poles are known worse.
    steep: f64,
    /// How much errors of terms are larger than rounding: by this sum's own, or next to a resonance by those of the mode's flight alone.
    blur: f64,
    /// The length of its generator, κ or more.
    fast: f64,
}

/// The kernel and its derivatives, from contacts that are hit to all.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct PeriodicKernel {
    pub(super) period: f64,
    /// The modes as the impacts feel them, and the sums of the regular ones.
    pub(super) felt: Arc<ParticipatingModes>,
    sums: Vec<Option<Sum>>,
    /// The rigid modes of the structure, as they are: each has an offset.
    rigid: Vec<LinearMode>,
    /// From each contact that is hit to itself, a period later.
    own: Vec<(usize, Jet)>,
}

/// What changes a number in size, and what turns it.
pub(super) const EITHER_WAY: [Turned; 2] = [Turned { even: 1.0, odd: 0.0 }, Turned { even: 0.0, odd: 1.0 }];

/// K and its first three derivatives; and the sizes of their terms, with what next to a resonance, and by errors of the modes, is lost on them:
/// [`UNIT`] of it bounds the error.
pub(super) type Jet = ([f64; 4], [f64; 4]);

/// What a mode has lost at four places and at their nearest ends, either way.
type Losses = [[f64x4; 2]; 2];

impl PeriodicKernel {
    pub(super) fn new(modes: &[LinearMode], felt: Arc<ParticipatingModes>, hit: &[usize], period: f64) -> Self {
        let sums = felt.modes.iter().map(|mode| Sum::of(mode, period)).collect();
        let rigid = modes.iter().filter(|mode| mode.is_rigid()).cloned().collect();
        let mut kernel = Self { period, felt, sums, rigid, own: Vec::new() };
        kernel.own = hit.iter().map(|&contact| (contact, kernel.jet(contact, contact, period))).collect();
        kernel
    }

    /// Whether nothing holds the structure somewhere.
    pub(super) fn has_rigid(&self) -> bool {
        !self.rigid.is_empty()
    }

    /// The rigid modes, in the order of the structure's.
    pub(super) fn rigid(&self) -> &[LinearMode] {
        &self.rigid
    }

    /// The regular modes that are felt, with (1−R)⁻¹.
    pub(super) fn regular(&self) -> impl Iterator<Item = (&LinearMode, Turned)> + Clone {
        self.sums_of().map(|(mode, sum)| (mode, sum.sum))
    }

    fn sums_of(&self) -> impl Iterator<Item = (&LinearMode, &Sum)> + Clone {
        self.felt.modes.iter().zip(&self.sums).filter_map(|(mode, sum)| Some((mode, sum.as_ref()?)))
    }

    /// The largest rate |λ| of a mode that is felt.
    pub(super) fn fastest(&self) -> f64 {
        self.sums_of().map(|(_, sum)| sum.fast).fold(0.0, f64::max)
    }

    /// The number of the first mode that impacts of these contacts would drive without bound.
    pub(super) fn resonant(&self, contacts: &[usize]) -> Option<usize> {
        let seen =
            |mode: &LinearMode, contact: usize| mode.rate * length(mode.rows[contact]) * length(mode.columns[contact]);
        let drives = |mode: &LinearMode, contact: usize| {
            let all: f64 = self.felt.modes.iter().map(|other| seen(other, contact)).sum();
            seen(mode, contact) > UNSEEN * all
        };
        let place = self.felt.modes.iter().zip(&self.sums).position(|(mode, sum)| {
            sum.is_some_and(|sum| sum.steep >= RESONANT) && contacts.iter().any(|contact| drives(mode, *contact))
        });
        place.map(|place| self.felt.numbers[place])
    }

    /// The kernel at −T < t ≤ T, for t ≤ 0 the past impulses alone: K(t+T).
    pub(super) fn jet(&self, to: usize, from: usize, t: f64) -> Jet {
        if t == 0.0
            && to == from
            && let Some((_, jet)) = self.own.iter().find(|(contact, _)| *contact == to)
        {
            return *jet;
        }
        let t = if t > 0.0 { t } else { t + self.period };
        let (mut jet, mut sizes) = ([0.0; 4], [0.0; 4]);
        let flights = Turn::flights(self.sums_of().map(|(mode, _)| mode.flow()), t);
        for ((mode, sum), flight) in self.sums_of().zip(flights) {
            let (row, column, turn) = (mode.rows[to], mode.columns[from], mode.turn);
            let (reach, doubt) = (length(row) * length(column), mode.errors_between(to, from));
            if reach == 0.0 && doubt == 0.0 {
                continue;
            }
            let mut motion = turn.product(flight, sum.sum);
            let mut size = (reach * (1.0 + sum.blur) + doubt / UNIT) * length([motion.even, motion.odd]);
            for (order, entry) in jet.iter_mut().enumerate() {
                *entry += turn.pair(row, motion, column);
                motion = turn.product(motion, mode.generator());
                sizes[order] += size;
                size *= sum.fast;
            }
        }
        for mode in &self.rigid {
            let shapes = mode.rows[to][0] * mode.columns[from][1] * mode.rate;
            let size = shapes.abs() + mode.errors_between(to, from) * mode.rate / UNIT;
            for (order, own) in rigid_jet(mode, self.period, t).into_iter().enumerate() {
                jet[order] += shapes * own;
                sizes[order] += size * own.abs();
            }
        }
        (jet, sizes)
    }

    /// Modes next to a resonance, by their place among the regular ones, and the relative error of their (1−R)⁻¹.
    pub(super) fn nearly_resonant(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let near =
            |(place, (_, sum)): (usize, (&LinearMode, &Sum))| (sum.blur < sum.steep).then_some((place, sum.steep));
        self.sums_of().enumerate().filter_map(near).map(|(place, steep)| (place, f64::EPSILON * steep))
    }

    /// What one regular mode has of the kernel and its first three derivatives at −T < t ≤ T, (1−R)⁻¹ times a number.
    pub(super) fn jet_of_mode(&self, place: usize, by: Turned, (to, from): (usize, usize), t: f64) -> [f64; 4] {
        let mut jet = [0.0; 4];
        let t = if t > 0.0 { t } else { t + self.period };
        for (mode, sum) in self.sums_of().skip(place).take(1) {
            let mut motion = mode.turn.product(mode.turn.flight(mode.decay, mode.rate, t), sum.sum);
            motion = mode.turn.product(motion, by);
            for entry in &mut jet {
                *entry = mode.turn.pair(mode.rows[to], motion, mode.columns[from]);
                motion = mode.turn.product(motion, mode.generator());
            }
        }
        jet
    }

    /// Derivatives by the period of the kernel and its first two derivatives, at −T < t < T as [`Self::jet`] takes it: the impulses of n periods
    /// ago are n times as much later.
    ///
    /// ```text
    /// Σ nA e^{A(t+nT)} = e^{A(t+T)}A(1−R)⁻²
    /// ```
    pub(super) fn by_period(&self, to: usize, from: usize, t: f64) -> [f64; 3] {
        let mut slopes = [0.0; 3];
        let flights = Turn::flights(self.sums_of().map(|(mode, _)| mode.flow()), t + self.period);
        for ((mode, sum), flight) in self.sums_of().zip(flights) {
            let (row, column, turn) = (mode.rows[to], mode.columns[from], mode.turn);
            let mut motion = turn.product(turn.product(flight, sum.sum), sum.sum);
            for entry in &mut slopes {
                motion = turn.product(motion, mode.generator());
                *entry += turn.pair(row, motion, column);
            }
        }
        for mode in &self.rigid {
            let shapes = mode.rows[to][0] * mode.columns[from][1] * mode.rate;
            let own = rigid_by_period(mode, self.period, t);
            slopes.iter_mut().zip(own).for_each(|(entry, own)| *entry += shapes * own);
        }
        slopes
    }

    /// The kernel from one contact to another and back, of modes that do not grow; `None` where one does, or is rigid.
    pub(super) fn between(&self, first: usize, second: usize) -> Option<Between> {
        let held = self.felt.modes.iter().all(is_held);
        if self.has_rigid() || !held {
            return None;
        }
        let mut between = Between { period: self.period, modes: Vec::new(), doubts: [[0.0; 3]; 2], fastest: 0.0 };
        for (mode, sum) in self.sums_of() {
            let (mut parts, mut fourth) = ([[[0.0; 2]; 4]; 2], [0.0; 2]);
            let turn = mode.turn;
            // Back: at T − t the mode has turned by its period and back again, and odd derivatives change their sign.
            let whole = if turn == Turn::Circular {
                let (sin, cos) = (mode.rate * self.period).sin_cos();
                Turned { even: cos, odd: sin }
            } else {
                Turned { even: 1.0, odd: 0.0 }
            };
            let ways = [(second, first, sum.sum, 1.0), (first, second, turn.product(whole, sum.sum), -1.0)];
            // e^{At} is no longer than 1, or than 1 + κt of a double pole.
            let flight = match turn {
                Turn::Circular => 1.0,
                Turn::Hyperbolic => std::f64::consts::SQRT_2,
                Turn::Parabolic => 1.0 + mode.rate / mode.decay,
            };
            for (way, (to, from, mut motion, sign)) in ways.into_iter().enumerate() {
                let (row, column) = (mode.rows[to], mode.columns[from]);
                let reach = flight * length(row) * length(column);
                // row·column and row·J·column
                let [plain, turned] =
                    [[1.0, 0.0], [0.0, 1.0]].map(|[even, odd]| turn.pair(row, Turned { even, odd }, column));
                for (order, part) in parts[way].iter_mut().enumerate() {
                    let by = if order % 2 == 1 { sign } else { 1.0 };
                    let Turned { even, odd } = motion;
                    *part = [even * plain + odd * turned, even * turned - turn.sign() * odd * plain].map(|x| by * x);
                    let size = motion.even.abs() + motion.odd.abs();
                    if let Some(doubt) = between.doubts[way].get_mut(order) {
                        let own = 6.0 * f64::EPSILON * (1.0 + sum.blur) * reach;
                        *doubt += (own + flight * mode.errors_between(to, from)) * size;
                    }
                    motion = turn.product(motion, mode.generator());
                }
                // Of J(a + bJ) the length of (a, b) times at most this.
                let size = if turn == Turn::Circular {
                    length([motion.even, motion.odd])
                } else {
                    motion.even.abs() + motion.odd.abs()
                };
                fourth[way] = reach * size;
            }
            between.fastest = between.fastest.max(mode.rate);
            let slowest = match turn {
                Turn::Circular => mode.decay,
                Turn::Hyperbolic => mode.decay - mode.rate,
                Turn::Parabolic => 0.0,
            };
            let left = (-mode.decay * self.period).exp();
            between.modes.push(Both { turn, decay: mode.decay, rate: mode.rate, left, parts, slowest, fourth });
        }
        Some(between)
    }
}

impl Sum {
    /// `None` of a rigid mode.
    fn of(mode: &LinearMode, period: f64) -> Option<Self> {
        if mode.is_rigid() {
            return None;
        }
        let one_less = one_less(mode, period);
        let square = match mode.turn {
            Turn::Circular => one_less.even * one_less.even + one_less.odd * one_less.odd,
            // By the two poles.
            Turn::Hyperbolic => (one_less.even + one_less.odd) * (one_less.even - one_less.odd),
            Turn::Parabolic => one_less.even * one_less.even,
        };
        // 1 − R = a − bJ has the inverse (a + bJ)/(a² + σb²); `odd` holds −b.
        let sum = Turned { even: one_less.even / square, odd: -one_less.odd / square };
        let size = (mode.errors.poles / f64::EPSILON).max(mode.decay.abs() + mode.rate) * period;
        let away = square.abs().sqrt();
        let steep = size / away;
        Some(Self { sum, steep, blur: if away < NEAR { size } else { steep }, fast: length([mode.decay, mode.rate]) })
    }
}

/// The kernels between two contacts, at φ from the first to the second and at T − φ back, as functions of φ.
#[derive(Debug)]
pub(super) struct Between {
    period: f64,
    modes: Vec<Both>,
    /// What rounding makes of the sums and of their first two derivatives: of the terms, far more than of their sum next to a resonance.
    pub(super) doubts: [[f64; 3]; 2],
    /// The fastest of the modes.
    pub(super) fastest: f64,
}

/// One mode, and what its two coordinates are multiplied by in either kernel and its first three derivatives.
#[derive(Debug)]
struct Both {
    turn: Turn,
    decay: f64,
    rate: f64,
    /// What is left of it after a period.
    left: f64,
    parts: [[[f64; 2]; 4]; 2],
    /// The rate at which all of it dies, and bounds of the fourth derivatives where it has not.
    slowest: f64,
    fourth: [f64; 2],
}

/// Far above the least number that keeps its digits.
const LEFT: f64 = 1e-200;

/// e^{−45} = 3e-20: what has died so far adds nothing to sums.
const DEAD: f64 = 45.0;

impl Between {
    /// Both kernels with three derivatives at four φ, and bounds of the fourth ones within radii of these.
    pub(super) fn jets(&self, places: Lane, radii: Lane) -> ([[f64x4; 4]; 2], [f64x4; 2]) {
        let (mut jets, mut fourths) = ([[ZERO; 4]; 2], [ZERO; 2]);
        let ways = [places, places.map(|t| self.period - t)];
        let nearest = [0, 1].map(|way| (0..LANES).map(|i| ways[way][i] - radii[i]).fold(f64::INFINITY, f64::min));
        // Many modes of a structure often lose alike.
        let mut lost: Option<((f64, f64), Losses)> = None;
        for mode in &self.modes {
            let Both { turn, decay, rate, parts, slowest, fourth, .. } = mode;
            if nearest.iter().all(|t| slowest * t > DEAD) {
                continue;
            }
            let losses = match lost {
                Some((of, losses)) if of == (*decay, *slowest) => losses,
                _ => Self::losses(mode, &ways, radii),
            };
            lost = Some(((*decay, *slowest), losses));
            let moved = match turn.turns(*rate, places) {
                Some([cos, sin]) => {
                    let (cos, sin) = (four(cos), four(sin));
                    [[cos * losses[0][0], sin * losses[0][0]], [cos * losses[1][0], -sin * losses[1][0]]]
                }
                None => ways.map(|times| {
                    let flights = times.map(|t| turn.flight(*decay, *rate, t));
                    [four(flights.map(|flight| flight.even)), four(flights.map(|flight| flight.odd))]
                }),
            };
            for ((jet, parts), [even, odd]) in jets.iter_mut().zip(parts).zip(moved) {
                for (entry, part) in jet.iter_mut().zip(parts) {
                    *entry += even * all(part[0]) + odd * all(part[1]);
                }
            }
            for way in 0..2 {
                fourths[way] += losses[way][1] * all(fourth[way]);
            }
        }
        (jets, fourths)
    }

    /// What a mode has lost at four places and at their nearest ends, either way.
    fn losses(&Both { decay, slowest, left, .. }: &Both, ways: &[Lane; 2], radii: Lane) -> Losses {
        let of = |rate: f64, t: f64| if rate == 0.0 { 1.0 } else { (-rate * t).exp() };
        let there = ways[0].map(|t| of(decay, t));
        // What is lost on both ways is what a period takes, as long as numbers hold it.
        let back = if left > LEFT { there.map(|there| left / there) } else { ways[1].map(|t| of(decay, t)) };
        [(there, ways[0]), (back, ways[1])].map(|(at, times)| {
            let ends: Lane = std::array::from_fn(|i| {
                let way = radii[i].min(times[i]);
                let gained = slowest * way;
                // e^x is below its chord from 0 to 1.
                if slowest == decay && (0.0..=1.0).contains(&gained) {
                    at[i] * (1.0 + (std::f64::consts::E - 1.0) * gained)
                } else {
                    of(slowest, times[i] - way)
                }
            });
            [four(at), four(ends)]
        })
    }

    /// Both kernels with two derivatives at one φ.
    pub(super) fn jets_at(&self, phi: f64) -> [[f64; 3]; 2] {
        let mut jets = [[0.0; 3]; 2];
        let ways = [phi, self.period - phi];
        let mut lost = (0.0, [1.0; 2]);
        for modes in self.modes.chunks(LANES) {
            // Four modes at a time.
            let angles = std::array::from_fn(|i| modes.get(i).map_or(0.0, |mode| mode.rate * phi));
            let [cos, sin] = Turn::Circular.turns(1.0, angles).unwrap_or_default();
            for (i, Both { turn, decay, rate, parts, slowest, .. }) in modes.iter().enumerate() {
                if slowest * ways[0].min(ways[1]) > DEAD {
                    continue;
                }
                let moved = if *turn == Turn::Circular {
                    if lost.0 != *decay {
                        lost = (*decay, ways.map(|t| (-decay * t).exp()));
                    }
                    let left = lost.1;
                    [[cos[i] * left[0], sin[i] * left[0]], [cos[i] * left[1], -sin[i] * left[1]]]
                } else {
                    ways.map(|t| turn.flight(*decay, *rate, t)).map(|flight| [flight.even, flight.odd])
                };
                for ((jet, parts), [even, odd]) in jets.iter_mut().zip(parts).zip(moved) {
                    jet.iter_mut().zip(parts).for_each(|(entry, part)| *entry += even * part[0] + odd * part[1]);
                }
            }
        }
        jets
    }
}

/// Nothing of it grows, or stays where it is.
fn is_held(mode: &LinearMode) -> bool {
    match mode.turn {
        Turn::Circular => mode.decay >= 0.0,
        Turn::Hyperbolic => mode.decay >= mode.rate,
        Turn::Parabolic => mode.decay > 0.0,
    }
}

/// The length of two numbers: `hypot`, which takes ten times as long, only where squares leave the range.
pub(super) fn length([x, y]: [f64; 2]) -> f64 {
    let square = x * x + y * y;
    if square > 1e-280 && square < 1e280 { square.sqrt() } else { x.hypot(y) }
}

/// k of a rigid mode and its first three derivatives at 0 ≤ t ≤ T. (Its rows are [φ, 0], its columns [0, φ/κ].)
pub(super) fn rigid_jet(mode: &LinearMode, period: f64, t: f64) -> [f64; 4] {
    let (part, dashpot) = (t / period, 2.0 * mode.decay);
    if dashpot == 0.0 {
        return [0.5 * t * (1.0 - part), 0.5 - part, -period.recip(), 0.0];
    }
    let dying = (-dashpot * t).exp() / -(-dashpot * period).exp_m1();
    let speed = dying - (dashpot * period).recip();
    [(0.5 - part - dying) / dashpot, speed, -dashpot * dying, dashpot * dashpot * dying]
}

/// Derivatives by T of a rigid mode's k and its first two derivatives, at −T < t < T: of those at t + T where t is not positive.
fn rigid_by_period(mode: &LinearMode, period: f64, t: f64) -> [f64; 3] {
    let (part, dashpot) = (t / period, 2.0 * mode.decay);
    if dashpot == 0.0 {
        return [0.5 * part * part, part / period, (period * period).recip()];
    }
    let left = (-dashpot * period).exp_m1();
    let dying = (-dashpot * (t + period)).exp() / (left * left);
    let pull = (dashpot * period).recip();
    [pull * part + dying, pull / period - dashpot * dying, dashpot * dashpot * dying]
}

/// 1 − e^{AT} as a + bJ, without cancellation next to a resonance.
fn one_less(mode: &LinearMode, period: f64) -> Turned {
    let (decay, angle) = (-mode.decay * period, mode.rate * period);
    match mode.turn {
        Turn::Circular => {
            let half = (0.5 * angle).sin();
            Turned { even: 2.0 * half * half - decay.exp_m1() * angle.cos(), odd: -decay.exp() * angle.sin() }
        }
        Turn::Hyperbolic => {
            let [slow, fast] = [decay + angle, decay - angle].map(|x| -x.exp_m1());
            Turned { even: 0.5 * (slow + fast), odd: 0.5 * (slow - fast) }
        }
        Turn::Parabolic => Turned { even: -decay.exp_m1(), odd: -decay.exp() * angle },
    }
}
