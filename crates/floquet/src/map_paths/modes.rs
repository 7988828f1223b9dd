//! What the secular functions need of every mode that the impacts feel.

use vibrochain_breather::Prepared;
use vibrochain_lattice::simd::lanes::{FOUR, HALF, LANES, Lane, ONE, TWO, ZERO, all, four};
use vibrochain_lattice::{ContactMode, ImpulseResponse, Turn, sine_over};
use wide::f64x4;

use crate::sizes::LARGE;

/// One mode of the even subspace; four of them as `Mode<Lane>` or `Mode<f64x4>`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Mode<T = f64> {
    /// b², Ω
    pub(crate) weight: T,
    pub(crate) frequency: T,
    /// c, s = cos, sin(ΩT/2)
    pub(crate) cos: T,
    pub(crate) sin: T,
    /// x = s/Ω, which a rigid mode has too, and its inverse; y = sΩ.
    pub(crate) sin_over: T,
    pub(crate) inverse: T,
    pub(crate) sin_times: T,
    /// Relative error of x and error of d = c² − s², from that of the phase, in units of ε.
    pub(crate) relative: T,
    pub(crate) shift: T,
    /// Relative error of the weight beyond rounding, in units of ε.
    pub(crate) doubt: T,
}

/// A mode without weight, far from what a formula could stumble over.
const PAD: Mode = Mode {
    weight: 0.0,
    frequency: 0.0,
    cos: 0.6,
    sin: 0.8,
    sin_over: 1.0,
    inverse: 1.0,
    sin_times: 0.0,
    relative: 1.0,
    shift: 1.0,
    doubt: 0.0,
};

/// Four of them.
const PADS: Mode<Lane> = Mode {
    weight: [PAD.weight; LANES],
    frequency: [PAD.frequency; LANES],
    cos: [PAD.cos; LANES],
    sin: [PAD.sin; LANES],
    sin_over: [PAD.sin_over; LANES],
    inverse: [PAD.inverse; LANES],
    sin_times: [PAD.sin_times; LANES],
    relative: [PAD.relative; LANES],
    shift: [PAD.shift; LANES],
    doubt: [PAD.doubt; LANES],
};

/// Phases below which sin y/y comes from its series.
const SOFT: f64 = 1e-3;

/// A part of its own weight below this is rounding: on a ring of 10⁷ masses the least that is none is 5e-14.
const SPARED: f64 = 16.0 * f64::EPSILON;

/// Frequencies this close are equal: each is worked out to 2ε.
const EQUAL: f64 = 4.0 * f64::EPSILON;

/// The even subspace, mode by mode and in groups of four, the last one padded.
#[derive(Debug, Clone, Default)]
pub(crate) struct Modes {
    list: Vec<Mode>,
    /// How many there are of which none is listed yet, see [`Modes::set_in_fours`].
    unlisted: usize,
    /// Their numbers in the lattice's own order, if these are others than their places.
    numbers: Vec<u32>,
    squares: Vec<f64>,
    order: Vec<u32>,
    /// Four at a time; none where [`Modes::group_few`] leaves them out.
    groups: Vec<Mode<Lane>>,
    /// The largest error of a frequency beyond rounding, in units of ε.
    rate_error: f64,
}

impl Modes {
    /// Takes over the modes of an impulse response.
    pub(crate) fn set(&mut self, response: &ImpulseResponse) {
        self.set_in_fours(response);
        self.make_list();
    }

    /// The same, of no more than [`LARGE`] modes in groups of four alone, until they are listed.
    pub(crate) fn set_in_fours(&mut self, response: &ImpulseResponse) {
        let half = 0.5 * response.period();
        let fours = response.swings_in_fours().map(
            #[inline(always)]
            |swings| {
                let [frequency, weight, cos, sin] = swings.map(four);
                Mode::four_of(frequency, weight, (cos, sin), half).lanes()
            },
        );
        self.fill(response.modes(), fours);
    }

