//! The model that a command is asked about, and which of its breathers.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use vibrochain_breather::{MAX_IMPACTS, Word};
use vibrochain_lattice::Force;
use vibrochain_maps::numbers::{real, whole};

/// Headings of help, which each flag names ([`PICTURES`](crate::common::page_args::PICTURES)).
const MODEL: &str = "Model";
const WHICH: &str = "Breathers";

/// Families as named on the command line.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum FamilyName {
    /// One impact on each barrier a period.
    DoubleSided,
    /// One impact a period, on the nearer barrier.
    SingleSided,
    /// Two different impacts on the nearer barrier in two periods of the force.
    PeriodDoubled,
}

/// The model: its parameters as flags, or a scene's, some of them changed by flags.
#[derive(Debug, Args)]
pub struct ModelArgs {
    /// Take the model from a file: a scene, a manifest, a file with `[model]` alone, or what --json has printed, whose orbit is then the
    /// one to start near. Flags change its values; what the scene sweeps they must give.
    #[arg(long, help_heading = MODEL, value_name = "FILE")]
    pub scene: Option<PathBuf>,
    /// Number of masses of the ring (the paper's N + 1), or of one layer. A ring of two has two springs between them: --ends free has one.
    #[arg(long, help_heading = MODEL, value_name = "M", required_unless_present = "scene", value_parser = whole::<i64>, allow_negative_numbers = true)]
    pub sites: Option<i64>,
    /// On-site stiffness γ₁.
    #[arg(long, help_heading = MODEL, value_name = "γ₁", required_unless_present = "scene", value_parser = real, allow_negative_numbers = true)]
    pub gamma1: Option<f64>,
    /// Coupling stiffness γ₂.
    #[arg(long, help_heading = MODEL, value_name = "γ₂", required_unless_present = "scene", value_parser = real, allow_negative_numbers = true)]
    pub gamma2: Option<f64>,
    /// Frequency ω of the force, and of the map.
    #[arg(long, help_heading = MODEL, value_name = "ω", required_unless_present = "scene", value_parser = real, allow_negative_numbers = true)]
    pub omega: Option<f64>,
    /// Centre a of the gap, 0 ≤ a < 1.
    #[arg(long, help_heading = MODEL, value_name = "a", required_unless_present = "scene", value_parser = real, allow_negative_numbers = true)]
    pub asymmetry: Option<f64>,
    /// Amplitude A of the force A cos ω(t+ψ) [default: no force].
    #[arg(long, help_heading = MODEL, value_name = "A", value_parser = real, allow_negative_numbers = true)]
    pub amplitude: Option<f64>,
    /// Force of several odd harmonics, instead of --amplitude: number:amplitude:phase of each, as in 1:0.1:0,3:0.03:1.57
    /// for 0.1 cos ω(t+ψ) + 0.03 cos(3ω(t+ψ) + 1.57).
    #[arg(long, help_heading = MODEL, value_name = "J:A:θ,…", conflicts_with = "amplitude", value_parser = vibrochain_maps::force::parse)]
    pub force: Option<Force>,
    /// Coefficient e of restitution, 0 < e ≤ 1 [default without force: 1].
    #[arg(long, help_heading = MODEL, value_name = "e", value_parser = real, allow_negative_numbers = true)]
    pub restitution: Option<f64>,
    /// What stands at the ends of the chain: each other, nothing, or walls [default: closed].
    #[arg(long, help_heading = MODEL, value_enum)]
    pub ends: Option<EndsName>,
    /// Number of equal chains side by side, coupled mass by mass [default: 1].
    #[arg(long, help_heading = MODEL, value_name = "L", value_parser = whole::<i64>, allow_negative_numbers = true)]
    pub layers: Option<i64>,
    /// Coupling stiffness γ₃ between layers.
    #[arg(long, help_heading = MODEL, value_name = "γ₃", value_parser = real, allow_negative_numbers = true)]
    pub gamma3: Option<f64>,
    /// Whether the last layer is the first one's neighbour, too [default: free].
    #[arg(long, help_heading = MODEL, value_enum)]
    pub layer_ends: Option<LayerEndsName>,
}

/// What stands at the ends of a chain.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum EndsName {
    /// Each other: a ring.
    Closed,
    /// Nothing.
    Free,
    /// Walls, to which springs go as between neighbours.
    Fixed,
}

/// What stands below the first and above the last layer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum LayerEndsName {
    /// Each other.
    Closed,
    /// Nothing.
    Free,
}

/// Which breathers: of a family, of any impact word, or near a given one. With --scene: the one family or word of the scene, or the orbit
/// of the file, if none of them is given.
#[derive(Debug, Clone, Args)]
#[group(skip)]
pub struct WhichArgs {
    /// Family of breathers.
    #[arg(long, help_heading = WHICH, value_enum, group = "which")]
    pub family: Option<FamilyName>,
    /// Breathers of an impact word: instants separated by commas or spaces, each one or more impacts, SITE+ on the upper or SITE- on
    /// the lower barrier, as in "0+3+,0-3-" for two masses in phase; SITE:LAYER+ where there are layers.
    #[arg(long, help_heading = WHICH, value_name = "WORD", group = "which")]
    pub word: Option<Word>,
    /// Periods of the force in one period of the word [default: 1; of `0-,0-`, the doubled family, 2].
    #[arg(long, help_heading = WHICH, value_name = "N", value_parser = force_periods, allow_negative_numbers = true)]
    pub force_periods: Option<u32>,
    /// The breather near that of a file, as `mapgen orbit --json` writes it (its first solution), or an object with `impacts`
    /// (site, barrier, time, impulse), `psi` and, of more than one period of the force, `period`.
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
