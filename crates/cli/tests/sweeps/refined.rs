//! Maps whose grid is refined where it changes.

use std::collections::BTreeMap;
use std::fs;

use serde_json::Value;
use vibrochain_testkit::TestDir;

const SCENE: &str = r#"
[model]
sites = 6
gamma1 = 0.2
asymmetry = 0.4
[sweep]
x = { parameter = "omega", from = 0.4, to = 3.0, points = 60 }
y = { parameter = "gamma2", from = 0.0, to = 0.3, points = 45 }
refine = { depth = 3 }
[compute]
families = ["double-sided", "single-sided"]
stability = true
"#;

const REFINE: &str = "refine = { depth = 3 }\n";

/// The scene of all cells of the finest grid.
fn finest() -> String {
    SCENE.replace(REFINE, "").replace("points = 60", "points = 480").replace("points = 45", "points = 360")
}

fn rows(text: &[u8]) -> Vec<Vec<String>> {
    let text = String::from_utf8(text.to_vec()).unwrap();
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

#[test]
fn leaves_are_rows_of_the_finest_grid_and_cover_it_once() {
    let dir = TestDir::with_scene(SCENE);
    dir.run("sweep scene.toml --out map.csv")
        .with(0, &["172800 cells (480 × 360: 60 × 45, refined 3 times)", "may have missed: "]);
    fs::write(dir.path("finest.toml"), finest()).unwrap();
    dir.run("sweep finest.toml --out finest.csv --quiet").with(0, &[]);
    let (leaves, all) = (rows(&dir.read("map.csv")), rows(&dir.read("finest.csv")));
    let usual = all[0].len();
    assert_eq!(
        (&leaves[0][..usual], &leaves[0][usual..].join(",")[..]),
        (&all[0][..], "cell_column,cell_row,cell_size")
    );
    let place: BTreeMap<&[String], usize> = all[1..].iter().enumerate().map(|(i, row)| (&row[..2], i)).collect();
    let (mut seen, mut sizes) = (vec![0; all.len() - 1], BTreeMap::new());
    for leaf in &leaves[1..] {
        let [column, row, size] = [0, 1, 2].map(|i| leaf[usual + i].parse::<usize>().unwrap());
        // It is computed at a cell of its own, and has the row of that.
        let at = place[&leaf[..2]];
        assert!((column..column + size).contains(&(at % 480)) && (row..row + size).contains(&(at / 480)), "{leaf:?}");
        assert_eq!(leaf[..usual], all[at + 1]);
        (row..row + size).for_each(|row| (column..column + size).for_each(|column| seen[row * 480 + column] += 1));
        *sizes.entry(size).or_insert(0_u64) += 1;
    }
    assert!(seen.iter().all(|&times| times == 1));
    // Four quarters that are alike are one leaf.
    let mut quarters: BTreeMap<[usize; 3], Vec<&[String]>> = BTreeMap::new();
    for leaf in &leaves[1..] {
        let [column, row, size] = [0, 1, 2].map(|i| leaf[usual + i].parse::<usize>().unwrap());
        quarters.entry([column / (2 * size), row / (2 * size), size]).or_default().push(leaf);
    }
    // Class and mechanism, solutions and status; a cell of the grid is no quarter.
    let words = |leaf: &[String]| [2, 3, 6, 7].map(|i| leaf[i].clone());
    let full = quarters.iter().filter(|([.., size], leaves)| *size < 8 && leaves.len() == 4);
    let alike = full.clone().filter(|(_, leaves)| leaves.iter().all(|leaf| words(leaf) == words(leaves[0])));
    assert_eq!((alike.count(), full.count() > 1000), (0, true));
    // What it lacks is little, and lies in leaves that were not halved to the end.
    let mut wrong = BTreeMap::new();
    for leaf in &leaves[1..] {
        let [column, row, size] = [0, 1, 2].map(|i| leaf[usual + i].parse::<usize>().unwrap());
        let cells = (row..row + size).flat_map(|row| (column..column + size).map(move |column| row * 480 + column));
        let others = cells.filter(|&cell| all[cell + 1][2] != leaf[2]).count();
        *wrong.entry(size).or_insert(0) += others;
    }
    assert_eq!(wrong[&1], 0);
    assert!(wrong.values().sum::<usize>() < seen.len() / 100, "{wrong:?}");
    assert_eq!(sizes.keys().copied().collect::<Vec<_>>(), [1, 2, 4, 8]);
    // Far fewer than all, and more than none.
    assert!(leaves.len() > 10_000 && leaves.len() < all.len() / 3, "{}", leaves.len());
    let manifest = dir.json("map.manifest.json");
    assert_eq!(manifest["cells"], 172_800);
    assert_eq!(manifest["refinement"]["grid"], serde_json::json!([480, 360]));
    assert_eq!(manifest["refinement"]["leaves"], leaves.len() - 1);
    let counted = |part: &str| manifest[part].as_object().unwrap().values().map(|n| n.as_u64().unwrap()).sum::<u64>();
    assert_eq!(counted("statuses"), 172_800);
    let of_class = |class: &str| -> u64 {
        let size = |leaf: &Vec<String>| leaf[usual + 2].parse::<u64>().unwrap();
        leaves[1..].iter().filter(|leaf| leaf[2] == class).map(|leaf| size(leaf) * size(leaf)).sum()
    };
    for class in ["none", "stable-double", "unstable-double", "stable-single", "unstable-single"] {
        assert_eq!(manifest["classes"][class], of_class(class), "{class}");
        assert!(of_class(class) > 0);
    }
}

#[test]
fn threads_shards_and_early_ends_do_not_change_a_byte() {
    let dir = TestDir::with_scene(SCENE);
    dir.run("sweep scene.toml --out map.csv --threads 1 --png map.png --svg map.svg --quiet").with(0, &[]);
    let table = dir.read("map.csv");
    for threads in [2, 3] {
        dir.run(&format!("sweep scene.toml --out again.csv --threads {threads} --quiet")).with(0, &[]);
        assert!(dir.read("again.csv") == table, "{threads}");
    }
    dir.run("sweep scene.toml --out map.csv.gz --quiet").with(0, &[]);
    assert!(dir.shell("mapgen sweep scene.toml --out - --quiet").out.into_bytes() == table);
    // Some chunks of another run, as after an early end; the rest by --resume.
    let large = SCENE.replace("points = 60", "points = 160").replace("points = 45", "points = 120");
    fs::write(dir.path("large.toml"), &large).unwrap();
    dir.run("sweep large.toml --out large.csv --quiet").with(0, &[]);
    dir.run("sweep large.toml --out rest.csv.parts --shard 1/2 --quiet").with(0, &[]);
    assert!(dir.chunks("rest.csv.parts") >= 1);
    dir.run("sweep large.toml --out rest.csv --quiet").with(2, &["--resume"]);
    dir.run("sweep large.toml --out rest.csv --resume --quiet").with(0, &[]);
    assert!(dir.read("rest.csv") == dir.read("large.csv"));
    for shard in [2, 0, 1] {
        dir.run(&format!("sweep large.toml --out parts --shard {shard}/3 --threads 1 --quiet")).with(0, &[]);
    }
    assert!(dir.chunks("parts") >= 2);
    dir.run("merge parts --out merged.csv --png merged.png --quiet").with(0, &[]);
    assert!(dir.read("merged.csv") == dir.read("large.csv"));
    let told = |name: &str| -> Value {
        let mut manifest = dir.json(name);
        for key in ["threads", "computed_cells", "wall_seconds"] {
            manifest.as_object_mut().unwrap().remove(key);
        }
        manifest
    };
    assert_eq!(told("merged.manifest.json"), told("large.manifest.json"));
    // A chunk that is changed is seen.
    let chunk = dir.path("parts/000000.chunk");
    let text = fs::read_to_string(&chunk).unwrap();
    fs::write(&chunk, text.replacen(",8\n", ",4\n", 1)).unwrap();
    dir.run("merge parts --out merged.csv --quiet").with(1, &["000000.chunk: it is damaged"]);
}

#[test]
fn a_table_is_drawn_once_more_and_its_manifest_is_its_scene() {
    let dir = TestDir::with_scene(SCENE);
    dir.run("sweep scene.toml --out map.csv --png map.png --svg map.svg --quiet").with(0, &[]);
    dir.run("draw map.csv --png drawn.png --svg drawn.svg --quiet").with(0, &[]);
    let told = "leaves for 172800 cells (480 × 360: 60 × 45, refined 3 times)";
    dir.run("draw map.csv --scene scene.toml --png given.png").with(0, &[told]);
    for (one, other) in [("map.png", "drawn.png"), ("map.png", "given.png"), ("map.svg", "drawn.svg")] {
        assert!(dir.read(one) == dir.read(other), "{one} {other}");
    }
    dir.run("draw map.csv --png radius.png --color spectral_radius --quiet").with(0, &[]);
    dir.run("sweep map.manifest.json --out again.csv --quiet").with(0, &[]);
    assert!(dir.read("again.csv") == dir.read("map.csv"));
    // A table that lacks a leaf, or has one twice, is none.
    let text = String::from_utf8(dir.read("map.csv")).unwrap();
    let lines: Vec<&str> = text.lines().collect();
    for (without, times) in [(700, 0), (700, 2)] {
        let kept = lines.iter().enumerate().flat_map(|(i, line)| vec![*line; if i == without { times } else { 1 }]);
        fs::write(dir.path("cut.csv"), kept.collect::<Vec<_>>().join("\n") + "\n").unwrap();
        dir.run("draw cut.csv --scene scene.toml --png cut.png").with(2, &["row ", "it is not of the next leaf"]);
    }
}

#[test]
fn what_cannot_be_refined_is_refused() {
    let dir = TestDir::new();
    let x = "x = { parameter = \"omega\", from = 0.4, to = 3.0, points = 60 }\n";
    let y = "y = { parameter = \"gamma2\", from = 0.0, to = 0.3, points = 45 }\n";
    for (old, new, told) in [
        ("depth = 3", "depth = 0", "depth = 0 is out of range: give how often a cell may be halved, 1 to 8"),
        ("depth = 3", "depth = 9", "depth = 9 is out of range"),
        ("depth = 3", "depth = -1", "depth = -1 is out of range"),
        ("depth = 3", "depth = 2.5", "floating point `2.5` is not a whole number"),
        ("depth = 3", "level = 3", "unknown key `level`: known here are `depth`"),
        ("depth = 3", "", "the key `depth` is missing"),
        (REFINE, "refin = { depth = 3 }\n", "unknown key `refin`"),
        (REFINE, "refine = 3\n", "integer `3` is not a table"),
        (y, "", "refine is of maps over two axes, here is one"),
        (y, &format!("{y}axes = [{{ parameter = \"gamma1\", values = [0.1, 0.2] }}]\n"), "here are 3"),
        (x, "x = { parameter = \"omega\", values = [0.5, 1.0] }\n", "refine halves equally spaced axes, omega is none"),
        ("points = 60 }", "points = 60, spacing = \"log\" }", "refine halves equally spaced axes, omega is none"),
        ("points = 60", "points = 200000", "would be 1600000 on the finest grid, more than 1000000"),
        ("points = 60", "points = 50000", "has 2250000 cells, more than 1000000"),
    ] {
        let text = SCENE.replace(old, new);
        let text = if old == y && !new.is_empty() { text.replace("gamma1 = 0.2\n", "") } else { text };
        let text =
            if old == y && new.is_empty() { text.replace("gamma1 = 0.2", "gamma1 = 0.2\ngamma2 = 0.1") } else { text };
        assert!(text != SCENE);
        dir.scene(&text);
        let ran = dir.run("sweep scene.toml --out map.csv");
        assert!(ran.code == Some(2) && ran.err.contains(told), "{new}: {ran:?}");
        assert!(ran.err.contains("scene.toml:"), "{ran:?}");
    }
    dir.scene(SCENE);
    dir.run("sweep scene.toml --out map.csv --png map.png --slice omega=0.4").with(2, &["--slice is of grids"]);
    dir.run("fate scene.toml --csv fates.csv").with(2, &["refine in scene.toml is of maps", "remove it"]);
}

#[test]
fn what_it_takes_is_told_beforehand() {
    let dir = TestDir::with_scene(SCENE);
    let told = dir.run("sweep scene.toml --dry-run").with(0, &[]).out;
    for words in ["cells    2700 (60 × 45)", "leaves   about ", "480 × 360 cells"] {
        assert!(told.contains(words), "{told}");
    }
}

/// What the summary says of thin stripes: of families, of words, under a force, and where growth is not asked for.
#[test]
fn how_stripes_were_followed_is_told() {
    let families = "families = [\"double-sided\", \"single-sided\"]";
    let words = "stripes of instability that pass between such points were followed, however thin";
    let dir = TestDir::new();
    for (old, new, told, not_told) in [
        (
            families,
            "families = [\"single-sided\"]",
            "thin stripes where two modes meet were followed, others not",
            "between such points",
        ),
        (families, "families = [\"0+1+,0-1-\"]", words, "others not"),
        (families, "families = [\"single-sided\", \"0+1+,0-1-\"]", words, "others not"),
        (
            "asymmetry = 0.4",
            "asymmetry = 0.4\namplitude = 0.01\nrestitution = 1",
            "thin stripes were not followed",
            "; stripes",
        ),
        ("stability = true\n", "", "may have missed: ", "stripes"),
    ] {
        let text = SCENE.replace(old, new).replace("points = 60", "points = 6").replace("points = 45", "points = 4");
        assert!(text.contains(new), "{text}");
        dir.scene(&text);
        let told_all = dir.run("sweep scene.toml --out map.csv").with(0, &[told]);
        assert!(!told_all.err.contains(not_told), "{told_all:?}");
    }
    // Of more masses than an order is told of: an error and a way out, which is one.
    let large = SCENE.replace("sites = 6", "sites = 201").replace(families, "families = [\"0+1+,0-1-\"]");
    let large = large.replace("points = 60", "points = 3").replace("points = 45", "points = 2");
    dir.scene(&large);
    dir.run("sweep scene.toml --out large.csv")
        .with(2, &["on 200 masses at most, here are 201", "threshold in [compute]"]);
    dir.scene(&large.replace("stability = true", "stability = true\nthreshold = 0.01"));
    dir.run("sweep scene.toml --out large.csv").with(0, &["may have missed: "]);
}
