//! `mapgen fate`, and the sections of `mapgen simulate`, as their users see them.

use std::fs;

use vibrochain_testkit::scenes::{FATE as SCENE, ONE_MASS as LINE};
use vibrochain_testkit::{TestDir, written};

fn table(bytes: &[u8]) -> Vec<Vec<String>> {
    let records = csv::ReaderBuilder::new().has_headers(false).from_reader(bytes).into_records();
    records.map(|record| record.unwrap().iter().map(str::to_owned).collect()).collect()
}

#[test]
fn the_table_has_the_same_bytes_for_any_number_of_threads_and_by_every_way_out() {
    let dir = TestDir::with_scene(SCENE);
    let line = "fate scene.toml --starts 3 --periods 100 --seed 5";
    dir.run(&format!("{line} --csv one.csv --threads 1")).with(0, &[]);
    dir.run(&format!("{line} --out five.csv --threads 5")).with(0, &[]);
    let piped = dir.run(&format!("{line} --csv - --threads 2 --quiet")).with(0, &[]);
    let one = dir.read("one.csv");
    assert!(one == dir.read("five.csv") && one == piped.out.as_bytes() && piped.err.is_empty(), "{piped:?}");
    let rows = table(&one);
    assert_eq!(rows.len(), 13);
    let column = |name: &str| rows[0].iter().position(|column| column == name).unwrap();
    let shares: Vec<usize> = (0..rows[0].len()).filter(|&i| rows[0][i].starts_with("share_")).collect();
    assert_eq!(shares.len(), 7);
    let mut with = 0;
    for row in &rows[1..] {
        if row[column("breather")].is_empty() {
            assert!(row[column("starts")].is_empty() && row[column("solutions")] == "0");
            continue;
        }
        with += 1;
        let sum: f64 = shares.iter().map(|&i| row[i].parse::<f64>().unwrap()).sum();
        assert!((sum - 1.0).abs() < 1e-12 && row[column("starts")] == "3", "{row:?}");
        let number = |name: &str| row[column(name)].parse::<f64>().unwrap();
        assert!((number("predicted_exponent") - number("measured_exponent")).abs() < 1e-6, "{row:?}");
    }
    assert!(with >= 6, "{with}");
    // Another seed is another ensemble.
    dir.run("fate scene.toml --starts 3 --periods 100 --seed 6 --csv other.csv").with(0, &[]);
    assert_ne!(dir.read("other.csv"), one);
}

#[test]
fn the_answer_counts_every_run_as_text_and_as_json() {
    let dir = TestDir::with_scene(SCENE);
    let line = "fate scene.toml --breathers every --starts 2 --periods 60";
    let text = dir.run(&format!("{line} --plot map.png")).with(0, &[]).out;
    assert!(text.starts_with("12 cells (4 × 3), "), "{text}");
    assert!(text.contains("differ from ln|μ|/T by at most"), "{text}");
    assert!(dir.read("map.png").starts_with(b"\x89PNG"));
    let json = written(&dir.run(&format!("{line} --json")).with(0, &[]).out);
    let ends: u64 = json["ends"].as_object().unwrap().values().map(|count| count.as_u64().unwrap()).sum();
    assert_eq!(json["runs"].as_u64(), Some(ends));
    assert_eq!(ends, 2 * json["breathers"].as_u64().unwrap());
    assert!(
        json["ensemble"]["starts"] == 2
            && json["model"]["sites"] == 5
            && json["exponent_difference"].as_f64().unwrap() < 1e-6
    );
}

