//! Linear structures with stops, unequal masses and damping that is no combination of mass and stiffness, given as full matrices: their
//! multipliers from J(z), against exponentials and saltations, and against the table.
#![allow(clippy::unwrap_used, reason = "a test stops at the first surprise")]

use vibrochain_breather::{BlochEquations, LinearImpact};
use vibrochain_floquet::{Complex, ImpactSpectrum};
use vibrochain_lattice::{BlochKernel, LinearMode, ModeShape, ParticipatingModes};
use vibrochain_testkit::{Before, Random, Structure, StructureImpact, structures};

fn shape_at<T: Default>(contacts: Vec<T>) -> ModeShape<T> {
    ModeShape { contacts, ..ModeShape::default() }
}

/// The kernel between the contacts of a structure, pole by pole.
fn kernel(structure: &Structure) -> BlochKernel {
    let mut modes = Vec::new();
    let scale = structure.rates().iter().map(|rate| rate.norm()).fold(0.0, f64::max);
    // A double pole at 0 is a rigid mode: the dense eigenvalues split it.
    let rigid = |rate: &Complex<f64>| rate.norm() < 1e-6 * scale;
    let rates = structure.rates();
    let (still, rates): (Vec<_>, Vec<_>) = rates.into_iter().partition(rigid);
    if still.len() == 2 {
        let softest = structure.stiffness.clone().symmetric_eigen();
        let shape = softest.eigenvectors.column(softest.eigenvalues.iamin()).into_owned();
        let length = shape.dot(&(&structure.mass * &shape)).sqrt();
        let shapes: Vec<f64> = structure.contacts.iter().map(|w| w.dot(&shape) / length).collect();
        modes.push(LinearMode::oscillator(0.0, 0.0, &shape_at(shapes), &[]));
    }
    let mut real: Vec<f64> = Vec::new();
    let mut upper: Vec<Complex<f64>> = Vec::new();
    let single = if still.len() == 1 { still.as_slice() } else { &[] };
    for rate in rates.iter().chain(single) {
        if rate.im > 0.0 {
            upper.push(*rate);
        } else if rate.im == 0.0 {
            real.push(rate.re);
        }
    }
    // Modes that share a pole share its null space.
    while let Some(rate) = upper.pop() {
        let (alike, rest): (Vec<_>, Vec<_>) = upper.iter().partition(|other| (**other - rate).norm() < 1e-7 * scale);
        upper = rest;
        let mean = alike.iter().sum::<Complex<f64>>() + rate;
        let mean = mean / (alike.len() + 1) as f64;
        let shapes = structure.shapes(mean, alike.len() + 1).into_iter();
        modes.extend(shapes.map(|contacts| LinearMode::pole(mean, &shape_at(contacts), &[])));
    }
    real.sort_by(|a, b| b.total_cmp(a));
    for pair in real.chunks_exact(2) {
        // Residues are real: a shape is real, or imaginary for a negative one.
        let both = [pair[0], pair[1]].map(|rate| {
            let shapes = structure.shapes(Complex::new(rate, 0.0), 1).remove(0);
            let sign = if shapes.iter().map(|shape| (shape * shape).re).sum::<f64>() > 0.0 { 1.0 } else { -1.0 };
            let part = |shape: &Complex<f64>| if sign > 0.0 { shape.re } else { shape.im };
            (sign, shape_at(shapes.iter().map(part).collect::<Vec<f64>>()))
        });
        let shapes = [&both[0].1, &both[1].1];
        modes.push(LinearMode::real_poles([pair[0], pair[1]], [both[0].0, both[1].0], shapes, &[]));
    }
    let contacts: Vec<usize> = (0..structure.contacts.len()).collect();
    ParticipatingModes { modes: modes.into(), ..ParticipatingModes::default() }.kernel(structure.period, &contacts)
}

