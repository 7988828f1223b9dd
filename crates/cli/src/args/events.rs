//! What happens as parameters vary: `locate`, `branch`, `curve`, `curves`.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use clap::builder::{PossibleValue, TypedValueParser};
use clap::{Arg, ArgGroup, Args, Command};
use vibrochain_floquet::Event;
use vibrochain_lattice::Parameter;
use vibrochain_maps::hints::meant;
use vibrochain_maps::numbers::{real, whole};
use vibrochain_maps::structure::Setting;

use super::model::{ModelArgs, WhichArgs};
use super::quantity::{Meanings, OF_BRANCHES, QuantityName, SHOWN_NAMES, among, by_name};
use crate::common::error::CliError;
use crate::common::pictures::page_args::{PICTURES, PageArgs};

/// Events of `mapgen locate`, and what each is.
const EVENTS: Meanings<Event> = &[
    (Event::Grazing, "A mass touches a barrier from inside, or an impact loses its velocity"),
    (
        Event::Pitchfork,
        "A multiplier meets +1 and the branch goes on; without force and losses also where the energy is extreme",
    ),
    (Event::PeriodDoubling, "A multiplier meets −1"),
    (Event::NeimarkSacker, "A complex pair of multipliers crosses the circle; without loss, two pairs collide on it"),
    (Event::Fold, "The branch turns back"),
    (Event::Sticking, "The acceleration after a plastic impact turns: the contact begins to rest"),
];

/// What varies: a parameter, or a number that only structures have.
#[derive(Debug, Clone, PartialEq)]
pub enum Free {
    /// A parameter of chains, by whose name structures have a number, too.
    Parameter(Parameter),
    /// A number of structures.
    Setting(Setting),
    /// Neither: what there is instead depends on the model.
    Unknown(String),
}

impl Free {
    /// Of a chain.
    pub(crate) fn parameter(&self) -> Result<Parameter, CliError> {
        match self {
            Self::Parameter(parameter) => Ok(*parameter),
            Self::Setting(setting) => {
                refuse!("{setting} is a number of structures: give --scene with [structure], or dashpots by --damping")
            }
            Self::Unknown(name) => {
                let names = Parameter::ALL.map(Parameter::name);
                let meant = meant(name, names);
                refuse!("`{name}` is no parameter of a chain: {meant}give one of {}", names.join(", "))
            }
        }
    }

    /// Of a structure.
    pub(crate) fn setting(&self) -> Result<Setting, CliError> {
        match self {
            Self::Parameter(parameter) => parameter.name().parse().map_err(CliError::Request),
            Self::Setting(setting) => Ok(*setting),
            Self::Unknown(name) => name.parse().map_err(CliError::Request),
        }
    }
}

/// Takes the name of what can be varied, as scenes and tables have it: of a parameter, or of any number of a structure.
#[derive(Clone)]
struct FreeParser;

impl TypedValueParser for FreeParser {
    type Value = Free;

    fn parse_ref(&self, _: &Command, _: Option<&Arg>, value: &OsStr) -> Result<Free, clap::Error> {
        let text = value.to_string_lossy();
        let parameter = Parameter::from_name(&text).map(Free::Parameter);
        Ok(parameter
            .or_else(|| text.parse().ok().map(Free::Setting))
            .unwrap_or_else(|| Free::Unknown(text.into_owned())))
    }

    fn possible_values(&self) -> Option<Box<dyn Iterator<Item = PossibleValue> + '_>> {
        let value = |parameter: Parameter| PossibleValue::new(parameter.name()).help(parameter.symbol());
        Some(Box::new(Parameter::ALL.map(value).into_iter()))
    }
}