#[test]
fn what_cannot_be_asked_is_refused_with_what_can() {
    let dir = TestDir::with_scene(SCENE);
    fs::write(dir.path("line.toml"), LINE).unwrap();
    for (line, told) in [
        ("fate scene.toml --starts 0", "--starts 0 is out of range: give a whole number from 1 to 10000"),
        ("fate scene.toml --starts 1e3", "not a whole number"),
        ("fate scene.toml --periods 5", "--periods 5 is out of range: give a whole number from 10"),
        ("fate scene.toml --perturb -.1", "--perturb -0.1 is out of range: give a size from 0 to 1"),
        ("fate scene.toml --transient 1", "--transient 1 is out of range: give a share from 0 to 0.95"),
        ("fate scene.toml --tolerance 2", "--tolerance 2 is out of range"),
        ("fate scene.toml --resume", "--out"),
        ("fate scene.toml --csv - --resume", "--resume has nothing to go on with: --out - is no plain file"),
        ("fate scene.toml --csv parts --shard 2/2", "there is no shard 2 of 2"),
        ("fate scene.toml --csv parts --shard 0/2 --plot map.png", "cannot be used with"),
        ("fate line.toml --diagram d.csv --resume", "cannot be used with"),
        ("fate scene.toml --plot map.gif", "end the name in .png, .svg or .pdf"),
        ("fate scene.toml --csv scene.toml", "scene.toml"),
        ("fate scene.toml --diagram d.csv", "--diagram needs a scene with one axis, this one has 2"),
        ("fate line.toml --diagram d.csv --points 0", "--points 0 is out of range"),
        ("fate line.toml --diagram d.csv --csv c.csv", "cannot be used with"),
        ("fate scene.toml --carry", "--diagram"),
        ("fate nothing.toml", "cannot read scene nothing.toml"),
        ("fate scene.toml --breathers some", "class, every, unstable"),
    ] {
        dir.run(line).with(2, &[told]);
    }
    assert_eq!(dir.names("."), ["line.toml", "scene.toml"]);
}

#[test]
fn over_one_axis_there_are_shares_and_a_diagram() {
    let dir = TestDir::with_scene(LINE);
    dir.run("fate scene.toml --starts 2 --periods 100 --plot shares.svg").with(0, &[]);
    assert!(String::from_utf8(dir.read("shares.svg")).unwrap().contains("share of the runs"));
    let told = dir.run("fate scene.toml --periods 300 --diagram d.csv --points 4 --plot d.svg").with(0, &[]).out;
    assert_eq!(told, "6 runs of 300 periods, 4 points each\n");
    let rows = table(&dir.read("d.csv"));
    assert_eq!(rows[0], ["amplitude", "period", "displacement_0", "velocity_0"]);
    assert!(rows.len() == 25 && rows[1][..2] == ["0.25", "296"] && rows[24][..2] == ["0.5", "299"]);
    // At the end of the axis the breather is stable: one point, again and again.
    let last: Vec<f64> = rows[21..].iter().map(|row| row[2].parse().unwrap()).collect();
    assert!(last.iter().all(|u| (u - last[0]).abs() < 1e-9), "{last:?}");
    assert!(String::from_utf8(dir.read("d.svg")).unwrap().contains("once a period"));
    let carried = dir.run("fate scene.toml --periods 300 --diagram c.csv --points 4 --carry").with(0, &[]).out;
    assert!(carried.contains("each from the end of the one before"), "{carried}");
}

/// Six chunks of two cells, each some tenths of a second of work.
const CHUNKED: &str = "fate line.toml --breathers every --starts 3 --periods 10000 --seed 4";

fn chunked() -> TestDir {
    let dir = TestDir::new();
    fs::write(dir.path("line.toml"), LINE.replace("points = 6", "points = 12")).unwrap();
    dir
}

/// Table and answer of a run that nobody has disturbed.
fn undisturbed() -> &'static (Vec<u8>, String) {
    static RAN: std::sync::OnceLock<(Vec<u8>, String)> = std::sync::OnceLock::new();
    RAN.get_or_init(|| {
        let dir = chunked();
        let answer = dir.run(&format!("{CHUNKED} --csv map.csv --threads 1")).with(0, &[]).out;
        assert_eq!(dir.names("."), ["line.toml", "map.csv", "map.manifest.json"]);
        (dir.read("map.csv"), answer)
    })
}

/// The last words of an interrupted run: the command that goes on with it.
fn told_to_go_on(err: &str) -> &str {
    err.trim().split_once("; go on with: ").unwrap_or_else(|| panic!("{err}")).1
}

