//! Values written and read with serde: what is read is what was written, to the last bit, what is out of range is refused in
//! the library's words, and the names are those of the program.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::fmt::Debug;
use std::path::Path;

use serde_json::{Value, json, to_value};
use vibrochain::breather::{
    Admissibility, BreatherError, Completeness, Family, Finder, Hit, NoBreather, Obstruction, Orbit, OrbitList, Proof,
    Scope, Unsearched, Word, admissibility, breathers,
};
use vibrochain::eventsim::{EventKind, Limits, Outcome, Simulation, Work};
use vibrochain::floquet::{
    Course, Event, Mechanism, Saltation, Search, Tolerance, diagram, locate, saltations, stability,
};
use vibrochain::lattice::{Barrier, Chain, Ends, Force, Harmonic, Model, Parameter, Point};
use vibrochain_cli::common::console::{Console, ctrl_c};
use vibrochain_maps::borders::BorderKind;
use vibrochain_maps::cell::Class;
use vibrochain_maps::scene::Scene;
use vibrochain_testkit::Values::{Either, Even, Is, Log};
use vibrochain_testkit::{Random, Ranges};

trait Both: serde::Serialize + serde::de::DeserializeOwned + PartialEq + Debug {}
impl<T: serde::Serialize + serde::de::DeserializeOwned + PartialEq + Debug> Both for T {}

/// Through text. `Debug` tells numbers of different bits apart.
fn read_back<T: Both>(value: &T) -> String {
    let text = serde_json::to_string(value).unwrap();
    let read: T = serde_json::from_str(&text).unwrap();
    assert!(
        read == *value && format!("{read:?}") == format!("{value:?}"),
        "{value:?} came back as {read:?} from {text}"
    );
    text
}

fn refused<T: Both>(value: Value, by: &str) {
    let error = serde_json::from_value::<T>(value.clone()).unwrap_err().to_string();
    assert!(error.starts_with(by), "{value}: {error}");
}

/// Of every kind: with and without force, of one harmonic and of several.
fn models(seed: u64, count: usize) -> Vec<Model> {
    let mut random = Random(seed);
    let ranges = Ranges {
        gamma2: Either(0.1, &Is(0.0), &Log(1e-3, 0.5)),
        asymmetry: Either(0.2, &Is(0.0), &Even(0.0, 0.9)),
        ..Ranges::FORCED
    };
    let mut model = || {
        let kind = random.below(3);
        let plain = random.model(if kind == 0 { &Ranges::CONSERVATIVE } else { &ranges });
        if kind < 2 {
            return plain;
        }
        let terms = [1, 3, 7].map(|number| Harmonic {
            number,
            amplitude: random.between(-0.5, 0.5),
            phase: random.value(Either(0.3, &Is(0.0), &Even(-3.0, 3.0))),
        });
        plain.point().under(&Force::new(&terms).unwrap()).model().unwrap()
    };
    (0..count).map(|_| model()).collect()
}

fn answer(line: &str) -> Value {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let mut console = Console::new(&mut out, &mut err, &ctrl_c);
    vibrochain_cli::program::run(line.split(' ').map(Into::into), &mut console).unwrap();
    serde_json::from_slice(&out).unwrap()
}

/// The flags of a model, from its written form.
fn flags(model: &Model) -> String {
    let mut flags = String::new();
    for (name, value) in to_value(model).unwrap().as_object().unwrap() {
        let value = match value.as_array() {
            None => value.as_str().map_or_else(|| value.to_string(), str::to_owned),
            Some(terms) => {
                let term = |term: &Value| format!("{}:{}:{}", term["harmonic"], term["amplitude"], term["phase"]);
                terms.iter().map(term).collect::<Vec<_>>().join(",")
            }
        };
        flags += &format!(" --{}={value}", name.replace('_', "-"));
    }
    flags
}

#[test]
fn models_come_back_to_the_last_bit() {
    let (mut conservative, mut several) = (0, 0);
    for model in models(1, 3000) {
        read_back(&model);
        read_back(model.chain());
        read_back(model.force());
        conservative += usize::from(model.is_conservative());
        several += usize::from(model.force().cosine_amplitude().is_none());
    }
    assert!(conservative > 800 && several > 800, "{conservative} {several}");
}

