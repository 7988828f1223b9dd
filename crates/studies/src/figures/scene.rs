//! Scenes of figures: a map is an ordinary sweep scene, everything else has a `[figure]` table that says what kind it is.

use serde::Deserialize;
use vibrochain_breather::Family;
use vibrochain_lattice::{Layout, MAX_SITES, Model, Parameter, Point, Short};

use crate::figures::library::Entry;
use vibrochain_cli::common::error::CliError;
use vibrochain_maps::caption::in_common;
use vibrochain_maps::scene::{Scene, Source};

/// A scene that has been read and checked.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum FigureScene {
    /// A map over two parameters.
    Map(Box<Scene>),
    /// Anything else.
    Lines(Box<LineScene>),
}

/// Curves at one or several points of the parameter space.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct LineScene {
    pub(super) title: String,
    pub(super) family: Family,
    pub(super) kind: Kind,
    /// The points, each with what sets it apart from the others ("a = 0.2").
    pub(super) curves: Vec<(String, Point, Model)>,
}

impl LineScene {
    /// The title, and the parameters that are fixed.
    pub(super) fn heading(&self) -> String {
        let models: Vec<_> = self.curves.iter().map(|(_, _, model)| model).collect();
        format!("{}: {}", self.title, in_common(&models))
    }
}

/// What is drawn.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Kind {
    /// Displacements of all masses at the impacts.
    Profile {
        /// Sites shown on either side of the breather; absent: all.
        reach: Option<i64>,
    },
    /// The impacting mass over a period.
    Trace,
    /// All solutions at one point, a(φ), and the solutions over one more parameter.
    Solutions {
        /// The parameter and its range.
        over: Parameter,
        from: f64,
        to: f64,
        points: usize,
    },
    /// A simulation from a perturbed orbit beside the orbit.
    Comparison {
        /// Size of the perturbation along the leading Floquet mode.
        perturb: f64,
        /// Periods of the force.
        periods: u64,
        /// Periods in each of the two windows shown.
        shown: u64,
        /// Where the second window begins.
        late: u64,
    },
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    figure: FigureTable,
    model: ValuesTable,
    #[serde(default)]
    curves: Vec<ValuesTable>,
}

#[derive(Deserialize)]
#[serde(tag = "kind", rename_all = "kebab-case", deny_unknown_fields)]
enum FigureTable {
    Profile { title: String, family: FamilyWord, reach: Option<i64> },
    Trace { title: String, family: FamilyWord },
    Solutions { title: String, family: FamilyWord, over: OverTable },
    Comparison { title: String, family: FamilyWord, perturb: f64, periods: u64, shown: u64, late: Option<u64> },
}

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
enum FamilyWord {
    DoubleSided,
    SingleSided,
    PeriodDoubled,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct OverTable {
    parameter: String,
    from: f64,
    to: f64,
    points: usize,
}

/// Parameters of the model; in `[[curves]]` those that differ.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ValuesTable {
    sites: Option<i64>,
    gamma1: Option<f64>,
    gamma2: Option<f64>,
    omega: Option<f64>,
    asymmetry: Option<f64>,
    forcing: Option<ForcingTable>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct ForcingTable {
    amplitude: Option<f64>,
    restitution: Option<f64>,
}

impl ValuesTable {
    fn values(&self) -> [Option<f64>; 6] {
        let forcing = self.forcing.as_ref();
        let (amplitude, restitution) = (forcing.and_then(|f| f.amplitude), forcing.and_then(|f| f.restitution));
        [self.gamma1, self.gamma2, self.omega, self.asymmetry, amplitude, restitution]
    }
}

/// The most curves of a figure, and points of one.
const MOST: usize = 2000;

/// The most periods of a comparison: minutes.
const MOST_PERIODS: u64 = 1_000_000;

/// Reads and checks a figure's scene.
///
/// # Errors
/// [`CliError::Request`], pointing into the file.
pub(super) fn parse(entry: &Entry) -> Result<FigureScene, CliError> {
    let source = Source { path: &entry.path, text: &entry.text };
    let table: toml::Table = toml::from_str(&entry.text).map_err(|error| source.unreadable(&error))?;
    if !table.contains_key("figure") {
        return Ok(FigureScene::Map(Box::new(Scene::parse(&entry.path, &entry.text)?)));
    }
    let wrong = |what: String| CliError::Request(format!("{}: {what}", entry.path.display()));
    let file: File = toml::from_str(&entry.text).map_err(|error| source.unreadable(&error))?;
    let (title, family, kind) = match file.figure {
        FigureTable::Profile { title, family, reach } => {
            if let Some(reach) = reach.filter(|reach| *reach < 1) {
                return Err(wrong(format!("reach = {reach} is out of range: give 1 or more")));
            }
            (title, family, Kind::Profile { reach })
        }
        FigureTable::Trace { title, family } => (title, family, Kind::Trace),
        FigureTable::Solutions { title, family, over } => {
            let parameter = Parameter::from_name(&over.parameter).ok_or_else(|| {
                let known = Parameter::ALL.map(Parameter::name).join(", ");
                wrong(format!("`{}` is not a parameter: give one of {known}", over.parameter))
            })?;
            let (from, to, points) = (over.from, over.to, over.points);
            if !(from.is_finite() && to.is_finite() && from < to && (2..=MOST).contains(&points)) {
                let range = format!("from = {}, to = {}, points = {points}", Short(from), Short(to));
                return Err(wrong(format!("{range}: give finite values with from < to and 2 to {MOST} points")));
            }
            (title, family, Kind::Solutions { over: parameter, from, to, points })
        }
        FigureTable::Comparison { title, family, perturb, periods, shown, late } => {
            if !(perturb.is_finite() && perturb > 0.0) {
                return Err(wrong(format!("perturb = {} is out of range: give a finite size above 0", Short(perturb))));
            }
            if shown < 1 || periods < shown || periods > MOST_PERIODS {
                let range = format!("shown = {shown}, periods = {periods}");
                return Err(wrong(format!("{range}: give 1 ≤ shown ≤ periods ≤ {MOST_PERIODS}")));
            }
            // The end of the run, if the scene does not say otherwise.
            let last = periods - shown;
            let late = late.unwrap_or(last);
            if late > last {
                return Err(wrong(format!("late = {late} is out of range: give at most periods - shown = {last}")));
            }
            (title, family, Kind::Comparison { perturb, periods, shown, late })
        }
    };
    let family = match family {
        FamilyWord::DoubleSided => Family::DoubleSided,
        FamilyWord::SingleSided => Family::SingleSided,
        FamilyWord::PeriodDoubled => Family::PeriodDoubled,
    };
    if file.curves.len() > MOST {
        return Err(wrong(format!("{} curves are too many: give at most {MOST}", file.curves.len())));
    }
    let base = file.model.values();
    let conservative = file.model.forcing.is_none() && file.curves.iter().all(|curve| curve.forcing.is_none());
    let own = [ValuesTable { sites: None, gamma1: None, gamma2: None, omega: None, asymmetry: None, forcing: None }];
    let mut curves = Vec::new();
    for curve in if file.curves.is_empty() { &own[..] } else { &file.curves } {
        let sites = curve.sites.or(file.model.sites).ok_or_else(|| wrong("sites is missing in [model]".to_owned()))?;
        let sites = usize::try_from(sites).ok().filter(|sites| (1..=MAX_SITES).contains(sites)).ok_or_else(|| {
            wrong(format!("sites = {sites} is out of range: give a whole number from 1 to {MAX_SITES}"))
        })?;
        let mut point = Point::of(Layout::ring(sites));
        let mut label: Vec<String> = curve.sites.map(|_| format!("N = {}", sites - 1)).into_iter().collect();
        for (parameter, own) in Parameter::of(1).iter().copied().zip(curve.values()) {
            let without_force = match parameter {
                Parameter::Amplitude if conservative => Some(0.0),
                Parameter::Restitution if conservative => Some(1.0),
                _ => None,
            };
            let value = own.or(base[parameter as usize]).or(without_force);
            let value = value.ok_or_else(|| wrong(format!("{} is missing in [model]", parameter.name())))?;
            point = point.with(parameter, value);
            label.extend(own.map(|value| format!("{} = {value}", parameter.symbol())));
        }
        let model = point.model().map_err(|error| wrong(error.to_string()))?;
        curves.push((label.join(", "), point, model));
    }
    Ok(FigureScene::Lines(Box::new(LineScene { title, family, kind, curves })))
}

#[cfg(test)]
mod tests {
    use std::path::PathBuf;

