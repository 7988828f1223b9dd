//! docs/guide/names.md against the program: every name is there, in each row they agree, and none is missing.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};

use clap::CommandFactory;
use serde_json::Value;
use vibrochain_cli::args::Cli;
use vibrochain_cli::common::schemas;
use vibrochain_testkit::{Schema, TestDir};

type Names = BTreeSet<String>;

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

fn page() -> String {
    fs::read_to_string(repository().join("docs/guide/names.md")).unwrap()
}

/// What is between backquotes.
fn quoted(text: &str) -> impl Iterator<Item = String> + '_ {
    text.split('`').skip(1).step_by(2).map(str::to_owned)
}

/// All long flags of all commands, studies aside.
fn flags() -> Names {
    fn collect(command: &clap::Command, found: &mut Names) {
        found.extend(command.get_arguments().filter(|argument| !argument.is_hide_set()).filter_map(|argument| {
            let name = argument.get_long().filter(|name| !["help", "version"].contains(name));
            name.map(|name| format!("--{name}"))
        }));
        command.get_subcommands().filter(|inner| !inner.is_hide_set()).for_each(|inner| collect(inner, found));
    }
    let mut found = Names::new();
    collect(&Cli::command(), &mut found);
    found
}

/// All keys of a schema.
fn properties(schema: &Value, keys: &mut Names) {
    match schema {
        Value::Object(rules) => {
            if let Some(properties) = rules.get("properties").and_then(Value::as_object) {
                keys.extend(properties.keys().cloned());
            }
            rules.values().for_each(|rule| properties(rule, keys));
        }
        Value::Array(rules) => rules.iter().for_each(|rule| properties(rule, keys)),
        _ => {}
    }
}

/// Those of a scene; and those of everything else.
fn keys() -> [Names; 2] {
    let (mut scene, mut rest) = (Names::new(), Names::new());
    properties(Schema::named("scene").value(), &mut scene);
    for name in schemas::names().into_iter().filter(|name| *name != "scene") {
        properties(Schema::named(name).value(), &mut rest);
    }
    [scene, rest]
}

const SCENE: &str = "[model]\nsites = 6\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\n\
    x = { parameter = \"omega\", from = 1.5, to = 1.7, points = 6 }\n\
    y = { parameter = \"gamma2\", from = 0.14, to = 0.16, points = 3 }\n\
    [compute]\nfamilies = [\"double-sided\"]\nstability = true\ncollisions = true\n";

/// What varies has a column.
const OTHER: &str = "[model]\nsites = 3\nlayers = 2\nomega = 1.5\ngamma2 = 0.1\n[sweep]\n\
    axes = [{ parameter = \"gamma1\", values = [0.2] }, { parameter = \"gamma3\", values = [0.05] }, { parameter = \"asymmetry\", values = [0.4] }]\n\
    [compute]\nfamilies = [\"0:0+0:1+,0:0-0:1-\"]\n";

/// Dashpots, too.
const DAMPED: &str = "[model]\nsites = 3\ngamma1 = 0.2\ngamma2 = 0.1\nomega = 1.5\nasymmetry = 0.4\namplitude = 0.1\nrestitution = 0.9\n[sweep]\n\
    axes = [{ parameter = \"damping\", values = [0.01] }, { parameter = \"coupling_damping\", values = [0.005] }]\n\
    [compute]\nfamilies = [\"double-sided\"]\n";

/// The columns of all tables that the program writes. Those of displacements and velocities are numbered by the mass.
fn columns() -> Names {
    const ORBIT: &str = "--family single-sided --sites 6 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";
    const FORCED: &str = "--family single-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.07 --asymmetry .8 --amplitude .165 --restitution .25";
    let layered = "--word 0:0+0:1+,0:0-0:1- --sites 6 --layers 2 --gamma3 .05 --gamma1 .2 --gamma2 .05 --omega 1.5 --asymmetry .2";
    let dir = TestDir::with_scene(SCENE);
    fs::write(dir.path("other.toml"), OTHER).unwrap();
    fs::write(dir.path("damped.toml"), DAMPED).unwrap();
    let mut commands = vec![
        "sweep other.toml --out table".to_owned(),
        "sweep damped.toml --out table".to_owned(),
        "sweep scene.toml --out table".to_owned(),
        "curves scene.toml --csv table --points more".to_owned(),
        format!("orbit {ORBIT} --multipliers table"),
        format!("simulate {layered} --periods 1 --impacts table --trajectory more"),
        "fate other.toml --starts 1 --periods 20 --csv table".to_owned(),
        format!("simulate {layered} --periods 2 --section table --skip 1"),
        "words --sites-used 1 --reach 0 --sites 6 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4 --csv table"
            .to_owned(),
        format!("locate {FORCED} --event fold --free amplitude --csv table"),
        format!("branch {FORCED} --free amplitude --from .16 --to .17 --csv table"),
        format!("curve {FORCED} --event fold --free amplitude --and restitution --tolerance 1e-2 --csv table"),
    ];
    commands.push("stripes scene.toml --out table".to_owned());
    let (mut found, mut tables) = (Names::new(), 0);
    for command in commands {
        let command = command.replace(" table", " table.csv").replace(" more", " more.csv");
        dir.run(&command).with(0, &[]);
        for name in ["table.csv", "more.csv"].into_iter().filter(|name| command.contains(name)) {
            let text = String::from_utf8(dir.read(name)).unwrap();
            found.extend(text.lines().next().unwrap().split(',').map(str::to_owned));
            tables += 1;
        }
    }
    assert!(tables >= 12, "{tables}");
    let numbered = |name: &String| {
        let mass =
            ["displacement_", "velocity_"].iter().find_map(|begin| name.strip_prefix(begin)?.parse::<u32>().ok());
        mass.is_some_and(|mass| mass > 0)
    };
    found.retain(|name| !numbered(name));
    found
}