#[test]
fn what_is_out_of_range_is_refused_in_the_librarys_words() {
    let good = json!({ "sites": 5, "gamma1": 0.2, "gamma2": 0.1, "omega": 1.5, "asymmetry": 0.4 });
    let model: Model = serde_json::from_value(good.clone()).unwrap();
    assert!(model.is_conservative(), "without force and losses unless they are given");
    let chain = |sites: usize, gamma1: f64, gamma2: f64| Chain::new(sites, gamma1, gamma2).unwrap_err().to_string();
    let point = |omega: f64, asymmetry: f64, amplitude: f64, restitution: f64| {
        let point = model.point().omega(omega).asymmetry(asymmetry);
        point.amplitude(amplitude).restitution(restitution).model().unwrap_err().to_string()
    };
    let both = "amplitude = 0.1 is out of range: give either an amplitude or a force";
    let term = json!([{ "harmonic": 3, "amplitude": 0.1 }]);
    for (change, by) in [
        (json!({ "sites": 0 }), chain(0, 0.2, 0.1)),
        (json!({ "gamma1": -0.2 }), chain(5, -0.2, 0.1)),
        (json!({ "gamma2": 1e101 }), chain(5, 0.2, 1e101)),
        (json!({ "gamma1": 0.0, "gamma2": 0.0 }), chain(5, 0.0, 0.0)),
        (json!({ "omega": 0.0 }), point(0.0, 0.4, 0.0, 1.0)),
        (json!({ "asymmetry": 1.0 }), point(1.5, 1.0, 0.0, 1.0)),
        (json!({ "amplitude": -1.0 }), point(1.5, 0.4, -1.0, 1.0)),
        (json!({ "restitution": 1.5 }), point(1.5, 0.4, 0.0, 1.5)),
        (json!({ "amplitude": 0.1, "force": term }), both.to_owned()),
        (json!({ "force": [{ "harmonic": 2, "amplitude": 0.1 }] }), "harmonic = 2 is out of range".to_owned()),
        (json!({ "force": [] }), "number of harmonics = 0 is out of range".to_owned()),
        (json!({ "frequency": 1.5 }), "unknown variant `frequency`, expected one of `gamma1`".to_owned()),
        (json!({ "sites": -1 }), "invalid value: integer `-1`".to_owned()),
        (json!({ "omega": null }), "invalid type: null".to_owned()),
    ] {
        let mut bad = good.clone();
        bad.as_object_mut().unwrap().extend(change.as_object().unwrap().clone());
        refused::<Model>(bad, &by);
    }
    refused::<Chain>(json!({ "sites": 5, "gamma1": -1.0, "gamma2": 0.1 }), &chain(5, -1.0, 0.1));
    refused::<Family>(json!("triple"), "unknown variant `triple`");
}

/// The names are those that the program writes and reads.
#[test]
fn the_program_writes_and_reads_the_same_names() {
    let (mut solutions, mut obstructed, mut scenes) = (0, 0, 0);
    for model in models(2, 60) {
        let written = to_value(model).unwrap();
        let family = if model.is_conservative() { Family::SingleSided } else { Family::DoubleSided };
        let Ok(found) = breathers(&model, family) else { continue };
        let told = answer(&format!("mapgen orbit --json --family {}{}", family.name(), flags(&model)));
        assert_eq!(written, told["parameters"]);
        assert_eq!(
            read_back(&serde_json::from_value::<Model>(told["parameters"].clone()).unwrap()),
            written.to_string()
        );
        for (orbit, told) in found.orbits.iter().zip(told["solutions"].as_array().unwrap()) {
            for (name, value) in to_value(orbit).unwrap().as_object().unwrap() {
                assert_eq!(*value, told[name], "{name}");
            }
            let admissibility = to_value(admissibility(orbit).unwrap()).unwrap();
            assert_eq!(admissibility["margin"], told["margin"]);
            for name in ["kind", "site", "barrier", "time", "impact", "excess", "velocity_before"] {
                assert_eq!(admissibility["obstruction"][name], told["obstruction"][name], "{name}");
            }
            obstructed += usize::from(!told["obstruction"].is_null());
            let verdict = to_value(stability(orbit, Tolerance::Rounding).unwrap().verdict).unwrap();
            for name in ["stable", "undecided", "mechanism", "spectral_radius"] {
                assert_eq!(verdict[name], told["stability"][name], "{name}");
            }
            solutions += 1;
        }
        // As the model of a manifest, which is a scene.
        let mut without = written.clone();
        without.as_object_mut().unwrap().remove("omega");
        let x = json!({ "parameter": "omega", "from": model.omega(), "to": 1e3, "points": 2 });
        let compute = json!({ "families": ["single-sided"] });
        let manifest = json!({ "model": without, "sweep": { "x": x }, "compute": compute }).to_string();
        let scene = Scene::parse(Path::new("map.manifest.json"), &manifest).unwrap();
        assert_eq!(scene.point(0).model().unwrap(), model);
        scenes += 1;
    }
    assert!(solutions > 60 && obstructed > 20 && scenes > 50, "{solutions} {obstructed} {scenes}");
}

