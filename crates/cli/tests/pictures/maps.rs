//! What `sweep` and `merge` draw: one axis as curves, a slice of three, a number as colours, borders over cells.

use std::collections::BTreeMap;

#[cfg(unix)]
use vibrochain_testkit::signal;
use vibrochain_testkit::svg::{lines, texts, ticks};
use vibrochain_testkit::{CHUNKS, Cells, SCENE, TestDir};

const MODEL: &str = "[model]\nsites = 6\ngamma1 = 0.2\n";

const OMEGA: &str = r#"{ parameter = "omega", from = 0.6, to = 1.8, points = 61 }"#;

const GAMMA2: &str = r#"{ parameter = "gamma2", from = 0.0, to = 0.2, points = 41 }"#;

const ASYMMETRY: &str = r#"{ parameter = "asymmetry", values = [0.7, 0.4, 0.1] }"#;

const COMPUTE: &str = "[compute]\nfamilies = [\"double-sided\", \"single-sided\"]\nstability = true\n";

/// The map of the ring over frequency and coupling, at one asymmetry or at three.
pub(crate) fn plane() -> String {
    format!("{MODEL}asymmetry = 0.4\n[sweep]\nx = {OMEGA}\ny = {GAMMA2}\n{COMPUTE}")
}

fn space() -> String {
    format!("{MODEL}[sweep]\nx = {OMEGA}\ny = {GAMMA2}\naxes = [{ASYMMETRY}]\n{COMPUTE}")
}

/// The rows of a table by their columns.
fn rows(table: &[u8]) -> Vec<BTreeMap<String, String>> {
    csv::Reader::from_reader(table).deserialize().map(Result::unwrap).collect()
}

fn number(row: &BTreeMap<String, String>, column: &str) -> Option<f64> {
    row[column].parse().ok()
}

#[test]
fn one_axis_is_drawn_as_curves_that_pass_where_the_table_says() {
    // Above its band, where the breather lives all along: one line. Existence and margin alone, one panel.
    let axis = r#"{ parameter = "omega", from = 1.3, to = 2.5, points = 121 }"#;
    let compute = "[compute]\nfamilies = [\"double-sided\"]\nimpulse = true\n";
    let dir = TestDir::with_scene(&format!("{MODEL}asymmetry = 0.4\ngamma2 = 0.1\n[sweep]\nx = {axis}\n{compute}"));
    dir.run("sweep scene.toml --out map.csv --svg map.svg --png map.png").with(0, &["121 cells"]);
    assert!(dir.read("map.png").starts_with(b"\x89PNG"));
    let svg = String::from_utf8(dir.read("map.svg")).unwrap();
    let texts = texts(&svg);
    for words in ["frequency ω", "strongest impulse |P|", "margin, the smallest distance to a barrier", "double-sided"]
    {
        assert!(texts.iter().any(|(_, text)| text == words), "{words} not in {texts:?}");
    }
    assert!(!texts.iter().any(|(_, text)| text.contains('μ')));
    let table = rows(&dir.read("map.csv"));
    assert_eq!(table.len(), 121);
    // The lower of two panels has the impulse: what its places are worth its ticks tell.
    let all = lines(&svg, "stroke=\"#103262\" stroke-width=\"3\"");
    let line = all.iter().filter(|line| line.len() > 20).max_by(|a, b| a[0].1.total_cmp(&b[0].1)).unwrap();
    let [of_x, of_y] = ticks(&svg);
    let bottom = of_x.iter().map(|tick| tick.1).fold(0.0, f64::max);
    let of_x: Vec<(f64, f64)> = of_x.iter().filter(|tick| tick.1 > bottom - 1.0).map(|tick| (tick.0, tick.2)).collect();
    let of_y: Vec<(f64, f64)> =
        of_y.iter().filter(|tick| tick.0 > bottom - 330.0).map(|tick| (tick.0, tick.2)).collect();
    assert!(of_x.len() >= 4 && of_y.len() >= 3, "{of_x:?} {of_y:?}");
    let place = |ticks: &[(f64, f64)], value: f64| {
        let (first, last) = (ticks[0], ticks[ticks.len() - 1]);
        first.0 + (value - first.1) / (last.1 - first.1) * (last.0 - first.0)
    };
    for row in &table {
        let (omega, impulse) = (number(row, "omega").unwrap(), number(row, "impulse").unwrap());
        let (x, y) = (place(&of_x, omega), place(&of_y, impulse.abs()));
        // The line passes there, though points that it passes anyway are left out.
        let off = line.windows(2).map(|pair| {
            let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
            let part = (((x - pair[0].0) * dx + (y - pair[0].1) * dy) / (dx * dx + dy * dy)).clamp(0.0, 1.0);
            (x - pair[0].0 - part * dx).hypot(y - pair[0].1 - part * dy)
        });
        let off = off.fold(f64::INFINITY, f64::min);
        assert!(off < 0.02, "{omega} {off}");
    }
}