/// Kills and Ctrl-C, where the system has them and nobody has told them to be ignored.
#[cfg(unix)]
#[test]
fn a_stopped_ensemble_goes_on_where_it_was_and_ends_in_the_same_bytes() {
    use vibrochain_testkit::{interrupts_are_ignored, signal};
    let (expected, answer) = undisturbed();
    let mut stopped = 0;
    for (name, code) in [("INT", Some(130)), ("TERM", Some(130)), ("KILL", None)] {
        if name == "INT" && interrupts_are_ignored() {
            continue;
        }
        let dir = chunked();
        let mut child = dir.start(&format!("{CHUNKED} --csv map.csv --plot map.svg --threads 2"));
        dir.await_chunks(&mut child, "map.csv.parts", 2);
        let ran = signal(child, name);
        assert_eq!(ran.code, code, "{ran:?}");
        let finished = dir.chunks("map.csv.parts");
        assert!((2..6).contains(&finished) && !dir.path("map.csv").exists(), "{ran:?}");
        let again = "mapgen fate line.toml --out map.csv --breathers every --periods 10000 --seed 4 --starts 3 --plot map.svg --threads 2 --resume";
        if code.is_some() {
            let told = format!("{finished} of 6 chunks are finished, in map.csv.parts");
            assert!(ran.err.contains(&told) && told_to_go_on(&ran.err) == again, "{ran:?}");
        }
        // Without being asked to, it neither goes on nor throws anything away.
        dir.run(&format!("{CHUNKED} --csv map.csv")).with(2, &["chunks of an unfinished sweep", "--resume"]);
        let ran = dir.shell(again).with(0, &[]);
        assert!(dir.read("map.csv") == *expected && ran.out == *answer, "{name}: {ran:?}");
        assert_eq!(dir.names("."), ["line.toml", "map.csv", "map.manifest.json", "map.svg"]);
        stopped += 1;
    }
    assert!(stopped >= 2);
    // One that has no table keeps nothing.
    let dir = chunked();
    let child = dir.start(&format!("{CHUNKED}00000 --plot map.svg"));
    std::thread::sleep(std::time::Duration::from_millis(500));
    signal(child, "TERM").with(130, &["interrupted: nothing was written"]);
    assert_eq!(dir.names("."), ["line.toml"]);
}

#[test]
fn shards_of_an_ensemble_merge_to_the_same_bytes_and_what_is_missing_is_named() {
    let (expected, answer) = undisturbed();
    let dir = chunked();
    for shard in [2, 0] {
        let told = format!("shard {shard}/3: 2 of 6 chunks in parts");
        dir.run(&format!("{CHUNKED} --csv parts --shard {shard}/3 --threads {}", 1 + shard)).with(0, &[&told]);
    }
    let damaged = dir.path("parts/000003.chunk");
    let mut bytes = fs::read(&damaged).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&damaged, bytes).unwrap();
    let told = ["2 of 6 chunks are missing in parts: 1, 4", "000003.chunk: it is damaged: its checksum is wrong"];
    let ran = dir.run("merge parts --out map.csv").with(1, &told);
    let line = ran.err.lines().find_map(|line| line.strip_prefix("make them with: ")).unwrap();
    assert_eq!(
        line,
        "mapgen fate line.toml --out parts --breathers every --periods 10000 --seed 4 --starts 3 --shard 0/1 --resume"
    );
    // Another ensemble, or none, is another table.
    let told = ["parts belongs to another ensemble: ensemble.seed is \"4\" there, \"5\" here"];
    dir.run(&format!("{} --csv parts --shard 1/3 --resume", CHUNKED.replace("seed 4", "seed 5"))).with(2, &told);
    dir.run("sweep line.toml --out parts --shard 1/3 --resume").with(2, &["parts belongs to another ensemble"]);
    dir.shell(line).with(0, &["000003.chunk: it is damaged", "computing it again"]);
    for (flag, told) in [("--curves --png map.png", "--curves is of maps"), ("--json --svg -", "--json prints")] {
        dir.run(&format!("merge parts --out map.csv {flag}")).with(2, &[told]);
    }
    let merged = dir.run("merge parts --out map.csv --png map.png").with(0, &[]);
    assert!(dir.read("map.csv") == *expected && merged.out == *answer, "{merged:?}");
    assert_eq!(dir.names("."), ["line.toml", "map.csv", "map.manifest.json", "map.png", "parts"]);
    // Compressed, it holds the same.
    dir.run("merge parts --out map.csv.gz --json").with(0, &[]);
    assert!(dir.shell("gzip -dc map.csv.gz | cmp - map.csv").code == Some(0));
    // Sound in its bytes, but of no ensemble that could be.
    let plan = fs::read_to_string(dir.path("parts/plan.json")).unwrap();
    fs::write(dir.path("parts/plan.json"), plan.replace("\"every\"", "\"some\"")).unwrap();
    dir.run("merge parts --out other.csv").with(2, &["plan.json cannot be used: it is damaged"]);
}

const POINT: &str = "--sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --amplitude .1 --restitution .9";

