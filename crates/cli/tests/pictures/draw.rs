//! `mapgen draw`: every table with a picture is drawn again from it, byte for byte, and none that is damaged.

use std::fs;

use vibrochain_testkit::TestDir;

const DOUBLING: &str = "--family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .165 --restitution .25";

const MAP: &str = "title = 'six'\n[model]\nsites = 6\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
    x = { parameter = 'omega', from = 0.6, to = 2.0, points = 31 }\n\
    y = { parameter = 'gamma2', from = 0.0, to = 0.3, points = 21 }\n\
    [compute]\nfamilies = ['double-sided-symmetric', 'single-sided']\nstability = true\n";

const RUNS: &str = "[model]\nsites = 5\ngamma1 = 0.2\nasymmetry = 0.4\nforcing = { amplitude = 0.1, restitution = 0.9 }\n[sweep]\n\
    x = { parameter = 'omega', from = 1.3, to = 1.7, points = 4 }\n\
    y = { parameter = 'gamma2', from = 0.05, to = 0.15, points = 3 }\n\
    [compute]\nfamilies = ['double-sided']\nstability = true\nthreshold = 0.01\n";

const LINE: &str = "[model]\nsites = 1\ngamma1 = 0.2\ngamma2 = 0\nomega = 1.2\nasymmetry = 0.4\nrestitution = 0.8\n[sweep]\n\
    axes = [{ parameter = 'amplitude', from = 0.1, to = 0.4, points = 6, spacing = 'log' }]\n\
    [compute]\nfamilies = ['single-sided']\nstability = true\n";

/// A folder with the tables of all commands that write one with a picture, and what draws each again: the command with TABLE and PICTURE,
/// and what else `draw` is told.
fn drawn() -> (TestDir, Vec<(&'static str, String, &'static str)>) {
    let dir = TestDir::with_scene(MAP);
    fs::write(dir.path("runs.toml"), RUNS).unwrap();
    fs::write(dir.path("line.toml"), LINE).unwrap();
    dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
    let lines = vec![
        ("ends", "fate runs.toml --starts 2 --periods 60 --seed 3 --csv TABLE --plot PICTURE".to_owned(), ""),
        ("shares", "fate line.toml --starts 3 --periods 60 --csv TABLE --plot PICTURE".to_owned(), ""),
        ("section", "fate line.toml --periods 60 --points 9 --diagram TABLE --plot PICTURE".to_owned(), ""),
        (
            "branch",
            format!(
                "branch --free amplitude --from .15 --to .17 --switch {DOUBLING} --all --show impulse,phi,psi,margin,spectral-radius \
                 --csv TABLE --plot PICTURE"
            ),
            "--all --show impulse,phi,psi,margin,spectral-radius",
        ),
        ("plain", format!("branch --free amplitude --from .16 --to .17 {DOUBLING} --csv TABLE --plot PICTURE"), ""),
        (
            "curve",
            format!(
                "curve --event period-doubling --free amplitude --from .1 --to .25 --and restitution --and-from .05 --and-to .4 \
                 --tolerance 1e-3 {DOUBLING} --csv TABLE --plot PICTURE"
            ),
            "",
        ),
        (
            "touch",
            "curve --event grazing --free amplitude --from .1 --to .25 --and restitution --and-from .05 --and-to 1 --tolerance 1e-3 \
             --family period-doubled --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .1583 --restitution .25 \
             --csv TABLE --plot PICTURE"
                .to_owned(),
            "",
        ),
    ];
    for (name, line, _) in &lines {
        let line = line.replace("TABLE", &format!("{name}.csv")).replace("PICTURE", &format!("{name}.svg"));
        dir.run(&line).with(0, &[]);
    }
    // What is drawn again asks for none of them.
    ["scene.toml", "runs.toml", "line.toml"].iter().for_each(|name| fs::remove_file(dir.path(name)).unwrap());
    (dir, lines)
}

#[test]
fn every_table_with_a_picture_is_drawn_again_to_the_byte() {
    let (dir, lines) = drawn();
    for (name, _, flags) in &lines {
        dir.run(format!("draw {name}.csv --svg again.svg --png again.png {flags}").trim_end()).with(0, &[]);
        assert!(dir.read("again.svg") == dir.read(&format!("{name}.svg")), "{name}");
        assert!(dir.read("again.svg").len() > 5000 && dir.read("again.png").starts_with(b"\x89PNG"), "{name}");
        // From a pipe to a pipe, where the manifest must be named.
        let piped = format!("mapgen draw - --scene {name}.manifest.json --svg - {flags} < {name}.csv > piped.svg");
        dir.shell(&piped).with(0, &[]);
        assert!(dir.read("piped.svg") == dir.read("again.svg"), "{name}");
    }
    assert_eq!(lines.len(), 7);
    assert!(String::from_utf8(dir.read("touch.svg")).unwrap().contains("curve 1: site 4 touches the lower barrier"));
    // One that is merged of shards has the same manifest beside it.
    let dir = TestDir::new();
    fs::write(dir.path("runs.toml"), RUNS).unwrap();
    let flags = "--starts 2 --periods 60";
    dir.run(&format!("fate runs.toml {flags} --csv parts --shard 0/1 --quiet")).with(0, &[]);
    dir.run("merge parts --out merged.csv --svg merged.svg --quiet").with(0, &[]);
    dir.run(&format!("fate runs.toml {flags} --csv whole.csv --quiet")).with(0, &[]);
    assert!(dir.read("merged.manifest.json") == dir.read("whole.manifest.json"));
    dir.run("draw whole.csv --svg whole.svg").with(0, &["12 cells"]);
    assert!(dir.read("merged.svg") == dir.read("whole.svg"));
}

