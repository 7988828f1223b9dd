//! J(z) against dense determinants, for words at any sites, and all other ways to work its determinant out against it.

use nalgebra::{Complex, DMatrix};
use vibrochain_breather::linear::determinant;
use vibrochain_breather::{BlochEquations, Finder, Hit, Orbit, OrbitList, Prepared};
use vibrochain_lattice::{Barrier, Chain, Spectrum, Stop};
use vibrochain_testkit::{Ranges, Values};

use super::*;
use crate::map_paths::Residues;

/// J(z) of an orbit.
fn equations(prepared: Prepared<'_>) -> BlochEquations {
    prepared.orbit().at_contacts(&Stop::default()).unwrap().bloch_equations().0
}

/// det(z−M)/det(z−R).
fn secular(equations: &BlochEquations, z: Complex<f64>) -> Complex<f64> {
    determinant(&mut equations.matrix(z), equations.size()) * equations.scale()
}

/// Four places, inside and outside the circle.
fn places(random: &mut Random) -> [Complex<f64>; 4] {
    [0.3, 0.9, 1.1, 2.5].map(|radius| Complex::from_polar(radius, std::f64::consts::TAU * random.unit()))
}

/// Words of one to five impacts at up to four sites: whether they are motions between barriers does not matter here.
#[test]
fn determinants_of_words_are_those_of_the_whole_lattice() {
    let (mut random, mut several, mut layered) = (Random(41), 0, 0);
    let (gamma1, gamma2) = (Values::Log(0.05, 1.0), Values::Log(0.02, 0.5));
    let ranges = Ranges { sites: [1, 6], gamma1, gamma2, ..Ranges::CONSERVATIVE };
    for case in 0..300 {
        let sites = 1 + (random.unit() * 9.0) as usize;
        let ring = Chain::new(sites, random.log(0.05, 1.0), random.log(0.02, 0.5)).unwrap();
        let chain = if case % 2 == 0 { ring } else { random.lattice(&ranges) };
        let sites = chain.sites();
        let (omega, e) = (random.between(0.7, 2.5), if case % 3 == 0 { 1.0 } else { random.between(0.3, 0.99) });
        let model = chain.point().omega(omega).asymmetry(0.3).amplitude(0.2).restitution(e).model().unwrap();
        let count = 1 + case % 5;
        let mut times: Vec<f64> = (0..count).map(|_| random.unit() * model.period()).collect();
        times.sort_by(f64::total_cmp);
        let mut hit = |time: &f64| {
            let site = (random.unit() * sites.min(4) as f64) as usize;
            let barrier = if random.unit() < 0.5 { Barrier::Upper } else { Barrier::Lower };
            Hit::new(site, barrier, *time, -barrier.sign() * random.between(0.5, 2.0))
        };
        let hits: Vec<Hit> = times.iter().map(&mut hit).collect();
        let orbit = Orbit::from_impulses(&model, 1, 0.4, &hits).unwrap();
        let equations = equations(Finder::new(sites).prepared(&orbit).unwrap());
        let dense = crate::full_monodromy(&orbit).unwrap();
        let size = dense.nrows();
        several += usize::from(orbit.impact_site().is_none());
        layered += usize::from(orbit.impact_site().is_none() && chain.layers() > 1);
        for z in places(&mut random) {
            let shifted = DMatrix::from_fn(size, size, |i, j| {
                Complex::new(-dense[(i, j)], 0.0) + if i == j { z } else { Complex::default() }
            });
            // All modes, those with a node at site 0 too.
            let poles = |k: usize| {
                let angle = Spectrum::new(chain).frequencies()[k] * model.period();
                let both = [1.0, -1.0].map(|sign| z - Complex::from_polar(1.0, sign * angle));
                both[0] * both[1]
            };
            let ring: Complex<f64> =
                (0..chain.even_modes()).map(|k| poles(k).powi(chain.multiplicity(k) as i32)).product();
            let (found, expected) = (secular(&equations, z), shifted.determinant() / ring);
            let allowed = 1e-11 * (1.0 + expected.norm()) * (1.0 + dense.norm());
            assert!((found - expected).norm() < allowed, "{case} {z}: {found} {expected}");
        }
    }
    assert!(several > 150 && layered > 40, "{several} {layered}");
}

#[test]
fn residues_of_reversible_orbits_have_that_determinant() {
    let (mut random, mut residues) = (Random(44), Residues::default());
    let mut checked = 0;
    for case in 0..200 {
        let sites = 1 + (random.unit() * 40.0) as usize;
        let (g1, g2) = (random.log(0.02, 1.0), random.log(1e-3, 0.5));
        let Some(model) = model(sites, g1, g2, random.between(0.5, 3.0), random.between(0.0, 0.9)) else { continue };
        let (mut finder, mut found) = (Finder::new(sites), OrbitList::default());
        if finder.find_symmetric(&model, BOTH[case % 2], &mut found).is_err() {
            continue;
        }
        for orbit in &found.orbits {
            let Ok(prepared) = finder.prepared(orbit) else { continue };
            if residues.replace(prepared).is_err() {
                continue;
            }
            let equations = equations(prepared);
            for z in places(&mut random) {
                let nu = (z + z.inv()) * 0.5;
                let terms = residues.poles().iter().zip(residues.residues()).map(|(d, r)| *r / (nu - d));
                let sizes: f64 = terms.clone().map(|term| term.norm()).sum();
                let (value, expected) = (terms.sum::<Complex<f64>>() * (nu - 1.0), secular(&equations, z));
                let allowed = 1e-10 * prepared.response().condition() * (1.0 + sizes) * (1.0 + nu.norm());
                assert!((value - expected).norm() < allowed, "{model:?} {z}: {value} {expected}");
                checked += 1;
            }
        }
    }
    assert!(checked > 300, "{checked}");
}
