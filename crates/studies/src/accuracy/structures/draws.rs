//! Random structures of one to three coordinates: ordinary ones, and kinds in which formulas lose digits.

use std::f64::consts::TAU;
use std::fmt::Write as _;

use fastrand::Rng;
use nalgebra::{Cholesky, DMatrix, DVector};
use vibrochain_lattice::{Complex, Contact, Structure};

use crate::accuracy::extremes::draws::power;

type C = Complex<f64>;

/// What is extreme about a structure.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Kind {
    /// Nothing: frequencies, loads and gaps of one size, damping of any form.
    Ordinary,
    /// Springs between 1 and 10⁶ in one row.
    Stiff,
    /// A coordinate with a mass between 1e-8 and 1e-4.
    NearlyMassless,
    /// Without dashpots, the period next to a whole number of a mode's: 1e-10 to 1e-4 from it.
    Resonant,
    /// The load moves the contact to its stop, but for 1e-12 to 1e-6.
    Grazing,
    /// A mode of critical damping, but for 1e-15 to 0.1.
    Critical,
    /// Plastic impacts, or elastic ones.
    EndsOfRestitution,
    /// Neither loads nor losses.
    Conservative,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 8] = [
        Self::Ordinary,
        Self::Stiff,
        Self::NearlyMassless,
        Self::Resonant,
        Self::Grazing,
        Self::Critical,
        Self::EndsOfRestitution,
        Self::Conservative,
    ];

    /// What it is called in tables.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Ordinary => "ordinary",
            Self::Stiff => "stiffness over 1e6",
            Self::NearlyMassless => "masses down to 1e-8",
            Self::Resonant => "next to a resonance",
            Self::Grazing => "next to grazing",
            Self::Critical => "ζ next to 1",
            Self::EndsOfRestitution => "e = 0 or 1",
            Self::Conservative => "no loads, no losses",
        }
    }
}

/// A structure with the orbits that are asked for.
#[derive(Debug, Clone)]
pub struct StructureDraw {
    /// Matrices, contacts and loads.
    pub structure: Structure,
    /// Frequency of the loads.
    pub omega: f64,
    /// The word of the orbits.
    pub word: &'static str,
    /// Periods of the loads in one of the orbits.
    pub force_periods: u32,
}

/// Symmetric, with eigenvalues from `least` to `least` + 4.
fn positive(random: &mut Rng, n: usize, least: f64) -> DMatrix<f64> {
    let factor = DMatrix::from_fn(n, n, |_, _| 2.0 * random.f64() - 1.0);
    &factor * factor.transpose() + DMatrix::identity(n, n) * least
}

/// Square roots of the eigenvalues of M⁻¹K, from the least on, and the modes that belong to them.
fn modes(mass: &DMatrix<f64>, stiffness: &DMatrix<f64>) -> (Vec<f64>, DMatrix<f64>) {
    let n = mass.nrows();
    let lower = Cholesky::new(mass.clone()).map_or(DMatrix::identity(n, n), |factors| factors.l());
    let inverse = lower.clone().try_inverse().unwrap_or(DMatrix::identity(n, n));
    let eigen = (&inverse * stiffness * inverse.transpose()).symmetric_eigen();
    let mut order: Vec<usize> = (0..n).collect();
    order.sort_by(|&i, &j| eigen.eigenvalues[i].total_cmp(&eigen.eigenvalues[j]));
    let shapes = inverse.transpose() * &eigen.eigenvectors;
    let frequencies = order.iter().map(|&k| eigen.eigenvalues[k].max(0.0).sqrt()).collect();
    (frequencies, DMatrix::from_fn(n, n, |i, k| shapes[(i, order[k])]))
}

fn either(random: &mut Rng) -> f64 {
    if random.bool() { 1.0 } else { -1.0 }
}

