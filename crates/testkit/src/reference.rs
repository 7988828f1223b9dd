//! The table of checked numbers (tests/data/reference.json).

use serde_json::Value;
use vibrochain_breather::Family;
use vibrochain_lattice::{Chain, Model};

/// One case of the table.
#[derive(Debug, Clone)]
pub struct Case {
    /// What the table calls it.
    pub name: String,
    /// Its parameters.
    pub model: Model,
    /// The family that its orbit belongs to.
    pub family: Family,
    /// All that the table says of it.
    pub values: Value,
}

impl Case {
    /// A number of the table, where it has one.
    #[must_use]
    pub fn number(&self, key: &str) -> Option<f64> {
        self.values[key].as_f64()
    }
}

fn case(values: &Value) -> Case {
    let parameter = |name: &str| values["parameters"][name].as_f64();
    let sites = values["parameters"]["sites"].as_u64().unwrap() as usize;
    let chain = Chain::new(sites, parameter("gamma1").unwrap(), parameter("gamma2").unwrap()).unwrap();
    let (amplitude, restitution) = (parameter("amplitude").unwrap_or(0.0), parameter("restitution").unwrap_or(1.0));
    let (omega, asymmetry) = (parameter("omega").unwrap(), parameter("asymmetry").unwrap());
    let model =
        chain.point().omega(omega).asymmetry(asymmetry).amplitude(amplitude).restitution(restitution).model().unwrap();
    let doubled = (values["period"].as_f64().unwrap() / model.period()).round() as u32 == 2;
    let family = match (values["p"].as_f64(), doubled) {
        (Some(_), _) => Family::SingleSided,
        (None, true) => Family::PeriodDoubled,
        (None, false) => Family::DoubleSided,
    };
    Case { name: values["name"].as_str().unwrap().to_owned(), model, family, values: values.clone() }
}

/// All cases of the table.
#[must_use]
pub fn reference() -> Vec<Case> {
    let text = include_str!("../../../tests/data/reference.json");
    let table: Value = serde_json::from_str(text).unwrap();
    let cases: Vec<Case> = table["cases"].as_array().unwrap().iter().map(case).collect();
    assert!(cases.len() >= 26, "{}", cases.len());
    cases
}