    /// The same of modes as the contact of a structure feels them.
    pub(crate) fn set_of_contact(&mut self, modes: &[ContactMode], period: f64) {
        let half = 0.5 * period;
        let fours = modes.chunks(LANES).map(|some| {
            // What fills up the last group is written over.
            let of =
                |number: fn(&ContactMode) -> f64| -> Lane { std::array::from_fn(|i| some.get(i).map_or(1.0, number)) };
            let frequency = of(|mode| mode.frequency);
            let [cos, sin] = Turn::Circular.turns(half, frequency).unwrap_or_default().map(four);
            let mut group = Mode::four_of(four(frequency), four(of(|mode| mode.weight)), (cos, sin), half);
            let units = ONE / all(f64::EPSILON);
            group.doubt = four(of(|mode| mode.weight_error)) * units;
            group.know(four(of(|mode| mode.frequency_error)) * units, half);
            group.lanes()
        });
        self.fill(modes.len(), fours);
        let errors = modes.iter().map(|mode| mode.frequency * mode.frequency_error);
        self.rate_error = errors.fold(0.0, f64::max) / f64::EPSILON;
    }

    /// Takes over so many modes.
    fn fill(&mut self, count: usize, fours: impl Iterator<Item = Mode<Lane>>) {
        self.clear();
        if count > LARGE {
            self.groups.clear();
            self.list.resize(count, PAD);
            for (some, four) in self.list.chunks_mut(LANES).zip(fours) {
                some.iter_mut().enumerate().for_each(|(j, mode)| four.write(j, mode));
            }
            return;
        }
        self.unlisted = count;
        // What is there is written over in its place.
        self.groups.resize(count.div_ceil(LANES), PADS);
        self.groups.iter_mut().zip(fours).for_each(|(group, four)| *group = four);
        if let Some(last) = self.groups.last_mut() {
            (count..count.next_multiple_of(LANES)).for_each(|k| last.put(k % LANES, &PAD));
        }
    }

    /// Lists them one by one, if that is not done.
    pub(crate) fn make_list(&mut self) {
        let count = std::mem::take(&mut self.unlisted);
        self.list.resize(self.list.len().max(count), PAD);
        for (some, four) in self.list.chunks_mut(LANES).zip(&self.groups).take(count.div_ceil(LANES)) {
            some.iter_mut().enumerate().for_each(|(j, mode)| four.write(j, mode));
        }
    }

    /// Takes over what the impacts at an orbit's one site feel: on a ring all modes that are even about it, on other lattices those
    /// without a node there, of weights φ². Of several modes with one frequency one combination is felt, with the sum of their weights.
    pub(crate) fn set_felt(&mut self, prepared: Prepared<'_>) {
        let (orbit, response) = (prepared.orbit(), prepared.response());
        let Some(site) = orbit.impact_site().filter(|_| !orbit.model().chain().is_ring()) else {
            return self.set(response);
        };
        let (frequencies, weights) = (response.frequencies(), response.weights());
        let (cos, sin, half) = (response.cos_half(), response.sin_half(), 0.5 * response.period());
        let Self { squares, order, .. } = self;
        squares.clear();
        squares.extend(response.shapes().evens(site, site).take(frequencies.len()));
        sort_felt(frequencies, squares, order);
        self.clear();
        for alike in by_frequency(frequencies, &self.order) {
            let [first, ..] = *alike else { continue };
            let k = first as usize;
            let weight: f64 = alike.iter().map(|&k| weights[k as usize] * self.squares[k as usize]).sum();
            self.list.push(Mode::new(frequencies[k], weight, (cos[k], sin[k]), half));
            self.numbers.push(first);
        }
        self.group_few();
    }

    /// Gives back the room of all modes; their numbers stay.
    pub(crate) fn give_back(&mut self) {
        self.list = Vec::new();
    }

    fn clear(&mut self) {
        self.list.clear();
        self.unlisted = 0;
        self.rate_error = 0.0;
        self.numbers.clear();
    }

