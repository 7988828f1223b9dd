//! Pictures by their pages: again from tables, on paper, moving, and too large.

use std::fs;

use vibrochain_testkit::TestDir;

use super::maps::plane;

/// Width and height of a PNG, and the dots of it that make a metre.
fn dimensions(png: &[u8]) -> ([u32; 2], u32) {
    let word = |at: usize| u32::from_be_bytes(png[at..at + 4].try_into().unwrap());
    let dots = png.windows(4).position(|name| name == b"pHYs").unwrap();
    ([word(16), word(20)], word(dots + 4))
}

#[test]
fn a_table_is_drawn_again_without_computing_it() {
    let dir = TestDir::with_scene(&plane());
    dir.run("sweep scene.toml --out map.csv --png map.png --svg map.svg --pdf map.pdf --quiet").with(0, &[]);
    dir.run("sweep scene.toml --out other.csv --png margin.png --color margin --curves --quiet").with(0, &[]);
    // The manifest says what the table is of; the scene itself is not needed.
    fs::remove_file(dir.path("scene.toml")).unwrap();
    dir.run("draw map.csv --png again.png --svg again.svg --pdf again.pdf").with(0, &["2501 cells"]);
    for end in ["png", "svg", "pdf"] {
        assert!(dir.read(&format!("map.{end}")) == dir.read(&format!("again.{end}")), "{end}");
    }
    dir.run("draw other.csv --png again.png --color margin --curves").with(0, &["borders "]);
    assert!(dir.read("margin.png") == dir.read("again.png"));
    assert!(dir.read("map.csv") == dir.read("other.csv"));

    let refused = |line: &str, told: &str| {
        let before = dir.names(".");
        dir.run(line).with(2, &[told]);
        assert_eq!(dir.names("."), before, "{line}");
    };
    refused("draw map.csv", "give --plot FILE");
    refused("draw map.csv --png map.csv", "the table and --png are the same file");
    refused("draw none.csv --scene map.manifest.json --png new.png", "it cannot be read as a table");
    fs::copy(dir.path("map.csv"), dir.path("alone.csv")).unwrap();
    refused("draw alone.csv --png new.png", "alone.manifest.json is not there");
    refused("draw map.csv --png new.png --color impulse", "add impulse = true");
    let table = String::from_utf8(dir.read("map.csv")).unwrap();
    fs::write(dir.path("map.csv"), table.replacen("stable-double", "stable-treble", 1)).unwrap();
    refused("draw map.csv --png new.png", "its class is `stable-treble`");
    let cut: String = table.lines().take(100).map(|line| format!("{line}\n")).collect();
    fs::write(dir.path("map.csv"), cut).unwrap();
    refused("draw map.csv --png new.png", "it has 99 rows for 2501 cells");
}