/// Events, branches and curves are written as the program writes them; of lattices with several layers, too.
#[test]
fn what_is_found_on_branches_is_written_as_by_the_program() {
    let rows = Chain::new(4, 0.2, 0.02).unwrap().with_ends(Ends::Free).with_layers(2, 0.05, Ends::Free).unwrap();
    let ring = Chain::new(7, 0.2, 0.1).unwrap();
    let cases = [
        (
            rows.point().omega(1.5).asymmetry(0.4).amplitude(0.3).restitution(0.8).model().unwrap(),
            "1:1+,1:1-",
            Event::Grazing,
            Parameter::Omega,
        ),
        (
            ring.point().omega(1.07).asymmetry(0.8).amplitude(0.165).restitution(0.25).model().unwrap(),
            "0-",
            Event::PeriodDoubling,
            Parameter::Amplitude,
        ),
    ];
    let (mut layers, mut points) = (0, 0);
    for (model, word, event, free) in cases {
        let flags = format!("--word {word} --free {free}{}", flags(&model));
        let (mut finder, mut found) = (Finder::new(model.chain().sites()), OrbitList::default());
        let word = word.parse::<Word>().unwrap().canonical(&model);
        finder.find_word(&model, &word, Scope::All, &mut found).unwrap();
        let orbit = found.orbits.iter().find(|orbit| admissibility(orbit).unwrap().is_physical()).unwrap();

        let search = Search::new(orbit, event, free);
        let mut located = locate(orbit, &search).unwrap().located;
        located.sort_by(|one, other| one.value.total_cmp(&other.value));
        let told = answer(&format!("mapgen locate --json --event {event} {flags}"));
        assert_eq!(to_value(&located).unwrap(), told["points"]);
        layers += usize::from(told["points"][0]["evidence"]["layer"].is_number());

        let range = [0.9, 1.1].map(|part| part * model.get(free));
        let course = Course { from: range[0], to: range[1], ..Course::new(orbit, free) };
        let told = answer(&format!("mapgen branch --json --from {} --to {} {flags}", range[0], range[1]));
        for (branch, told) in diagram(orbit, &course).unwrap().branches.iter().zip(told["branches"].as_array().unwrap())
        {
            assert_eq!(to_value(branch.points().collect::<Vec<_>>()).unwrap(), told["points"]);
            assert_eq!(to_value(branch.events().collect::<Vec<_>>()).unwrap(), told["events"]);
            points += branch.points().count();
        }
    }
    assert!(layers > 0 && points > 10, "{layers} {points}");
}

/// As text an orbit is written only; its parameters and impacts are enough to have it again.
#[test]
fn an_orbit_is_made_again_from_what_was_written_of_it() {
    let mut orbits = 0;
    for model in models(3, 200) {
        let family = if model.is_conservative() { Family::DoubleSided } else { Family::SingleSided };
        let Ok(found) = breathers(&model, family) else { continue };
        for orbit in &found.orbits {
            let written = to_value(orbit).unwrap();
            let read: Model = serde_json::from_value(to_value(orbit.model()).unwrap()).unwrap();
            let hits: Vec<Hit> = serde_json::from_value(written["impacts"].clone()).unwrap();
            let refused = serde_json::from_value::<Orbit>(written).unwrap_err().to_string();
            assert!(refused.contains("make it from its parameters and impacts"), "{refused}");
            let again = match Orbit::from_impulses(&read, orbit.force_periods(), orbit.psi().unwrap_or(0.0), &hits) {
                // A wrong sign is no word.
                Err(BreatherError::Impact { .. }) => continue,
                again => again.unwrap(),
            };
            for (own, given) in again.impacts().iter().zip(orbit.impacts()) {
                assert_eq!((own.time, own.impulse), (given.time, given.impulse));
                assert!((own.acceleration - given.acceleration).abs() < 1e-6 * (1.0 + given.acceleration.abs()));
            }
            orbits += 1;
        }
    }
    assert!(orbits > 100, "{orbits}");
}

