//! The model that a command is asked about, and which of its breathers.

use std::path::PathBuf;

use clap::{Arg, ArgMatches, Args, Command, FromArgMatches, ValueEnum};
use vibrochain_breather::{Family, MAX_IMPACTS, Word};
use vibrochain_lattice::{DampedParameter, Ends, Force, Parameter, Row, RowEnds};
use vibrochain_maps::numbers::{real, whole};

use super::quantity::{Meanings, by_name};

/// Headings of help, which each flag names ([`PICTURES`](crate::common::pictures::page_args::PICTURES)).
const MODEL: &str = "Model";
const WHICH: &str = "Breathers";
const DAMPED: &str = "Loads and stops of a structure";

/// Families, and what each is.
const FAMILIES: Meanings<Family> = &[
    (Family::DoubleSided, "One impact on each barrier a period"),
    (Family::SingleSided, "One impact a period, on the nearer barrier"),
    (Family::PeriodDoubled, "Two different impacts on the nearer barrier in two periods of the force"),
];

/// What stands at the ends of a chain; and below the first and above the last layer.
const ENDS: Meanings<RowEnds> = &[
    (RowEnds::Alike(Ends::Closed), "Each other: a ring"),
    (RowEnds::Alike(Ends::Free), "Nothing"),
    (RowEnds::Alike(Ends::Fixed), "Walls, to which springs go as between neighbours"),
    (
        RowEnds::FixedFree,
        "A wall before the first mass, nothing behind the last one: a chain that is asked as a structure",
    ),
];
const LAYER_ENDS: Meanings<Ends> = &[(Ends::Closed, "Each other"), (Ends::Free, "Nothing")];

/// The model: its parameters as flags, or a scene's, some of them changed by flags.
#[derive(Debug, Clone, Args)]
pub struct ModelArgs {
    /// Take the model from a file: a scene, a manifest, a file with `[model]` alone, or what --json has printed, whose orbit is then the
    /// one to start near. Flags change its values; what the scene sweeps they must give.
    #[arg(long, help_heading = MODEL, display_order = 0, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Number of masses of the ring (the paper's N + 1), or of one layer. A ring of two has two springs between them: --ends free has one.
    #[arg(long, help_heading = MODEL, display_order = 1, value_name = "M", required_unless_present = "scene", value_parser = whole::<i64>, allow_negative_numbers = true)]
    pub sites: Option<i64>,
    /// Each parameter's.
    #[command(flatten)]
    pub values: ParameterArgs,
    /// Force of several odd harmonics, instead of --amplitude: number:amplitude:phase of each, as in 1:0.1:0,3:0.03:1.57
    /// for 0.1 cos ω(t+ψ) + 0.03 cos(3ω(t+ψ) + 1.57).
    #[arg(long, help_heading = MODEL, display_order = place(Parameter::Amplitude) + 1, value_name = "J:A:θ,…", conflicts_with = "amplitude")]
    pub force: Option<Force>,
    /// What stands at the ends of the chain: each other, nothing, or walls [default: closed].
    #[arg(long, help_heading = MODEL, display_order = place(Parameter::Restitution) + 1, value_parser = by_name(ENDS, RowEnds::name))]
    pub ends: Option<RowEnds>,
    /// Number of equal chains side by side, coupled mass by mass [default: 1].
    #[arg(long, help_heading = MODEL, display_order = place(Parameter::Restitution) + 2, value_name = "L", value_parser = whole::<i64>, allow_negative_numbers = true)]
    pub layers: Option<i64>,
    /// Stops of their own, or numbers of a scene's structure.
    #[command(flatten)]
    pub structure: StructureArgs,
    /// Whether the last layer is the first one's neighbour, too [default: free].
    #[arg(long, help_heading = MODEL, display_order = place(Parameter::Gamma3) + 1, value_parser = by_name(LAYER_ENDS, Ends::name))]
    pub layer_ends: Option<Ends>,
}

impl ModelArgs {
    /// The ends of a lattice, if they are alike: others are a structure's.
    #[must_use]
    pub fn lattice_ends(&self) -> Option<Ends> {
        match self.ends? {
            RowEnds::Alike(ends) => Some(ends),
            RowEnds::FixedFree => None,
        }
    }

    /// The first of the flags that makes a chain a structure: of dashpots those without a force, with which it may have a period of its own.
    #[must_use]
    pub fn of_structures(&self) -> Option<String> {
        let own = DampedParameter::ALL.into_iter().find(|one| self.values.own(*one).is_some());
        let is_forced = self.values.get(Parameter::Amplitude).is_some() || self.force.is_some() || self.scene.is_some();
        let dashpots = [Parameter::Damping, Parameter::CouplingDamping].into_iter().filter(|_| !is_forced);
        let dashpot = dashpots.into_iter().find(|one| self.values.get(*one).is_some());
        let others =
            [("stops", !self.structure.stops.is_empty()), ("ends fixed-free", self.ends == Some(RowEnds::FixedFree))];
        let other = others.into_iter().find(|(_, given)| *given).map(|(name, _)| name.to_owned());
        own.map(DampedParameter::flag).or(dashpot.map(Parameter::flag)).or(other)
    }
}