/// A structure of that kind.
#[must_use]
pub fn draw(random: &mut Rng, kind: Kind) -> StructureDraw {
    let n = match kind {
        Kind::Stiff | Kind::NearlyMassless => random.usize(2..=3),
        _ => random.usize(1..=3),
    };
    let mut mass =
        if random.bool() { DMatrix::from_diagonal_element(n, n, 1.0) } else { positive(random, n, 0.5) * 0.5 };
    let mut stiffness = positive(random, n, 0.3);
    match kind {
        Kind::Stiff => {
            let scales: Vec<f64> = (0..n).map(|i| if i == 0 { 1.0 } else { power(random, 0.0, 3.0) }).collect();
            stiffness = DMatrix::from_fn(n, n, |i, j| scales[i] * stiffness[(i, j)] * scales[j]);
        }
        Kind::NearlyMassless => {
            mass = DMatrix::from_fn(n, n, |i, j| if i == j { 0.5 + random.f64() } else { 0.0 });
            mass[(n - 1, n - 1)] = power(random, -8.0, -4.0);
        }
        _ => {}
    }
    let (frequencies, shapes) = modes(&mass, &stiffness);
    let damping = match kind {
        Kind::Resonant | Kind::Conservative => DMatrix::default(),
        Kind::Critical => {
            let critical = random.usize(..n);
            let room = if random.u8(..4) == 0 { 0.0 } else { either(random) * power(random, -15.0, -1.0) };
            let ratio = |k: usize| if k == critical { 1.0 + room } else { 0.05 };
            let modal = DMatrix::from_fn(n, n, |i, k| if i == k { 2.0 * ratio(k) * frequencies[k] } else { 0.0 });
            let weighted = &mass * &shapes;
            let damping = &weighted * modal * weighted.transpose();
            (&damping + damping.transpose()) * 0.5
        }
        _ => match random.u8(..4) {
            0 => DMatrix::default(),
            1 => &mass * power(random, -3.0, -1.0) + &stiffness * power(random, -3.0, -1.0),
            _ => positive(random, n, 0.01) * power(random, -3.0, 0.0),
        },
    };
    let omega = match kind {
        Kind::Resonant => {
            let off = 1.0 + either(random) * power(random, -10.0, -4.0);
            frequencies[random.usize(..n)] / f64::from(random.u8(1..=3)) * off
        }
        _ => frequencies[0] * (0.4 + 2.1 * random.f64()),
    };
    let loads = if kind == Kind::Conservative {
        Vec::new()
    } else {
        let part = |random: &mut Rng| {
            let phase = if random.bool() { 0.0 } else { TAU * random.f64() };
            C::from_polar(0.3 + random.f64(), phase)
        };
        vec![(1, DVector::from_fn(n, |_, _| part(random)))]
    };
    let static_load = if kind != Kind::Conservative && random.u8(..3) == 0 {
        DVector::from_fn(n, |_, _| 0.4 * random.f64() - 0.2)
    } else {
        DVector::default()
    };
    let structure = Structure { mass, damping, stiffness, contacts: Vec::new(), static_load, loads, modes: None };
    with_contacts(random, kind, structure, omega)
}

/// Contacts that the load may well reach, and a word of theirs.
fn with_contacts(random: &mut Rng, kind: Kind, mut structure: Structure, omega: f64) -> StructureDraw {
    let n = structure.mass.nrows();
    let count = if n > 1 && kind != Kind::Grazing { random.usize(1..=2) } else { 1 };
    let word = match (kind, count, random.u8(..8)) {
        (Kind::Grazing, ..) => "0+",
        (Kind::Conservative, _, 0..4) => "0+",
        (Kind::Conservative, ..) => "0+,0-",
        (_, 1, 0..3) => "0+",
        (_, 1, 3) => "0+,0+",
        (_, 1, 4) => "0-,0+,0-",
        (_, 1, _) => "0+,0-",
        (_, _, 0..4) => "0+,1+",
        (_, _, 4) => "0+,1+,1+",
        (_, _, _) => "1-,0+",
    };
    let force_periods = if word == "0+" && kind != Kind::Conservative { u32::from(random.u8(1..=2)) } else { 1 };
    for number in 0..count {
        let mut weights = DVector::zeros(n);
        weights[number] = 1.0;
        if n == 3 && random.u8(..4) == 0 {
            weights[2] = -1.0;
        }
        let (still, swing) = reach(&structure, &weights, omega);
        let gap = |random: &mut Rng| match kind {
            Kind::Conservative => 0.1 + random.f64(),
            Kind::Grazing => swing * (1.0 + either(random) * power(random, -12.0, -6.0)),
            _ => swing * (0.1 + 1.2 * random.f64()),
        };
        let has = |letter: &str| word.contains(&format!("{number}{letter}"));
        let mut stop = |letter: &str, sign: f64| {
            let there = has(letter) || (kind != Kind::Grazing && random.bool());
            there.then(|| still + sign * gap(random))
        };
        let (upper, lower) = (stop("+", 1.0), stop("-", -1.0));
        let upper = if upper.is_none() && lower.is_none() { Some(still + swing) } else { upper };
        let restitution = match kind {
            Kind::Conservative => 1.0,
            Kind::EndsOfRestitution => f64::from(u8::from(random.bool())),
            _ => 0.3 + 0.65 * random.f64(),
        };
        structure.contacts.push((weights, Contact { lower, upper, restitution }));
    }
    StructureDraw { structure, omega, word, force_periods }
}