#[test]
fn what_is_no_table_or_a_damaged_one_is_refused() {
    let (dir, lines) = drawn();
    let refused = |line: &str, told: &str| {
        let before = dir.names(".");
        dir.run(line.trim_end()).with(2, &[told]);
        assert_eq!(dir.names("."), before, "{line}");
    };
    let mut damaged = 0;
    for (name, _, flags) in &lines {
        let text = String::from_utf8(dir.read(&format!("{name}.csv"))).unwrap();
        let manifest = format!("--scene {name}.manifest.json");
        let draw = |table: &str| format!("draw {table} --svg new.svg {manifest} {flags}").trim_end().to_owned();
        let rows: Vec<&str> = text.lines().collect();
        let last = rows.len() - 1;
        // A row less, a field less, a row without its end, a word where a number is, a number without bound.
        let whole = |rows: &[String]| rows.iter().map(|row| format!("{row}\n")).collect::<String>();
        let with = |at: usize, row: &str| {
            let mut rows: Vec<String> = rows.iter().map(|row| (*row).to_owned()).collect();
            row.clone_into(&mut rows[at]);
            whole(&rows)
        };
        let first: Vec<&str> = rows[1].split(',').collect();
        let number = first.iter().position(|field| field.contains('.') && field.parse::<f64>().is_ok()).unwrap();
        let changed = |to: &str| {
            let fields: Vec<&str> =
                first.iter().enumerate().map(|(i, field)| if i == number { to } else { field }).collect();
            with(1, &fields.join(","))
        };
        let cut = whole(&rows[..last].iter().map(|row| (*row).to_owned()).collect::<Vec<_>>());
        for text in [cut, with(1, first[0]), changed("many"), changed("inf"), text.replacen('\n', "", 1)] {
            fs::write(dir.path("bad.csv"), text).unwrap();
            refused(&draw("bad.csv"), "table bad.csv: ");
            damaged += 1;
        }
        fs::remove_file(dir.path("bad.csv")).unwrap();
        // Of another table, of none, or damaged.
        let other = if ["curve", "touch"].contains(name) { "branch" } else { "curve" };
        refused(&format!("draw {name}.csv --svg new.svg --scene {other}.manifest.json {flags}"), "it is of a table of");
        refused(&format!("draw {name}.csv --svg new.svg --scene map.manifest.json {flags}"), "urn:vibrochain:table:1");
        fs::write(dir.path("bad.json"), "{").unwrap();
        refused(&format!("draw {name}.csv --svg new.svg --scene bad.json {flags}"), "manifest bad.json: ");
        fs::remove_file(dir.path("bad.json")).unwrap();
        refused(
            &format!("draw {name}.csv --svg new.svg --palette paper {flags}"),
            "--palette is of maps, this is a table of",
        );
    }
    assert_eq!(damaged, 35);
    refused("draw ends.csv --svg new.svg --show phi", "--show is of tables of sweep or branch, this is one of fate");
    refused("draw curve.csv --svg new.svg --all", "--all is of tables of branch, this is one of curve");
    refused("draw - --svg new.svg", "table -: it is empty");
    refused("draw ends.csv --svg ends.manifest.json", "the scene and --svg are the same file");
    // Tables without a picture.
    fs::write(dir.path("scene.toml"), MAP).unwrap();
    dir.run("curves scene.toml --csv borders.csv --places 100 --quiet").with(0, &[]);
    refused("draw borders.csv --svg new.svg", "and not what lives between them");
    dir.run(&format!("locate --event fold --free amplitude {DOUBLING} --csv events.csv")).with(0, &[]);
    refused("draw events.csv --svg new.svg", "no picture is known of the columns");
    fs::write(dir.path("empty.csv"), "").unwrap();
    refused("draw empty.csv --svg new.svg", "it is empty");
    refused("draw none.csv --svg new.svg", "it cannot be read as a table");
    refused("draw ends.csv.gz --svg new.svg", "unpack it first");
    fs::remove_file(dir.path("branch.manifest.json")).unwrap();
    refused("draw branch.csv --svg new.svg", "branch.manifest.json is not there, which says what the table is of");
}
