//! What docs/stripes.md tells of the growth and width of stripes, against stripes found.

use std::f64::consts::PI;

use vibrochain_breather::{Family, Finder, OrbitList};
use vibrochain_floquet::{DressedModes, Stripe, StripeEnd, StripeFinder, StripeLine};
use vibrochain_lattice::{Chain, Ends, Model, Parameter};
use vibrochain_studies::stripes::{growth_at_meeting, weak_growth};
use vibrochain_testkit::Random;

fn line(sites: usize, gamma2: f64, asymmetry: f64, family: Family) -> StripeLine {
    let model = Model::conservative(Chain::new(sites, 0.2, gamma2).unwrap(), 1.0, asymmetry).unwrap();
    StripeLine { model, family, free: Parameter::Omega }
}

/// The modes of the breather at a frequency, and its model.
fn modes(line: &StripeLine, omega: f64) -> Option<(Model, DressedModes)> {
    let model = line.model.with(Parameter::Omega, omega).unwrap();
    let (mut finder, mut found) = (Finder::new(2), OrbitList::default());
    finder.find_symmetric(&model, line.family, &mut found).ok()?;
    let mut modes = DressedModes::default();
    modes.replace(finder.prepared(found.orbits.first()?).ok()?).ok()?;
    Some((model, modes))
}

/// The stripes of two named modes at a harmonic that lie apart from all others.
fn apart(line: &StripeLine, harmonic: usize) -> Vec<(Stripe, (usize, usize))> {
    let chain = line.model.chain();
    let top = (chain.gamma1() + 4.0 * chain.gamma2()).sqrt();
    let row = StripeFinder::default().along(line, (0.6, 2.02 * top), 1500).unwrap();
    let alone = |stripe: &Stripe| {
        let touches = |other: &&Stripe| (other.centre - stripe.centre).abs() < other.half_width + stripe.half_width;
        row.stripes.iter().filter(touches).count() == 1
    };
    let whole = row.stripes.iter().filter(|stripe| stripe.ends == [StripeEnd::Edge; 2] && alone(stripe));
    whole.filter_map(|stripe| stripe.pair.filter(|pair| pair.1 == harmonic).map(|pair| (*stripe, pair.0))).collect()
}

#[test]
fn what_a_wave_gains_at_the_breather_tells_the_growth_at_any_coupling() {
    for (sites, most, typical) in [(6, 0.3, 0.08), (11, 0.15, 0.04), (21, 0.1, 0.02), (41, 0.1, 0.01)] {
        let (mut growths, mut widths, mut without) = (Vec::new(), Vec::new(), 0);
        let double = [(0.01, 0.4), (0.03, 0.8), (0.1, 0.1), (0.3, 0.4)].map(|place| (Family::DoubleSided, place));
        for (family, (gamma2, asymmetry)) in double.into_iter().chain([(Family::SingleSided, (0.03, 0.8))]) {
            let line = line(sites, gamma2, asymmetry, family);
            for (stripe, pair) in apart(&line, 1) {
                let (model, dressed) = modes(&line, stripe.centre).unwrap();
                let Some(law) = growth_at_meeting(&dressed, &model, pair) else {
                    // Of the internal mode, or next to where it leaves the band.
                    assert!(gamma2 == 0.3);
                    without += 1;
                    continue;
                };
                growths.push((stripe.growth / law - 1.0).abs());
                widths.push((stripe.half_width * PI / (stripe.centre * law) - 1.0).abs());
            }
        }
        assert!(growths.len() >= 20 && 20 * without <= growths.len(), "{} {without}", growths.len());
        for (kind, ratios) in [("growth", &mut growths), ("width", &mut widths)] {
            ratios.sort_by(f64::total_cmp);
            let (worst, middle) = (ratios[ratios.len() - 1], ratios[ratios.len() / 2]);
            println!("{sites} {kind}: {} stripes, {middle:.4} {worst:.4}", ratios.len());
            assert!(worst < most && middle < typical, "{sites} {kind} {worst} {middle}");
        }
    }
}