#[test]
fn stable_and_unstable_pieces_are_told_apart_and_gaps_left() {
    let dir = TestDir::with_scene(&format!(
        "{MODEL}asymmetry = 0.4\ngamma2 = 0.1\n[sweep]\nx = {{ parameter = \"omega\", from = 0.5, to = 2.5, points = 401 }}\n{COMPUTE}"
    ));
    dir.run("sweep scene.toml --out map.csv --svg map.svg").with(0, &[]);
    let svg = String::from_utf8(dir.read("map.svg")).unwrap();
    let table = rows(&dir.read("map.csv"));
    let class = |name: &str| table.iter().filter(|row| row["class"] == name).count();
    assert!(class("none") > 10 && class("unstable-double") > 10 && class("stable-single") > 10);
    for words in ["stable double-sided", "unstable double-sided", "stable single-sided", "unstable single-sided"] {
        // Once, for all panels.
        assert_eq!(texts(&svg).iter().filter(|(_, text)| text == words).count(), 1, "{words}");
    }
    // Growth from grazing to stripes spans decades.
    for words in ["largest |μ|, logarithmic", "1", "2", "10"] {
        assert!(texts(&svg).iter().any(|(_, text)| text == words), "{words}");
    }
    // Solid lines are three pixels wide, dashes two. In the lower panel, of margins, runs of a class are pieces of a line.
    let runs = |name: &str| {
        let whole = table.chunk_by(|one, other| one["class"] == other["class"]);
        whole.filter(|run| run[0]["class"] == name).count()
    };
    let middle = texts(&svg).iter().find(|(_, text)| text == "frequency ω").unwrap().0.1 - 370.0;
    let pieces = |style: &str| lines(&svg, style).iter().filter(|line| line[0].1 > middle).count();
    assert_eq!(pieces("stroke=\"#103262\" stroke-width=\"3\""), runs("stable-double"));
    assert_eq!(pieces("stroke=\"#2e86ab\" stroke-width=\"3\""), runs("stable-single"));
    assert_eq!(pieces("stroke=\"#103262\" stroke-width=\"2\""), runs("unstable-double"));
    assert!(svg.contains("stroke-dasharray=\"8 5\""));
}

