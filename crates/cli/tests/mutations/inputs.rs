//! Damaged files and command lines, each by its number.

use std::ffi::OsString;
use std::fs;
use std::sync::OnceLock;

use crate::mutate::Mutator;
use crate::run::mapgen;

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

/// A map that has stripes.
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
const MORE_LINES: [&str; 7] = [
    "mapgen locate --event grazing --free omega --from .9 --to 1.1 --family single-sided --sites 3 --gamma1 .2 --gamma2 .1 --omega 1 --asymmetry .4",
    "mapgen locate --json --event fold --free amplitude --family double-sided --sites 2 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .1 --restitution .9",
    "mapgen stripes scene.toml --out stripes.csv",
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
pub(crate) struct Input {
    pub(crate) scene: Vec<u8>,
    pub(crate) state: Vec<u8>,
    /// The plan and the chunk of a folder to merge.
    pub(crate) parts: [Vec<u8>; 2],
    pub(crate) line: Vec<OsString>,
}

impl Input {
    pub(crate) fn new(seed: u64, number: u64) -> Self {
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
    pub(crate) fn of_all_commands(seed: u64, number: u64) -> Self {
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

    pub(crate) fn tell(&self) -> String {
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
