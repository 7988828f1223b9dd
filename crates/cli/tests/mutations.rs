//! Damaged scenes, states and command lines, each run in this process: whatever is asked, the program ends with exit code
//! 0, 1, 2 or 3, says why, and never tells a number that is none. Every input follows from the seed and its own number.
//! Some of them, of all commands, are run by the real program under a limit of memory and of time.
//!
//! A few thousand are tried always, fifty thousand by the test `slow_…`. `MUTATIONS` (how many), `MUTATIONS_LIMITED` (how
//! many under limits), `MUTATIONS_SEED` and `MUTATIONS_WORK` (0: nothing is computed) make longer campaigns:
//!
//! ```sh
//! MUTATIONS=1000000 MUTATIONS_SEED=7 MUTATIONS_WORK=0 cargo test --workspace --test mutations -- --ignored fifty
//! ```
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

#[path = "mutation/judge.rs"]
mod judge;
#[path = "mutation/mutate.rs"]
mod mutate;

use std::ffi::OsString;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, OnceLock, PoisonError};

use tempfile::TempDir;
use vibrochain_breather::{Family, Word};
use vibrochain_cli::args::{Cli, Command, PictureArgs, read};
use vibrochain_cli::common::console::Console;
use vibrochain_cli::common::error::CliError;
use vibrochain_cli::common::model;
use vibrochain_cli::program;
use vibrochain_lattice::{Model, Stop};
use vibrochain_maps::scene::Scene;

use judge::{Outcome, complaints, file_complaints};
use mutate::Mutator;

const COUNT: u64 = 50_000;
/// Of these, what there is always time for.
const FEW: u64 = 5_000;
const SEED: u64 = 20_240_229;

/// Masses × windows of flight that a run may ask for; beyond it, it is told to stop as soon as it listens, or not computed.
const WORK: f64 = 8_000.0;

const SCENES: [&str; 6] = [
    r#"title = "two families"
[model]
sites = 5
gamma1 = 0.2
asymmetry = 0.4
[sweep]
x = { parameter = "omega", from = 0.7, to = 3.0, points = 3 }
y = { parameter = "gamma2", from = 0.0, to = 0.3, points = 2 }
[compute]
families = ["double-sided", "single-sided"]
"#,
    r#"[model]
sites = 4
gamma1 = 0.2
gamma2 = 0.1
forcing = { amplitude = 0.1, restitution = 0.9 }
[sweep]
y = { parameter = "asymmetry", from = 0.1, to = 0.9, points = 2 }
x.parameter = "omega"
x.from = 0.8
x.to = 1.9
x.points = 3
[compute]
families = ["single-sided", "double-sided"]
stability = true
threshold = 0.01
"#,
    r#"[model]
sites = 3
gamma1 = 0.2
gamma2 = 0.1
omega = 1.1
asymmetry = 0.4
forcing = {}
[sweep.x]
parameter = "amplitude"
from = 0.05
to = 0.9
points = 2
[sweep.y]
parameter = "restitution"
from = 0.2
to = 1.0
points = 2
[compute]
families = ["double-sided"]
stability = true
"#,
    r#"[model]
sites = 1
omega = 1.5
asymmetry = 0.0
[sweep]
x = { parameter = "gamma1", from = 0.1, to = 1.0, points = 2 }
y = { parameter = "gamma2", from = 0.0, to = 0.0001, points = 2 }
[compute]
families = ["double-sided"]
stability = true
"#,
    r#"[model]
sites = 2
gamma1 = 0.2
[sweep]
axes = [
    { parameter = "omega", values = [0.7, 1.1, 1.7] },
    { parameter = "gamma2", from = 0.001, to = 0.1, points = 2, spacing = "log" },
    { parameter = "asymmetry", values = [0.4, 0] },
]
[compute]
families = ["single-sided"]
"#,
    r#"[model]
sites = 3
gamma1 = 0.2
gamma2 = 0.1
asymmetry = 0.4
[sweep]
x = { parameter = "omega", from = 0.7, to = 1.7, points = 3, spacing = "linear" }
y = { parameter = "amplitude", from = 1e-3, to = 1, points = 2, spacing = "log" }
axes = [{ parameter = "restitution", values = [0.5] }]
[compute]
families = ["single-sided"]
"#,
];

const STATE: &str = r#"{"displacement": [0.1, -0.2, 0.3], "velocity": [0.5, 0.0, -1.5e0]}"#;