#[test]
fn other_values_come_back_and_have_their_names() {
    for parameter in Parameter::ALL {
        assert_eq!(read_back(&parameter), format!("\"{}\"", parameter.name()));
    }
    for barrier in Barrier::ALL {
        assert_eq!(read_back(&barrier), format!("\"{}\"", barrier.name()));
    }
    for family in Family::ALL {
        assert_eq!(read_back(&family), format!("\"{}\"", family.name()));
    }
    assert_eq!(to_value(Class::ALL).unwrap(), json!(Class::ALL.map(Class::name)));
    assert_eq!(to_value(BorderKind::ALL).unwrap(), json!(BorderKind::ALL.map(BorderKind::name)));
    for mechanism in Mechanism::ALL {
        assert_eq!(read_back(&mechanism), format!("\"{}\"", mechanism.name()));
    }
    for event in Event::ALL {
        assert_eq!(read_back(&event), format!("\"{}\"", event.name()));
    }
    for kind in EventKind::ALL {
        assert_eq!(read_back(&kind), format!("\"{}\"", kind.name()));
    }
    read_back(&[Scope::All, Scope::Symmetric, Scope::Candidates, Scope::SymmetricCandidates]);
    assert_eq!(read_back(&[Tolerance::Rounding, Tolerance::Excess(0.01)]), "[null,0.01]");
    for proof in [Proof::ClosedForm, Proof::Enclosures { intervals: 40 }, Proof::BranchAndPrune { boxes: 7 }] {
        assert_eq!(to_value(proof).unwrap()["by"], proof.name());
        read_back(&Completeness::All(proof));
        read_back(&Completeness::None { reason: NoBreather::ForceTooWeak { threshold: 0.1 + 0.2 }, by: Some(proof) });
    }
    read_back(&Completeness::None { reason: NoBreather::NotSearched(Unsearched::FreePhases), by: None });
    read_back(&[Completeness::Asked { left_out: 3 }, Completeness::Open { unresolved: 1, exhausted: 2 }]);
    let crossing = Obstruction::Crossing { site: 3, barrier: Barrier::Upper, time: 0.1, excess: 0.3 };
    read_back(&Admissibility { margin: Some(-0.3), obstruction: Some(crossing), closest: None });

    let ring = Point::ring(5).gamma1(0.2).gamma2(0.1);
    let model = ring.omega(1.5).asymmetry(0.4).amplitude(0.1).restitution(0.9).model().unwrap();
    let mut found = OrbitList::default();
    Finder::new(5).find(&model, Family::DoubleSided, &mut found).unwrap();
    let orbit = &found.orbits[0];
    read_back(&saltations(orbit).unwrap().collect::<Vec<Saltation>>());

    let search = Search { from: 0.9, to: 1.0, ..Search::new(orbit, Event::Fold, Parameter::Restitution) };
    read_back(&Search { from: 0.1 + 0.2, ..search });

    let mut simulation = Simulation::new(&model, 0.0, &[0.0; 5], &[2.0, -1.0, 1.5, 0.5, -0.5]).unwrap();
    let (report, events) = simulation.collect(&Limits::impacts(5));
    assert_eq!(to_value(report).unwrap()["outcome"], "impacts-reached");
    let event = to_value(events[4]).unwrap();
    for name in ["time", "contact", "barrier", "velocity_before", "velocity_after", "kind"] {
        assert!(!event[name].is_null(), "{event}");
    }
    assert_eq!(event["time"]["offset"], json!(events[4].time.offset()));
    read_back::<Work>(&report.work);
    read_back(&Outcome::Cascade { contact: 3, barrier: Barrier::Lower, bounces: 100 });
}
