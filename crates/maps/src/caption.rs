//! What captions say: of models, all that is fixed; of events, their names in words.

use vibrochain_lattice::{Model, Parameter, Part};

/// "21 masses (N = 20), γ₁ = 0.2, …": all that is fixed.
#[must_use]
pub fn describe(model: &Model) -> String {
    in_common(&[model])
}

/// The name of an event in the words of a legend.
#[must_use]
pub fn in_words(name: &str) -> String {
    match name {
        "neimark-sacker" => "Neimark–Sacker".to_owned(),
        // A ratio alone says nothing to who has not read of it.
        ratio if ratio.starts_with("1:") => format!("resonance {ratio}"),
        name => name.replace('-', " "),
    }
}

/// All that is fixed while a parameter varies.
#[must_use]
pub fn describe_without(model: &Model, free: Parameter) -> String {
    let value = model.get(free);
    let other = [value * 0.5 + 0.125, value * 0.5 + 0.0625].into_iter().find_map(|other| model.with(free, other).ok());
    other.map_or_else(|| describe(model), |other| in_common(&[model, &other]))
}

/// What several points of a figure have in common; what differs is told by its curves.
#[must_use]
pub fn in_common(models: &[&Model]) -> String {
    let parts = |model: &Model| {
        let point = model.point();
        let said = |parameter: Parameter| match (&point.force, parameter.row().part) {
            (_, Part::Driving) if model.is_conservative() => None,
            (Some(force), _) if parameter == Parameter::Amplitude => Some(format!("force {force}")),
            _ if point.tells(parameter) => Some(format!("{} = {}", parameter.symbol(), point.get(parameter))),
            _ => None,
        };
        std::iter::once(point.layout.to_string()).chain(Parameter::told().filter_map(said)).collect::<Vec<_>>()
    };
    let all: Vec<Vec<String>> = models.iter().map(|model| parts(model)).collect();
    let common = |part: &&String| all.iter().all(|parts| parts.contains(part));
    all.first().into_iter().flatten().filter(common).cloned().collect::<Vec<_>>().join(", ")
}
