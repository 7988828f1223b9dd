//! The model a command is asked about: flags, a scene's file, or a file with some values changed by flags.

use vibrochain_floquet::Tolerance;
use vibrochain_lattice::{Ends, Layout, MAX_SITES, Model, Parameter, Part, Point, Short};
use vibrochain_maps::scene::{Given, tolerance_from};

use crate::args::ModelArgs;
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::structures;

/// A model, and the file it was taken from.
#[derive(Debug)]
pub struct Chosen {
    /// The model, checked.
    pub model: Model,
    /// What --scene has read; its values may have been changed.
    pub scene: Option<Given>,
    /// What flags have changed of it, for people.
    pub changed: Option<String>,
}

impl Chosen {
    /// From which excess on an orbit counts as unstable: as the flag --threshold has it, or else the scene.
    ///
    /// # Errors
    /// [`CliError::Request`] for a value out of range.
    pub fn tolerance(&self, threshold: Option<f64>) -> Result<Tolerance, CliError> {
        match threshold {
            Some(threshold) => tolerance_from(threshold).map_err(CliError::Request),
            None => Ok(self.scene.as_ref().and_then(|scene| scene.tolerance).unwrap_or(Tolerance::Rounding)),
        }
    }
}

/// [`model`], with a remark about what flags have changed of the file.
///
/// # Errors
/// As [`model`].
pub fn chosen(args: &ModelArgs, console: &mut Console<'_>) -> Result<Chosen, CliError> {
    let chosen = model(args)?;
    chosen.changed.iter().for_each(|changed| console.summary(changed));
    if let Some(remark) =
        springs(&chosen.model.chain().layout(), chosen.model.chain().gamma2()).filter(|_| args.ends.is_none())
    {
        console.summary(remark);
    }
    Ok(chosen)
}

/// What is easily overlooked of two masses that nobody has given ends.
pub(crate) fn springs(layout: &Layout, gamma2: f64) -> Option<&'static str> {
    let twice = layout.length == 2 && layout.ends == Ends::Closed && gamma2 > 0.0;
    twice.then_some("a ring of two masses has two springs of gamma2 between them: with one spring its ends are \"free\" (--ends free)")
}

/// The model of the flags and of the file they name.
///
/// # Errors
/// [`CliError::Request`] for a value out of range, one that is missing, or a file that cannot be read.
pub fn model(args: &ModelArgs) -> Result<Chosen, CliError> {
    structures::refuse(args)?;
    let scene = args.scene.as_deref().map(Given::read).transpose()?;
    let given = scene.as_ref();
    let layout = layout(args, given)?;
    let mut changed = Changed::default();
    changed.counts(args, given);
    let mut point = Point::of(layout);
    for &parameter in Parameter::of(layout.layers) {
        let flag = args.values.get(parameter);
        let there = given.and_then(|given| given.get(parameter));
        if let (Some(flag), Some(there)) = (flag, there) {
            changed.value(parameter.name(), Short(flag), Short(there), flag != there);
        }
        let value = match flag.or(there) {
            Some(value) => value,
            None => absent(args, given, parameter)?,
        };
        point = point.with(parameter, value);
    }
    let absent = |parameter: &Parameter| !Parameter::of(layout.layers).contains(parameter);
    if let Some(parameter) = Parameter::ALL.into_iter().filter(absent).find(|one| args.values.get(*one).is_some()) {
        refuse!("--{} couples layers, of which there is one: give --layers, too", parameter.flag());
    }
    // A force by its harmonics, unless the flags have a plain one.
    let amplitude = args.values.get(Parameter::Amplitude);
    let harmonics = given.and_then(|given| given.force.as_ref()).filter(|_| amplitude.is_none());
    if let Some(force) = args.force.as_ref().or(harmonics) {
        point = point.under(force);
    }
    if let Some(there) = given.and_then(|given| given.force.as_ref()) {
        match (&args.force, amplitude) {
            (Some(force), _) => changed.value("force", force, there, force != there),
            (None, Some(amplitude)) => {
                changed.value("amplitude", Short(amplitude), format_args!("force {there}"), true)
            }
            (None, None) => {}
        }
    }
    let model = point.model()?;
    let changed = given.and_then(|given| changed.told(given));
    Ok(Chosen { model, scene, changed })
}

