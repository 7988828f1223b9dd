//! Linear structures with stops (tests/data/structures.json), dense: state matrices, exponentials, saltation by saltation.

use nalgebra::{Complex, DMatrix, DVector};
use serde_json::Value;
use vibrochain_lattice::Contact;

use crate::random::Random;

/// One impact of a structure.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StructureImpact {
    /// Number of the contact.
    pub contact: usize,
    /// Time within the period.
    pub time: f64,
    /// Its impulse.
    pub impulse: f64,
    /// Coefficient of restitution.
    pub restitution: f64,
    /// Where its stop is.
    pub stop: f64,
}

/// M q″ + C q′ + K q = s + f cos ω(t+ψ) with contacts g = w·q, and a periodic orbit of it.
#[derive(Debug, Clone)]
#[allow(missing_docs, reason = "they are the letters of the equation")]
pub struct Structure {
    pub name: String,
    pub mass: DMatrix<f64>,
    pub damping: DMatrix<f64>,
    pub stiffness: DMatrix<f64>,
    /// w of each contact.
    pub contacts: Vec<DVector<f64>>,
    /// Lower stop, upper stop and restitution of each contact of the table; of random ones each impact has its own.
    pub limits: Vec<(Option<f64>, Option<f64>, f64)>,
    pub load: DVector<f64>,
    pub static_load: DVector<f64>,
    pub omega: f64,
    pub psi: f64,
    /// Of the orbit.
    pub period: f64,
    pub impacts: Vec<StructureImpact>,
    /// Those of the table, of largest modulus.
    pub multipliers: Vec<Complex<f64>>,
    /// Whether every contact of the table stays between its stops.
    pub physical: bool,
}

/// What the state is just before an impact.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Before {
    /// g
    pub place: f64,
    /// g′⁻
    pub velocity: f64,
    /// g″⁻
    pub acceleration: f64,
}

fn vector(value: &Value) -> DVector<f64> {
    DVector::from_iterator(
        value.as_array().unwrap().len(),
        value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()),
    )
}

fn matrix(value: &Value) -> DMatrix<f64> {
    let rows: Vec<_> = value.as_array().unwrap().iter().map(|row| vector(row).transpose()).collect();
    DMatrix::from_rows(&rows)
}

fn structure(value: &Value) -> Structure {
    let number = |value: &Value| value.as_f64().unwrap();
    let contacts = value["contacts"].as_array().unwrap();
    let impact = |impact: &Value| {
        let contact = impact["contact"].as_u64().unwrap() as usize;
        let stop = number(&contacts[contact][impact["side"].as_str().unwrap()]);
        let restitution = number(&contacts[contact]["restitution"]);
        StructureImpact {
            contact,
            time: number(&impact["time"]),
            impulse: number(&impact["impulse"]),
            restitution,
            stop,
        }
    };
    let omega = number(&value["omega"]);
    Structure {
        name: value["name"].as_str().unwrap().to_owned(),
        mass: matrix(&value["mass"]),
        damping: matrix(&value["damping"]),
        stiffness: matrix(&value["stiffness"]),
        contacts: contacts.iter().map(|contact| vector(&contact["weights"])).collect(),
        limits: (contacts.iter())
            .map(|contact| (contact["lower"].as_f64(), contact["upper"].as_f64(), number(&contact["restitution"])))
            .collect(),
        load: vector(&value["load"]),
        static_load: vector(&value["static_load"]),
        omega,
        psi: value["psi"].as_f64().unwrap_or(0.0),
        period: std::f64::consts::TAU / omega * number(&value["force_periods"]),
        impacts: value["impacts"].as_array().unwrap().iter().map(impact).collect(),
        multipliers: (value["multipliers"].as_array().unwrap().iter())
            .map(|pair| Complex::new(number(&pair[0]), number(&pair[1])))
            .collect(),
        physical: value["physical"].as_bool().unwrap(),
    }
}

