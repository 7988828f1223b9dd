//! What all commands have in common, and what helps to begin.

use std::collections::BTreeSet;
use std::fs;

use serde_json::Value;
use vibrochain_testkit::{TestDir, written};

const MODEL: &str = "--sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";

#[test]
fn a_new_scene_computes_as_it_is_and_names_every_key() {
    let dir = TestDir::new();
    dir.run("init new.toml").with(0, &["mapgen sweep new.toml"]);
    dir.run("sweep new.toml --out map.csv --json").with(0, &[]);
    let text = String::from_utf8(dir.read("new.toml")).unwrap();
    let printed = dir.run("init -").with(0, &[]);
    assert_eq!((printed.out.as_str(), printed.err.as_str()), (text.as_str(), ""));
    // The keys that docs/scenes.md lists, which a test of its own holds against the parser.
    let table = fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../docs/scenes.md")).unwrap();
    let keys: BTreeSet<&str> = table.lines().filter_map(|line| line.strip_prefix("| `")?.split('`').next()).collect();
    let words: BTreeSet<&str> = text.split(|c: char| !c.is_alphanumeric() && c != '_').collect();
    let missing: Vec<_> = keys.difference(&words).collect();
    assert!(keys.len() > 25 && missing.is_empty(), "{missing:?} of {keys:?}");
    // What is commented out can be taken in, a line at a time: each is known, and refused at most beside what is there.
    let mut taken = 0;
    for line in text.lines().filter(|line| line.starts_with("# ") && line.contains(" = ")) {
        let key = line[2..].split(' ').next().unwrap();
        if !keys.contains(key) {
            continue;
        }
        fs::write(dir.path("one.toml"), text.replace(line, &line[2..])).unwrap();
        let ran = dir.run("sweep one.toml --out one.csv --dry-run");
        assert!(!ran.err.contains("unknown"), "{line}: {ran:?}");
        taken += 1;
    }
    assert!(taken >= 10, "{taken}");

    // What is there stays.
    fs::write(dir.path("new.toml"), "mine").unwrap();
    dir.run("init new.toml").with(2, &["new.toml is there already"]);
    assert_eq!(dir.read("new.toml"), b"mine");
    dir.run("init new.csv").with(2, &["end the name in .toml"]);
}

#[test]
fn shells_and_manuals_know_all_commands() {
    let dir = TestDir::new();
    let help = dir.run("--help").out;
    let listed = help.split("Commands:").nth(1).unwrap().split("Options:").next().unwrap();
    let commands: Vec<&str> = (listed.lines())
        .filter_map(|line| line.strip_prefix("  ")?.split(' ').next())
        .filter(|name| !name.is_empty() && *name != "help")
        .collect();
    assert!(commands.len() > 12 && commands.contains(&"sweep"), "{commands:?}");
    for shell in ["bash", "zsh", "fish"] {
        let script = dir.run(&format!("completions {shell}")).with(0, &[]).out;
        for command in &commands {
            assert!(script.contains(command), "{shell}: {command}");
        }
        assert!(script.contains("restitution"), "{shell}");
    }
    dir.run("completions csh").with(2, &["possible values: bash"]);
    dir.run("man pages").with(0, &["manual pages are in pages"]);
    let pages = dir.names("pages");
    assert_eq!(pages.len(), commands.len() + 1, "{pages:?}");
    for command in &commands {
        let page = String::from_utf8(dir.read(&format!("pages/mapgen-{command}.1"))).unwrap();
        assert!(page.contains(".SH DESCRIPTION"), "{command}");
    }
}

#[test]
fn version_and_time_are_told_to_those_who_ask() {
    let dir = TestDir::new();
    assert_eq!(dir.run("--version").out.lines().count(), 1);
    for line in ["--version --verbose", "-v --version"] {
        let about = dir.run(line).with(0, &[]).out;
        assert!(
            about.contains("revision") && about.contains("feature compress") && about.contains("cores "),
            "{about}"
        );
    }
    let ran =
        dir.run(&format!("orbit --family double-sided {MODEL} --verbose --threads 3")).with(0, &["at most 3 threads"]);
    assert!(ran.out.contains("1 solution, 1 physical"));
    for command in ["orbit --family double-sided", "simulate --family double-sided"] {
        dir.run(&format!("{command} {MODEL} --threads 0"))
            .with(2, &["out of range: give a whole number from 1 to 1024"]);
    }
}