/// Where the flag of a parameter stands in help, among the other flags of a model.
fn place(parameter: Parameter) -> usize {
    10 * (1 + parameter as usize)
}

/// The same of one that chains have beside those of a model.
fn own_place(parameter: DampedParameter) -> usize {
    10 * (1 + parameter as usize)
}

/// Values of parameters: flags made from the table of parameters.
#[derive(Debug, Clone, Default)]
pub struct ParameterArgs {
    /// In the order of [`Parameter::ALL`].
    plain: [Option<f64>; Parameter::ALL.len()],
    /// In the order of [`DampedParameter::ALL`].
    own: [Option<f64>; DampedParameter::ALL.len()],
}

impl ParameterArgs {
    /// The value that a flag gives.
    pub fn get(&self, parameter: Parameter) -> Option<f64> {
        self.plain[parameter as usize]
    }

    /// The value that a flag of chains as structures gives.
    pub fn own(&self, parameter: DampedParameter) -> Option<f64> {
        self.own[parameter as usize]
    }
}

/// The flag of a parameter.
fn flag(row: &'static Row, name: String, heading: &'static str, place: usize) -> Arg {
    let flag = Arg::new(row.name).long(name).value_name(row.symbol).help(row.help).help_heading(heading);
    flag.display_order(place).value_parser(real).allow_negative_numbers(true)
}

impl Args for ParameterArgs {
    fn augment_args(command: Command) -> Command {
        let plain = Parameter::ALL.map(|parameter| {
            let flag = flag(parameter.row(), parameter.flag(), MODEL, place(parameter));
            match parameter {
                _ if parameter.row().default.is_some() => flag,
                Parameter::Asymmetry => flag.required_unless_present_any(["scene", "lower", "upper"]),
                _ => flag.required_unless_present("scene"),
            }
        });
        let own = DampedParameter::ALL;
        command.args(plain).args(own.map(|one| flag(one.row(), one.flag(), DAMPED, own_place(one))))
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for ParameterArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        let value = |name: &str| matches.get_one(name).copied();
        let plain = Parameter::ALL.map(|parameter| value(parameter.name()));
        Ok(Self { plain, own: DampedParameter::ALL.map(|parameter| value(parameter.name())) })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), clap::Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}

/// Which masses of a chain have stops, and other numbers of a scene's structure.
#[derive(Debug, Clone, Default, Args)]
pub struct StructureArgs {
    /// Sites that have stops, a list with a comma [default: all].
    #[arg(long, help_heading = DAMPED, display_order = own_place(DampedParameter::StaticForce) + 1, value_name = "SITE,…", value_delimiter = ',', value_parser = whole::<usize>)]
    pub stops: Vec<usize>,
    /// Another number of a scene's structure: omega, load, static, damping, contact.N.lower, contact.N.upper, contact.N.restitution; of
    /// matrices masses.I, mass.I.J, stiffness.I.J, damping.I.J, load.I, static.I.
    #[arg(long, help_heading = DAMPED, display_order = own_place(DampedParameter::Upper) + 1, value_name = "NAME=VALUE")]
    pub set: Vec<String>,
}

/// Which breathers: of a family, of any impact word, or near a given one. With --scene: the one family or word of the scene, or the orbit
/// of the file, if none of them is given.
#[derive(Debug, Clone, Args)]
#[group(skip)]
pub struct WhichArgs {
    /// Family of breathers.
    #[arg(long, help_heading = WHICH, value_parser = by_name(FAMILIES, Family::name), group = "which")]
    pub family: Option<Family>,
    /// Breathers of an impact word: instants separated by commas or spaces, each one or more impacts, SITE+ on the upper or SITE- on
    /// the lower barrier, as in "0+3+,0-3-" for two masses in phase; SITE:LAYER+ where there are layers.
    #[arg(long, help_heading = WHICH, value_name = "WORD", group = "which")]
    pub word: Option<Word>,
    /// Periods of the force in one period of the word [default: 1; of `0-,0-`, the doubled family, 2].
    #[arg(long, help_heading = WHICH, value_name = "N", value_parser = force_periods, allow_negative_numbers = true)]
    pub force_periods: Option<u32>,
    /// The breather near that of a file, as `mapgen orbit --json` writes it (its first solution), an object with `impacts`
    /// (site, barrier, time, impulse), `psi` and, of more than one period of the force, `period`, or the table that `mapgen simulate
    /// --impacts` has written of a run that has settled on one.
    #[arg(long, help_heading = WHICH, value_name = "FILE", group = "which")]
    pub near: Option<PathBuf>,
}

/// A number of periods: every mass hits at least once in them, and a word has room for so many impacts.
fn force_periods(text: &str) -> Result<u32, String> {
    let most = u32::try_from(MAX_IMPACTS).unwrap_or(u32::MAX);
    match whole(text)? {
        periods if (1..=most).contains(&periods) => Ok(periods),
        periods => Err(format!("{periods} is out of range: a word takes 1 to {most} periods of the force")),
    }
}

/// What a site of a word does.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum SiteFamily {
    /// One impact on each barrier a period.
    DoubleSided,
    /// One impact a period, on the nearer barrier.
    SingleSided,
    /// Each of the two.
    Either,
}
