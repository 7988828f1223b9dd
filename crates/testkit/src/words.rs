//! The table of checked impact words (tests/data/words.json), and random words.

use serde_json::Value;
use vibrochain_breather::{Hit, Letter, Word};
use vibrochain_lattice::{Barrier, Chain, Ends, Model};

use crate::random::Random;

/// One word of the table.
#[derive(Debug, Clone)]
pub struct WordCase {
    /// The word, in groups of impacts at one instant.
    pub word: String,
    /// Its parameters.
    pub model: Model,
    /// Phase of the force.
    pub psi: f64,
    /// Its impacts, in order of time.
    pub hits: Vec<Hit>,
    /// Whether it is physical; not told under a force.
    pub physical: Option<bool>,
    /// Its spectral radius, by dense eigenvalues.
    pub spectral_radius: f64,
}

fn case(values: &Value) -> WordCase {
    let model = &values["model"];
    let parameter = |name: &str, otherwise: f64| model[name].as_f64().unwrap_or(otherwise);
    let sites = model["sites"].as_u64().unwrap() as usize;
    let ends =
        |name: &str, otherwise: Ends| model[name].as_str().map_or(otherwise, |ends| Ends::from_name(ends).unwrap());
    let layers = model["layers"].as_u64().unwrap_or(1) as usize;
    let chain = Chain::new(sites, parameter("gamma1", 0.0), parameter("gamma2", 0.0)).unwrap();
    let chain = chain.with_ends(ends("ends", Ends::Closed));
    let chain = chain.with_layers(layers, parameter("gamma3", 0.0), ends("layer_ends", Ends::Free)).unwrap();
    let (amplitude, restitution) = (parameter("amplitude", 0.0), parameter("restitution", 1.0));
    let (omega, asymmetry) = (parameter("omega", 0.0), parameter("asymmetry", 0.0));
    let model =
        chain.point().omega(omega).asymmetry(asymmetry).amplitude(amplitude).restitution(restitution).model().unwrap();
    let hit = |impact: &Value| {
        let impulse = impact["impulse"].as_f64().unwrap();
        let barrier = match impact["barrier"].as_str() {
            Some("upper") => Barrier::Upper,
            Some(_) => Barrier::Lower,
            // Where it is not told the impulse points inward.
            None if impulse < 0.0 => Barrier::Upper,
            None => Barrier::Lower,
        };
        // Some are a few roundings before 0.
        let time = impact["time"].as_f64().unwrap().max(0.0);
        Hit::new(impact["site"].as_u64().unwrap() as usize, barrier, time, impulse)
    };
    WordCase {
        word: values["word"].as_str().unwrap().to_owned(),
        model,
        psi: values["psi"].as_f64().unwrap_or(0.0),
        hits: values["impacts"].as_array().unwrap().iter().map(hit).collect(),
        physical: values["physical"].as_bool(),
        spectral_radius: values["spectral_radius"].as_f64().unwrap(),
    }
}

/// All words of the table.
#[must_use]
pub fn words() -> Vec<WordCase> {
    let table: Value = serde_json::from_str(include_str!("../../../tests/data/words.json")).unwrap();
    let lists = ["reversible", "forced"].map(|key| table[key].as_array().unwrap());
    let cases: Vec<_> = lists.into_iter().flatten().map(case).collect();
    assert!(cases.len() >= 54, "{}", cases.len());
    cases
}

impl Random {
    /// A word of one or two instants at up to four sites.
    pub fn word(&mut self, chain: &Chain) -> Option<Word> {
        let mut instants = vec![Vec::new(), Vec::new()];
        for _ in 0..1 + self.below(4) {
            let (site, layer) = chain.layout().place(self.below(chain.sites()));
            let barriers =
                if self.chance(0.5) { [Barrier::Upper, Barrier::Lower] } else { [Barrier::Lower, Barrier::Upper] };
            let double = self.chance(0.6);
            let first = self.below(2);
            for (i, barrier) in barriers.into_iter().enumerate() {
                if double || i == first {
                    instants[i].push(Letter { site, layer, barrier });
                }
            }
        }
        instants.retain(|letters| !letters.is_empty());
        Word::new(instants).ok()
    }
}