#[test]
fn a_picture_is_as_wide_and_as_fine_as_its_page() {
    let dir = TestDir::with_scene(&plane());
    dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
    let drawn = |flags: &str| {
        dir.run(format!("draw map.csv --png page.png --svg page.svg --quiet {flags}").trim_end()).with(0, &[]);
        (dimensions(&dir.read("page.png")), String::from_utf8(dir.read("page.svg")).unwrap())
    };
    // 86 mm at 600 dpi are 2031.5 pixels; 0.0254 m have 600.
    let (([width, height], dots), svg) = drawn("--style column");
    assert!((2031..=2032).contains(&width) && height > width && dots == 23_622, "{width} {height} {dots}");
    assert!(svg.contains("width=\"325.039\"") && svg.contains("pixelated"));
    let (([width, _], dots), _) = drawn("--width 100mm --dpi 254");
    assert_eq!((width, dots), (1000, 10_000));
    // A width on paper is for print: letters of 8 points as they are in a column, no pixels of a screen.
    let size = |svg: &str| svg.split("scale(").nth(1).unwrap().split(')').next().unwrap().parse::<f64>().unwrap();
    let column = size(&svg);
    let (([width, _], dots), svg) = drawn("--width 86mm");
    assert_eq!((width, dots), (1016, 11_811));
    assert!((size(&svg) / column - 8.0 / 7.5).abs() < 1e-3, "{column} {}", size(&svg));
    assert_eq!(drawn("--width 325px").0.1, 3780);
    let (([wide, high], _), small) = drawn("");
    let (([same, higher], _), large) = drawn("--font-size 16");
    assert!((size(&large) / size(&small) - 16.0 / 11.25).abs() < 1e-3 && same > wide && higher > high);
    for (flags, told) in [
        ("--width 86", "no unit: give a number with its unit"),
        ("--width 86km", "not a length: give a number with its unit"),
        ("--width 1mm", "--width of 1 mm: give 20 mm to 2 m"),
        ("--dpi 0", "give 36 to 2400"),
        ("--dpi nan", "--dpi"),
        ("--font-size 1000", "give 4 to 72 points"),
        ("--style poster", "possible values: screen, column, page, slide"),
        ("--width 2000mm --dpi 2400", "pixels across, at most 20000"),
    ] {
        dir.run(&format!("draw map.csv --png new.png {flags}")).with(2, &[told]);
    }
    assert!(!dir.path("new.png").exists());
    dir.run("sweep scene.toml --out new.csv --dpi 100").with(2, &["--dpi is of pictures: ask for one with --plot"]);
}

#[test]
fn a_run_moves() {
    let dir = TestDir::new();
    let point = "--family double-sided --sites 5 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";
    for end in ["gif", "png", "svg"] {
        dir.run(&format!("simulate {point} --periods 1 --animate run.{end} --quiet")).with(0, &[]);
        dir.run(&format!("simulate {point} --periods 1 --animate again.{end} --quiet")).with(0, &[]);
        assert!(dir.read(&format!("run.{end}")) == dir.read(&format!("again.{end}")), "{end}");
    }
    assert!(dir.read("run.gif").starts_with(b"GIF89a"));
    let count = |bytes: &[u8], name: &[u8]| bytes.windows(name.len()).filter(|part| *part == name).count();
    // 64 pictures of a period: the end is the beginning.
    assert_eq!(count(&dir.read("run.png"), b"fcTL"), 64);
    let svg = String::from_utf8(dir.read("run.svg")).unwrap();
    let heights = svg.split("attributeName=\"cy\"").nth(1).unwrap().split("values=\"").nth(1).unwrap();
    let heights: Vec<f64> = heights.split('"').next().unwrap().split(';').map(|y| y.parse().unwrap()).collect();
    assert_eq!((heights.len(), heights[0]), (65, heights[64]));
    // Both barriers glow where mass 0 meets them, and at no other.
    assert_eq!(svg.matches("attributeName=\"opacity\"").count(), 2);
    // Of a long run the last periods alone.
    dir.run(&format!("simulate {point} --periods 40 --samples 8 --animate long.png --quiet")).with(0, &[]);
    assert_eq!(count(&dir.read("long.png"), b"fcTL"), 96);
    for (flags, told) in [
        ("--animate run.mp4", "end the name in .gif, .png or .svg"),
        ("--animate x.gif --sites 401", "401 masses cannot be told apart"),
        ("--periods 1 --dpi 90", "--dpi is of pictures: ask for one with --plot or --animate"),
    ] {
        dir.run(&format!(
            "simulate {} {flags}",
            if flags.contains("--sites") { point.replace("--sites 5 ", "") } else { point.to_owned() }
        ))
        .with(2, &[told]);
    }
}

