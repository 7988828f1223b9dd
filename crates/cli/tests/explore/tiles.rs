//! Tiles are what a sweep computes and draws.

use std::fs;

use serde_json::{Value, json};
use vibrochain_floquet::Mechanism;
use vibrochain_maps::cell::{Class, Status};
use vibrochain_testkit::{Cells, TestDir, written};

use crate::served::{Served, scene};

/// The cell number `i` of a tile, as its row in a table has it.
fn row(tile: &[u8], cells: usize, i: usize) -> [String; 6] {
    let number = |k: usize| {
        let value = f64::from_le_bytes(tile[8 * (k * cells + i)..][..8].try_into().unwrap());
        if value.is_nan() { String::new() } else { format!("{:016x}", value.to_bits()) }
    };
    let byte = |k: usize| usize::from(tile[(16 + k) * cells + i]);
    let name = |names: &[&'static str], k: usize| names.get(byte(k)).map_or(String::new(), ToString::to_string);
    let classes: Vec<&str> = Class::ALL.iter().map(|class| class.name()).collect();
    let mechanisms: Vec<&str> = Mechanism::ALL.iter().map(|mechanism| mechanism.name()).collect();
    let statuses: Vec<&str> = Status::ALL.iter().map(|status| status.name()).collect();
    [name(&classes, 0), name(&mechanisms, 1), number(0), number(1), byte(3).to_string(), name(&statuses, 2)]
}

/// Through two programs, of which only one knows tiles.
#[test]
fn a_tile_is_to_the_bit_what_a_sweep_of_its_range_computes() {
    let served = Served::new(" --threads 2");
    let mut cases = Vec::new();
    let compute = |families: Value| json!({ "families": families, "stability": true });
    let forced = json!({ "sites": 5, "gamma1": 0.2, "asymmetry": 0.4, "amplitude": 0.1, "restitution": 0.9 });
    cases.push((
        scene(),
        vec![(0, 0, 0), (3, 3, 2), (3, 7, 7), (10, 380, 301), (20, 400_001, 314_159), (30, 1 << 29, 123_456_789)],
    ));
    let mut other = scene();
    (other["model"], other["compute"]) = (forced.clone(), compute(json!(["single-sided", "double-sided"])));
    cases.push((other.clone(), vec![(0, 0, 0), (6, 27, 22), (20, 500_000, 300_000)]));
    other["compute"]["threshold"] = 0.01.into();
    cases.push((other, vec![(2, 1, 1)]));
    let mut words = scene();
    (words["model"]["sites"], words["compute"]) = (8.into(), compute(json!(["0+3+,0-3-", "0+3-,0-3+"])));
    cases.push((words, vec![(1, 0, 0), (15, 12_345, 4321)]));
    let mut symmetric = scene();
    (symmetric["model"]["asymmetry"], symmetric["compute"]) = (0.0.into(), compute(json!(["double-sided-symmetric"])));
    cases.push((symmetric, vec![(4, 5, 9)]));
    let mut existence = scene();
    existence["compute"] = json!({ "families": ["double-sided"] });
    cases.push((existence, vec![(20, 1_048_575, 0)]));
    let mut turned = scene();
    turned["model"] = json!({ "sites": 5, "gamma1": 0.2, "gamma2": 0.1, "omega": 1.07, "restitution": 0.25 });
    turned["sweep"] = json!({
        "x": { "parameter": "amplitude", "from": 0.1, "to": 0.3, "points": 2 },
        "y": { "parameter": "asymmetry", "from": 0.5, "to": 0.9, "points": 2 },
    });
    turned["compute"] = compute(json!(["single-sided"]));
    cases.push((turned, vec![(0, 0, 0), (20, 300_000, 700_000)]));

    let (mut tiles, mut classes, mut compared) = (0, std::collections::BTreeSet::new(), 0);
    for (scene, places) in cases {
        for (z, x, y) in places {
            let answer = served.post("tile", &json!({ "scene": scene, "z": z, "x": x, "y": y }));
            assert_eq!(answer.code, 200, "{answer:?}");
            const SIDE: usize = 64;
            assert_eq!(answer.body.len(), SIDE * SIDE * 20);
            // Where the tile is, worked out anew.
            let mut range = scene.clone();
            for (axis, number) in [("x", x), ("y", y)] {
                let end = |key: &str| scene["sweep"][axis][key].as_f64().unwrap();
                let step = (end("to") - end("from")) / (SIDE as f64 * 2f64.powi(z));
                let at = |cell: f64| end("from") + (f64::from(number) * SIDE as f64 + cell + 0.5) * step;
                let own = &mut range["sweep"][axis];
                (own["from"], own["to"], own["points"]) = (at(0.0).into(), at(63.0).into(), SIDE.into());
            }
            fs::write(served.dir.path("tile.json"), range.to_string()).unwrap();
            served.dir.run("sweep tile.json --out tile.csv --quiet").with(0, &[]);
            let text = String::from_utf8(served.dir.read("tile.csv")).unwrap();
            let mut lines = text.lines();
            let header: Vec<&str> = lines.next().unwrap().split(',').collect();
            let column = |name: &str| header.iter().position(|own| *own == name).unwrap();
            let columns = ["class", "mechanism", "spectral_radius", "margin", "solutions", "status"].map(column);
            let bits =
                |text: &str| text.parse::<f64>().map_or(String::new(), |value| format!("{:016x}", value.to_bits()));
            for (i, line) in lines.enumerate() {
                let fields: Vec<&str> = line.split(',').collect();
                let [class, mechanism, radius, margin, solutions, status] = columns.map(|column| fields[column]);
                let expected =
                    [class.into(), mechanism.into(), bits(radius), bits(margin), solutions.into(), status.into()];
                assert_eq!(row(&answer.body, SIDE * SIDE, i), expected, "{z}/{x}/{y}, cell {i}");
                classes.insert(class.to_owned());
                compared += 1;
            }
            tiles += 1;
        }
    }
    assert_eq!((tiles, compared), (16, 16 * 64 * 64));
    assert!(classes.len() >= 8, "{classes:?}");
}

/// The colours of numbers are those of `sweep --color`, for the cells of a tile: each by its own number, and the scale with its ticks.
#[test]
fn numbers_have_the_colours_of_a_sweep() {
    const SIDE: usize = 64;
    let served = Served::new("");
    let start = served.get("start").json();
    let rgb = |value: &Value| {
        let number = value.as_u64().unwrap();
        [number >> 16, number >> 8 & 255, number & 255].map(|part| part as u8)
    };
    let colours: Vec<[u8; 3]> = start["colours"]["scale"].as_array().unwrap().iter().map(rgb).collect();
    let below = rgb(&start["colours"]["below"]);
    let (mut numbers, mut none, mut lower) = (0, 0, 0);
    for (asymmetry, z) in [(0.4, 0), (0.1, 3)] {
        let mut scene = scene();
        scene["model"]["asymmetry"] = asymmetry.into();
        let tile = served.post("tile", &json!({ "scene": scene, "z": z, "x": (1 << z) / 2, "y": (1 << z) / 2 }));
        let mut own = scene.clone();
        for axis in ["x", "y"] {
            let [from, to] = ["from", "to"].map(|end| scene["sweep"][axis][end].as_f64().unwrap());
            let step = (to - from) / (SIDE as f64 * 2f64.powi(z));
            let first = f64::from((1 << z) / 2) * SIDE as f64;
            let at = |cell: f64| from + (first + cell + 0.5) * step;
            own["sweep"][axis]["from"] = at(0.0).into();
            own["sweep"][axis]["to"] = at(63.0).into();
            own["sweep"][axis]["points"] = SIDE.into();
        }
        fs::write(served.dir.path("own.json"), own.to_string()).unwrap();
        for color in ["spectral_radius", "margin", "solutions"] {
            let line = format!("sweep own.json --out own.csv --png own.png --svg own.svg --color {color} --quiet");
            served.dir.run(&line).with(0, &[]);
            let drawn = Cells::of(&served.dir.read("own.png"), SIDE as u32, SIDE as u32);
            let scale = served.post("scale", &json!({ "scene": own, "color": color })).json();
            let [from, to] = [0, 1].map(|i| scale["ends"][i].as_f64().unwrap());
            let svg = String::from_utf8(served.dir.read("own.svg")).unwrap();
            let words: Vec<String> = vibrochain_testkit::svg::texts(&svg).into_iter().map(|(_, text)| text).collect();
            let ticks = scale["ticks"].as_array().unwrap();
            let mut told: Vec<&str> = ticks.iter().map(|tick| tick[1].as_str().unwrap()).collect();
            told.extend([&scale["heading"], &scale["below"]].into_iter().filter_map(Value::as_str));
            assert!(
                told.len() > 1 && told.iter().all(|text| words.iter().any(|word| word == text)),
                "{told:?} {words:?}"
            );
            for i in 0..SIDE * SIDE {
                let number = |at: usize| f64::from_le_bytes(tile.body[at + 8 * i..at + 8 * i + 8].try_into().unwrap());
                let seen = drawn.of_cell(i, SIDE);
                let value = match color {
                    "spectral_radius" => f64::from((number(0) - 1.0) as f32),
                    "margin" => f64::from(number(8 * SIDE * SIDE) as f32),
                    _ => Some(tile.body[19 * SIDE * SIDE + i]).filter(|count| *count > 0).map_or(f64::NAN, f64::from),
                };
                if value.is_nan() {
                    assert_eq!(seen, [255; 3], "{color} {i}");
                    none += 1;
                    continue;
                }
                let place = if scale["logarithm"] == true { value.log10() } else { value };
                if scale["logarithm"] == true && (place.is_nan() || place < from) {
                    assert_eq!(seen, below, "{color} {i}");
                    lower += 1;
                    continue;
                }
                // Between two steps of the scale that is handed over.
                let step = ((place - from) / (to - from)).clamp(0.0, 1.0) * (colours.len() - 1) as f64;
                let near = colours[step.round() as usize];
                assert!(seen.iter().zip(near).all(|(a, b)| a.abs_diff(b) <= 1), "{color} {i} {seen:?} {near:?}");
                numbers += 1;
            }
        }
    }
    assert!(numbers > 8000 && none > 1000 && lower > 500, "{numbers} {none} {lower}");
    assert_eq!(numbers + none + lower, 2 * 3 * SIDE * SIDE);
    let mut bare = scene();
    bare["compute"]["stability"] = false.into();
    let refused =
        |scene: &Value, color: &str| served.post("scale", &json!({ "scene": scene, "color": color })).refused(400);
    assert!(refused(&bare, "spectral_radius").contains("add stability = true"));
    assert!(refused(&scene(), "impulse").contains("give spectral_radius, margin, solutions"));
    bare["sweep"]["x"]["points"] = 100_000.into();
    assert!(refused(&bare, "margin").contains("give at most 32768"));
}

/// What lies beyond the ends of a parameter's range is told apart, and costs no tile.
#[test]
fn a_tile_beyond_the_model_says_so() {
    let served = Served::new("");
    let answer = served.post("tile", &json!({ "scene": scene(), "z": 0, "x": 0, "y": -1 }));
    let status = &answer.body[18 * 4096..19 * 4096];
    assert!(answer.code == 200 && status.iter().all(|status| *status == 255));
}

/// The map of a structure: a tile has the classes that a sweep of its cells' values writes, and a point the orbits that `orbit` prints.
#[test]
fn a_structure_is_flown_over_as_it_is_swept() {
    let dir = TestDir::new();
    let scene = |limits: [[f64; 2]; 2], points: usize| {
        let axis = |name: &str, [from, to]: [f64; 2]| {
            format!("{{ parameter = \"{name}\", from = {from:?}, to = {to:?}, points = {points} }}")
        };
        format!(
            "title = \"oscillator\"\nomega = 2\n[structure]\nmasses = [1]\nstiffness = [[1]]\ndamping = [[0.1]]\n[[contact]]\nat = 0\n\
             upper = 0.1\nrestitution = 0.8\n[force]\nload = [1]\n[sweep]\nx = {}\ny = {}\n[compute]\nfamilies = [\"0+\", \"0+,0+/2\"]\n",
            axis("omega", limits[0]),
            axis("contact.0.upper", limits[1])
        )
    };
    fs::write(dir.path("map.toml"), scene([[0.5, 4.5], [0.05, 0.45]], 9)).unwrap();
    fs::create_dir(dir.path("tmp")).unwrap();
    let served = Served::on(dir, " map.toml");
    let page = served.get("");
    assert!(page.code == 200 && String::from_utf8(page.body).unwrap().contains("structure.js"));
    for file in ["structure.js", "ask.js", "dom.js", "plane.js", "style.css"] {
        assert_eq!(served.get(file).code, 200, "{file}");
    }
    let start = served.get("start").json();
    assert_eq!(start["words"], json!(["0+", "0+,0+/2"]));
    assert_eq!(start["axes"][1], json!({ "name": "contact.0.upper", "from": 0.05, "to": 0.45 }));
    let side = usize::try_from(start["side"].as_u64().unwrap()).unwrap();
    let tile = served.post("cells", &json!({ "z": 2, "x": 1, "y": 2 })).json();
    let step = [4.0 / (4.0 * side as f64), 0.4 / (4.0 * side as f64)];
    let first = [1.5 + 0.5 * step[0], 0.25 + 0.5 * step[1]];
    let last = [0, 1].map(|i| first[i] + (side - 1) as f64 * step[i]);
    fs::write(served.dir.path("tile.toml"), scene([[first[0], last[0]], [first[1], last[1]]], side)).unwrap();
    served.dir.run("sweep tile.toml --out tile.csv").with(0, &[]);
    let table = fs::read_to_string(served.dir.path("tile.csv")).unwrap();
    let mut lines = table.lines();
    assert!(lines.next().unwrap().starts_with("omega,contact.0.upper,class,word,"));
    let cells = tile["cells"].as_array().unwrap();
    let (mut count, mut seen) = (0, std::collections::BTreeSet::new());
    for (line, cell) in lines.zip(cells) {
        let class = tile["classes"][usize::try_from(cell.as_u64().unwrap()).unwrap()].as_str().unwrap();
        let (how, word) = class.split_once(' ').unwrap_or((class, ""));
        let word = if word.contains(',') { format!("\"{word}\"") } else { word.to_owned() };
        assert!(line.contains(&format!(",{how},{word},")), "{line} {class}");
        seen.insert(class.to_owned());
        count += 1;
    }
    assert!(count == side * side && cells.len() == count && seen.len() > 2, "{count} {seen:?}");
    let told = served.post("orbits", &json!({ "at": [2.325, 0.1] })).json();
    assert_eq!(told.as_array().unwrap().len(), 2);
    let own = written(
        &served
            .dir
            .run("orbit --scene map.toml --word 0+ --set omega=2.325 --set contact.0.upper=0.1 --json")
            .with(0, &[])
            .out,
    );
    assert_eq!(told[0]["answer"]["solutions"], own["solutions"]);
    assert!(told[0]["files"]["orbit.svg"].as_str().unwrap().contains("<svg"));
    for (question, asked) in [
        ("cells", json!({ "z": 41, "x": 0, "y": 0 })),
        ("cells", json!({ "z": 1, "x": 4, "y": 0 })),
        ("orbits", json!({ "at": [1] })),
    ] {
        assert_eq!(served.post(question, &asked).code, 400, "{question} {asked}");
    }
    served.post("tile", &json!({ "scene": {}, "z": 0, "x": 0, "y": 0 })).refused(400);
    // What cannot be flown over.
    let dir = TestDir::new();
    fs::write(dir.path("line.toml"), scene([[0.5, 4.5], [0.05, 0.45]], 9).replace("\ny = ", "\n# y = ")).unwrap();
    dir.run("explore line.toml").with(2, &["two axes"]);
}