impl Structure {
    /// One whose orbit is still to be found, without stops, loads and phase.
    #[must_use]
    pub fn without_orbit(
        [mass, damping, stiffness]: [DMatrix<f64>; 3],
        contacts: Vec<DVector<f64>>,
        omega: f64,
    ) -> Self {
        let none = DVector::zeros(mass.nrows());
        Self {
            name: "random".to_owned(),
            mass,
            damping,
            stiffness,
            contacts,
            limits: Vec::new(),
            load: none.clone(),
            static_load: none,
            omega,
            psi: 0.0,
            period: std::f64::consts::TAU / omega,
            impacts: Vec::new(),
            multipliers: Vec::new(),
            physical: false,
        }
    }

    /// As the library takes it.
    #[must_use]
    pub fn linear(&self) -> vibrochain_lattice::Structure {
        let stops = self.limits.iter().map(|&(lower, upper, restitution)| Contact { lower, upper, restitution });
        let load = self.load.map(|f| Complex::new(f, 0.0));
        vibrochain_lattice::Structure {
            mass: self.mass.clone(),
            damping: self.damping.clone(),
            stiffness: self.stiffness.clone(),
            contacts: self.contacts.iter().cloned().zip(stops).collect(),
            static_load: self.static_load.clone(),
            loads: if self.load.amax() == 0.0 { vec![] } else { vec![(1, load)] },
            modes: None,
        }
    }
}

/// All structures of the table.
#[must_use]
pub fn structures() -> Vec<Structure> {
    let table: Value = serde_json::from_str(include_str!("../../../tests/data/structures.json")).unwrap();
    table["cases"].as_array().unwrap().iter().map(structure).collect()
}

impl Random {
    /// A structure of two to eight coordinates with one to four impacts on contacts of any kind, damping that is no combination of mass
    /// and stiffness; restitutions are those that make its impacts an orbit.
    pub fn structure(&mut self) -> Structure {
        let size = 2 + self.below(7);
        let full = |random: &mut Self| DMatrix::from_fn(size, size, |_, _| random.between(-1.0, 1.0));
        let square = |random: &mut Self| {
            let factor = full(random);
            &factor * factor.transpose() / size as f64
        };
        let mass = square(self) * 0.3 + DMatrix::identity(size, size);
        let stiffness = square(self) + DMatrix::identity(size, size) * self.between(0.05, 1.0);
        let damping = square(self) * self.log(1e-3, 10.0);
        let contacts: Vec<_> =
            (0..1 + self.below(3)).map(|_| DVector::from_fn(size, |_, _| self.between(-1.0, 1.0))).collect();
        let omega = self.between(0.4, 2.0);
        let period = std::f64::consts::TAU / omega;
        let count = 1 + self.below(4);
        let mut times: Vec<f64> = (0..count).map(|_| self.between(0.0, period)).collect();
        times[0] = 0.0;
        times.sort_by(f64::total_cmp);
        let impacts: Vec<StructureImpact> = (times.into_iter())
            .map(|time| {
                let contact = self.below(contacts.len());
                StructureImpact { contact, time, impulse: 0.0, restitution: self.between(0.1, 1.0), stop: 0.0 }
            })
            .collect();
        let mut structure = Structure {
            load: DVector::from_fn(size, |_, _| self.between(-2.0, 2.0)),
            static_load: DVector::from_fn(size, |_, _| self.between(-0.2, 0.2)),
            psi: self.between(0.0, period),
            impacts,
            ..Structure::without_orbit([mass, damping, stiffness], contacts, omega)
        };
        // Newton's law is linear in the impulses.
        let velocities =
            |structure: &Structure| structure.before().iter().map(|before| before.velocity).collect::<Vec<_>>();
        let still = DVector::from_vec(velocities(&structure));
        let mut law = DMatrix::zeros(count, count);
        for j in 0..count {
            structure.impacts[j].impulse = 1.0;
            let moved = DVector::from_vec(velocities(&structure)) - &still;
            law.set_column(j, &moved);
            structure.impacts[j].impulse = 0.0;
            law[(j, j)] += 1.0 / (structure.effective_mass(j) * (1.0 + structure.impacts[j].restitution));
        }
        let impulses = law.lu().solve(&-still).unwrap();
        structure.impacts.iter_mut().zip(&impulses).for_each(|(impact, impulse)| impact.impulse = *impulse);
        let places: Vec<f64> = structure.before().iter().map(|before| before.place).collect();
        structure.impacts.iter_mut().zip(places).for_each(|(impact, place)| impact.stop = place);
        structure
    }
}