    /// Takes over some modes of another set.
    pub(crate) fn gather(&mut self, all: &Self, chosen: &[usize]) {
        self.clear();
        self.list.extend(chosen.iter().map(|&k| all.list[k]));
        self.group();
    }

    /// The number of a mode in the lattice's own order.
    pub(crate) fn number(&self, k: usize) -> usize {
        self.numbers.get(k).map_or(k, |&number| number as usize)
    }

    /// A mode with this part of its weight has a node where the impacts are.
    pub(crate) fn is_spared(part: f64) -> bool {
        part < SPARED
    }

    /// Of more than [`LARGE`] modes only parts are taken four at a time, see [`Modes::gather`]: groups of all of them would be as many
    /// bytes again.
    fn group_few(&mut self) {
        self.groups.clear();
        if self.list.len() <= LARGE {
            self.group();
        }
    }

    fn group(&mut self) {
        self.groups.clear();
        let (fours, rest) = self.list.as_chunks();
        self.groups.extend(fours.iter().map(Mode::group));
        if !rest.is_empty() {
            let mut four = [PAD; 4];
            four[..rest.len()].copy_from_slice(rest);
            self.groups.push(Mode::group(&four));
        }
    }

    /// Number of modes.
    pub(crate) fn count(&self) -> usize {
        self.list.len().max(self.unlisted)
    }

    /// All of them.
    pub(crate) fn list(&self) -> &[Mode] {
        debug_assert_eq!(self.unlisted, 0, "modes that are in groups alone");
        &self.list
    }

    /// The largest error of a frequency beyond rounding, in units of ε.
    pub(crate) fn rate_error(&self) -> f64 {
        self.rate_error
    }

    /// One of them.
    #[inline(always)]
    pub(crate) fn mode(&self, k: usize) -> Mode {
        self.list[k]
    }

    /// All of them, four at a time; of a whole lattice none if there are more than [`LARGE`].
    #[inline(always)]
    pub(crate) fn groups(&self) -> &[Mode<Lane>] {
        debug_assert_eq!(self.groups.len(), self.count().div_ceil(4), "modes that were left out of the groups");
        &self.groups
    }
}

impl Mode {
    /// A mode from its cos, sin(ΩT/2), `half` being T/2.
    fn new(frequency: f64, weight: f64, (cos, sin): (f64, f64), half: f64) -> Self {
        Mode::four_of(all(frequency), all(weight), (all(cos), all(sin)), half).lanes().at(0)
    }
}

/// Numbers of the modes that have no node where all impacts are, by rising frequency; `squares` are φ² there, weights left out.
pub(crate) fn sort_felt(frequencies: &[f64], squares: &[f64], order: &mut Vec<u32>) {
    order.clear();
    order.extend((0..frequencies.len()).filter(|&k| !Modes::is_spared(squares[k])).map(|k| k as u32));
    order.sort_unstable_by(|&a, &b| frequencies[a as usize].total_cmp(&frequencies[b as usize]).then(a.cmp(&b)));
}

/// Those of equal frequency together.
pub(crate) fn by_frequency<'a>(frequencies: &'a [f64], order: &'a [u32]) -> impl Iterator<Item = &'a [u32]> + 'a {
    order.chunk_by(|&low, &high| {
        let (low, high) = (frequencies[low as usize], frequencies[high as usize]);
        high - low <= EQUAL * high
    })
}