fn equations(structure: &Structure) -> BlochEquations {
    let before = structure.before();
    let impacts = structure.impacts.iter().zip(&before).map(|(impact, before)| LinearImpact {
        contact: impact.contact,
        time: impact.time,
        impulse: impact.impulse,
        restitution: impact.restitution,
        acceleration_before: before.acceleration,
    });
    BlochEquations::new(kernel(structure), impacts.collect())
}

/// det J(z) with its scale.
fn secular(equations: &BlochEquations, z: Complex<f64>) -> Complex<f64> {
    let size = equations.size();
    let rows = equations.matrix(z);
    let mut matrix: Vec<Vec<Complex<f64>>> = rows.chunks(size).map(<[_]>::to_vec).collect();
    let mut determinant = Complex::new(equations.scale(), 0.0);
    for k in 0..size {
        let pivot = (k..size).max_by(|&i, &j| matrix[i][k].norm().total_cmp(&matrix[j][k].norm())).unwrap();
        if pivot != k {
            matrix.swap(k, pivot);
            determinant = -determinant;
        }
        determinant *= matrix[k][k];
        for i in k + 1..size {
            let factor = matrix[i][k] / matrix[k][k];
            for j in k..size {
                let above = matrix[k][j];
                matrix[i][j] -= factor * above;
            }
        }
    }
    determinant
}

/// f is det(z−M)/det(z−R), and its zeros are the eigenvalues of M; the largest distance.
fn check(structure: &Structure, random: &mut Random, conservative: bool) -> f64 {
    let equations = equations(structure);
    for (i, impact) in structure.impacts.iter().enumerate() {
        let contact = equations.impacts()[i].contact;
        let mobility = equations.kernel().mobility(contact, contact);
        assert!((mobility * structure.effective_mass(i) - 1.0).abs() < 1e-11, "{}: {impact:?}", structure.name);
    }
    let matrix = structure.monodromy();
    let size = matrix.nrows();
    for _ in 0..3 {
        let z = Complex::from_polar(random.between(0.4, 1.8), random.between(0.0, 6.3));
        let dense = nalgebra::DMatrix::from_fn(size, size, |i, j| {
            Complex::new(-matrix[(i, j)], 0.0) + if i == j { z } else { Complex::new(0.0, 0.0) }
        });
        let poles = equations.kernel().modes().iter().flat_map(|mode| mode.poles());
        let free: Complex<f64> = poles.map(|pole| z - pole).product();
        let (expected, found) = (dense.determinant() / free, secular(&equations, z));
        assert!(
            (found - expected).norm() < 1e-6 * (1.0 + expected.norm()),
            "{} {z}: {found} {expected}",
            structure.name
        );
    }
    let spectrum =
        if conservative { ImpactSpectrum::conservative(&equations) } else { ImpactSpectrum::new(&equations) };
    // The table knows the orbit of stiff modes to fewer digits than a sum of all multipliers has.
    let newton = |(i, (impact, before)): (usize, (&StructureImpact, Before))| {
        impact.impulse / structure.effective_mass(i) + (1.0 + impact.restitution) * before.velocity
    };
    let left =
        structure.impacts.iter().zip(structure.before()).enumerate().map(newton).fold(0.0, |a: f64, b| a.max(b.abs()));
    assert!(spectrum.is_certified || left > 1e-10, "{}: {spectrum:?}", structure.name);
    let mut open: Vec<Complex<f64>> = matrix.complex_eigenvalues().iter().copied().collect();
    assert_eq!(spectrum.multipliers.len() + if conservative { 2 } else { 0 }, open.len(), "{}", structure.name);
    let norm = matrix.norm();
    let mut farthest: f64 = 0.0;
    for (z, error) in spectrum.multipliers.iter().zip(&spectrum.errors) {
        let distance = |w: &Complex<f64>| (w - z).norm();
        let nearest = (0..open.len()).min_by(|&i, &j| distance(&open[i]).total_cmp(&distance(&open[j]))).unwrap();
        let off = distance(&open.swap_remove(nearest));
        // Dense eigenvalues err, too, and those of a trivial pair's neighbours by a root.
        assert!(off < error + 1e-8 * norm, "{}: {z} {off:e} {error:e}", structure.name);
        farthest = farthest.max(off);
    }
    farthest
}

