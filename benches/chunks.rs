//! What it costs to keep chunks: the same sweep in memory, into one file, and as `mapgen sweep` does it, plain and compressed, in turn.
//!
//! Printed are, of each, the median and its excess over the sweep in memory, also as a share of the processor time of that. The time of
//! the thread that sees to files (`files`) is what no number of threads makes shorter: that many times fewer than all processor time is
//! the most cores that a sweep can keep busy.
//! `cargo bench --bench chunks [-- SCENE.toml [REPETITIONS [THREADS]]]`
#![allow(missing_docs, reason = "a program of its own")]
#![allow(clippy::unwrap_used, clippy::panic, reason = "a benchmark stops at the first surprise")]

use std::ffi::OsStr;
use std::hint::black_box;
use std::io::{Write, sink, stdout};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::Instant;

use vibrochain_cli::common::console::{Console, ctrl_c};
use vibrochain_lattice::Stop;
use vibrochain_maps::files::Output;
use vibrochain_maps::scene::Scene;
use vibrochain_maps::sweep::{Ended, Job, blocks};
use vibrochain_maps::table::{RowWriter, header};

const SCENE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/conservative-n20.toml");

/// Computes all cells and hands the text of their rows to `take`.
fn rows(scene: &Scene, threads: usize, mut take: impl FnMut(&[u8])) {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
    let job = Job { scene, pool: &pool, stop: &Stop::default() };
    take(header(scene).as_bytes());
    let (whole, writer) = (0..scene.cells(), RowWriter::new(scene, false));
    let ended = blocks(
        &job,
        &[whole],
        |range, cells| writer.rows(range, cells).text,
        |block| {
            take(&block.made);
            Ok::<(), ()>(())
        },
    );
    assert!(matches!(ended, Ended::Complete(_)));
}

fn in_memory(scene: &Scene, threads: usize) {
    rows(scene, threads, |text| {
        black_box(text);
    });
}

/// No table that outlives its process costs less: a temporary file, flushed and renamed.
fn one_file(scene: &Scene, threads: usize, out: &Path) {
    let mut output = Output::create(out).unwrap();
    rows(scene, threads, |text| output.write_all(text).unwrap());
    output.commit().unwrap();
}

fn mapgen(scene: &Path, threads: usize, out: &Path) {
    let (mut quiet, mut silent) = (sink(), sink());
    let mut console = Console::new(&mut quiet, &mut silent, &ctrl_c);
    let threads = threads.to_string();
    let words = ["mapgen".as_ref(), "sweep".as_ref(), scene.as_os_str(), "--out".as_ref(), out.as_os_str()];
    let words = words.into_iter().chain(["--threads", &threads, "--quiet"].map(OsStr::new));
    vibrochain_cli::program::run(words.map(Into::into), &mut console).unwrap();
}

/// Ways of the same sweep.
const WAYS: usize = 5;

/// In milliseconds.
type Clock = fn() -> f64;

/// What is measured, each from any beginning: the clock; the processor time of all threads, ended ones too; that of
/// the thread that asked for the sweep, which takes no part in computing cells and sees to all that is kept of them.
const CLOCKS: [(&str, Clock); 3] = [("wall", wall), ("processor", processor), ("files", files)];

fn wall() -> f64 {
    static BEGUN: LazyLock<Instant> = LazyLock::new(Instant::now);
    1e3 * BEGUN.elapsed().as_secs_f64()
}

#[cfg(unix)]
fn clock(clock: rustix::time::ClockId) -> f64 {
    let time = rustix::time::clock_gettime(clock);
    1e3 * time.tv_sec as f64 + 1e-6 * time.tv_nsec as f64
}

#[cfg(unix)]
fn processor() -> f64 {
    clock(rustix::time::ClockId::ProcessCPUTime)
}

#[cfg(unix)]
fn files() -> f64 {
    clock(rustix::time::ClockId::ThreadCPUTime)
}

#[cfg(not(unix))]
fn processor() -> f64 {
    f64::NAN
}

#[cfg(not(unix))]
fn files() -> f64 {
    f64::NAN
}

fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted[sorted.len() / 2]
}

fn main() {
    let all: Vec<String> = std::env::args().skip(1).collect();
    // `cargo test --benches` leaves this out.
    let measured = all.iter().any(|word| word == "--bench");
    let mut words = all.iter().filter(|word| !word.starts_with("--"));
    let file = PathBuf::from(words.next().map_or(SCENE, String::as_str));
    let repetitions = words.next().map_or(21, |word| word.parse().unwrap());
    let threads = words.next().map_or(1, |word| word.parse().unwrap());
    let repetitions = if measured { repetitions } else { 1 };

    let scene = Scene::read(&file).unwrap();
    let dir = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
    let [out, zst, gz] = ["map.csv", "map.csv.zst", "map.csv.gz"].map(|name| dir.path().join(name));
    let ways: [(&str, &dyn Fn()); WAYS] = [
        ("in memory", &|| in_memory(&scene, threads)),
        ("one file", &|| one_file(&scene, threads, &out)),
        ("mapgen sweep", &|| mapgen(&file, threads, &out)),
        (".csv.zst", &|| mapgen(&file, threads, &zst)),
        (".csv.gz", &|| mapgen(&file, threads, &gz)),
    ];
    let mut times = [const { [const { Vec::new() }; WAYS] }; CLOCKS.len()];
    // In turn, so that whatever else the machine does meets all alike; the first round warms up.
    for round in 0..=repetitions {
        for (way, (_, run)) in ways.iter().enumerate() {
            let begun = CLOCKS.map(|(_, now)| now());
            run();
            if round > 0 {
                CLOCKS
                    .iter()
                    .zip(begun)
                    .zip(&mut times)
                    .for_each(|(((_, now), begun), list)| list[way].push(now() - begun));
            }
        }
    }
    let mut text = format!("{} cells, {threads} threads, medians of {repetitions} in ms\n", scene.cells());
    // Beside all the work there is.
    let whole = median(&times[1][0]);
    for ((clock, _), list) in CLOCKS.iter().zip(&times) {
        for (way, (what, _)) in ways.iter().enumerate() {
            let time = median(&list[way]);
            // Of pairs, which a slow spell meets together.
            let more: Vec<f64> = list[way].iter().zip(&list[0]).map(|(time, base)| time - base).collect();
            let more = median(&more);
            let share = 100.0 * more / whole;
            text += &format!("{clock:<10} {what:<13} {time:>8.1} {more:>+7.1} {share:>+6.2} %\n");
        }
    }
    // A benchmark whose output is cut off (`| head`) has nothing left to say.
    let _ = stdout().write_all(text.as_bytes());
}