const SWEEP: &str = "mapgen sweep scene.toml --out map.csv --quiet --threads 1";

const MERGE: &str = "mapgen merge parts --out map.csv --quiet";

const LINES: [&str; 20] = [
    "mapgen orbit --word 0+2+,0-2- --json --sites 5 --gamma1 .2 --gamma2 .05 --omega 1.5 --asymmetry .2",
    "mapgen orbit --word 0+2-,0-2+ --sites 5 --gamma1 .2 --gamma2 .02 --omega 1.5 --asymmetry .1 --amplitude .3 --restitution .9",
    "mapgen words --sites-used 2 --reach 2 --families double-sided,single-sided --all --csv words.csv --sites 5 --gamma1 .2 --gamma2 .05 --omega .75 --asymmetry .4",
    "mapgen orbit --near state.json --sites 3 --gamma1 .2 --gamma2 .05 --omega 1.5 --asymmetry .2",
    "mapgen orbit --family double-sided --json --sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4",
    "mapgen orbit --family single-sided --sites 6 --gamma1 .2 --gamma2 .1 --omega .93 --asymmetry .4 --threshold 0.01",
    "mapgen orbit --family double-sided --json --sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .1 --restitution .9",
    "mapgen orbit --family single-sided --json --sites 4 --gamma1 .2 --gamma2 .1 --omega .92 --asymmetry .7 --amplitude .05 --restitution .9",
    "mapgen orbit --family period-doubled --sites 7 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .1582 --restitution .25",
    "mapgen orbit --family double-sided --json --sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --force 1:.1:0,3:-.033:0,5:.02:.5 --restitution .9",
    "mapgen orbit --family double-sided --sites 2 --gamma1 0 --gamma2 .1 --omega 1.3 --asymmetry 0 --amplitude 1.5 --restitution 1",
    "mapgen orbit --family double-sided --json --sites 1 --gamma1 .2 --gamma2 0 --omega .42 --asymmetry 0 --amplitude 0 --restitution 1",
    "mapgen simulate --family double-sided --sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --periods 3 --impacts impacts.csv",
    "mapgen simulate --family double-sided --sites 3 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --periods 4 --section section.csv --section-sites 0,2 --section-phase .25 --skip 1.5",
    "mapgen fate scene.toml --starts 2 --periods 12 --perturb 1e-3 --seed 3 --transient .25 --csv fate.csv --plot fate.svg",
    "mapgen fate scene.toml --periods 12 --diagram diagram.csv --points 3 --carry",
    "mapgen simulate --family single-sided --sites 4 --gamma1 .2 --gamma2 .1 --omega .93 --asymmetry .4 --periods 2 --perturb 1e-8 --direction unstable --samples 4 --trajectory trajectory.csv",
    "mapgen simulate --family double-sided --sites 3 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .1 --restitution .9 --solution 1 --perturb 1e-3 --seed 5 --max-impacts 7",
    "mapgen simulate --state state.json --psi .3 --sites 3 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .4 --restitution .5 --periods 2 --impacts impacts.csv --trajectory trajectory.csv --samples 3",
    "mapgen simulate --family single-sided --sites 3 --gamma1 .2 --gamma2 .1 --omega .92 --asymmetry .4 --force 1:.1:.3,3:.02 --restitution .9 --periods 2",
];

/// A map that stripes are drawn over.
const STRIPES: &str = r#"title = "stripes"
[model]
sites = 5
gamma1 = 0.2
asymmetry = 0.4
[sweep]
x = { parameter = "omega", from = 0.7, to = 3.0, points = 9 }
y = { parameter = "gamma2", from = 0.05, to = 0.3, points = 5 }
[compute]
families = ["double-sided"]
stability = true
"#;

/// Commands that are run under limits alone: some of them take seconds.
const MORE_LINES: [&str; 8] = [
    "mapgen locate --event grazing --free omega --from .9 --to 1.1 --family single-sided --sites 3 --gamma1 .2 --gamma2 .1 --omega 1 --asymmetry .4",
    "mapgen locate --json --event fold --free amplitude --family double-sided --sites 2 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .1 --restitution .9",
    "mapgen stripes scene.toml --out stripes.png --csv stripes.csv",
    "mapgen stripes scene.toml --out stripes.svg --all --style column --letters",
    "mapgen sweep scene.toml --out map.csv --png map.png --svg map.svg --pdf map.pdf --threads 2 --width 86mm --dpi 150 --font-size 8",
    "mapgen merge parts --out map.csv --png map.png",
    "mapgen orbit --family double-sided --sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --all-plots plots --multipliers multipliers.csv",
    "mapgen simulate --family double-sided --sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --periods 3 --plot run.png --samples 9",
];