#[test]
fn a_slice_is_the_map_of_its_value_and_the_table_stays_whole() {
    let dir = TestDir::with_scene(&plane());
    for color in ["class", "spectral_radius", "margin"] {
        dir.run(&format!("sweep scene.toml --out plane.csv --png {color}.png --color {color} --quiet")).with(0, &[]);
    }
    dir.scene(&space());
    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    for color in ["class", "spectral_radius", "margin"] {
        let flags = format!("--slice asymmetry=.4 --color {color} --quiet");
        dir.run(&format!("sweep scene.toml --out space.csv --png swept.png {flags}")).with(0, &[]);
        dir.run(&format!("merge parts --out merged.csv --png merged.png {flags}")).with(0, &[]);
        let expected = dir.read(&format!("{color}.png"));
        assert!(dir.read("swept.png") == expected && dir.read("merged.png") == expected, "{color}");
    }
    assert!(dir.read("class.png") != dir.read("margin.png"));
    assert_eq!(rows(&dir.read("space.csv")).len(), 3 * 41 * 61);
    assert!(dir.read("space.csv") == dir.read("merged.csv"));
    // Of a slice along one axis the curves; of a table that goes down a pipe, too.
    let ran = dir.run("sweep scene.toml --out - --svg line.svg --slice asymmetry=0.4 --slice gamma2=0.1 --quiet");
    assert!(ran.with(0, &[]).out.as_bytes() == dir.read("space.csv"));
    let line = String::from_utf8(dir.read("line.svg")).unwrap();
    assert!(texts(&line).iter().any(|(_, text)| text.contains("γ₂ = 0.1") && text.contains("a = 0.4")), "{line}");
}

#[test]
fn colours_are_those_of_the_scale() {
    let dir = TestDir::with_scene(&plane());
    dir.run("sweep scene.toml --out map.csv --png margin.png --color margin --quiet").with(0, &[]);
    dir.run("sweep scene.toml --out map.csv --png growth.png --svg growth.svg --color spectral_radius --quiet")
        .with(0, &[]);
    dir.run("sweep scene.toml --out map.csv --png count.png --svg count.svg --color solutions --quiet").with(0, &[]);
    let table = rows(&dir.read("map.csv"));
    let cells = |name: &str| Cells::of(&dir.read(name), 61, 41);
    let (margin, growth, count) = (cells("margin.png"), cells("growth.png"), cells("count.png"));
    let luminance = |[r, g, b]: [u8; 3]| 0.2126 * f64::from(r) + 0.7152 * f64::from(g) + 0.0722 * f64::from(b);
    let mut margins: Vec<(f64, [u8; 3])> = Vec::new();
    let mut growths: Vec<(f64, [u8; 3])> = Vec::new();
    let (mut nothing, mut none) = (0, 0);
    for (i, row) in table.iter().enumerate() {
        let seen = [&margin, &growth, &count].map(|picture| picture.of_cell(i, 61));
        let Some(value) = number(row, "margin") else {
            assert_eq!(seen, [[255; 3]; 3]);
            nothing += 1;
            continue;
        };
        margins.push((value, seen[0]));
        let more = number(row, "spectral_radius").unwrap() - 1.0;
        if more > 1e-8 {
            growths.push((more, seen[1]));
        } else {
            assert_eq!(seen[1], [215; 3]);
            none += 1;
        }
    }
    assert!(nothing > 100 && none > 500 && growths.len() > 100, "{nothing} {none} {}", growths.len());
    for (name, list) in [("margin", &mut margins), ("growth", &mut growths)] {
        list.sort_by(|one, other| one.0.total_cmp(&other.0));
        assert!(list.windows(2).all(|pair| luminance(pair[0].1) <= luminance(pair[1].1) + 1.0), "{name}");
        let colours: std::collections::BTreeSet<_> = list.iter().map(|(_, colour)| *colour).collect();
        assert!(colours.len() > 20, "{name}");
    }
    // The ends of viridis, as they are published.
    assert_eq!((margins[0].1, margins[margins.len() - 1].1), ([68, 1, 84], [253, 231, 37]));
    let words = |name: &str| texts(&String::from_utf8(dir.read(name)).unwrap());
    let decades: Vec<String> = words("growth.svg").into_iter().map(|(_, text)| text).collect();
    let low = growths[0].0.log10().floor();
    let below = decades.iter().find(|text| text.starts_with("excess below 10⁻")).unwrap();
    let digits: Vec<char> = "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().collect();
    let told = digits.iter().position(|digit| below.ends_with(*digit)).unwrap();
    assert_eq!(-(told as f64), low, "{below} {}", growths[0].0);
    assert!(words("count.svg").iter().any(|(_, text)| text == "1") && !decades.contains(&"stable double-sided".into()));
}