#[test]
fn structures_of_the_table_are_orbits_and_have_its_multipliers() {
    let mut random = Random(3);
    let (mut checked, mut free, mut rigid, mut overdamped) = (0, 0, 0, 0);
    for structure in structures() {
        for (i, (impact, before)) in structure.impacts.iter().zip(structure.before()).enumerate() {
            let length = 1.0 + impact.stop.abs();
            assert!((before.place - impact.stop).abs() < 1e-9 * length, "{} {i}: {before:?}", structure.name);
            let newton = impact.impulse / structure.effective_mass(i) + (1.0 + impact.restitution) * before.velocity;
            assert!(newton.abs() < 1e-8 * (1.0 + impact.impulse.abs()), "{} {i}: {newton:e}", structure.name);
        }
        let lossless =
            structure.damping.norm() == 0.0 && structure.impacts.iter().all(|impact| impact.restitution == 1.0);
        let conservative = lossless && structure.load.norm() == 0.0;
        check(&structure, &mut random, conservative);
        let equations = equations(&structure);
        let spectrum =
            if conservative { ImpactSpectrum::conservative(&equations) } else { ImpactSpectrum::new(&equations) };
        let mut all = spectrum.multipliers.clone();
        all.extend(std::iter::repeat_n(Complex::new(1.0, 0.0), if conservative { 2 } else { 0 }));
        for listed in &structure.multipliers {
            let off = all.iter().map(|z| (z - listed).norm()).fold(f64::INFINITY, f64::min);
            // The table's come from a dense matrix, which splits trivial pairs.
            let allowed = if conservative { 1e-6 } else { 1e-8 } * (1.0 + listed.norm());
            assert!(off < allowed, "{}: {listed} {off:e}", structure.name);
            checked += 1;
        }
        free += usize::from(conservative);
        let modes = equations.kernel().modes();
        rigid += usize::from(modes.iter().any(|mode| mode.rates().iter().any(|rate| rate.norm() < 1e-12)));
        overdamped += usize::from(modes.iter().any(|mode| mode.rates()[0].im == 0.0));
    }
    assert!(checked > 100 && free > 5 && rigid >= 1 && overdamped >= 1, "{checked} {free} {rigid} {overdamped}");
}

/// Whether the modes that are made here of the matrices give them back, which of two poles that nearly meet they do not.
fn has_modes(structure: &Structure) -> bool {
    let equations = equations(structure);
    structure.impacts.iter().enumerate().all(|(i, _)| {
        let contact = equations.impacts()[i].contact;
        let mobility = equations.kernel().mobility(contact, contact);
        (mobility * structure.effective_mass(i) - 1.0).abs() < 1e-11
    })
}

fn random_structures_hold(count: usize) {
    let mut random = Random(11);
    let (mut off, mut overdamped, mut several): (Vec<f64>, usize, usize) = (Vec::new(), 0, 0);
    for _ in 0..count {
        let structure = random.structure();
        if !has_modes(&structure) {
            continue;
        }
        off.push(check(&structure, &mut random, false));
        overdamped += usize::from(structure.rates().iter().any(|rate| rate.im == 0.0));
        several += usize::from(structure.impacts.len() > 2);
    }
    off.sort_by(f64::total_cmp);
    let held = off.len();
    assert!(held * 50 >= count * 49, "{held} of {count}");
    println!("median {:e}, worst {:e}, {overdamped} overdamped", off[held / 2], off[held - 1]);
    assert!(off[held / 2] < 1e-12 && overdamped * 20 > count && several * 10 > count, "{overdamped} {several}");
}

#[test]
fn random_structures_have_the_multipliers_of_their_matrices() {
    random_structures_hold(60);
}

#[test]
#[ignore = "a minute: cargo test --workspace --test structures -- --ignored slow"]
fn slow_two_thousand_random_structures_have_the_multipliers_of_their_matrices() {
    random_structures_hold(2000);
}
