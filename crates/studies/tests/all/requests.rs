//! What is wrong with a request is told before anything is computed or written.

use std::fs;

use vibrochain_testkit::{Ran, TestDir, studies};

#[test]
fn names_and_endings_are_looked_at_first() {
    let dir = TestDir::of("studies");
    for (line, told) in [
        ("figures --only 3 --out figures.svg", "--out figures.svg ends as a file does"),
        ("figures --only 3 --out figures --document new/../figures", "--out and --document"),
        ("accuracy --quick --out docs.md", "--out docs.md ends as a file does"),
        ("validate --out table.csv", "a document in Markdown is written here"),
        ("errata --out table.json", "a document in Markdown is written here"),
    ] {
        dir.run(line).with(2, &[told]);
        assert!(dir.names(".").is_empty(), "{line}");
    }
    for line in ["figures --out figures --only 9", "accuracy --out accuracy --quick --suite extremes"] {
        let ran: Ran = dir.command(line).env("RAYON_NUM_THREADS", "100000").output().unwrap().into();
        ran.with(2, &["RAYON_NUM_THREADS 100000 is out of range: give a whole number from 1 to 1024"]);
    }
}

#[test]
fn documents_go_to_standard_output_too() {
    let dir = TestDir::of("studies");
    dir.run("validate --out table.md").with(0, &[]);
    let shown = dir.run("validate --out -").with(0, &[]);
    assert!(shown.out.as_bytes() == dir.read("table.md") && shown.out.len() > 100);
}

#[test]
fn a_figure_on_a_resonance_is_exit_code_three() {
    let dir = TestDir::of("studies");
    fs::create_dir(dir.path("scenes")).unwrap();
    // 2ω on the uniform mode.
    let figure = "[figure]\nkind = \"trace\"\ntitle = \"t\"\nfamily = \"single-sided\"\n[model]\nsites = 5\n\
                  gamma1 = 0.25\ngamma2 = 0.1\nomega = 0.25\nasymmetry = 0.4\n";
    fs::write(dir.path("scenes/figure-1.toml"), figure).unwrap();
    dir.run("figures --scenes scenes --out out").with(3, &["harmonic 2 of omega = 0.25 meets mode 0"]);
}

#[test]
fn the_validation_table_is_what_the_command_prints() {
    let run = studies(&[]).arg("validate").assert().success();
    let text = String::from_utf8(run.get_output().stdout.clone()).unwrap();
    let rows: Vec<Vec<&str>> = text
        .lines()
        .filter(|line| line.contains("-sided |") || line.contains("-doubled |"))
        .map(|line| line.split('|').map(str::trim).collect())
        .collect();
    assert!(rows.len() >= 24);
    for row in rows {
        let number = |i: usize| row[i].parse::<f64>().ok();
        assert!(number(9).unwrap() < 1e-11 && number(11).unwrap() < 1e-7, "{row:?}");
        assert!(number(10).is_none_or(|drift| drift < 1e-9), "{row:?}");
        let leading = number(12).unwrap();
        assert!(number(13).is_none_or(|growth| (growth / leading - 1.0).abs() < 1e-3), "{row:?}");
    }
}