/// What sweeps may be asked besides.
const SWEEPS: [&str; 6] = [
    " --threshold 0.01",
    " --resume",
    " --dry-run",
    " --resume --threshold 0.01",
    " --shard 0/1",
    " --shard 1/3 --resume",
];

/// A plan and its one chunk, as the program leaves them.
fn sound() -> &'static [Vec<u8>; 2] {
    static SOUND: OnceLock<[Vec<u8>; 2]> = OnceLock::new();
    SOUND.get_or_init(|| {
        let folder = tempfile::tempdir().unwrap();
        let (scene, parts) = (folder.path().join("scene.toml"), folder.path().join("parts"));
        fs::write(&scene, SCENES[0]).unwrap();
        let line: Vec<OsString> = ["mapgen".into(), "sweep".into(), scene.into(), "--out".into(), parts.clone().into()]
            .into_iter()
            .chain(["--quiet", "--threads", "1", "--shard", "0/1"].map(Into::into))
            .collect();
        assert_eq!(mapgen(&line, false).code, 0);
        ["plan.json", "000000.chunk"].map(|name| fs::read(parts.join(name)).unwrap())
    })
}

/// One damaged input: the files it reads and its command line.
#[derive(Debug)]
struct Input {
    scene: Vec<u8>,
    state: Vec<u8>,
    /// The plan and the chunk of a folder to merge.
    parts: [Vec<u8>; 2],
    line: Vec<OsString>,
}

impl Input {
    fn new(seed: u64, number: u64) -> Self {
        let mut mutator = Mutator::new(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ number);
        let (mut scene, mut state) = (SCENES[0].as_bytes().to_vec(), STATE.as_bytes().to_vec());
        let mut parts = sound().clone();
        let words = |line: &'static str| -> Vec<&str> { line.split(' ').collect() };
        let whole = |line: &'static str| line.split(' ').map(OsString::from).collect();
        let line = match mutator.rng.u8(..20) {
            0..9 => {
                let base = *mutator.pick(&SCENES);
                scene = mutator.file(base);
                whole(SWEEP)
            }
            9 => {
                scene = mutator.valid_scene().into_bytes();
                whole(SWEEP)
            }
            10 => {
                scene = mutator.pick(&SCENES).as_bytes().to_vec();
                let more = *mutator.pick(&SWEEPS);
                let mut words = words(SWEEP);
                if more.contains("--shard") {
                    // A folder is not named as a file is.
                    words.iter_mut().filter(|word| **word == "map.csv").for_each(|word| *word = "parts");
                }
                words.extend(more.split(' ').skip(1));
                mutator.line(&words)
            }
            11 if mutator.rng.bool() => {
                // Either of the two, or both.
                let which = mutator.rng.u8(1..4);
                for (bit, part) in parts.iter_mut().enumerate() {
                    if which >> bit & 1 == 1 {
                        *part = mutator.bytes(part);
                    }
                }
                whole(MERGE)
            }
            11..13 => {
                state = mutator.file(STATE);
                let from_state = LINES.iter().find(|line| line.contains("--state"));
                whole(from_state.unwrap())
            }
            13..16 => {
                let base = *mutator.pick(&LINES);
                mutator.valid_line(&words(base))
            }
            _ => {
                let base = *mutator.pick(&LINES);
                mutator.line(&words(base))
            }
        };
        Self { scene, state, parts, line }
    }

    /// Of any command.
    fn of_all_commands(seed: u64, number: u64) -> Self {
        let mut input = Self::new(seed, number);
        let mut mutator = Mutator::new(seed.wrapping_add(number.wrapping_mul(0x9e37_79b9_7f4a_7c15)));
        if mutator.rng.bool() {
            let words: Vec<&str> = mutator.pick(&MORE_LINES).split(' ').collect();
            input.line = if mutator.rng.bool() { mutator.line(&words) } else { mutator.valid_line(&words) };
            if mutator.rng.bool() {
                input.scene = mutator.file(STRIPES);
            }
        }
        // No process can be given such a word.
        input.line.retain(|word| !word.as_encoded_bytes().contains(&0));
        input
    }