#[test]
fn a_stroboscopic_section_is_the_trajectory_at_the_force_s_own_instants() {
    let dir = TestDir::new();
    fs::write(dir.path("state.json"), r#"{"displacement":[0.1,0,0,0,0],"velocity":[1.5,0,0.3,0,0]}"#).unwrap();
    // A quarter of a period before the force is greatest: samples 4 to a period meet the section at the second of each.
    let quarter = -0.25 * std::f64::consts::TAU / 1.5;
    let run = format!("simulate --state state.json --psi {quarter} {POINT} --periods 12");
    dir.run(&format!(
        "{run} --section s.csv --section-sites 2,0 --skip 3 --trajectory t.csv --samples 4 --impacts i.csv"
    ))
    .with(0, &[]);
    let (section, samples) = (table(&dir.read("s.csv")), table(&dir.read("t.csv")));
    assert_eq!(section[0], ["time", "period", "phase", "displacement_0", "displacement_2", "velocity_0", "velocity_2"]);
    assert_eq!(section.len(), 10);
    for (i, row) in section[1..].iter().enumerate() {
        let sample = &samples[1 + 4 * (3 + i) + 1];
        let same = |a: &str, b: &str| (a.parse::<f64>().unwrap() - b.parse::<f64>().unwrap()).abs() < 1e-9;
        assert!(row[1] == (3 + i).to_string() && same(&row[2], "0"), "{row:?}");
        // (time, five displacements, five velocities.)
        for (mine, theirs) in [(0, 0), (3, 1), (4, 3), (5, 6), (6, 8)] {
            assert!(same(&row[mine], &sample[theirs]), "{row:?} {sample:?}");
        }
    }
    // The run is the same as without.
    dir.run(&format!("{run} --impacts alone.csv")).with(0, &[]);
    assert_eq!(dir.read("i.csv"), dir.read("alone.csv"));
    assert!(table(&dir.read("i.csv")).len() > 5);
}

#[test]
fn a_section_at_impacts_has_those_of_its_masses_after_the_transient() {
    let dir = TestDir::new();
    let run = format!("simulate --family double-sided {POINT} --periods 20");
    dir.run(&format!("{run} --section s.csv --section-at impact --skip 5 --impacts i.csv")).with(0, &[]);
    let (section, impacts) = (table(&dir.read("s.csv")), table(&dir.read("i.csv")));
    assert_eq!(section[0], ["time", "period", "phase", "site", "barrier", "velocity_before", "velocity_after"]);
    // Two a period of one mass; the breather's own phases.
    assert_eq!((section.len(), impacts.len()), (31, 41));
    for (row, impact) in section[1..].iter().zip(&impacts[11..]) {
        assert_eq!((&row[0], &row[3], &row[4], &row[5]), (&impact[0], &impact[1], &impact[2], &impact[3]));
    }
    let phases: Vec<f64> = section[1..].iter().step_by(2).map(|row| row[2].parse().unwrap()).collect();
    assert!(phases.iter().all(|phase| (phase - phases[0]).abs() < 1e-6), "{phases:?}");
    for (flags, told) in [
        ("--section s.csv --skip 30", "--skip 30 is out of range"),
        ("--section s.csv --section-sites 5", "--section-sites 5 does not exist: give sites from 0 to 4"),
        ("--section s.csv --section-phase 1.5", "--section-phase 1.5 is out of range"),
        ("--skip 3", "--section"),
        ("--section i.csv --impacts i.csv", "i.csv"),
    ] {
        dir.run(&format!("{run} {flags}")).with(2, &[told]);
    }
}

#[test]
fn words_of_other_motions_stand_under_their_heading() {
    let dir = TestDir::with_scene(
        "[model]\nsites = 5\ngamma1 = 0.2\ngamma2 = 0.1\nasymmetry = 0.4\namplitude = 0.3\nrestitution = 0.8\n[sweep]\nx = { parameter = 'omega', values = [0.9, 1.1] }\n[compute]\nfamilies = ['double-sided', 'single-sided']\n",
    );
    let out = dir.run("fate scene.toml --breathers every --starts 2 --periods 300").with(0, &[]).out;
    let heading = out.lines().position(|line| line == "  impact words of `periodic`, by runs");
    let word = out.lines().position(|line| line.ends_with("  0+1+2+3+4+,0-1-2-3-4-"));
    assert!(heading.is_some() && word > heading, "{out}");
}