impl Mode<f64x4> {
    /// Four modes from their cos, sin(ΩT/2), `half` being T/2.
    #[inline(always)]
    fn four_of(frequency: f64x4, weight: f64x4, (cos, sin): (f64x4, f64x4), half: f64) -> Self {
        // ΩT
        let y = TWO * frequency * all(half);
        // sin(ΩT/2)/Ω, which a soft mode needs from its series.
        let mut sin_over = sin / frequency;
        if !(frequency * all(half)).simd_gt(all(SOFT)).all() {
            let mut lanes = sin_over.to_array();
            for (sin_over, frequency) in lanes.iter_mut().zip(frequency.to_array()) {
                if frequency * half <= SOFT {
                    *sin_over = sine_over(frequency, half);
                }
            }
            sin_over = four(lanes);
        }
        // A phase y carries a relative error of about 2ε, so that δx/x = y cot y and δd = 2y sin 2y.
        let relative = FOUR + y.simd_gt(all(SOFT)).select((y * cos / sin).abs(), ONE);
        let shift = TWO * (y * cos * sin).abs() + FOUR * (cos * cos).fast_min(sin * sin);
        let (inverse, sin_times) = (ONE / sin_over, frequency * sin);
        Self { weight, frequency, cos, sin, sin_over, inverse, sin_times, relative, shift, doubt: ZERO }
    }

    /// Adds what errors of the frequencies make of x and d, these in units of ε and relative.
    fn know(&mut self, errors: f64x4, half: f64) {
        let y = TWO * self.frequency * all(half);
        let turned = (y * self.cos / self.sin).abs();
        // Of sin(y/2)/Ω, where y is small or 0 about 0.
        self.relative += errors * (ONE + HALF * y.simd_gt(all(SOFT)).select(turned, TWO));
        self.shift += TWO * errors * (y * self.cos * self.sin).abs();
    }

    fn lanes(&self) -> Mode<Lane> {
        Mode {
            weight: self.weight.to_array(),
            frequency: self.frequency.to_array(),
            cos: self.cos.to_array(),
            sin: self.sin.to_array(),
            sin_over: self.sin_over.to_array(),
            inverse: self.inverse.to_array(),
            sin_times: self.sin_times.to_array(),
            relative: self.relative.to_array(),
            shift: self.shift.to_array(),
            doubt: self.doubt.to_array(),
        }
    }
}

impl Mode<Lane> {
    fn group(modes: &[Mode; 4]) -> Self {
        let mut group = PADS;
        modes.iter().enumerate().for_each(|(i, mode)| group.put(i, mode));
        group
    }

    /// One of the four.
    fn at(&self, i: usize) -> Mode {
        let mut mode = PAD;
        self.write(i, &mut mode);
        mode
    }

    /// The same into `mode`, number by number: a whole mode would be copied by a call.
    #[inline(always)]
    fn write(&self, i: usize, mode: &mut Mode) {
        mode.weight = self.weight[i];
        mode.frequency = self.frequency[i];
        mode.cos = self.cos[i];
        mode.sin = self.sin[i];
        mode.sin_over = self.sin_over[i];
        mode.inverse = self.inverse[i];
        mode.sin_times = self.sin_times[i];
        mode.relative = self.relative[i];
        mode.shift = self.shift[i];
        mode.doubt = self.doubt[i];
    }

    /// Replaces one of the four.
    #[inline(always)]
    fn put(&mut self, i: usize, mode: &Mode) {
        self.weight[i] = mode.weight;
        self.frequency[i] = mode.frequency;
        self.cos[i] = mode.cos;
        self.sin[i] = mode.sin;
        self.sin_over[i] = mode.sin_over;
        self.inverse[i] = mode.inverse;
        self.sin_times[i] = mode.sin_times;
        self.relative[i] = mode.relative;
        self.shift[i] = mode.shift;
        self.doubt[i] = mode.doubt;
    }

    /// As operands.
    #[inline(always)]
    pub(crate) fn four(&self) -> Mode<f64x4> {
        Mode {
            weight: four(self.weight),
            frequency: four(self.frequency),
            cos: four(self.cos),
            sin: four(self.sin),
            sin_over: four(self.sin_over),
            inverse: four(self.inverse),
            sin_times: four(self.sin_times),
            relative: four(self.relative),
            shift: four(self.shift),
            doubt: four(self.doubt),
        }
    }
}