#[test]
fn what_goes_on_at_the_breather_does_not_know_how_long_the_ring_is() {
    // The same wave number in rings of 10, 30 and 90, whose modes 2, 7 and 22 have q = π/2.
    let mut checked = 0;
    for (gamma2, asymmetry) in [(0.01, 0.4), (0.1, 0.1), (0.1, 0.4), (0.3, 0.2)] {
        let found = [(10, 2), (30, 7), (90, 22)].map(|(sites, k)| {
            let line = line(sites, gamma2, asymmetry, Family::DoubleSided);
            let start = 2.0 * f64::sqrt(0.2 + 2.0 * gamma2);
            let centre = (0..6).fold(start, |omega, _| 2.0 * modes(&line, omega).unwrap().1.frequency(k).unwrap());
            let stripe = StripeFinder::default().near(&line, (k, k), 1, centre).unwrap();
            (stripe.growth * sites as f64, stripe.half_width * sites as f64)
        });
        for (short, within) in [(found[0], 0.12), (found[1], 0.04)] {
            let (growth, width) = (short.0 / found[2].0, short.1 / found[2].1);
            assert!((growth - 1.0).abs() < within && (width - 1.0).abs() < within, "{gamma2} {growth} {width}");
            checked += 1;
        }
    }
    assert_eq!(checked, 8);
}

#[test]
fn hardly_coupled_masses_have_stripes_in_closed_form() {
    let (mut random, mut finder) = (Random(16), StripeFinder::default());
    // How far coupled, and within what.
    for (least, most, within) in [(1e-5, 1e-3, 0.01), (1e-3, 1e-2, 0.1)] {
        let (mut checked, mut both) = ([[0; 2]; 2], 0);
        for i in 0..400 {
            let family = [Family::DoubleSided, Family::SingleSided][i % 2];
            let (sites, harmonic) = (4 + random.below(80), 1 + 2 * (i / 2 % 2));
            // Modes far from those of the bare ring: there rounding has the frequencies.
            let count = sites / 2;
            let pair = (random.below(count), random.below(count));
            let pair = (pair.0.min(pair.1), pair.0.max(pair.1));
            let coupling = random.log(least, most) / harmonic as f64;
            let line = line(sites, 0.2 * coupling, random.between(0.05, 0.8), family);
            let frequency = |k: usize| {
                let sine = (PI * (2 * k + 1) as f64 / (2 * sites) as f64).sin();
                (0.2 + 4.0 * line.model.chain().gamma2() * sine * sine).sqrt()
            };
            let omega = (frequency(pair.0) + frequency(pair.1)) / harmonic as f64;
            let Ok(stripe) = finder.near(&line, pair, harmonic, omega) else { continue };
            let law = weak_growth(&line, pair, harmonic).unwrap();
            let width = PI * harmonic as f64 * stripe.half_width / stripe.centre;
            let told = format!("{family:?} {sites} {pair:?} {harmonic} {coupling}: {} {law}", stripe.growth);
            assert!((stripe.growth / law - 1.0).abs() < within && (width / law - 1.0).abs() < within, "{told}");
            checked[i % 2][i / 2 % 2] += 1;
            both += usize::from(pair.0 == pair.1);
        }
        println!("{checked:?}, {both} of one mode");
        assert!(checked.iter().flatten().all(|count| *count > 40) && both > 5, "{checked:?} {both}");
    }
}

#[test]
fn where_there_is_no_law_none_is_told() {
    let double = line(21, 0.1, 0.4, Family::DoubleSided);
    let law = |(model, dressed): &(Model, DressedModes), pair| growth_at_meeting(dressed, model, pair);
    let inside = modes(&double, 1.5218).unwrap();
    assert!(law(&inside, (8, 9)).is_some_and(|growth| (growth / 4.845e-4 - 1.0).abs() < 0.03));
    // The internal mode, one that is not there; single-sided breathers of low frequency have several partners.
    assert_eq!(law(&inside, (8, 10)), None);
    assert_eq!(law(&inside, (8, 30)), None);
    let slow = modes(&line(21, 0.2, 0.4, Family::SingleSided), 0.25).unwrap();
    assert!((0..10).all(|k| law(&slow, (k, k)).is_none()));
    // Above twice the band a wave has no partner.
    let fast = modes(&double, 2.0).unwrap();
    assert!((0..10).all(|k| law(&fast, (k, k)).is_none()));
    assert_eq!(weak_growth(&double, (8, 9), 2), None);
    assert!(weak_growth(&line(21, 0.1, 0.0, Family::DoubleSided), (8, 9), 1).is_some_and(|growth| growth == 0.0));
    let row = Model::conservative(Chain::new(8, 0.2, 0.1).unwrap().with_ends(Ends::Free), 1.5, 0.4).unwrap();
    assert_eq!(weak_growth(&StripeLine { model: row, ..double }, (0, 1), 1), None);
}