    use super::*;
    use crate::figures::library::built_in;

    fn read(text: &str) -> Result<FigureScene, String> {
        let entry = Entry { id: "0".to_owned(), path: PathBuf::from("figure-0.toml"), text: text.to_owned() };
        parse(&entry).map_err(|error| {
            assert_eq!(error.exit_code(), 2);
            error.to_string()
        })
    }

    const PROFILE: &str = r#"
        [figure]
        kind = "profile"
        title = "Breathers"
        family = "double-sided"
        reach = 10
        [model]
        sites = 21
        gamma1 = 0.2
        gamma2 = 0.1
        omega = 1.5
        asymmetry = 0.4
        [[curves]]
        sites = 11
        asymmetry = 0.0
    "#;

    #[test]
    fn all_scenes_built_in_are_sound() {
        for entry in built_in() {
            let scene = parse(&entry).unwrap_or_else(|error| panic!("{error}"));
            assert_eq!(matches!(scene, FigureScene::Map(_)), entry.id.starts_with("10") || entry.id.starts_with("15"));
        }
    }

    #[test]
    fn curves_take_over_what_they_do_not_say() {
        let Ok(FigureScene::Lines(scene)) = read(PROFILE) else { panic!("not a line scene") };
        let (label, point, model) = &scene.curves[0];
        assert_eq!((label.as_str(), point.sites(), point.get(Parameter::Omega)), ("N = 10, a = 0", 11, 1.5));
        assert!(model.is_conservative() && scene.kind == Kind::Profile { reach: Some(10) });
    }

    #[test]
    fn wrong_scenes_are_told_what_is_wrong() {
        for (from, to, message) in [
            ("profile", "portrait", "unknown variant `portrait`"),
            ("reach = 10", "reach = 0", "reach = 0 is out of range"),
            ("reach = 10", "reech = 10", "unknown key `reech`"),
            ("omega = 1.5", "", "omega is missing"),
            ("asymmetry = 0.4", "asymmetry = 0.4\nforcing = { amplitude = 0.1 }", "restitution is missing"),
            ("sites = 11", "sites = 0", "sites = 0 is out of range"),
            ("gamma1 = 0.2", "gamma1 = -0.2", "gamma1"),
            ("double-sided", "triple-sided", "unknown variant `triple-sided`"),
        ] {
            let answer = read(&PROFILE.replace(from, to)).unwrap_err();
            assert!(answer.contains(message) && answer.starts_with("figure-0.toml"), "{answer}");
        }
    }
}