/// Where a branch is taken up, and how far it is followed.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("start").args(["family", "word", "near", "scene"]).required(true).multiple(true))]
pub struct AlongArgs {
    /// What varies: a parameter, or of a structure any number of it, as in contact.0.upper, load, damping or stiffness.1.2.
    #[arg(long, value_parser = FreeParser)]
    pub free: Free,
    /// Least value of the free parameter [default: the lower end of its axis in --scene, or else half its start; asymmetry 0, restitution 0.05].
    #[arg(long, value_name = "VALUE", value_parser = real, allow_negative_numbers = true)]
    pub from: Option<f64>,
    /// Largest value of the free parameter [default: the upper end of its axis in --scene, or else twice its start; asymmetry 0.99, restitution 1].
    #[arg(long, value_name = "VALUE", value_parser = real, allow_negative_numbers = true)]
    pub to: Option<f64>,
    /// Which breathers.
    #[command(flatten)]
    pub which: WhichArgs,
    /// Which of several solutions to start from, numbered as `mapgen orbit` lists them [default: the first physical one].
    #[arg(long, value_name = "K", value_parser = whole::<usize>, allow_negative_numbers = true)]
    pub solution: Option<usize>,
    /// The model.
    #[command(flatten)]
    pub model: ModelArgs,
}

impl AlongArgs {
    /// The files that are read, by their flags: none of them is written to.
    pub(crate) fn reads(&self) -> [(&'static str, Option<&Path>); 2] {
        [("--scene", self.model.scene.as_deref()), ("--near", self.which.near.as_deref())]
    }
}

/// Arguments of `mapgen locate`.
#[derive(Debug, Args)]
#[command(
    after_help = "The flags of the model give the start, the free parameter's included. The branch through it is followed both \
                  ways, to the ends of the range or its own; every event on it is an answer, and so is that there is none."
)]
pub struct LocateArgs {
    /// What to look for.
    #[arg(long, value_parser = by_name(EVENTS, Event::name))]
    pub event: Event,
    /// Where, along what, how far.
    #[command(flatten)]
    pub along: AlongArgs,
    /// The events as a table (CSV).
    #[arg(long, alias = "csv", value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `mapgen branch`.
#[derive(Debug, Args)]
#[command(
    after_help = "The flags of the model give the start, the free parameter's included. The branch through it is followed both \
                  ways, round its folds, to the ends of the range or its own. Every step is looked at in its middle and halved \
                  where two events could hide in it. Multipliers come from dense matrices, which takes long from a hundred masses on; \
                  --events grazing,fold needs none."
)]
pub struct BranchArgs {
    /// Where, along what, how far.
    #[command(flatten)]
    pub along: AlongArgs,
    /// Events to look for, a list with commas [default: all].
    #[arg(long, value_parser = by_name(EVENTS, Event::name), value_delimiter = ',')]
    pub events: Vec<Event>,
    /// Go on along what branches off at period doublings, pitchforks and grazing.
    #[arg(long)]
    pub switch: bool,
    /// How often a branch may leave another.
    #[arg(long, value_name = "K", default_value_t = 1, requires = "switch", value_parser = whole::<u32>, allow_negative_numbers = true)]
    pub generations: u32,
    /// Also what is not physical, in text and picture.
    #[arg(long)]
    pub all: bool,
    /// Excess per period, |μ| − 1, below which a breather counts as stable [default: strict].
    #[arg(long, value_name = "EXCESS", value_parser = real, allow_negative_numbers = true)]
    pub threshold: Option<f64>,
    /// Points and events as a table (CSV).
    #[arg(long, alias = "csv", value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Picture of the diagram, .png, .svg or .pdf: solid stable, dashed unstable; with --all, thin not physical.
    #[arg(long, help_heading = PICTURES, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// How it is made.
    #[command(flatten)]
    pub page: PageArgs,
    /// What the picture shows, a list with commas.
    #[arg(long, help_heading = PICTURES, value_name = "QUANTITY", value_delimiter = ',', default_value = SHOWN_NAMES, requires = "plot", value_parser = among(&OF_BRANCHES))]
    pub show: Vec<QuantityName>,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `mapgen curve`.
#[derive(Debug, Args)]
#[command(
    after_help = "The flags of the model give the start, both varied parameters included. From there the event is looked for along the \
                  first, as `mapgen locate` does; every one that is found is followed both ways in the window of both, round turning \
                  points, to the window's edge or its own end. Errors, and how far a straight line between neighbouring points may be \
                  from the curve, are parts of the window's sides. Multipliers come from dense matrices."
)]
pub struct CurveArgs {
    /// What to look for and to follow.
    #[arg(long, value_parser = by_name(EVENTS, Event::name))]
    pub event: Event,
    /// Where, along what, how far.
    #[command(flatten)]
    pub along: AlongArgs,
    /// The second that varies.
    #[arg(long, value_parser = FreeParser)]
    pub and: Free,
    /// Least value of the second parameter [default: as of the first].
    #[arg(long, value_name = "VALUE", value_parser = real, allow_negative_numbers = true)]
    pub and_from: Option<f64>,
    /// Largest value of the second parameter [default: as of the first].
    #[arg(long, value_name = "VALUE", value_parser = real, allow_negative_numbers = true)]
    pub and_to: Option<f64>,
    /// How far a straight line between two neighbouring points may be from the curve, as a part of the window's sides.
    #[arg(long, value_name = "PART", default_value_t = 1e-6, value_parser = real, allow_negative_numbers = true)]
    pub tolerance: f64,
    /// Points of all curves as a table (CSV).
    #[arg(long, alias = "csv", value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Picture of the curves, .png, .svg or .pdf: solid where the orbit is physical.
    #[arg(long, help_heading = PICTURES, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// How it is made.
    #[command(flatten)]
    pub page: PageArgs,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
}