/// A picture that is too large is refused before anything is computed or made, by every command.
#[test]
fn limits_of_a_picture_are_known_at_once() {
    let scene = "[model]\nsites = 21\ngamma1 = 0.2\nasymmetry = 0.4\n[sweep]\nx = { parameter = 'omega', from = 0.4, to = 3.0, points = 3000 }\ny = { parameter = 'gamma2', from = 0.0, to = 0.3, points = 3000 }\n[compute]\nfamilies = ['double-sided']\nstability = true\n";
    let dir = TestDir::with_scene(scene);
    let line = scene.replace("y = {", "# y = {").replace("[sweep]", "gamma2 = 0.1\n[sweep]");
    std::fs::write(dir.path("line.toml"), line).unwrap();
    let orbit = "--family double-sided --sites 21 --gamma1 .2 --gamma2 .1 --omega 1.5 --asymmetry .4";
    let commands = [
        "sweep scene.toml --out map.csv --plot a.png".to_owned(),
        "sweep scene.toml --out map.csv --plot a.png --width 600mm".to_owned(),
        "sweep line.toml --out map.csv --plot a.pdf".to_owned(),
        "fate line.toml --out map.csv --plot a.png".to_owned(),
        "fate scene.toml --starts 1 --out map.csv --plot a.png".to_owned(),
        "fate line.toml --diagram d.csv --plot a.png".to_owned(),
        "curves scene.toml --plot a.png".to_owned(),
        format!("curve --event grazing --free omega --and gamma2 {orbit} --plot a.png"),
        format!("branch --free omega {orbit} --plot a.png"),
        format!("simulate {orbit} --periods 1e9 --plot a.png"),
        format!("simulate {orbit} --periods 1e9 --animate a.gif"),
    ];
    for command in &commands {
        let dpi = if command.contains("--width") { 700 } else { 2400 };
        let ran = dir.run(&format!("{command} --dpi {dpi}"));
        assert!(ran.code == Some(2) && !ran.err.contains("--resume"), "{command}: {ran:?}");
        assert!(ran.err.contains("legend are more than") || ran.err.contains("pixels across"), "{command}: {ran:?}");
        assert_eq!(dir.names("."), ["line.toml", "scene.toml"], "{command}");
    }
}

/// Eight solutions, the third and fourth of them physical: on paper these come first, and no more than a page holds.
#[test]
fn a_picture_of_many_solutions_is_a_page_and_begins_with_the_physical_ones() {
    let dir = TestDir::new();
    let orbit = "orbit --family double-sided --sites 1 --gamma1 .3 --gamma2 0 --omega .5 --asymmetry .1 --amplitude .3 --restitution .8";
    let draw = |flags: &str| {
        let ran = dir.run(format!("{orbit} --plot a.svg {flags}").trim_end()).with(0, &[]);
        assert!(ran.out.contains("8 solutions, 2 physical"), "{ran:?}");
        let svg = fs::read_to_string(dir.path("a.svg")).unwrap();
        let height = svg.split("viewBox=\"0 0 ").nth(1).unwrap().split('"').next().unwrap().split(' ').nth(1).unwrap();
        let numbers: Vec<usize> =
            svg.split("breather ").skip(1).filter_map(|rest| rest.split(':').next()?.parse().ok()).collect();
        (numbers, height.parse::<f64>().unwrap() / 96.0 * 25.4, ran.err)
    };
    let (screen, _, told) = draw("");
    assert!(screen[..2] == [3, 4] && screen.len() == 8 && told.is_empty(), "{screen:?} {told}");
    for style in ["column", "page"] {
        let (shown, height, told) = draw(&format!("--style {style}"));
        assert!(height <= 240.0 && shown.len() < 8 && shown[0] == 3, "{style}: {height} mm, {shown:?}");
        assert!(
            told.contains(&format!("a.svg shows {} of 8 solutions, the physical ones first", shown.len())),
            "{told}"
        );
    }
    let (one, ..) = draw("--solution 7");
    assert_eq!(one, [7]);
    dir.run(&format!("{orbit} --all-plots all --solution 4 --quiet")).with(0, &[]);
    assert!(dir.names("all").len() > 4 && dir.names("all").iter().all(|name| name.starts_with("solution-4-")));
    dir.run(&format!("{orbit} --plot a.svg --solution 9")).with(2, &["--solution 9 is out of range: there are 8"]);
    dir.run(&format!("{orbit} --solution 1")).with(2, &["--solution is of pictures"]);
}
