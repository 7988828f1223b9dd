//! The periodic kernel between two contacts, there and back, as functions of one time, four at once and with bounds: what enclosures of two and
//! of three impacts are made of.

use vibrochain_lattice::simd::lanes::{LANES, Lane, ZERO, all, four};
use vibrochain_lattice::{LinearMode, Turn, Turned};
use wide::f64x4;

use super::periodic_kernel::{PeriodicKernel, length};
use crate::roots::patch::Piece;

/// What a mode has lost at four places and at their nearest ends, either way.
type Losses = [[f64x4; 2]; 2];

/// The kernels between two contacts, at φ from the first to the second and at T − φ back, as functions of φ.
#[derive(Debug)]
pub(super) struct Between {
    period: f64,
    modes: Vec<Both>,
    /// What rounding makes of the sums and of their first two derivatives. Next to a resonance without the error of (1−R)⁻¹, which is the same
    /// number in all of them: they are the kernels of a mode nearby, and what is proved of them is proved of it.
    pub(super) doubts: [[f64; 3]; 2],
    /// The fastest of the modes.
    pub(super) fastest: f64,
    /// Of rigid modes what their parabola t/2 − t²/2T is multiplied by in either kernel.
    rigid: [f64; 2],
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

/// Of a pair of impacts: K and (1+e)K′ at the later one, and at the earlier one.
pub(super) type Pair = [[Piece; 2]; 2];

/// Far above the least number that keeps its digits.
const LEFT: f64 = 1e-200;

/// e^{−45} = 3e-20: what has died so far adds nothing to sums.
const DEAD: f64 = 45.0;

impl Between {
    /// The kernel from one contact to another and back, of modes that do not grow; `None` where one does, or is rigid with a dashpot.
    pub(super) fn new(kernel: &PeriodicKernel, first: usize, second: usize) -> Option<Self> {
        let held = kernel.felt.modes.iter().filter(|mode| !mode.is_rigid()).all(is_held);
        if kernel.rigid().iter().any(|mode| mode.decay != 0.0) || !held {
            return None;
        }
        let period = kernel.period;
        let mut between = Self { period, modes: Vec::new(), doubts: [[0.0; 3]; 2], fastest: 0.0, rigid: [0.0; 2] };
        for mode in kernel.rigid() {
            for (way, (to, from)) in [(second, first), (first, second)].into_iter().enumerate() {
                let shapes = mode.rows[to][0] * mode.columns[from][1] * mode.rate;
                let doubt = 6.0 * f64::EPSILON * shapes.abs() + mode.errors_between(to, from) * mode.rate;
                between.rigid[way] += shapes;
                let sizes = [period, 1.0, period.recip()];
                between.doubts[way].iter_mut().zip(sizes).for_each(|(entry, size)| *entry += doubt * size);
            }
        }
        for (mode, sum) in kernel.sums_of() {
            let (mut parts, mut fourth) = ([[[0.0; 2]; 4]; 2], [0.0; 2]);
            let turn = mode.turn;
            // Back: at T − t the mode has turned by its period and back again, and odd derivatives change their sign.
            let whole = if turn == Turn::Circular {
                let (sin, cos) = (mode.rate * kernel.period).sin_cos();
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
            let left = (-mode.decay * kernel.period).exp();
            between.modes.push(Both { turn, decay: mode.decay, rate: mode.rate, left, parts, slowest, fourth });
        }
        Some(between)
    }

    /// Both kernels with three derivatives at four φ, and bounds of the fourth ones within radii of these.
    pub(super) fn jets(&self, places: Lane, radii: Lane) -> ([[f64x4; 4]; 2], [f64x4; 2]) {
        let (mut jets, mut fourths) = ([[ZERO; 4]; 2], [ZERO; 2]);
        if self.rigid != [0.0; 2] {
            let of = |order: usize| four(places.map(|phi| self.parabola(phi)[order]));
            let parabola = [of(0), of(1), of(2), ZERO];
            jets = self.rigid.map(|shapes| parabola.map(|entry| entry * all(shapes)));
        }
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

    /// Both kernels where the impacts are so far apart, with the factors 1+e of the first contact and of the second. Beyond `longest` they go on as
    /// parabolas do: what is found there is none.
    pub(super) fn pieces(&self, (apart, radius): (f64, f64), weights: [f64; 2], longest: f64) -> Pair {
        let place = apart.min(longest);
        let (beyond, reach) = (apart - place, (radius - (apart - place)).max(0.0));
        let (jets, fourths) = self.jets([place; LANES], [reach; LANES]);
        [0, 1].map(|way| {
            let [value, slope, bend, third] = jets[way].map(|lanes| lanes.to_array()[0]);
            let [of_value, of_slope, _] = self.doubts[way];
            let fourth = fourths[way].to_array()[0];
            let third_bound = third.abs() + reach * fourth;
            // Back, the slope in time is the opposite of that in the time apart.
            let by = weights[1 - way] * [1.0, -1.0][way];
            let moved = |[value, slope, bend]: [f64; 3]| {
                [value + beyond * (slope + 0.5 * beyond * bend), slope + beyond * bend, bend]
            };
            let (place, law) = (moved([value, slope, bend]), moved([slope, bend, third]).map(|x| by * x));
            [
                Piece { jet: place, third: third_bound, doubt: of_value },
                Piece { jet: law, third: by.abs() * fourth, doubt: by.abs() * of_slope },
            ]
        })
    }

    /// t/2 − t²/2T with two derivatives, the same there and back.
    fn parabola(&self, phi: f64) -> [f64; 3] {
        let part = phi / self.period;
        [0.5 * phi * (1.0 - part), 0.5 - part, -self.period.recip()]
    }

    /// Both kernels with two derivatives at one φ.
    pub(super) fn jets_at(&self, phi: f64) -> [[f64; 3]; 2] {
        let parabola = self.parabola(phi);
        let mut jets = self.rigid.map(|shapes| parabola.map(|entry| entry * shapes));
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