/// Arguments of `mapgen curves`.
#[derive(Debug, Args)]
#[command(
    after_help = "Stripes of conservative breathers are found by the modes that meet, with both edges, however thin. What a coarse \
                  look at the window shows besides is enclosed between two neighbouring places; the event there is located and followed \
                  both ways. At last the window is cut by all borders, and what is left in the faces is asked the same question. \
                  Where the scene allows some excess, stability is lost at no event: that border is traced by the excess. Errors, and how far a straight line between \
                  neighbouring points may be from its border, are parts of the window's sides."
)]
pub struct CurvesArgs {
    /// Scene file (TOML) with two equally spaced axes.
    pub scene: PathBuf,
    /// Points of all borders as a table (CSV).
    #[arg(long, alias = "csv", value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Points of codimension two as a table (CSV).
    #[arg(long, value_name = "FILE")]
    pub points: Option<PathBuf>,
    /// Picture of the map by its regions, .png, .svg or .pdf: a stripe thinner than a pixel is drawn by its share.
    #[arg(long, help_heading = PICTURES, value_name = "FILE")]
    pub plot: Option<PathBuf>,
    /// How it is made.
    #[command(flatten)]
    pub page: PageArgs,
    /// Print JSON instead of text.
    #[arg(long)]
    pub json: bool,
    /// How far a straight line between two neighbouring points may be from its border, as a part of the window's sides.
    #[arg(long, value_name = "PART", default_value_t = 1e-6, value_parser = real, allow_negative_numbers = true)]
    pub tolerance: f64,
    /// Places of the window, spread by area, that are asked what lives there once all borders are known. If a piece of the window of
    /// share 3/N has lost its border, one of the N falls into it in 19 of 20 cases, and it is told.
    #[arg(long, value_name = "N", default_value_t = 100_000, value_parser = whole::<usize>, allow_negative_numbers = true)]
    pub places: usize,
    /// Excess per period, |μ| − 1, below which a breather counts as stable [default: that of the scene, or strict].
    #[arg(long, value_name = "EXCESS", value_parser = real, allow_negative_numbers = true)]
    pub threshold: Option<f64>,
}
