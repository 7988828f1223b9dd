//! Krein's form on eigenvectors, from the states of all modes that the impacts feel, and the part of the orbit's symmetries that each is in.
//!
//! Mode k has real coordinates x_k, y_k just before the first impact, with w_k(x_k² + y_k²)/2 its action: w = Ω where y = ẋ/Ω and the shape has
//! mass 1. The form is Σ w_k Im(x̄_k y_k), as ½i(ẋ̄·x − x̄·ẋ) is, summed over masses; against the action it lies between −1 and 1.

use nalgebra::{Complex, DMatrix};
use vibrochain_breather::BlochEquations;

use super::function::SpectralFunction;
use super::parts::Parts;
use super::shape::MOST_DEFECT;
use crate::singular::Singular;

type C = Complex<f64>;

/// How far the number of multipliers in a part may be from a whole one: eigenvectors mix that far where another part's multiplier is near.
const MIXED: f64 = 0.1;

/// One of several multipliers at a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct KreinForm {
    /// Bit by bit, which mirrors change the sign of its eigenvector.
    pub(crate) part: u32,
    /// The multiplier of half a period, where the orbit is its own image after that.
    pub(crate) half: Option<C>,
    /// Krein's form as a part of the action. Where multipliers of one part coincide it is the least of theirs, or 0 if they have both signs.
    pub(crate) form: f64,
}

/// J(z) of an orbit without losses, with its symmetries.
#[derive(Debug)]
pub(crate) struct KreinForms<'a> {
    function: SpectralFunction<'a>,
    parts: Parts,
    /// w_k
    weights: Vec<f64>,
}

impl<'a> KreinForms<'a> {
    pub(crate) fn new(equations: &'a BlochEquations) -> Self {
        Self { parts: Parts::of(equations), ..Self::without_parts(equations) }
    }

    /// The same, where parts are not asked for.
    pub(crate) fn without_parts(equations: &'a BlochEquations) -> Self {
        let kernel = equations.kernel();
        let length = |[x, y]: [f64; 2]| x.hypot(y);
        let weight = |k: usize| {
            let rows = (0..kernel.contacts()).map(|contact| (contact, length(kernel.row(k, contact))));
            let largest = rows.max_by(|a, b| a.1.total_cmp(&b.1));
            largest.map_or(0.0, |(contact, seen)| seen / length(kernel.column(k, contact)))
        };
        let weights = (0..kernel.modes().len()).map(weight).collect();
        Self { function: SpectralFunction::new(equations, false), parts: Parts::default(), weights }
    }

    /// How many reflections part the multipliers.
    pub(crate) fn reflections(&self) -> usize {
        self.parts.count()
    }

    /// Those of `count` multipliers next to z; `None` where they are none, or their parts cannot be told.
    pub(crate) fn at(&self, z: C, count: usize) -> Option<Vec<KreinForm>> {
        let (function, size) = (&self.function, self.function.equations.size());
        let null = function.null(z, count)?;
        // Not a number is no multiplier, either.
        if null.defect.is_nan() || null.defect > MOST_DEFECT {
            return None;
        }
        let (mut form, mut action) = (DMatrix::<C>::zeros(count, count), DMatrix::<C>::zeros(count, count));
        for (k, weight) in self.weights.iter().enumerate() {
            let states: Vec<[C; 2]> = (0..count).map(|column| function.state(z, &null, column, k)).collect();
            for (i, [x, y]) in states.iter().enumerate() {
                for (j, [other_x, other_y]) in states.iter().enumerate() {
                    let turned = x.conj() * other_y - y.conj() * other_x;
                    form[(i, j)] += C::new(0.0, -0.5 * weight) * turned;
                    action[(i, j)] += (x.conj() * other_x + y.conj() * other_y) * (0.5 * weight);
                }
            }
        }
        let vectors = null.right.rows(0, size).clone_owned();
        let mut reflections: Vec<DMatrix<C>> = Vec::new();
        if self.reflections() > 0 {
            let inverse = (vectors.adjoint() * &vectors).try_inverse()?;
            let own = |image| &inverse * (vectors.adjoint() * image);
            reflections.extend(self.parts.reflected(&vectors, z).map(own));
        }
        let mut found = Vec::with_capacity(count);
        for part in 0..1_u32 << reflections.len() {
            let mut projector = DMatrix::<C>::identity(count, count);
            for (bit, reflection) in reflections.iter().enumerate() {
                let sign = if part >> bit & 1 == 1 { -0.5 } else { 0.5 };
                projector = &projector * C::new(0.5, 0.0) + &projector * reflection * C::new(sign, 0.0);
            }
            let trace = projector.trace();
            let number = trace.re.round();
            if (trace - number).norm() > MIXED {
                return None;
            }
            let number = number.max(0.0) as usize;
            if number > 0 {
                let basis = Singular::of(&projector)?.left.columns(0, number.min(count)).clone_owned();
                let [form, action] = [&form, &action].map(|matrix| basis.adjoint() * matrix * &basis);
                let form = least(form, action)?;
                // The last reflection is the one by half a period.
                let last = 1_u32 << (reflections.len().max(1) - 1);
                let is_odd = part & last != 0;
                let half = self.parts.have_shift().then(|| if is_odd { -z.sqrt() } else { z.sqrt() });
                let part = if half.is_some() { part & !last } else { part };
                found.extend(std::iter::repeat_n(KreinForm { part, half, form }, number));
            }
        }
        (found.len() == count).then_some(found)
    }
}

/// The least form as a part of the action, 0 if it has both signs.
fn least(form: DMatrix<C>, action: DMatrix<C>) -> Option<f64> {
    let unit = action.cholesky()?.l().try_inverse()?;
    let values = (&unit * form * unit.adjoint()).symmetric_eigenvalues();
    let all_alike = values.iter().all(|value| *value > 0.0) || values.iter().all(|value| *value < 0.0);
    let least = values.iter().copied().min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
    Some(if all_alike { least } else { 0.0 })
}