impl Structure {
    /// Number of coordinates.
    #[must_use]
    pub fn size(&self) -> usize {
        self.mass.nrows()
    }

    /// M⁻¹
    fn inverse(&self) -> DMatrix<f64> {
        self.mass.clone().try_inverse().unwrap()
    }

    /// The state matrix of (q, q′).
    fn state(&self) -> DMatrix<f64> {
        let (n, inverse) = (self.size(), self.inverse());
        let mut state = DMatrix::zeros(2 * n, 2 * n);
        state.view_mut((0, n), (n, n)).fill_with_identity();
        state.view_mut((n, 0), (n, n)).copy_from(&-(&inverse * &self.stiffness));
        state.view_mut((n, n), (n, n)).copy_from(&-(&inverse * &self.damping));
        state
    }

    /// m = 1/(w·M⁻¹w) of an impact's contact.
    #[must_use]
    pub fn effective_mass(&self, impact: usize) -> f64 {
        let w = &self.contacts[self.impacts[impact].contact];
        1.0 / w.dot(&(self.inverse() * w))
    }

    /// The motion under the loads alone at time t: q, q′.
    fn steady(&self, t: f64) -> DVector<f64> {
        let n = self.size();
        let complex = |matrix: &DMatrix<f64>| matrix.map(|x| Complex::new(x, 0.0));
        let omega = Complex::new(0.0, self.omega);
        let dynamic = complex(&self.mass) * (omega * omega) + complex(&self.damping) * omega + complex(&self.stiffness);
        let swing = dynamic.lu().solve(&self.load.map(|x| Complex::new(x, 0.0))).unwrap();
        let turn = Complex::from_polar(1.0, self.omega * (t + self.psi));
        // With a rigid mode only loads that do not push it.
        let still = self.stiffness.clone().svd(true, true).solve(&self.static_load, 1e-12).unwrap();
        DVector::from_fn(
            2 * n,
            |i, _| if i < n { still[i] + (swing[i] * turn).re } else { (swing[i - n] * omega * turn).re },
        )
    }

    /// The orbit's state q, q′ just before each impact, by exponentials of the state matrix.
    #[must_use]
    pub fn states(&self) -> Vec<DVector<f64>> {
        let (n, state, inverse) = (self.size(), self.state(), self.inverse());
        let kick = |impact: &StructureImpact| {
            let velocity = &inverse * &self.contacts[impact.contact] * impact.impulse;
            DVector::from_fn(2 * n, |i, _| if i < n { 0.0 } else { velocity[i - n] })
        };
        // What impacts add to the steady motion, once around from 0.
        let (mut around, mut now) = (DVector::zeros(2 * n), 0.0);
        for impact in &self.impacts {
            around = (&state * (impact.time - now)).exp() * around + kick(impact);
            now = impact.time;
        }
        around = (&state * (self.period - now)).exp() * around;
        let closed = DMatrix::identity(2 * n, 2 * n) - (&state * self.period).exp();
        let mut motion = closed.svd(true, true).solve(&around, 1e-10).unwrap();
        let stiffness = self.stiffness.clone().svd(true, true);
        let (softest, least) = stiffness.singular_values.argmin();
        if least < 1e-12 {
            // A rigid mode may stand anywhere: to be put where the first impact meets its stop.
            let shape = stiffness.v_t.unwrap().row(softest).transpose();
            let (w, first) = (&self.contacts[self.impacts[0].contact], self.impacts[0]);
            let at = (self.steady(first.time) + &motion).rows(0, n).dot(w);
            let mut place = motion.rows_mut(0, n);
            place += &shape * ((first.stop - at) / w.dot(&shape));
        }
        let mut now = 0.0;
        (self.impacts.iter())
            .map(|impact| {
                motion = (&state * (impact.time - now)).exp() * &motion;
                now = impact.time;
                let before = self.steady(now) + &motion;
                motion += kick(impact);
                before
            })
            .collect()
    }