/// What flags have changed of a file.
#[derive(Default)]
struct Changed(Vec<String>);

impl Changed {
    fn told(&self, given: &Given) -> Option<String> {
        (!self.0.is_empty()).then(|| format!("{} with {}", given.path.display(), self.0.join(", ")))
    }

    fn value(&mut self, name: &str, now: impl std::fmt::Display, there: impl std::fmt::Display, differs: bool) {
        if differs {
            self.0.push(format!("{name} = {now} (there {there})"));
        }
    }

    /// Numbers and ends.
    fn counts(&mut self, args: &ModelArgs, given: Option<&Given>) {
        let Some(Layout { length, ends: along, layers, layer_ends }) = given.map(|given| given.layout) else { return };
        for (name, flag, there) in [("sites", args.sites, length), ("layers", args.layers, layers)] {
            if let Some(flag) = flag {
                self.value(name, flag, there, usize::try_from(flag) != Ok(there));
            }
        }
        let ends = [("ends", args.lattice_ends(), along), ("layer_ends", args.layer_ends, layer_ends)];
        for (name, flag, there) in ends {
            if let Some(flag) = flag {
                self.value(name, flag.name(), there.name(), flag != there);
            }
        }
    }
}

fn layout(args: &ModelArgs, given: Option<&Given>) -> Result<Layout, CliError> {
    let count = |name: &str, flag: Option<i64>, there: Option<usize>, most: usize| {
        let Some(value) = flag else { return Ok(there.unwrap_or(1)) };
        let range = format!("{name} = {value} is out of range: give a whole number from 1 to {most}");
        usize::try_from(value).ok().filter(|count| (1..=most).contains(count)).ok_or(CliError::Request(range))
    };
    let there = given.map(|given| given.layout);
    let length = count("sites", args.sites, there.map(|there| there.length), MAX_SITES)?;
    let layers = count("layers", args.layers, there.map(|there| there.layers), MAX_SITES / length)?;
    if layers > MAX_SITES / length {
        let most = MAX_SITES / layers;
        refuse!("sites = {length} is out of range: in {layers} layers give a whole number from 1 to {most}");
    }
    Ok(Layout {
        length,
        ends: args.lattice_ends().or(there.map(|there| there.ends)).unwrap_or(Ends::Closed),
        layers,
        layer_ends: args.layer_ends.or(there.map(|there| there.layer_ends)).unwrap_or(Ends::Free),
    })
}

/// The value of a parameter that neither flags nor file give.
fn absent(args: &ModelArgs, given: Option<&Given>, parameter: Parameter) -> Result<f64, CliError> {
    let (name, flag) = (parameter.name(), parameter.flag());
    let request = |message: String| Err(CliError::Request(message));
    let forced = args.values.get(Parameter::Amplitude).is_some()
        || args.force.is_some()
        || given.is_some_and(|given| given.force.is_some() || given.get(Parameter::Amplitude).is_some());
    if parameter == Parameter::Amplitude && args.force.is_some() {
        return Ok(0.0);
    }
    if let Some((given, axis)) = given.and_then(|given| Some((given, given.axis(parameter)?))) {
        let [from, to] = axis.limits().map(Short);
        return request(format!("{name} is swept by {}, from {from} to {to}: give --{flag}", given.path.display()));
    }
    match (parameter.row().default, parameter.row().part) {
        (None, _) => request(format!("{name} is missing: give --{flag}")),
        (Some(default), Part::Dashpots) => Ok(default),
        (Some(_), Part::Layers) => request(format!("{name} is missing: layers need --{flag}")),
        (Some(_), Part::Driving) if forced && parameter != Parameter::Amplitude => {
            request(format!("{name} is missing: a force needs --{flag}"))
        }
        (Some(default), _) => Ok(default),
    }
}