/// All source of the crates that are libraries.
fn sources() -> Vec<String> {
    fn collect(folder: &Path, found: &mut Vec<String>) {
        for entry in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if entry.is_dir() {
                collect(&entry, found);
            } else {
                found.push(fs::read_to_string(&entry).unwrap());
            }
        }
    }
    let mut found = Vec::new();
    for name in ["lattice", "breather", "floquet", "eventsim", "maps", "fate"] {
        collect(&repository().join("crates").join(name).join("src"), &mut found);
    }
    found
}

/// Whether `text` has `what` as a whole word.
fn has(text: &str, what: &str) -> bool {
    let part = |c: char| c.is_alphanumeric() || c == '_';
    text.match_indices(what).any(|(at, _)| !text[at + what.len()..].starts_with(part))
}

/// `Type::name` is a field, a method or a variant of that type.
fn is_rust(name: &str, sources: &[String]) -> bool {
    let (of, name) = name.split_once("::").unwrap();
    let named = |text: &&String| ["struct", "enum", "impl"].iter().any(|word| has(text, &format!("{word} {of}")));
    sources.iter().filter(named).any(|text| {
        [format!("pub fn {name}"), format!("pub {name}:"), format!("    {name}")].iter().any(|form| has(text, form))
    })
}

/// `Class.name` is a property or a method of the stub, or an attribute that the class describes, or one that it is derived from.
fn is_python(name: &str) -> bool {
    let (of, name) = name.split_once('.').unwrap();
    let folder = repository().join("crates/python/python/vibrochain");
    ["_vibrochain.pyi", "_map.py", "_run.py", "_fate.py"].iter().any(|file| {
        let text = fs::read_to_string(folder.join(file)).unwrap();
        let mut of = of.to_owned();
        while let Some(class) = text
            .split("\nclass ")
            .find(|class| class.starts_with(&format!("{of}:")) || class.starts_with(&format!("{of}(")))
        {
            let forms = [format!("def {name}("), format!("self.{name}:"), format!("self.{name} =")];
            if forms.iter().any(|form| class.contains(form)) {
                return true;
            }
            let base = class.strip_prefix(&format!("{of}(")).and_then(|rest| rest.split_once("):"));
            let Some((base, _)) = base else { break };
            base.clone_into(&mut of);
        }
        false
    })
}

#[test]
fn every_name_is_the_programs_and_in_each_row_they_agree() {
    let (flags, [scene, json], columns, sources) = (flags(), keys(), columns(), sources());
    let mut checked = [0; 6];
    let mut wrong = Vec::new();
    let page = page();
    for row in page.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| thing")) {
        let fields: Vec<&str> = row.split('|').map(str::trim).collect();
        assert_eq!(fields.len(), 10, "{row}");
        let mut names = Vec::new();
        for (place, field) in fields[2..8].iter().enumerate() {
            let Some(name) = quoted(field).next() else {
                assert!(field.is_empty(), "{row}");
                continue;
            };
            let there = match place {
                0 => flags.contains(&name),
                1 => scene.contains(&name),
                2 => columns.contains(&name),
                3 => json.contains(&name),
                4 => is_rust(&name, &sources),
                _ => is_python(&name),
            };
            if !there {
                wrong.push(format!("there is no {name}: {row}"));
            }
            checked[place] += 1;
            let last = name.rsplit(['.', ':']).next().unwrap();
            let plain = last.trim_start_matches("--").trim_start_matches("is_").replace('-', "_");
            names.push(plain);
        }
        names.dedup();
        // A reason for a difference, and none where there is none.
        if (names.len() > 1) == fields[8].is_empty() {
            wrong.push(format!("{names:?}: {row}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(checked.iter().zip([20, 18, 25, 60, 60, 55]).all(|(count, least)| *count >= least), "{checked:?}");
}

/// A flag that takes the name of a column has it as the column is called.
#[test]
fn values_of_flags_are_called_as_columns_are() {
    let (columns, program) = (columns(), Cli::command());
    let (mut flags, mut unknown) = (0, Vec::new());
    for argument in program.get_subcommands().flat_map(clap::Command::get_arguments) {
        if !["color", "show"].contains(&argument.get_long().unwrap_or_default()) {
            continue;
        }
        flags += 1;
        let values = argument.get_possible_values();
        unknown.extend(values.iter().map(|value| value.get_name().to_owned()).filter(|name| !columns.contains(name)));
    }
    assert!(flags >= 4 && unknown.is_empty(), "{flags} {unknown:?}");
}

#[test]
fn no_flag_key_or_column_is_missing() {
    let page = page();
    let told: Names = quoted(&page).collect();
    let lack = |names: Names| names.into_iter().filter(|name| !told.contains(name)).collect::<Vec<_>>();
    let [scene, json] = keys();
    let missing = [lack(flags()), lack(scene), lack(columns()), lack(json)];
    assert!(missing.iter().all(Vec::is_empty), "{missing:#?}");
}