/// Where the static load holds a contact, and how far the other one moves it.
fn reach(structure: &Structure, weights: &DVector<f64>, omega: f64) -> (f64, f64) {
    let n = structure.mass.nrows();
    let damping = |i: usize, j: usize| if structure.damping.is_empty() { 0.0 } else { structure.damping[(i, j)] };
    let dynamic = DMatrix::from_fn(n, n, |i, j| {
        let stiffness = structure.stiffness[(i, j)] - omega * omega * structure.mass[(i, j)];
        C::new(stiffness, omega * damping(i, j))
    });
    let seen = |place: DVector<C>| weights.iter().zip(&place).map(|(w, x)| x * *w).sum::<C>();
    let swing = structure.loads.first().and_then(|(_, load)| dynamic.lu().solve(load)).map_or(1.0, |x| seen(x).norm());
    let still = match structure.static_load.is_empty() {
        true => None,
        false => structure.stiffness.clone().lu().solve(&structure.static_load),
    };
    (still.map_or(0.0, |x| weights.dot(&x)), swing)
}

impl StructureDraw {
    /// As a scene in JSON that `mapgen` reads.
    #[must_use]
    pub fn scene(&self) -> String {
        let Self { structure, omega, word, force_periods } = self;
        let rows = |matrix: &DMatrix<f64>| {
            let rows = matrix.row_iter().map(|row| row.iter().copied().collect::<Vec<f64>>());
            format!("{:?}", rows.collect::<Vec<_>>())
        };
        let list = |values: &DVector<f64>| format!("{:?}", values.as_slice());
        let mut text = format!("{{\"omega\":{omega:?},\"word\":\"{word}\",\"force_periods\":{force_periods}");
        // Writing to a String cannot fail.
        let _ = write!(text, ",\"structure\":{{\"mass\":{}", rows(&structure.mass));
        let _ = write!(text, ",\"stiffness\":{}", rows(&structure.stiffness));
        if !structure.damping.is_empty() {
            let _ = write!(text, ",\"damping\":{}", rows(&structure.damping));
        }
        let contact = |(weights, contact): &(DVector<f64>, Contact)| {
            let stop = |name: &str, stop: Option<f64>| stop.map_or(String::new(), |at| format!(",\"{name}\":{at:?}"));
            let stops = stop("lower", contact.lower) + &stop("upper", contact.upper);
            format!("{{\"weights\":{}{stops},\"restitution\":{:?}}}", list(weights), contact.restitution)
        };
        let contacts: Vec<String> = structure.contacts.iter().map(contact).collect();
        let _ = write!(text, "}},\"contact\":[{}]", contacts.join(","));
        let mut force = Vec::new();
        if let Some((_, load)) = structure.loads.first() {
            force.push(format!("\"load\":{}", list(&load.map(|f| f.norm()))));
            force.push(format!("\"phases\":{}", list(&load.map(|f| f.arg()))));
        }
        if !structure.static_load.is_empty() {
            force.push(format!("\"static\":{}", list(&structure.static_load)));
        }
        if !force.is_empty() {
            let _ = write!(text, ",\"force\":{{{}}}", force.join(","));
        }
        text + "}"
    }
}