    fn tell(&self) -> String {
        let words: Vec<_> = self.line.iter().map(|word| format!("{word:?}")).collect();
        format!(
            "{}\n--- scene.toml\n{}\n--- state.json\n{}\n--- parts\n{}\n{}",
            words.join(" "),
            String::from_utf8_lossy(&self.scene),
            String::from_utf8_lossy(&self.state),
            String::from_utf8_lossy(&self.parts[0]),
            String::from_utf8_lossy(&self.parts[1])
        )
    }
}

/// What is to be done with a command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Plan {
    /// All of it.
    Whole,
    /// Told to stop as soon as it listens.
    Stopped,
    /// No further than its parameters.
    Parameters,
}

/// Windows of flight in a period of the slowest orbit; their square where all solutions are sought, because both their
/// number and the work on each grow with them. A sweep without force seeks the symmetric one alone.
fn windows(model: &Model, all: bool) -> f64 {
    let top = (model.chain().gamma1() + 4.0 * model.chain().gamma2()).sqrt().max(model.omega());
    let windows = 1.0 + 2.0 * model.period() * top;
    if all || !model.is_conservative() { windows * windows } else { windows }
}

/// How much of a command is affordable. What cannot be parsed is always run whole: it costs nothing.
fn plan(line: &[OsString], work: f64) -> Plan {
    let of = |cost: f64, otherwise: Plan| if cost <= work { Plan::Whole } else { otherwise };
    let cli = read::<Cli>(line.iter().cloned());
    let threads = cli.as_ref().ok().and_then(|cli| cli.common.threads);
    match cli.map(|cli| cli.command) {
        Err(_) => Plan::Whole,
        Ok(Command::Sweep(args)) => {
            let Ok(scene) = Scene::read(&args.scene) else { return Plan::Whole };
            let mut windows_most = 0.0_f64;
            for corner in 0..1_usize << scene.axes.len() {
                let limits = scene.axes.iter().enumerate().map(|(i, axis)| (axis, axis.limits()[corner >> i & 1]));
                let corner = limits.fold(scene.base, |point, (axis, value)| point.with(axis.parameter, value));
                windows_most = windows_most.max(corner.model().map_or(1.0, |model| windows(&model, false)));
            }
            // A picture takes longer than its cells, threads longer than they are worth.
            let PictureArgs { png, svg, pdf, .. } = &args.pictures;
            let pictures =
                [png, svg, pdf].iter().any(|file| file.is_some()) || threads.is_none_or(|threads| threads > 4);
            let cost = scene.cells() as f64 * scene.base.sites() as f64 * windows_most;
            of(if pictures { f64::INFINITY } else { cost }, Plan::Stopped)
        }
        // Every border of a window; hundreds of periods of many runs; a page that is served until it is stopped.
        Ok(Command::Curves(_) | Command::Fate(_) | Command::Explore(_)) => Plan::Stopped,
        // Each word by a dense matrix.
        Ok(Command::Words(args)) => match model::model(&args.model).map(|chosen| chosen.model) {
            Ok(model) => {
                let words = Word::combinations(
                    &model.chain().layout(),
                    args.sites_used,
                    args.reach,
                    &[Family::DoubleSided, Family::SingleSided],
                );
                of(words * (model.chain().sites() as f64).powi(3) * windows(&model, true), Plan::Stopped)
            }
            Err(_) => Plan::Whole,
        },
        Ok(Command::Orbit(args)) => match model::model(&args.model).map(|chosen| chosen.model) {
            Ok(model) if args.plot.is_none() && args.all_plots.is_none() => {
                // Words under a force are followed over many orbits.
                let orbits = if args.which.word.is_some() { 100.0 } else { 1.0 };
                of(orbits * model.chain().sites() as f64 * windows(&model, true), Plan::Parameters)
            }
            Ok(_) => Plan::Parameters,
            Err(_) => Plan::Whole,
        },
        // Hundreds of orbits.
        Ok(Command::Locate(args)) => match model::model(&args.along.model).map(|chosen| chosen.model) {
            Ok(model) => of(100.0 * model.chain().sites() as f64 * windows(&model, true), Plan::Parameters),
            Err(_) => Plan::Whole,
        },
        // Hundreds of spectra of each branch.
        Ok(Command::Branch(args)) => match model::model(&args.along.model).map(|chosen| chosen.model) {
            Ok(_) if args.switch || args.plot.is_some() => Plan::Parameters,
            Ok(model) => {
                let spectra = 1000.0 * (model.chain().sites() as f64).powi(3);
                of(spectra.max(100.0 * model.chain().sites() as f64 * windows(&model, true)), Plan::Parameters)
            }
            Err(_) => Plan::Whole,
        },
        // As many, of each curve.
        Ok(Command::Curve(_)) => Plan::Parameters,
        Ok(Command::Simulate(args)) => {
            let Ok(model) = model::model(&args.model).map(|chosen| chosen.model) else { return Plan::Whole };
            let sites = model.chain().sites() as f64;
            if args.plot.is_some() || sites * windows(&model, true) > work {
                return Plan::Parameters;
            }
            let periods = args.periods;
            let sampled = if args.trajectory.is_some() { args.samples as f64 } else { 1.0 };
            // Impacts of a mass that is thrown from barrier to barrier.
            let fastest = args.state.as_deref().map_or(0.0, fastest).max(model.amplitude() / model.omega());
            let impacts = fastest * model.period();
            of(sites * periods * (windows(&model, true) + sampled + sites * impacts), Plan::Stopped)
        }
        // What is there is read, nothing is computed; pictures take longer.
        // The same.
        Ok(Command::Draw(_)) => Plan::Stopped,
        Ok(Command::Merge(args)) => {
            let PictureArgs { png, svg, pdf, .. } = &args.pictures;
            if [png, svg, pdf].iter().any(|file| file.is_some()) { Plan::Stopped } else { Plan::Whole }
        }
        // Minutes of work, tested elsewhere.
        Ok(Command::Init(_) | Command::Completions(_) | Command::Man(_)) => Plan::Whole,
        Ok(Command::Stripes(_)) => Plan::Parameters,
        Ok(Command::Schema(_)) => Plan::Whole,
    }
}

