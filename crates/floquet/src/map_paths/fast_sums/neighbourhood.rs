//! A function by poles d and charges q, Σ q/(ν−d), in the neighbourhood of some poles of a large ring: these one by one, the others as a
//! polynomial (see [`crate::map_paths::fast_sums::multipole`]), so that a value costs the same for any number of modes.

use std::ops::Range;

use nalgebra::Complex;
use vibrochain_lattice::simd::lanes::{Lane, room};

use crate::map_paths::fast_sums::multipole::{Field, NODES, Nodal, Ranges, Tree, derivative};
use crate::map_paths::reversible::pole::{Angle, FAR_ROOT};

/// One pole as a source of a field.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ChargedPole {
    pub(crate) at: Angle,
    /// What the error of the pole is known by.
    pub(crate) shift: f64,
    /// The charge and its error.
    pub(crate) charges: [f64; 2],
}

/// Poles one by one, in groups of four, and the field of those left out.
#[derive(Debug, Clone)]
pub(crate) struct NearPoles {
    pub(crate) charges: [Vec<Lane>; 2],
    pub(crate) shifts: Vec<Lane>,
    cos: Vec<Lane>,
    sin: Vec<Lane>,
    pub(crate) middle: f64,
    /// The field of far poles and its derivatives in u = (ν − middle)·scale, and its error.
    pub(crate) scale: f64,
    pub(crate) far: [Nodal; 3],
    pub(crate) noise: f64,
    /// The part of it that is not due to errors of the charges.
    pub(crate) rounding: f64,
}

impl Default for NearPoles {
    fn default() -> Self {
        let (shifts, cos, sin) = Default::default();
        let (charges, far) = ([const { Vec::new() }; 2], [[0.0; NODES]; 3]);
        Self { charges, shifts, cos, sin, middle: 0.0, scale: 0.0, far, noise: 0.0, rounding: 0.0 }
    }
}

impl NearPoles {
    /// Takes over the poles that are counted one by one.
    pub(crate) fn fill(&mut self, sources: impl ExactSizeIterator<Item = ChargedPole>) {
        let count = sources.len();
        let mut charges = self.charges.each_mut().map(|charges| room(charges, count, 0.0));
        let [shifts, cos, sin] = [(&mut self.shifts, 0.0), (&mut self.cos, FAR_ROOT), (&mut self.sin, FAR_ROOT)]
            .map(|(list, pad)| room(list, count, pad));
        for (i, source) in sources.enumerate() {
            charges.iter_mut().zip(source.charges).for_each(|(charges, charge)| charges[i] = charge);
            (shifts[i], cos[i], sin[i]) = (source.shift, source.at.cos, source.at.sin);
        }
    }

    /// Takes over some of another's poles, by their places there.
    fn select(&mut self, whole: &Self, places: &Ranges) {
        let count = places.iter().map(|places| places.len()).sum();
        let copy = |to: &mut Vec<Lane>, from: &[Lane], pad: f64| {
            let mut to = room(to, count, pad);
            for places in places {
                let (here, rest) = to.split_at_mut(places.len());
                here.copy_from_slice(&from.as_flattened()[places.start as usize..places.end as usize]);
                to = rest;
            }
        };
        self.charges.iter_mut().zip(&whole.charges).for_each(|(to, from)| copy(to, from, 0.0));
        copy(&mut self.shifts, &whole.shifts, 0.0);
        copy(&mut self.cos, &whole.cos, FAR_ROOT);
        copy(&mut self.sin, &whole.sin, FAR_ROOT);
    }

    /// Where the pole of this place is, cos φ of which is `d`.
    pub(crate) fn at(&self, place: usize, d: f64) -> Angle {
        Angle { d, cos: self.cos.as_flattened()[place], sin: self.sin.as_flattened()[place] }
    }

    /// The field's polynomial is good at u: within an ellipse about its interval on which it still converges fast.
    pub(crate) fn holds(&self, u: Complex<f64>) -> bool {
        u.re.abs() <= 1.2 && u.im.abs() <= 0.5
    }

    /// Distances of a pole from all that are counted one by one.
    pub(crate) fn distances(&self, from: &Angle, out: &mut Vec<Lane>) {
        from.distances(&self.cos, &self.sin, out);
    }
}

/// The neighbourhood of some gaps, each named by the place of its left pole: which poles are near, and the field of the others. The near
/// ones are copied only where they are looked at ([`Nearby`]): all of them at once would be five times the poles.
#[derive(Debug, Clone)]
pub(crate) struct Neighbourhood {
    pub(crate) gaps: Range<usize>,
    near: Ranges,
    pub(crate) middle: f64,
    /// As in [`NearPoles`].
    pub(crate) scale: f64,
    far: Nodal,
    noise: f64,
    rounding: f64,
}

/// Divides poles, by their rising `points` d, into neighbourhoods.
pub(crate) fn divide(points: &[f64], charges: impl Fn(usize) -> [f64; 2]) -> Vec<Neighbourhood> {
    let total_error: f64 = (0..points.len()).map(|place| charges(place)[1]).sum();
    let (sources, targets) = (Tree::new(points, false), Tree::new(points, true));
    let neighbourhood = |field: Field<2>| {
        // Interpolation errs by 2e-14 of the kernels, which the sum of moduli overestimates rather than under.
        let rounding = 1e-14 * field.far[0].iter().map(|c| c.abs()).sum::<f64>();
        Neighbourhood {
            gaps: field.targets,
            near: field.near,
            middle: field.middle,
            scale: if field.half > 0.0 { 1.0 / field.half } else { 0.0 },
            noise: rounding + field.far[1][0].abs() + total_error,
            rounding,
            far: field.far[0],
        }
    };
    sources.fields(points, charges, &targets).map(neighbourhood).collect()
}

/// A look at one neighbourhood after the other: the poles and the field of the last one, and distances from one of its poles.
#[derive(Debug, Clone, Default)]
pub(crate) struct Nearby {
    near_poles: NearPoles,
    /// The first gap of the neighbourhood that `near_poles` is of.
    first_gap: Option<usize>,
    pub(crate) distances: Vec<Lane>,
}

impl Nearby {
    /// Forgets where it looked: poles are about to change.
    pub(crate) fn forget(&mut self) {
        self.first_gap = None;
    }

    /// Looks at a neighbourhood of the poles `whole` from one of them.
    pub(crate) fn look<'a>(
        &'a mut self,
        whole: &NearPoles,
        neighbourhood: &Neighbourhood,
        from: &Angle,
    ) -> (&'a NearPoles, &'a [Lane]) {
        let Self { near_poles, first_gap, distances } = self;
        let Neighbourhood { gaps, near, middle, scale, far, noise, rounding } = neighbourhood;
        if *first_gap != Some(gaps.start) {
            *first_gap = Some(gaps.start);
            near_poles.select(whole, near);
            (near_poles.middle, near_poles.scale, near_poles.noise, near_poles.rounding) =
                (*middle, *scale, *noise, *rounding);
            let slope = derivative(far);
            near_poles.far = [*far, slope, derivative(&slope)];
        }
        near_poles.distances(from, distances);
        (near_poles, distances)
    }
}