#[test]
fn a_run_goes_on_from_its_own_answer() {
    let dir = TestDir::new();
    // Losses and a force, off any breather, so that the phase matters.
    let model = format!("{MODEL} --amplitude .3 --restitution .8");
    fs::write(dir.path("start.json"), r#"{"displacement":[0.1,-0.2,0.3,0,0.2],"velocity":[0.5,0,-1,0.1,0.3]}"#)
        .unwrap();
    let run = |state: &str, periods: f64, flags: &str| {
        dir.run(&format!("simulate --state {state} {model} --periods {periods} --json{flags}")).with(0, &[]).out
    };
    let whole = written(run("start.json", 3.75, " --psi .3"));
    fs::write(dir.path("half.json"), run("start.json", 1.3, " --psi .3")).unwrap();
    let half = dir.json("half.json");
    assert_eq!((&half["outcome"], &half["periods"]), (&"time-reached".into(), &1.into()));
    let rest = written(run("half.json", 2.45, ""));
    for name in ["displacement", "velocity"] {
        let [one, other] = [&whole, &rest].map(|run| run["state"][name].as_array().unwrap());
        assert_eq!((one.len(), other.len()), (5, 5));
        for (one, other) in one.iter().zip(other) {
            assert!((one.as_f64().unwrap() - other.as_f64().unwrap()).abs() < 1e-10, "{name}: {one} {other}");
        }
    }
    let count = |run: &Value| run["impacts"].as_u64().unwrap();
    assert!(count(&half) > 0 && count(&whole) == count(&half) + count(&rest));
}

#[test]
fn tables_and_json_of_an_answer_agree() {
    let dir = TestDir::new();
    let doubling = "--event period-doubling --free amplitude --family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .165 --restitution .25";
    let located = written(&dir.run(&format!("locate {doubling} --csv events.csv --json")).with(0, &[]).out);
    let mut table = csv::Reader::from_path(dir.path("events.csv")).unwrap();
    assert_eq!(table.headers().unwrap().iter().take(3).collect::<Vec<_>>(), ["event", "amplitude", "error"]);
    let rows: Vec<_> = table.records().map(Result::unwrap).collect();
    let points = located["points"].as_array().unwrap();
    assert!(!rows.is_empty() && rows.len() == points.len());
    for (row, point) in rows.iter().zip(points) {
        assert_eq!((&row[0], row[1].parse().ok()), ("period-doubling", point["value"].as_f64()));
        assert_eq!(row[3].split(' ').next().unwrap().parse().ok(), point["orbit"]["impacts"][0]["impulse"].as_f64());
    }

    let words =
        dir.run(&format!("words --sites-used 2 --reach 2 {MODEL} --all --csv words.csv --json")).with(0, &[]).out;
    let orbits = written(&words)["solutions"].as_array().unwrap().clone();
    let mut table = csv::Reader::from_path(dir.path("words.csv")).unwrap();
    let rows: Vec<_> = table.records().map(Result::unwrap).collect();
    assert!(rows.len() == orbits.len() && rows.len() >= 4, "{}", rows.len());
    for (row, orbit) in rows.iter().zip(&orbits) {
        assert_eq!((&row[0], row[2] == *"true"), (orbit["word"].as_str().unwrap(), orbit["physical"] == true));
        assert_eq!(row[6].parse().ok(), orbit["spectral_radius"].as_f64());
    }
}

#[test]
fn the_manifest_is_printed_for_those_who_ask() {
    let scene = "[model]\nsites = 5\ngamma1 = 0.2\ngamma2 = 0.1\nasymmetry = 0.4\n[sweep]\nx = { parameter = 'omega', from = 1.0, to = 2.0, points = 5 }\n[compute]\nfamilies = ['double-sided']\n";
    let dir = TestDir::with_scene(scene);
    let ran = dir.run("sweep scene.toml --out map.csv --json").with(0, &[]);
    assert_eq!((ran.out.into_bytes(), ran.err.as_str()), (dir.read("map.manifest.json"), ""));
    dir.run("sweep scene.toml --out - --json").with(2, &["--json prints to standard output"]);
    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    let merged = dir.run("merge parts --out again.csv --json").with(0, &[]);
    assert_eq!(merged.out.into_bytes(), dir.read("again.manifest.json"));
    assert_eq!(dir.read("again.csv"), dir.read("map.csv"));
    dir.run("merge parts --out - --json").with(2, &["--json prints to standard output"]);
}

/// The commands that a document shows in blocks of shell, a line each.
fn shown(text: &str) -> Vec<String> {
    let mut commands = Vec::new();
    for block in text.split("```sh\n").skip(1) {
        let block = block.split("```").next().unwrap().replace("\\\n", " ");
        for line in block.lines().map(str::trim) {
            // A comment, what it is piped to, or where it goes, is for the shell.
            let line = line.split(" #").next().unwrap().split(['|', '>', '&', ';']).next().unwrap();
            let called = line.strip_prefix("cargo run --locked --release -- ").or_else(|| line.strip_prefix("mapgen "));
            commands.extend(called.map(|rest| format!("mapgen {rest}")));
        }
    }
    commands
}

#[test]
fn the_documents_show_commands_that_the_program_understands() {
    let root = std::path::Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let mut pages = vec![root.join("README.md")];
    for folder in ["docs", "docs/guide", "docs/how"] {
        let entries = fs::read_dir(root.join(folder)).unwrap().map(|entry| entry.unwrap().path());
        pages.extend(entries.filter(|path| path.extension().is_some_and(|end| end == "md")));
    }
    let mut understood = 0;
    for page in pages {
        for command in shown(&fs::read_to_string(&page).unwrap()) {
            // Words in quotes stay together.
            let mut words: Vec<String> = Vec::new();
            for (i, part) in command.split('"').enumerate() {
                if i % 2 == 1 {
                    words.push(part.to_owned());
                } else {
                    words.extend(part.split_whitespace().map(str::to_owned));
                }
            }
            let read = vibrochain_cli::args::read::<vibrochain_cli::args::Cli>(words.iter().map(Into::into));
            if let Err(error) = read {
                assert!(error.exit_code() == 0, "{}: {command}\n{error}", page.display());
            }
            for scene in words.iter().filter(|word| word.starts_with("scenes/")) {
                assert!(root.join(scene).is_file(), "{}: {scene}", page.display());
            }
            understood += 1;
        }
    }
    assert!(understood > 30, "{understood}");
}

#[test]
fn what_a_build_lacks_is_told_by_its_feature() {
    let dir = TestDir::new();
    let about = dir.run("--version --verbose").with(0, &[]).out;
    for (feature, there) in [("explore", cfg!(feature = "explore")), ("parquet", cfg!(feature = "parquet"))] {
        let told = if there { "yes" } else { "no" };
        let line = about.lines().find(|line| line.starts_with(&format!("feature {feature} "))).unwrap();
        assert_eq!(line.split_whitespace().nth(2), Some(told), "{line}");
    }
    if !cfg!(feature = "explore") {
        dir.run("explore").with(2, &["build with the feature `explore`"]);
    }
}

#[test]
fn headings_of_help_hold_what_they_name() {
    let dir = TestDir::new();
    // What stands under "Pictures:" in the help of any command.
    let of_pictures = [
        "--plot",
        "--all-plots",
        "--format",
        "--animate",
        "--show",
        "--slice",
        "--curves",
        "--palette",
        "--style",
        "--width",
        "--dpi",
        "--font-size",
        "--letters",
        "--all",
        "--solution",
    ];
    let mut seen = 0;
    for command in ["sweep", "merge", "draw", "orbit", "branch", "curve", "curves", "simulate", "fate"] {
        let help = dir.run(&format!("{command} --help")).with(0, &[]).out;
        let section = help.split("\nPictures:\n").nth(1).unwrap_or_else(|| panic!("{command}: {help}"));
        // The next heading begins at the margin.
        let section: Vec<&str> = section.lines().take_while(|line| line.is_empty() || line.starts_with(' ')).collect();
        let flags = section
            .iter()
            .filter_map(|line| line.strip_prefix("      --"))
            .filter_map(|flag| flag.split([' ', '\n']).next());
        for flag in flags {
            assert!(of_pictures.contains(&format!("--{flag}").as_str()), "{command}: --{flag}");
            seen += 1;
        }
    }
    assert!(seen > 60, "{seen}");
}

#[test]
fn names_of_before_go_on_working_and_help_does_not_show_them() {
    let dir = TestDir::with_scene(
        "[model]\nsites = 5\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\nx = { parameter = 'omega', from = 1.0, to = 2.0, points = 5 }\ny = { parameter = 'gamma2', from = 0.0, to = 0.2, points = 4 }\n[compute]\nfamilies = ['double-sided']\nstability = true\n",
    );
    let mut same = 0;
    let mut alike = |old: &str, new: &str, files: &[&str]| {
        let of = |line: &str| {
            dir.run(line).with(0, &[]);
            files.iter().map(|name| (dir.read(name), fs::remove_file(dir.path(name)).unwrap()).0).collect::<Vec<_>>()
        };
        assert!(of(old) == of(new), "{old}");
        same += files.len();
    };
    alike("sweep scene.toml --csv map.csv", "sweep scene.toml --out map.csv", &["map.csv"]);
    let orbit = format!("orbit --family double-sided {MODEL}");
    alike(
        "sweep scene.toml --out map.csv --png a.png --svg a.svg --pdf a.pdf --color spectral-radius",
        "sweep scene.toml --out map.csv --plot a.png --plot a.svg --plot a.pdf --show spectral_radius",
        &["a.png", "a.svg", "a.pdf"],
    );
    alike("draw map.csv --svg a.svg --color margin", "draw map.csv --plot a.svg --show margin", &["a.svg"]);
    alike("stripes scene.toml --widths a.csv", "stripes scene.toml --out a.csv", &["a.csv"]);
    alike(
        &format!("{orbit} --all-plots p --svg"),
        &format!("{orbit} --all-plots p --format svg"),
        &["p/solution-1-profile.svg"],
    );
    let locate = format!("locate --event fold --free omega --family double-sided {MODEL}");
    alike(&format!("{locate} --csv a.csv"), &format!("{locate} --out a.csv"), &["a.csv"]);
    assert!(same >= 2);
    for command in
        ["sweep", "merge", "draw", "orbit", "locate", "branch", "curve", "curves", "words", "fate", "stripes"]
    {
        let help = dir.run(&format!("{command} --help")).with(0, &[]).out;
        for old in ["--csv", "--png", "--svg", "--pdf", "--color"] {
            assert!(!help.contains(old), "{command}: {old}");
        }
    }
}

#[test]
fn quiet_commands_say_nothing_and_write_what_is_asked_for() {
    let dir = TestDir::with_scene(
        "[model]\nsites = 5\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\nx = { parameter = 'omega', from = 1.4, to = 1.6, points = 3 }\ny = { parameter = 'gamma2', from = 0.05, to = 0.2, points = 3 }\n[compute]\nfamilies = ['double-sided']\nstability = true\n",
    );
    let start = format!("--family double-sided {MODEL}");
    let mut quiet = vec![
        format!("orbit {start}"),
        format!("simulate {start} --periods 2"),
        format!("words --sites-used 1 --reach 0 {MODEL}"),
        format!("words --sites-used 1 --reach 0 {MODEL} --from-zero"),
        format!("locate --event fold --free omega {start}"),
        format!("branch --free omega {start} --events grazing"),
        format!("curve --event grazing --free omega --and gamma2 --tolerance 1e-2 {start}"),
        "curves scene.toml --places 0 --tolerance 1e-3".to_owned(),
        "fate scene.toml --starts 1 --periods 20".to_owned(),
        "init new.toml".to_owned(),
    ];
    quiet.push("stripes scene.toml".to_owned());
    for line in &quiet {
        let loud = dir.run(line).with(0, &[]);
        assert!(!(loud.out + &loud.err).is_empty(), "{line}");
        let _ = fs::remove_file(dir.path("new.toml"));
        let ran = dir.run(&format!("{line} --quiet")).with(0, &[]);
        assert_eq!((ran.out.as_str(), ran.err.as_str()), ("", ""), "{line}");
    }
    assert!(dir.run(&format!("orbit {start} --quiet --json")).with(0, &[]).out.starts_with('{'));
    dir.run(&format!("simulate {start} --periods 2 --impacts a.csv -q")).with(0, &[]);
    assert!(!dir.read("a.csv").is_empty());
    dir.run(&format!("orbit {start} --omega 0 -q")).with(2, &["omega"]);
}

#[test]
fn a_flag_or_command_that_is_not_there_gets_a_tip_that_helps() {
    let dir = TestDir::new();
    let scene = "fate scene.toml";
    let orbit = format!("orbit --family double-sided {MODEL}");
    let cases = [
        (format!("{scene} --png a.png"), "pictures are --plot FILE"),
        (format!("{scene} --pgn a.png"), "pictures are --plot FILE"),
        ("sweep scene.toml --out a.csv --plto a.png".to_owned(), "did you mean --plot?"),
        (format!("{orbit} --friction .1"), "friction cannot be said"),
        (format!("{orbit} --viscosity .1"), "--damping of each mass"),
        (format!("{orbit} --mass 2"), "all masses of a chain are 1"),
        (format!("{orbit} --gama1 2"), "did you mean --gamma1?"),
        (format!("{orbit} --starts 3"), "--starts is of fate, not of orbit"),
        ("animate".to_owned(), "simulate … --animate run.gif"),
        ("sweeep".to_owned(), "did you mean `sweep`?"),
        ("valdate".to_owned(), ""),
    ];
    for (line, tip) in &cases {
        let ran = dir.run(line).with(2, &[*tip]);
        assert_eq!(ran.err.contains("tip:"), !tip.is_empty(), "{ran:?}");
        assert!(!ran.err.contains("similar") && !ran.err.contains("as a value"), "{ran:?}");
    }
    // Out of range is out of one range.
    for threads in ["0", "-1", "1025"] {
        dir.run(&format!("{orbit} --threads {threads}")).with(2, &["give a whole number from 1 to 1024"]);
    }
}
