//! Random models, all from one generator: a test asks for the ranges that its subject lives in.

use vibrochain_lattice::{Chain, Ends, Model, Spectrum};

use crate::random::Random;

/// Where a random number is taken from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Values {
    /// Always this one.
    Is(f64),
    /// Evenly between two.
    Even(f64, f64),
    /// Evenly in the logarithm.
    Log(f64, f64),
    /// In so many of all cases from the first, otherwise from the second.
    Either(f64, &'static Values, &'static Values),
}

use Values::{Either, Even, Is, Log};

/// Where a random model is taken from.
#[derive(Debug, Clone, Copy, PartialEq)]
#[allow(missing_docs, reason = "they are the parameters of a model")]
pub struct Ranges {
    /// The fewest and the most masses.
    pub sites: [usize; 2],
    pub gamma1: Values,
    pub gamma2: Values,
    pub omega: Values,
    pub asymmetry: Values,
    pub amplitude: Values,
    pub restitution: Values,
}

impl Ranges {
    /// Short rings under a force, most of them with losses.
    pub const FORCED: Self = Self {
        sites: [1, 16],
        gamma1: Log(0.02, 1.0),
        gamma2: Log(1e-3, 0.5),
        omega: Even(0.4, 3.0),
        asymmetry: Even(0.0, 0.9),
        amplitude: Log(0.05, 2.0),
        restitution: Either(0.2, &Is(1.0), &Even(0.2, 0.99)),
    };

    /// The same without force and losses.
    pub const CONSERVATIVE: Self = Self { amplitude: Is(0.0), restitution: Is(1.0), ..Self::FORCED };
}

/// What a harmonic of ω is to lie next to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Meeting {
    /// The frequency of a mode.
    Mode,
    /// The sum of two of them.
    Sum,
    /// Their difference, which may be 0.
    Difference,
}

impl Random {
    /// A number.
    pub fn value(&mut self, values: Values) -> f64 {
        match values {
            Is(value) => value,
            Even(low, high) => self.between(low, high),
            Log(low, high) => self.log(low, high),
            Either(part, first, second) => {
                let which = if self.chance(part) { first } else { second };
                self.value(*which)
            }
        }
    }

    /// One of a list.
    pub fn of<T: Copy>(&mut self, list: &[T]) -> T {
        list[self.below(list.len())]
    }

    /// A number next to another one, this part of it off on either side.
    pub fn beside(&mut self, value: f64, off: Values) -> f64 {
        let sign = if self.chance(0.5) { 1.0 } else { -1.0 };
        value * (1.0 + sign * self.value(off))
    }

    /// A ring.
    pub fn chain(&mut self, ranges: &Ranges) -> Chain {
        let [fewest, most] = ranges.sites;
        let sites = fewest + self.below(most + 1 - fewest);
        Chain::new(sites, self.value(ranges.gamma1), self.value(ranges.gamma2)).unwrap()
    }

    /// A ring, or the same masses with other ends, or up to four layers of them.
    pub fn lattice(&mut self, ranges: &Ranges) -> Chain {
        let layers = if self.chance(0.5) { 1 } else { 2 + self.below(3) };
        let gamma3 = if layers > 1 { self.value(ranges.gamma2) } else { 0.0 };
        let ends = [Ends::Closed, Ends::Free, Ends::Fixed];
        let chain = self.chain(ranges).with_ends(self.of(&ends));
        let layer_ends = self.of(&[Ends::Closed, Ends::Free]);
        chain.with_layers(layers, gamma3, layer_ends).unwrap()
    }

    /// A model.
    pub fn model(&mut self, ranges: &Ranges) -> Model {
        let chain = self.chain(ranges);
        let [omega, asymmetry, amplitude, restitution] =
            [ranges.omega, ranges.asymmetry, ranges.amplitude, ranges.restitution].map(|values| self.value(values));
        chain.point().omega(omega).asymmetry(asymmetry).amplitude(amplitude).restitution(restitution).model().unwrap()
    }

    /// A frequency of which one of the first harmonics lies next to what modes of the ring make, this part of it off.
    pub fn meeting(&mut self, chain: &Chain, meeting: Meeting, harmonics: usize, off: Values) -> f64 {
        let spectrum = Spectrum::new(*chain);
        let [first, second] = [(); 2].map(|()| self.of(spectrum.frequencies()));
        let target = match meeting {
            Meeting::Mode => first,
            Meeting::Sum => first + second,
            Meeting::Difference => (first - second).abs(),
        };
        let harmonic = 1 + self.below(harmonics);
        self.beside(target / harmonic as f64, off)
    }
}

/// The scene of the paper's map over so many points.
#[must_use]
pub fn paper_map(sites: usize, forced: bool, [columns, rows]: [usize; 2], stability: bool) -> String {
    let forcing = if forced { "forcing = { amplitude = 0.1, restitution = 0.9 }" } else { "" };
    format!(
        r#"
        [model]
        sites = {sites}
        gamma1 = 0.2
        asymmetry = 0.4
        {forcing}
        [sweep]
        x = {{ parameter = "omega",  from = 0.4, to = 3.0, points = {columns} }}
        y = {{ parameter = "gamma2", from = 0.0, to = 0.3, points = {rows} }}
        [compute]
        families = ["double-sided", "single-sided"]
        stability = {stability}
        "#
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn models_fill_their_ranges_and_do_not_leave_them() {
        let mut random = Random(1);
        let ranges = Ranges { sites: [2, 4], asymmetry: Either(0.25, &Is(0.0), &Even(0.1, 0.9)), ..Ranges::FORCED };
        let (mut sizes, mut plain, mut elastic, mut soft) = ([0; 5], 0, 0, 0);
        for _ in 0..4000 {
            let model = random.model(&ranges);
            let (chain, a) = (model.chain(), model.asymmetry());
            sizes[chain.sites()] += 1;
            assert!((0.02..=1.0).contains(&chain.gamma1()) && (1e-3..=0.5).contains(&chain.gamma2()), "{model:?}");
            assert!(a == 0.0 || (0.1..=0.9).contains(&a), "{model:?}");
            plain += usize::from(a == 0.0);
            elastic += usize::from(model.restitution() == 1.0);
            // Half of a logarithmic range.
            soft += usize::from(chain.gamma1() < 0.02f64.sqrt());
        }
        assert!(sizes[..2] == [0, 0] && sizes[2..].iter().all(|&size| (1200..1467).contains(&size)), "{sizes:?}");
        assert!((900..1100).contains(&plain) && (700..900).contains(&elastic) && (1880..2120).contains(&soft));
    }

    #[test]
    fn meetings_are_as_near_as_they_were_asked_to_be() {
        let mut random = Random(2);
        let mut sides = [0; 2];
        for _ in 0..500 {
            let chain = random.chain(&Ranges { sites: [2, 9], ..Ranges::FORCED });
            let frequencies = Spectrum::new(chain).frequencies().to_vec();
            let omega = random.meeting(&chain, Meeting::Sum, 4, Log(1e-10, 1e-6));
            let sums = frequencies.iter().flat_map(|a| frequencies.iter().map(move |b| a + b));
            let off = sums.flat_map(|sum| (1..5).map(move |j| f64::from(j) * omega / sum - 1.0));
            let nearest = off.min_by(|a, b| a.abs().total_cmp(&b.abs())).unwrap();
            assert!(nearest.abs() < 1.1e-6, "{nearest:e}");
            sides[usize::from(nearest > 0.0)] += 1;
        }
        assert!(sides.iter().all(|&side| side > 200), "{sides:?}");
    }
}