#[test]
fn borders_are_drawn_where_they_are() {
    let dir = TestDir::with_scene(&plane());
    dir.run("sweep scene.toml --out map.csv --png cells.png --quiet").with(0, &[]);
    dir.run("sweep scene.toml --out map.csv --png curves.png --svg curves.svg --curves").with(0, &["borders "]);
    dir.run("curves scene.toml --csv borders.csv --places 10000").with(0, &[]);
    let (plain, drawn) = (Cells::of(&dir.read("cells.png"), 61, 41), Cells::of(&dir.read("curves.png"), 61, 41));
    let (width, height) = (61 * plain.cell.0, 41 * plain.cell.1);
    // Pixels of the points that the other command writes. A cell covers half a step about its value.
    let place = |omega: f64, gamma2: f64| {
        let (x, y) = ((omega - 0.6) / 1.2 * 60.0 + 0.5, gamma2 / 0.2 * 40.0 + 0.5);
        (x * f64::from(plain.cell.0), f64::from(height) - y * f64::from(plain.cell.1))
    };
    let points: Vec<(f64, f64)> = rows(&dir.read("borders.csv"))
        .iter()
        .map(|row| place(number(row, "omega").unwrap(), number(row, "gamma2").unwrap()))
        .collect();
    assert!(points.len() > 500);
    let near = |x: f64, y: f64, pixels: f64| {
        points.windows(2).any(|pair| {
            let (a, b) = (pair[0], pair[1]);
            let [dx, dy] = [b.0 - a.0, b.1 - a.1];
            let part = (((x - a.0) * dx + (y - a.1) * dy) / (dx * dx + dy * dy).max(1e-9)).clamp(0.0, 1.0);
            dx.hypot(dy) < 100.0 && (x - a.0 - part * dx).hypot(y - a.1 - part * dy) < pixels
        })
    };
    let (mut changed, mut elsewhere) = (0, 0);
    for y in 0..height {
        for x in 0..width {
            let pixel = |cells: &Cells| cells.picture.at(cells.corner.0 + x, cells.corner.1 + y);
            if pixel(&plain) != pixel(&drawn) {
                changed += 1;
                elsewhere += usize::from(!near(f64::from(x) + 0.5, f64::from(y) + 0.5, 3.0));
            }
        }
    }
    assert!(changed > 3000 && changed < (width * height) as usize / 4, "{changed}");
    assert_eq!(elsewhere, 0, "of {changed}");
    // Between two cells of different class there is one, where the classes are drawn by cells; but for both ends of the map.
    let table = rows(&dir.read("map.csv"));
    let (mut changes, mut bare) = (0, 0);
    for row in 2..39_usize {
        for column in 0..60_usize {
            let [one, other] = [column, column + 1].map(|column| &table[61 * row + column]["class"]);
            if one == other {
                continue;
            }
            changes += 1;
            let y = (40 - row as u32) * plain.cell.1 + plain.cell.1 / 2;
            let from = column as u32 * plain.cell.0 + plain.cell.0 / 2;
            let pixel = |cells: &Cells, x: u32, y: u32| cells.picture.at(cells.corner.0 + x, cells.corner.1 + y);
            // Between two dashes on white nothing is seen.
            let same = |x: u32| (y - 2..=y + 2).all(|y| pixel(&plain, x, y) == pixel(&drawn, x, y));
            bare += usize::from((from..=from + plain.cell.0).all(same));
        }
    }
    assert!(changes > 100 && bare == 0, "{changes} {bare}");
    let svg = String::from_utf8(dir.read("curves.svg")).unwrap();
    for words in ["<title>double-sided: grazing</title>", "<title>double-sided: neimark-sacker, stripe "] {
        assert!(svg.contains(words), "{words}");
    }
    assert!(texts(&svg).iter().any(|(_, text)| text == "Neimark–Sacker") && svg.trim_end().ends_with("</svg>"));
}

