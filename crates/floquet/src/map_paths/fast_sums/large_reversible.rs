//! Residues of large rings in O(M): pairs of modes with near poles by the formulas of [`crate::map_paths::reversible::single_sided`] and
//! [`crate::map_paths::reversible::double_sided`], far ones by Cauchy sums,
//!
//! ```text
//! single:  c_k Σ b²[2c_k − c(x_k/x + x/x_k)]/(d_k−d)  =  c_k [2c_k A₀ − x_k A₁ − A₂/x_k],     charges b², b²c/x, b²cx at d
//! double:  Σ b²(x_k y + y_k x − 2s_k²)/(c_k−c)        =  x_k B₂ + y_k B₁ − 2s_k² B₀,          charges b², b²x, b²y at c
//!          Σ b²(1, x, y)/(c_k+c)                      =  −B(−c_k), the mode itself left out.
//! ```

use vibrochain_lattice::simd::lanes::Lane;

use crate::map_paths::fast_sums::multipole::{Field, Tree};
use crate::map_paths::modes::Modes;
use crate::map_paths::reversible::pole::Pole;
use crate::map_paths::reversible::{double_sided, single_sided};

/// Sorted positions and the modes they belong to.
fn sorted(count: usize, position: impl Fn(usize) -> f64) -> (Vec<f64>, Vec<u32>) {
    let mut order: Vec<u32> = (0..count as u32).collect();
    order.sort_unstable_by(|&k, &l| position(k as usize).total_cmp(&position(l as usize)));
    (order.iter().map(|&k| position(k as usize)).collect(), order)
}

fn gather(near: &mut Modes, chosen: &mut Vec<usize>, modes: &Modes, order: &[u32], field: &Field<3>) {
    chosen.clear();
    chosen.extend(field.near().map(|place| order[place] as usize));
    near.gather(modes, chosen);
}

/// As [`single_sided::residues`].
pub(crate) fn single_sided(modes: &Modes, poles: &mut Vec<Pole>) {
    poles.clear();
    poles.reserve_exact(modes.count());
    let (points, order) = sorted(modes.count(), |k| {
        let mode = modes.mode(k);
        (mode.cos - mode.sin) * (mode.cos + mode.sin)
    });
    let charge = |place: usize| {
        let mode = modes.mode(order[place] as usize);
        let w = mode.weight;
        [w, w * mode.cos * mode.inverse, w * mode.cos * mode.sin_over]
    };
    let tree = Tree::new(&points, false);
    let (mut near, mut chosen) = (Modes::default(), Vec::new());
    for field in tree.fields(&points, charge, &tree) {
        gather(&mut near, &mut chosen, modes, &order, &field);
        for place in field.targets.clone() {
            let mode = modes.mode(order[place] as usize);
            let [a0, a1, a2] = field.at(points[place]);
            let far = mode.cos * (2.0 * mode.cos * a0 - mode.sin_over * a1 - mode.inverse * a2);
            poles.push(single_sided::residue(order[place] as usize, &mode, &single_sided::sums(&near, &mode), far));
        }
    }
}

/// As [`double_sided::residues`].
pub(crate) fn double_sided(modes: &Modes, saltations: &double_sided::Saltations, poles: &mut Vec<Pole>) {
    let (points, order) = sorted(modes.count(), |k| modes.mode(k).cos);
    let charge = |place: usize| {
        let mode = modes.mode(order[place] as usize);
        [mode.weight, mode.weight * mode.sin_over, mode.weight * mode.sin_times]
    };
    let tree = Tree::new(&points, false);
    let (mut near, mut chosen, mut masked): (Modes, Vec<usize>, Vec<Lane>) = Default::default();
    let mut own = vec![double_sided::Own::default(); modes.count()];
    for field in tree.fields(&points, charge, &tree) {
        gather(&mut near, &mut chosen, modes, &order, &field);
        masked.clear();
        masked.extend(near.groups().iter().map(|group| group.weight));
        for place in field.targets.clone() {
            let k = order[place] as usize;
            let mode = modes.mode(k);
            let [b0, b1, b2] = field.at(points[place]);
            let mut sum = double_sided::sums(&near, &masked, &mode).0.total();
            sum.add_far(mode.sin_over * b2 + mode.sin_times * b1 - 2.0 * mode.sin * mode.sin * b0);
            own[k] = sum;
        }
    }
    poles.clear();
    poles.reserve_exact(modes.count());
    let (mirrored, images) = sorted(modes.count(), |k| -modes.mode(k).cos);
    for field in tree.fields(&points, charge, &Tree::new(&mirrored, false)) {
        gather(&mut near, &mut chosen, modes, &order, &field);
        for place in field.targets.clone() {
            let k = images[place] as usize;
            let mode = modes.mode(k);
            let mut far = field.at(mirrored[place]).map(|b| -b);
            masked.clear();
            masked.extend(near.groups().iter().map(|group| group.weight));
            match chosen.iter().position(|&l| l == k) {
                Some(itself) => masked.as_flattened_mut()[itself] = 0.0,
                None => {
                    let itself = mode.weight / (2.0 * mode.cos);
                    for (far, charge) in far.iter_mut().zip([1.0, mode.sin_over, mode.sin_times]) {
                        *far -= itself * charge;
                    }
                }
            }
            let mut mirror = double_sided::sums(&near, &masked, &mode).1.total();
            mirror.add_far(mode.inverse, far);
            let (residue, error) = double_sided::residue(&mode, saltations, &own[k], &mirror);
            poles.push(Pole::new(k, mode.cos, mode.sin, mode.shift, residue, error));
        }
    }
}