/// The largest number of a state file.
fn fastest(path: &Path) -> f64 {
    let text = fs::read_to_string(path).unwrap_or_default();
    let value: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let numbers = value["velocity"].as_array().into_iter().flatten().filter_map(serde_json::Value::as_f64);
    numbers.fold(0.0, |most: f64, x| most.max(x.abs()))
}

/// Runs the program in this process.
fn mapgen(line: &[OsString], stopped: bool) -> Outcome {
    let (mut out, mut err) = (Vec::new(), Vec::new());
    let interrupt = move || Ok(Stop::when(move || stopped));
    let mut console = Console::new(&mut out, &mut err, &interrupt);
    let result = program::run(line.iter().cloned(), &mut console);
    let (code, message) = match &result {
        Ok(()) => (0, String::new()),
        Err(CliError::Usage(error)) => (error.exit_code() as u8, error.render().to_string()),
        Err(error) => {
            console.remark(&format!("error: {error}"));
            (error.exit_code(), String::new())
        }
    };
    Outcome { code, out: String::from_utf8(out).unwrap(), message: String::from_utf8(err).unwrap() + &message }
}

/// A folder of its own as the present one, while it lives; there is one present folder in a process.
struct Desk {
    folder: TempDir,
    home: PathBuf,
    _alone: MutexGuard<'static, ()>,
}

impl Desk {
    fn new() -> Self {
        static ALONE: Mutex<()> = Mutex::new(());
        let alone = ALONE.lock().unwrap_or_else(PoisonError::into_inner);
        // In memory, where there is such a folder: a disk would take minutes to see to it that nothing is ever lost.
        let folder = tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap();
        let desk = Self { folder, home: std::env::current_dir().unwrap(), _alone: alone };
        std::env::set_current_dir(desk.folder.path()).unwrap();
        desk
    }

    fn lay_out(&self, input: &Input) {
        for (name, content) in [("scene.toml", &input.scene), ("state.json", &input.state)] {
            if input.line.iter().any(|word| word == name) {
                fs::write(self.folder.path().join(name), content).unwrap();
            }
        }
        for entry in fs::read_dir(self.folder.path()).unwrap() {
            let entry = entry.unwrap();
            // Chunks of the run before.
            if entry.file_type().unwrap().is_dir() {
                fs::remove_dir_all(entry.path()).unwrap();
            }
        }
        if input.line.iter().any(|word| word == "merge") {
            let parts = self.folder.path().join("parts");
            fs::create_dir(&parts).unwrap();
            for (name, content) in ["plan.json", "000000.chunk"].iter().zip(&input.parts) {
                fs::write(parts.join(name), content).unwrap();
            }
        }
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        // A folder that cannot be left stays behind, that is all.
        let _ = std::env::set_current_dir(&self.home);
    }
}

