//! The paper's own way of computing its maps, as a slow peer.

use vibrochain_breather::Family;
use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Chain, Decay, Model, decay};
use vibrochain_maps::cell::{Class, Task, Worker};
use vibrochain_studies::accuracy::paper::{BLUR, Kernels};

const GAMMA1: f64 = 0.2;
const ASYMMETRY: f64 = 0.4;

fn model(sites: usize, gamma2: f64, omega: f64) -> Model {
    Model::conservative(Chain::new(sites, GAMMA1, gamma2).unwrap(), omega, ASYMMETRY).unwrap()
}

/// Points of the paper's map.
fn grid(columns: usize, rows: usize) -> impl Iterator<Item = (f64, f64)> {
    (0..rows).flat_map(move |j| {
        (0..columns).map(move |i| (0.3 * j as f64 / (rows - 1) as f64, 0.4 + 2.6 * i as f64 / (columns - 1) as f64))
    })
}

#[test]
fn the_2000_term_series_differs_only_where_the_series_is_wrong() {
    series_differs_only_where_it_is_wrong(3);
}

#[test]
#[ignore = "half a minute: cargo test --workspace --test all -- --ignored slow"]
fn slow_the_2000_term_series_differs_only_where_the_series_is_wrong() {
    series_differs_only_where_it_is_wrong(1);
}

/// At every point of a map, or every third.
fn series_differs_only_where_it_is_wrong(every: usize) {
    let (sites, mut worker) = (21, Worker::new(21));
    let families = vec![Family::DoubleSided, Family::SingleSided];
    let tolerance = Tolerance::Excess(BLUR);
    let task = Task {
        families,
        words: Vec::new(),
        symmetric: false,
        stability: true,
        tolerance,
        collisions: false,
        impulse: false,
    };
    let (mut compared, mut wrong, mut worst) = (0, 0, 0.0_f64);
    for (gamma2, omega) in grid(40, 24).step_by(every).filter(|(gamma2, _)| *gamma2 > 0.0) {
        let model = model(sites, gamma2, omega);
        // The series has no resonance to report; its terms are those of the closed form by construction of λ_j.
        assert!(matches!(decay(model.chain(), 10.0 * omega), Decay::Evanescent(_)));
        let cell = worker.cell(&model, &task);
        let (family, stable) = match cell.class.unwrap() {
            Class::StableDouble => (Family::DoubleSided, true),
            Class::UnstableDouble => (Family::DoubleSided, false),
            Class::StableSingle => (Family::SingleSided, true),
            Class::UnstableSingle => (Family::SingleSided, false),
            _ => continue,
        };
        let ours = cell.spectral_radius.unwrap();
        // The same procedure with the closed form agrees with the block of half the dimension …
        let exact = Kernels::closed(&model).unwrap().spectral_radius(&model, family).unwrap();
        assert!((exact - ours).abs() < 1e-5 * ours, "{gamma2} {omega}: {exact} {ours}");
        // … so that what is left between the maps is the series.
        let series = Kernels::by_series(&model, 2000).spectral_radius(&model, family).unwrap();
        compared += 1;
        let error = (series - ours).abs();
        if error > 1e-3 {
            wrong += 1;
            worst = worst.max(error / ours);
            // With 100 times the terms the series comes as much closer to the closed form.
            let longer = Kernels::by_series(&model, 200_000).spectral_radius(&model, family).unwrap();
            assert!((longer - ours).abs() < 0.2 * error, "{gamma2} {omega}: {series} {longer} {ours}");
        } else if (ours - 1.0 - BLUR).abs() > error {
            assert_eq!(series < 1.0 + BLUR, stable, "{gamma2} {omega}: {series} {ours}");
        }
    }
    println!(
        "{compared} cells, in {wrong} the series' radius is off by more than 1e-3, at worst by {worst:.3} of itself"
    );
    let cells = 960 / every;
    let seen = if every == 1 { 0.04 } else { 0.01 };
    assert!(compared > 7 * cells / 10 && wrong > cells / 50 && worst > seen, "{compared} {wrong} {worst}");
}
