//! Two impacts of one mass in a period: those of which E of `two_impacts` knows all orbits.

use vibrochain_lattice::{Barrier, Model};

use crate::orbit::Family;

/// Two impacts of one mass in a period of the orbit: the barriers they meet, in turn, and how many periods of the force they take.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Pattern {
    barriers: [Barrier; 2],
    periods: u32,
}

impl Pattern {
    pub(crate) const DOUBLE_SIDED: Self = Self { barriers: [Barrier::Upper, Barrier::Lower], periods: 1 };
    pub(crate) const DOUBLED: Self = Self { barriers: [Barrier::Lower, Barrier::Lower], periods: 2 };

    /// That of impacts on these barriers, if their orbits are the zeros of E: in one period of the force, or two alike in two.
    pub(crate) fn of(barriers: &[Barrier], periods: u32) -> Option<Self> {
        match (barriers, periods) {
            ([first, second], 1 | 2) if first == second => Some(Self { barriers: [*first; 2], periods }),
            ([_, _], 1) => Some(Self::DOUBLE_SIDED),
            _ => None,
        }
    }

    /// The family that is called so.
    pub(crate) fn family(self) -> Family {
        match self {
            Self::DOUBLE_SIDED => Family::DoubleSided,
            Self::DOUBLED => Family::PeriodDoubled,
            _ => Family::Word,
        }
    }

    pub(crate) fn barriers(&self) -> &[Barrier; 2] {
        &self.barriers
    }

    pub(crate) fn periods(self) -> u32 {
        self.periods
    }

    /// Both impacts are on one barrier.
    pub(crate) fn is_alike(self) -> bool {
        self.barriers[0] == self.barriers[1]
    }

    /// Between the middles of the two flights the force turns round: an odd number of its half periods.
    pub(crate) fn turns_round(self) -> bool {
        self.periods % 2 == 1
    }

    /// β of two impacts on one barrier.
    pub(crate) fn stop(self, model: &Model) -> f64 {
        model.barrier(self.barriers[0])
    }

    /// sin h and cos h, h = nπ/2 + x, from cos x and sin x: each as a wave, its value and −slope/rate.
    pub(crate) fn waves<T: Copy + std::ops::Neg<Output = T>>(self, cos: T, sin: T) -> [(T, T); 2] {
        if self.turns_round() { [(cos, sin), (-sin, cos)] } else { [(-sin, cos), (-cos, -sin)] }
    }
}