fn setting(name: &str, default: u64) -> u64 {
    std::env::var(name).map_or(default, |value| value.parse().unwrap())
}

#[test]
fn thousands_of_damaged_requests() {
    damaged_requests(FEW);
}

#[test]
#[ignore = "a minute: cargo test --workspace --test mutations -- --ignored slow"]
fn slow_fifty_thousand_damaged_requests() {
    damaged_requests(setting("MUTATIONS", COUNT));
}

fn damaged_requests(count: u64) {
    let seed = setting("MUTATIONS_SEED", SEED);
    let work = setting("MUTATIONS_WORK", WORK as u64) as f64;
    let desk = Desk::new();
    let outputs = ["map.csv", "map.manifest.json", "impacts.csv", "trajectory.csv"];
    // Runs by subcommand and exit code.
    let mut ran = [[0_u64; 4]; 4];
    let (mut planned, mut wrong, mut slowest) = ([0_u64; 3], Vec::new(), (0.0, 0));
    // One input alone, to look at it closely.
    let only = std::env::var("MUTATIONS_ONLY").ok().map(|number| number.parse::<u64>().unwrap());
    for number in only.map_or(0..count, |number| number..number + 1) {
        let input = Input::new(seed, number);
        if only.is_some() {
            println!("{}", input.tell());
        }
        desk.lay_out(&input);
        let plan = plan(&input.line, work);
        planned[plan as usize] += 1;
        if plan == Plan::Parameters {
            continue;
        }
        let started = std::time::Instant::now();
        let stopped = plan == Plan::Stopped;
        let mut complaint = match catch_unwind(AssertUnwindSafe(|| mapgen(&input.line, stopped))) {
            Ok(outcome) => {
                let commands = ["sweep", "orbit", "simulate", "merge"];
                let command = input.line.get(1).and_then(|word| commands.iter().position(|name| word == name));
                if let (Some(command), 0..4) = (command, outcome.code) {
                    ran[command][usize::from(outcome.code)] += 1;
                }
                let complaint = complaints(&outcome, stopped);
                if complaint.is_empty() { complaint } else { format!("{complaint}{outcome:?}\n") }
            }
            Err(_) => "panicked\n".to_owned(),
        };
        for name in outputs {
            if !Path::new(name).exists() {
                continue;
            }
            complaint.push_str(&file_complaints(Path::new(name)));
            // What is judged once need not be judged again.
            let _ = fs::remove_file(name);
        }
        let took = started.elapsed().as_secs_f64();
        if took > slowest.0 {
            slowest = (took, number);
        }
        if !complaint.is_empty() {
            wrong.push(format!("input {number}: {complaint}{}", input.tell()));
        }
    }
    println!("{count} inputs of seed {seed}: run, stopped, parameters only {planned:?}");
    println!("exit codes 0 to 3 of sweep, orbit, simulate, merge: {ran:?}; slowest {slowest:?}");
    let shown: Vec<_> = wrong.iter().take(12).cloned().collect();
    assert!(wrong.is_empty(), "{} inputs went wrong:\n{}", wrong.len(), shown.join("\n=====\n"));
    // The damage is not so heavy that nothing would be computed, nor so light that nothing would be refused.
    if work == WORK && only.is_none() {
        // Of a hundred thousand, and in proportion.
        let least = [[1000, 0, 1000, 0], [1000, 0, 1000, 1], [1000, 0, 1000, 100], [10, 100, 100, 0]];
        for (ran, least) in ran.iter().flatten().zip(least.iter().flatten()) {
            assert!(*ran >= least * count / 100_000, "{ran} of {least}");
        }
    }
}

/// Requests that are run under limits.
const LIMITED: u64 = 120;
/// Of these, what there is always time for: every one that is cut short takes a second.
const LIMITED_FEW: u64 = 40;

/// Address space of a run, in KiB: a gigabyte and a half, threads and all.
const MEMORY: u64 = 3 << 19;

/// Processor time of a run, in seconds: much more than any takes that can be told to be short, and a moment of the others.
const SECONDS: [u64; 2] = [30, 1];

