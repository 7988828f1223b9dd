//! What vanishes at an event of an orbit.
//!
//! det J(z₀) vanishes where z₀ is a multiplier, on grazing orbits like elsewhere: with the sign of the impulses it goes smoothly on where one
//! of them vanishes, so that nothing here knows of the square root that maps of such orbits have.

use nalgebra::Complex;
use smallvec::{SmallVec, smallvec};
use vibrochain_breather::system::Evaluation;
use vibrochain_breather::{Approach, BlochEquations, BranchError, ContactOrbit, Hit};
use vibrochain_lattice::Barrier;

use super::regular::Regular;
use super::watcher::TOUCHES;
use crate::locate::Event;
use vibrochain_breather::time_between;

type C = Complex<f64>;

/// Next to the real axis the imaginary part is its derivative.
pub(super) const REAL: f64 = 1e-6;

/// Values of a test function.
pub(crate) type Values = SmallVec<[f64; 2]>;

/// Of an event what vanishes there, in unknowns of the orbit and perhaps one more, its mark.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Test {
    /// det J(1) of the orbit's own equations, among orbits of the symmetry that is kept to: where the branch turns back.
    Fold,
    /// det J(1) of all of them: a multiplier +1, where the branch turns back or another leaves it.
    One,
    /// det J(1) without the orbit's own derivative, of one that may begin at any time: another multiplier +1, as where its energy is extreme.
    AnotherOne,
    /// det J(−1)
    MinusOne,
    /// det J(e^{iθ}), which is complex; the mark is θ. Its imaginary part, an odd function, is divided by sin θ.
    Circle,
    /// The same and its derivative by θ, of an orbit without losses, where it is real; the mark is θ.
    Collision,
    /// The velocity before an impact.
    Velocity(usize),
    /// The acceleration after a plastic impact.
    Release(usize),
    /// The distance of a contact to a barrier where it turns round; the mark is when, in periods.
    Touch(usize, Barrier),
    /// The distance of a contact to a barrier where an impact of another contact turns it round, as coupled masses or bars do; that impact.
    Corner(usize, Barrier, usize),
}

/// Instants this near to each other, as a part of the period, are one.
const TOGETHER: f64 = 1e-9;

impl Test {
    /// What vanishes where a contact touches at the instant of another one's impact, if it does not stand still there.
    pub(crate) fn corner(touch: &Approach, orbit: &ContactOrbit) -> Option<Self> {
        let period = orbit.period();
        let is_there =
            |hit: &Hit| hit.site != touch.site && time_between(hit.time, touch.time, period) <= TOGETHER * period;
        let impact = orbit.hits().iter().position(is_there)?;
        let [_, velocity] = orbit.state(touch.site, touch.time).ok()?;
        (velocity.abs() > TOUCHES * orbit.speed()).then_some(Self::Corner(touch.site, touch.barrier, impact))
    }

    /// Of an event as it is known by a mark.
    pub(crate) fn event(self, turns: bool) -> Event {
        match self {
            Self::Fold => Event::Fold,
            Self::One if turns => Event::Fold,
            Self::One | Self::AnotherOne => Event::Pitchfork,
            Self::MinusOne => Event::PeriodDoubling,
            Self::Circle | Self::Collision => Event::NeimarkSacker,
            Self::Release(_) => Event::Sticking,
            Self::Velocity(_) | Self::Touch(..) | Self::Corner(..) => Event::Grazing,
        }
    }

    /// Whether it has a mark.
    pub(crate) fn is_marked(self) -> bool {
        matches!(self, Self::Circle | Self::Collision | Self::Touch(..))
    }

    /// θ of the multiplier e^{iθ} that it looks at.
    pub(super) fn angle(self, mark: Option<f64>) -> f64 {
        match self {
            Self::MinusOne => std::f64::consts::PI,
            Self::Circle | Self::Collision => mark.unwrap_or(0.0),
            _ => 0.0,
        }
    }

    /// Its values at an orbit, each over a size of its own.
    pub(crate) fn values<K>(
        self,
        here: &Evaluation<ContactOrbit, K>,
        mark: Option<f64>,
    ) -> Result<Values, BranchError> {
        let (orbit, mark) = (&here.orbit, mark.unwrap_or(0.0));
        Ok(match self {
            Self::Fold => smallvec![here.matrix.determinant()],
            Self::One => smallvec![here.all().determinant()],
            Self::AnotherOne => smallvec![another_one(orbit).ok_or(BranchError::NoConvergence)?],
            Self::MinusOne => smallvec![minus_one(orbit)?],
            Self::Circle => {
                let [value, slope] = at(&orbit.bloch_equations().0, mark);
                // Where the pair turns real both are 0.
                let odd = if mark.sin().abs() > REAL { value.im / mark.sin() } else { slope.im / mark.cos() };
                smallvec![value.re, odd]
            }
            Self::Collision => {
                let [value, slope] = at(&orbit.bloch_equations().0, mark);
                smallvec![value.re, slope.re / mark.sin()]
            }
            Self::Velocity(i) => {
                let impact = orbit.impacts().get(i).ok_or(BranchError::NoConvergence)?;
                smallvec![impact.velocity_before / orbit.speed()]
            }
            Self::Release(i) => {
                let [acceleration, _] = orbit.acceleration_after(i)?.ok_or(BranchError::NoConvergence)?;
                smallvec![acceleration / (orbit.model().omega() * orbit.speed())]
            }
            Self::Touch(contact, barrier) => {
                let wall = orbit.model().barrier_at(contact, barrier)?;
                let [place, velocity] = orbit.state(contact, mark.rem_euclid(1.0) * orbit.period())?;
                let speed = orbit.speed();
                smallvec![(wall - place) * orbit.model().omega() / speed, velocity / speed]
            }
            Self::Corner(contact, barrier, impact) => {
                let time = orbit.hits().get(impact).ok_or(BranchError::NoConvergence)?.time;
                let [place, _] = orbit.state(contact, time)?;
                smallvec![(orbit.model().barrier_at(contact, barrier)? - place) * orbit.model().omega() / orbit.speed()]
            }
        })
    }
}

/// det J(−1), which is real, made regular.
pub(crate) fn minus_one(orbit: &ContactOrbit) -> Result<f64, BranchError> {
    Ok(at(&orbit.bloch_equations().0, std::f64::consts::PI)[0].re)
}

/// det J(1) without the orbit's own derivative; `None` of orbits that have a phase, and where a mode's pole is 1.
pub(crate) fn another_one(orbit: &ContactOrbit) -> Option<f64> {
    if !orbit.is_conservative() {
        return None;
    }
    let (mut equations, _) = orbit.bloch_equations();
    equations.leave_out_shift()?;
    Some(at(&equations, 0.0)[0].re)
}

/// det J(e^{iθ}) made regular, and its derivative by θ where it vanishes.
fn at(equations: &BlochEquations, theta: f64) -> [C; 2] {
    Regular::of(equations, theta).values()
}
