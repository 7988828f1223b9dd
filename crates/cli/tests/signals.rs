//! Every command that computes for long is told to stop at a random moment: it ends soon, with 130 and a word, and leaves nothing behind.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::fs;
use std::process::Child;
use std::thread::sleep;
use std::time::{Duration, Instant};

use fastrand::Rng;
use vibrochain_testkit::{Ran, TestDir, signal};

/// A ring on which every command has minutes to do.
const RING: &str = "--sites 301 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";

/// Scenes of as much work.
const SCENES: [(&str, &str); 3] = [
    (
        "large.toml",
        "[model]\nsites = 301\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
         x = { parameter = \"omega\", from = 0.9, to = 2.2, points = 40 }\n\
         y = { parameter = \"gamma2\", from = 0.02, to = 0.2, points = 30 }\n\
         [compute]\nfamilies = [\"double-sided\", \"single-sided\"]\nstability = true\n",
    ),
    (
        "fine.toml",
        "[model]\nsites = 101\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
         x = { parameter = \"omega\", from = 0.9, to = 2.2, points = 3000 }\n\
         y = { parameter = \"gamma2\", from = 0.02, to = 0.2, points = 3000 }\n\
         [compute]\nfamilies = [\"double-sided\", \"single-sided\"]\nstability = true\n",
    ),
    (
        "word.toml",
        "[model]\nsites = 7\ngamma1 = 0.2\nasymmetry = 0.2\nforcing = { amplitude = 0.3, restitution = 0.8 }\n[sweep]\n\
         x = { parameter = \"omega\", from = 0.9, to = 2.2, points = 300 }\n\
         y = { parameter = \"gamma2\", from = 0.01, to = 0.2, points = 300 }\n\
         [compute]\nfamilies = [\"0+1+,0-1-\"]\nstability = true\n",
    ),
];

fn rings() -> Vec<(String, String)> {
    SCENES.iter().map(|(name, text)| ((*name).to_owned(), (*text).to_owned())).collect()
}

/// Lines of every command that may take long, each with files to write; `RING` stands for the ring.
const LINES: [&str; 14] = [
    "sweep fine.toml --out a.csv --png a.png",
    "sweep fine.toml --out - --png a.png",
    "curves large.toml --places 0 --csv a.csv --points b.csv --plot a.png",
    "curves word.toml --csv a.csv --plot a.svg",
    "stripes fine.toml --out a.csv",
    "stripes large.toml --out a.csv",
    "locate RING --family double-sided --event neimark-sacker --free omega --from .8 --to 2.2 --csv a.csv",
    "branch RING --family double-sided --free omega --from .8 --to 2.2 --csv a.csv --plot a.png",
    "curve RING --family double-sided --event neimark-sacker --free omega --and gamma2 --csv a.csv --plot a.png",
    "orbit --sites 999 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .2 --amplitude .3 --restitution .8 --word 0+4+,0-4- --multipliers a.csv",
    "words RING --sites-used 3 --reach 6 --csv a.csv",
    "simulate RING --family double-sided --periods 1e6 --impacts a.csv --plot a.png",
    "simulate --sites 999 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .2 --amplitude .3 --restitution .8 --word 0+4+,0-4- --periods 1e7 --impacts a.csv",
    "fate large.toml --starts 10 --periods 1000 --csv a.csv --plot a.png",
];

/// What a program may still compute after the signal: it looks every 0.2 s, and writes what it has.
const MOST_COMPUTED: Duration = Duration::from_millis(500);

/// What may wait for a program that ends soon, on a machine that does much else.
const PATIENCE: Duration = Duration::from_secs(60);

/// Waits until the program listens to the signal: before, whoever starts it has it end as any other.
fn listens(child: &mut Child) -> bool {
    let begun = Instant::now();
    let status = format!("/proc/{}/status", child.id());
    while child.try_wait().unwrap().is_none() {
        let text = fs::read_to_string(&status).unwrap_or_default();
        let caught = text.lines().find_map(|line| line.strip_prefix("SigCgt:"));
        // SIGTERM is number 15.
        if caught.is_some_and(|mask| u64::from_str_radix(mask.trim(), 16).unwrap() >> 14 & 1 == 1) {
            return true;
        }
        assert!(begun.elapsed() < PATIENCE, "no handler of signals is installed");
        sleep(Duration::from_millis(1));
    }
    false
}

/// The time that a process has had of the processors, as long as it is there: what else the machine does is not in it.
fn computed(child: u32) -> Option<Duration> {
    let text = fs::read_to_string(format!("/proc/{child}/stat")).ok()?;
    let fields: Vec<&str> = text.rsplit_once(')')?.1.split_whitespace().collect();
    // A process that has ended and was not waited for has none left.
    let ticks = |place: usize| fields.get(place)?.parse::<u64>().ok();
    (fields.first() != Some(&"Z")).then_some(Duration::from_millis(10 * (ticks(11)? + ticks(12)?)))
}

/// Sends the signal and waits for the end; how long that took, by the clock and by the time that the process has had.
fn ended(child: Child) -> (Ran, [Duration; 2]) {
    let (id, begun) = (child.id(), Instant::now());
    let before = computed(id).unwrap_or_default();
    let waiter = std::thread::spawn(move || signal(child, "TERM"));
    let mut last = before;
    while !waiter.is_finished() {
        last = computed(id).unwrap_or(last);
        sleep(Duration::from_millis(2));
    }
    (waiter.join().unwrap(), [begun.elapsed(), last.saturating_sub(before)])
}

/// Sends the signal to each line after a random time, up to so many seconds, so many times. How many were at work then.
fn at_random(lines: &[&str], scenes: &[(String, String)], times: u32, most: f64, seed: u64) -> u32 {
    let (mut random, mut stopped) = (Rng::with_seed(seed), 0);
    for line in lines {
        for _ in 0..times {
            let dir = TestDir::new();
            for (name, text) in scenes {
                fs::write(dir.path(name), text).unwrap();
            }
            let inputs = dir.names(".");
            let line = line.replace("RING", RING);
            let mut child = dir.start(&format!("{line} --threads 1"));
            let at_work = listens(&mut child);
            // Short times as often as long ones.
            sleep(Duration::from_secs_f64(most * random.f64().powi(2)));
            if !at_work || child.try_wait().unwrap().is_some() {
                let ended = child.wait_with_output().unwrap();
                // Some structures have no answer, and say so.
                assert!(ended.status.code().is_some_and(|code| code < 4), "{line}: {ended:?}");
                continue;
            }
            let (ran, [passed, computed]) = ended(child);
            println!("{:.2} s, of them {:.2} s at work  {line}", passed.as_secs_f64(), computed.as_secs_f64());
            // It may have been done just then.
            if ran.code.is_some_and(|code| code < 4) {
                continue;
            }
            assert!(passed < PATIENCE && computed < MOST_COMPUTED, "{line}: {passed:?} {computed:?}");
            ran.with(130, &["interrupted"]);
            stopped += 1;
            // A table in chunks goes on by --resume, a run is kept as far as it came.
            let kept = |name: &String| name == "a.csv.parts" || line.starts_with("simulate");
            let left: Vec<String> = dir.names(".").into_iter().filter(|name| !inputs.contains(name)).collect();
            assert!(left.iter().all(|name| !name.starts_with('.') && kept(name)), "{line}: {left:?}");
        }
    }
    stopped
}

/// Structures drawn at random: of two coordinates to a thousand, by matrices or by modes; and some that once took longest to hear.
fn structures(random: &mut Rng) -> Vec<(String, String)> {
    let list = |numbers: &mut dyn Iterator<Item = f64>| {
        format!("[{}]", numbers.map(|number| format!("{number:?}")).collect::<Vec<_>>().join(", "))
    };
    let map = "[sweep]\nx = { parameter = \"omega\", from = 0.3, to = 3, points = 40 }\n\
               [compute]\nfamilies = [\"0-,0+,0-\", \"0-,0+\"]\n";
    let words = ["0-,0+,0-", "0-,0+", "0-"];
    let mut scenes: Vec<(String, String)> = [2, 20, 300, 1000].into_iter().enumerate().flat_map(|(i, n)| {
        let word = words[random.usize(0..3)];
        let stop = "lower = -0.3\nupper = 0.4\nrestitution = 0.7\n";
        let head = format!("omega = {:?}\nword = \"{word}\"\n[structure]\n", 0.3 + random.f64());
        let masses = list(&mut (0..n).map(|_| 0.5 + random.f64()));
        let springs = list(&mut (0..n).map(|_| 0.2 + 2.0 * random.f64()));
        let shape = list(&mut (0..n).map(|_| random.f64() - 0.5));
        let ratios = list(&mut (0..n).map(|_| 0.02 * random.f64()));
        let loads = list(&mut (0..n).map(|_| random.f64() - 0.5));
        let modal = format!(
            "{head}frequencies = {springs}\nratios = {ratios}\ncontact_shapes = [{shape}]\nload_shapes = {loads}\n\
             [[contact]]\n{stop}{map}"
        );
        // A chain of these masses: its matrix stands in a file of its own.
        let mut matrix = format!("%%MatrixMarket matrix coordinate real symmetric\n{n} {n} {}\n", 2 * n - 1);
        (1..=n).for_each(|k| matrix += &format!("{k} {k} {:?}\n", 2.0 + random.f64()));
        (2..=n).for_each(|k| matrix += &format!("{k} {} -1\n", k - 1));
        let by_matrices = format!(
            "{head}masses = {masses}\nstiffness = \"k{i}.mtx\"\n[[contact]]\nat = 0\n{stop}[force]\nload = {loads}\n{map}"
        );
        [(format!("modes{i}.toml"), modal), (format!("k{i}.mtx"), matrix), (format!("matrix{i}.toml"), by_matrices)]
    }).collect();
    // A mass of condition 1e16, and a load far below its frequencies: hundreds of thousands of windows a period.
    let stiff = "omega = 0.01\nword = \"2-\"\n[structure]\n\
                 mass = [[0.6065387395747284, 1.1586822403581845], [1.1586822403581845, 2.216393580325657]]\n\
                 stiffness = [[1472898.3176430897, -850108.9218719737], [-850108.9218719737, 1173728.1996519205]]\n\
                 [[contact]]\nat = 1\nupper = 0.0\nrestitution = 0.8\n[[contact]]\nat = 0\nlower = 0.5\nrestitution = 1\n\
                 [[contact]]\nat = 1\nlower = -1e6\nupper = 0.0\nrestitution = 0.6\n[force]\nload = [1e9, 0]\n\
                 [sweep]\nx = { parameter = \"omega\", from = 0.01, to = 1.5, points = 5 }\n\
                 [compute]\nfamilies = [\"2-\", \"1-,0+\"]\n";
    // 2 million numbers to read.
    let long = format!(
        "omega = 1\nword = \"0+\"\n[structure]\nmasses = [1]\nstiffness = [[{}]]\n[[contact]]\nat = 0\nupper = 1\n",
        "1,".repeat(2_000_000)
    );
    scenes.extend([("stiff.toml".to_owned(), stiff.to_owned()), ("long.toml".to_owned(), long)]);
    scenes
}

/// Lines on these structures.
const OF_STRUCTURES: [&str; 14] = [
    "orbit --scene long.toml",
    "sweep long.toml --out a.csv",
    "sweep stiff.toml --out -",
    "orbit --scene matrix3.toml",
    "orbit --scene matrix3.toml --set stiffness.0.0=3 --set stiffness.1.1=3",
    "orbit --scene modes3.toml",
    "orbit --scene modes2.toml --word 0-,0+,0-,0+",
    "locate --scene modes3.toml --free omega --event grazing",
    "locate --scene matrix2.toml --free stiffness.0.0 --event period-doubling --out a.csv",
    "branch --scene modes1.toml --free load --out a.csv --plot a.png",
    "branch --scene matrix2.toml --free omega --out a.csv --plot a.png",
    "curve --scene modes1.toml --event grazing --free load --and omega --out a.csv",
    "sweep matrix3.toml --out a.csv --png a.png",
    "sweep modes2.toml --out a.csv --png a.png",
];

#[test]
fn every_command_hears_a_signal_at_a_random_moment() {
    let stopped = at_random(&LINES, &rings(), 1, 0.5, 5);
    assert!(stopped as usize >= LINES.len() - 3, "{stopped}");
}

#[test]
#[ignore = "minutes: cargo test --workspace --test signals -- --ignored slow"]
fn slow_every_command_hears_a_signal_at_many_random_moments() {
    let stopped = at_random(&LINES, &rings(), 12, 8.0, 17);
    assert!(stopped as usize >= 8 * LINES.len(), "{stopped}");
}

/// Structures, too, of any size, while they are read and while their modes, orbits and multipliers are worked out.
#[test]
fn structures_of_any_size_hear_a_signal_at_a_random_moment() {
    let scenes = structures(&mut Rng::with_seed(41));
    let stopped = at_random(&OF_STRUCTURES, &scenes, 1, 1.0, 43);
    assert!(stopped as usize >= OF_STRUCTURES.len() / 3, "{stopped}");
}

/// Runs, fates and numbers far apart: of these some once did not hear for 9 to 22 s.
fn runs_and_extremes(random: &mut Rng) -> Vec<(String, String)> {
    let mut list = |count: usize, size: f64| -> String {
        let numbers = (0..count).map(|_| format!("{:.3}", size * (2.0 * random.f64() - 1.0)));
        numbers.collect::<Vec<_>>().join(", ")
    };
    let mut state =
        |count| format!("{{\"displacement\":[{}],\"velocity\":[{}],\"psi\":0}}", list(count, 0.3), list(count, 2.0));
    let states = [100_001, 30, 50].map(|count| (format!("s{count}.json"), state(count)));
    let damped = |count: usize, contacts: usize| {
        let contact = |at: usize| format!("[[contact]]\nat = {at}\nlower = -0.5\nupper = 0.4\nrestitution = 0.8\n");
        let contacts: String = (0..contacts).map(contact).collect();
        format!(
            "omega = 1.1\nword = \"0+,0-\"\n[structure]\nchain = {{ sites = {count}, gamma1 = 0.2, gamma2 = 0.1, damping = 0.01 }}\n\
             {contacts}[force]\nload = {:?}\n[sweep]\nx = {{ parameter = \"omega\", from = 0.8, to = 2, points = 20 }}\n\
             [compute]\nfamilies = [\"0+,0-\", \"0+\"]\n",
            vec![0.5; count]
        )
    };
    let excited =
        damped(40, 1).replace("damping = 0.01", "damping = -0.05").replace("0.5,", "0,").replace("0.5]", "0]");
    let loads = "1e9, 0, -1, -1, 1e9, 1e-9, 1e-9, 0, 1e-9, 0.67, -1.3, 0.5, -1, 1, 0.5, 0.5, 1e-9, 1, 0, 1e9";
    let heavy = format!(
        "omega = 0.5\nword = \"0-,0+,0-\"\n[structure]\n\
         chain = {{ sites = 20, gamma1 = 2, gamma2 = 2, ends = \"fixed\", damping = 1000.0, coupling_damping = 0 }}\n\
         [[contact]]\nat = 3\nlower = -0.5\nupper = 0.5\nrestitution = 0.0\n[force]\nload = [{loads}]\n"
    );
    let light = "omega = 0.01\nword = \"0+,0-\"\n[structure]\nmasses = [1e-9]\nstiffness = [[1.7108671418045929]]\n\
                 [[contact]]\nat = 0\nlower = 0\nupper = 1\nrestitution = 0.999999999999\n\
                 [force]\nload = [-1]\nharmonic = 50\nstatic = [0.1]\n";
    let scenes = [
        ("damped30.toml", damped(30, 30)),
        ("damped50.toml", damped(50, 50)),
        ("large.toml", damped(1000, 1)),
        ("excited.toml", excited),
        ("heavy.toml", heavy),
        ("light.toml", light.to_owned()),
    ];
    states.into_iter().chain(scenes.map(|(name, text)| (name.to_owned(), text))).collect()
}

/// Lines on these.
const OF_RUNS: [&str; 12] = [
    "simulate --sites 100001 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .2 --state s100001.json --periods 50",
    "simulate --scene damped30.toml --state s30.json --periods 1e6",
    "simulate --scene damped50.toml --state s50.json --periods 1e6",
    "simulate --sites 50 --ends free --gamma1 .2 --gamma2 .1 --damping .01 --omega 1.1 --asymmetry .2 --amplitude .5 --restitution .8 \
     --state s50.json --periods 1e6",
    "simulate --scene large.toml --word 0+,0- --periods 1e6",
    "fate large.toml --out a.csv",
    "fate large.toml --breathers rest --out a.csv",
    "orbit --scene excited.toml --word 0+,0-,0+",
    "sweep excited.toml --out a.csv",
    "fate excited.toml --out a.csv",
    "branch --scene heavy.toml --free damping",
    "locate --scene light.toml --free damping --event neimark-sacker",
];

#[test]
fn runs_of_any_size_hear_a_signal_at_a_random_moment() {
    let scenes = runs_and_extremes(&mut Rng::with_seed(47));
    let stopped = at_random(&OF_RUNS, &scenes, 1, 0.6, 53);
    assert!(stopped as usize >= OF_RUNS.len() / 2, "{stopped}");
}

#[test]
#[ignore = "minutes: cargo test --workspace --test signals -- --ignored slow"]
fn slow_structures_of_any_size_hear_a_signal_at_many_random_moments() {
    let mut stopped = 0;
    for seed in 0..12 {
        let scenes = structures(&mut Rng::with_seed(seed));
        stopped += at_random(&OF_STRUCTURES, &scenes, 1, 8.0, 100 + seed);
        stopped += at_random(&OF_RUNS, &runs_and_extremes(&mut Rng::with_seed(seed)), 1, 8.0, 200 + seed);
    }
    assert!(stopped as usize >= 4 * OF_STRUCTURES.len(), "{stopped}");
}