/// How the real program ended within these limits; nothing if its time was up.
#[cfg(unix)]
fn limited(line: &[OsString], seconds: u64) -> Result<Option<Outcome>, String> {
    use std::os::unix::process::ExitStatusExt;
    let ran = std::process::Command::new("sh")
        .args(["-c", &format!("ulimit -v {MEMORY}; ulimit -t {seconds}; exec \"$0\" \"$@\"")])
        .arg(assert_cmd::cargo::cargo_bin("mapgen"))
        .args(&line[1..])
        .stdin(std::process::Stdio::null())
        .output()
        .map_err(|error| error.to_string())?;
    let told = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    // SIGKILL and SIGXCPU: whose time is up gets either.
    match (ran.status.code(), ran.status.signal()) {
        (_, Some(9 | 24)) => Ok(None),
        (Some(code), _) if told(&ran.stderr).contains("panicked at") => Err(format!("{code}: {}", told(&ran.stderr))),
        (Some(code @ (0..=3 | 130)), _) => {
            Ok(Some(Outcome { code: code as u8, out: told(&ran.stdout), message: told(&ran.stderr) }))
        }
        _ => Err(format!("{}: {}", ran.status, told(&ran.stderr))),
    }
}

#[cfg(unix)]
#[test]
fn requests_of_all_commands_keep_within_memory_and_time() {
    requests_under_limits(LIMITED_FEW);
}

#[cfg(unix)]
#[test]
#[ignore = "a minute: cargo test --workspace --test mutations -- --ignored slow"]
fn slow_a_hundred_requests_of_all_commands_keep_within_memory_and_time() {
    requests_under_limits(setting("MUTATIONS_LIMITED", LIMITED));
}

#[cfg(unix)]
fn requests_under_limits(count: u64) {
    let seed = setting("MUTATIONS_SEED", SEED);
    let desk = Desk::new();
    let (mut ended, mut cut, mut wrong) = ([0_u64; 4], 0, Vec::new());
    for number in 0..count {
        for entry in fs::read_dir(desk.folder.path()).unwrap().flatten() {
            if entry.file_type().unwrap().is_file() {
                fs::remove_file(entry.path()).unwrap();
            }
        }
        let input = Input::of_all_commands(seed, number);
        desk.lay_out(&input);
        let short = plan(&input.line, WORK) == Plan::Whole;
        match limited(&input.line, SECONDS[usize::from(!short)]) {
            Ok(Some(outcome)) => {
                if let Some(count) = ended.get_mut(usize::from(outcome.code)) {
                    *count += 1;
                }
                let complaint = complaints(&outcome, false);
                if !complaint.is_empty() {
                    wrong.push(format!("input {number}: {complaint}{outcome:?}\n{}", input.tell()));
                }
            }
            Ok(None) if short => wrong.push(format!("input {number}: out of time\n{}", input.tell())),
            Ok(None) => cut += 1,
            Err(how) => wrong.push(format!("input {number}: {how}\n{}", input.tell())),
        }
    }
    println!("{count} requests of seed {seed}: exit codes 0 to 3 {ended:?}, {cut} cut short");
    let shown: Vec<_> = wrong.iter().take(6).cloned().collect();
    assert!(wrong.is_empty(), "{} requests went wrong:\n{}", wrong.len(), shown.join("\n=====\n"));
    // Of 120, and in proportion.
    let least = |most: u64| most * count / LIMITED;
    let enough = [ended[0] > least(10), ended[1] + ended[3] > least(1), ended[2] > least(30)];
    assert!(enough == [true; 3], "{ended:?} {cut}");
}

#[test]
fn the_real_program_says_the_same() {
    let desk = Desk::new();
    let program = assert_cmd::cargo::cargo_bin("mapgen");
    let mut compared = 0;
    for number in 0.. {
        let input = Input::new(SEED + 1, number);
        desk.lay_out(&input);
        if plan(&input.line, WORK) != Plan::Whole {
            continue;
        }
        let real = std::process::Command::new(&program).args(&input.line[1..]).output().unwrap();
        desk.lay_out(&input);
        let outcome = mapgen(&input.line, false);
        assert_eq!(real.status.code(), Some(i32::from(outcome.code)), "{}", input.tell());
        // Help is an answer, and clap prints it as one. What a sweep took is not the same twice.
        let told = String::from_utf8(real.stdout).unwrap() + &String::from_utf8(real.stderr).unwrap();
        if !told.contains(" per cell and core") {
            assert_eq!(told, outcome.out + &outcome.message, "{}", input.tell());
        }
        compared += 1;
        if compared == 60 {
            break;
        }
    }
}