#[test]
fn what_cannot_be_drawn_is_refused_before_anything_is_computed() {
    let line = format!("{MODEL}asymmetry = 0.4\ngamma2 = 0.1\n[sweep]\nx = {OMEGA}\n{COMPUTE}");
    let bare = plane().replace("stability = true\n", "");
    let log =
        plane().replace("from = 0.0, to = 0.2, points = 41", "from = 0.01, to = 0.2, points = 41, spacing = \"log\"");
    let png = "sweep scene.toml --out map.csv --png map.png";
    for (scene, flags, told) in [
        (
            space(),
            "",
            "pictures have one or two axes, here are 3, omega, gamma2 and asymmetry: choose the cells to draw",
        ),
        (space(), "", "as in --slice asymmetry=0.4"),
        (space(), "--curves", "as in --slice asymmetry=0.4"),
        (
            space(),
            "--slice asymmetry=0.3",
            "--slice asymmetry=0.3: asymmetry = 0.3 is none of its 3 values: next to it are 0.1 and 0.4",
        ),
        (space(), "--slice gamma1=0.2", "gamma1 is no axis of the scene: give one of omega, gamma2 and asymmetry"),
        (space(), "--slice asymmetry=0.4 --slice asymmetry=0.1", "asymmetry is given twice"),
        (space(), "--slice asymmetry", "not a parameter with its value: give one such as asymmetry=0.4"),
        (space(), "--slice a=0.4", "`a` is no parameter: give one of gamma1, gamma2, omega, asymmetry,"),
        (space(), "--slice asymmetry=0,4", "not a number"),
        (space(), "--slice asymmetry=nan", "asymmetry = NaN is none of its 3 values"),
        (line.clone(), "--slice omega=0.6", "no axis is left to draw along: leave out one --slice"),
        (line.clone(), "--color margin", "--show is of maps over two axes, here is one, omega: leave it out"),
        (line, "--curves", "--curves draws borders over a map of two axes, here is one, omega: leave it out"),
        (log, "--curves", "--curves: borders are followed along equally spaced axes"),
        (
            bare.clone(),
            "--color spectral_radius",
            "--show spectral_radius: the scene does not compute it; add stability = true",
        ),
        (bare, "--color impulse", "--show impulse: the scene does not compute it; add impulse = true"),
        (plane(), "--color radius", "spectral_radius"),
    ] {
        let dir = TestDir::with_scene(&scene);
        dir.run(format!("{png} {flags}").trim()).with(2, &[told]);
        assert_eq!(dir.names("."), ["scene.toml"], "{flags}");
    }
    let dir = TestDir::with_scene(&plane());
    for flags in ["--curves", "--color margin", "--slice gamma2=0.1"] {
        dir.run(&format!("sweep scene.toml --out map.csv {flags}")).with(2, &["--png"]);
    }
    assert_eq!(dir.names("."), ["scene.toml"]);
}

/// A signal while borders are sought: all cells are computed, and are kept.
#[cfg(unix)]
#[test]
fn how_to_go_on_is_told_with_all_that_was_asked_for() {
    let dir = TestDir::with_scene(SCENE);
    let command = "sweep scene.toml --out map.csv --png map.png --slice gamma2=0 --color margin";
    dir.run(&format!("{command} --quiet")).with(2, &["--show is of maps"]);
    let command = "sweep scene.toml --out map.csv --plot map.png --show margin --curves";
    let mut child = dir.start(command);
    // The last chunk has its name when it is clear that the table has none.
    dir.await_chunks(&mut child, "map.csv.parts", CHUNKS as usize - 1);
    std::thread::sleep(std::time::Duration::from_millis(100));
    let told = format!("chunks are finished, in map.csv.parts; go on with: mapgen {command} --resume");
    signal(child, "TERM").with(130, &["interrupted: ", &told]);
    assert_eq!(dir.names("."), ["map.csv.parts", "scene.toml"]);
    assert!(dir.chunks("map.csv.parts") + 1 >= CHUNKS as usize);
}