    /// q″ of a state at time t.
    fn acceleration(&self, state: &DVector<f64>, t: f64) -> DVector<f64> {
        let n = self.size();
        let push = &self.load * (self.omega * (t + self.psi)).cos() + &self.static_load;
        self.inverse() * (push - &self.stiffness * state.rows(0, n) - &self.damping * state.rows(n, n))
    }

    /// What each impact's contact does just before it.
    #[must_use]
    pub fn before(&self) -> Vec<Before> {
        let (n, states) = (self.size(), self.states());
        (self.impacts.iter().zip(&states))
            .map(|(impact, state)| {
                let w = &self.contacts[impact.contact];
                let acceleration = w.dot(&self.acceleration(state, impact.time));
                Before { place: w.dot(&state.rows(0, n)), velocity: w.dot(&state.rows(n, n)), acceleration }
            })
            .collect()
    }

    /// The monodromy matrix from just before the first impact, by exponentials and saltations.
    #[must_use]
    pub fn monodromy(&self) -> DMatrix<f64> {
        let (n, state) = (self.size(), self.state());
        let mut matrix = DMatrix::identity(2 * n, 2 * n);
        for (i, (impact, early)) in self.impacts.iter().zip(self.states()).enumerate() {
            let w = &self.contacts[impact.contact];
            let mut reset = DMatrix::identity(2 * n, 2 * n);
            let jump = self.inverse() * w * w.transpose() * (self.effective_mass(i) * (1.0 + impact.restitution));
            let mut corner = reset.view_mut((n, n), (n, n));
            corner -= &jump;
            let field = |x: &DVector<f64>| {
                let acceleration = self.acceleration(x, impact.time);
                DVector::from_fn(2 * n, |k, _| if k < n { x[k + n] } else { acceleration[k - n] })
            };
            let gap = DVector::from_fn(2 * n, |k, _| if k < n { w[k] } else { 0.0 });
            let velocity = w.dot(&early.rows(n, n));
            let off = (&reset * field(&early) - field(&(&reset * &early))) * gap.transpose() / velocity;
            let until = self.impacts.get(i + 1).map_or(self.period + self.impacts[0].time, |next| next.time);
            matrix = (&state * (until - impact.time)).exp() * (&reset - off) * matrix;
        }
        matrix
    }

    /// The poles λ of (λ²M + λC + K)⁻¹.
    #[must_use]
    pub fn rates(&self) -> Vec<Complex<f64>> {
        self.state().complex_eigenvalues().iter().copied().collect()
    }

    /// w·φ at all contacts for a pole λ that `count` modes share, φᵀ(2λM + C)φ = 1 for each and 0 between two.
    #[must_use]
    pub fn shapes(&self, rate: Complex<f64>, count: usize) -> Vec<Vec<Complex<f64>>> {
        let complex = |matrix: &DMatrix<f64>| matrix.map(|x| Complex::new(x, 0.0));
        let stiffness = complex(&self.mass) * (rate * rate) + complex(&self.damping) * rate + complex(&self.stiffness);
        let svd = stiffness.svd(false, true);
        let mut order: Vec<usize> = (0..self.size()).collect();
        order.sort_by(|&i, &j| svd.singular_values[i].total_cmp(&svd.singular_values[j]));
        let rows = svd.v_t.unwrap();
        let slope = complex(&self.mass) * (rate * 2.0) + complex(&self.damping);
        let mut found: Vec<DVector<Complex<f64>>> = Vec::new();
        for &i in &order[..count] {
            let mut shape = rows.row(i).adjoint();
            for other in &found {
                let share = (other.transpose() * &slope * &shape)[(0, 0)];
                shape -= other * share;
            }
            let square = (shape.transpose() * &slope * &shape)[(0, 0)];
            found.push(shape / square.sqrt());
        }
        let at = |shape: &DVector<Complex<f64>>| {
            self.contacts.iter().map(|w| w.map(|x| Complex::new(x, 0.0)).dot(shape)).collect()
        };
        found.iter().map(at).collect()
    }
}
