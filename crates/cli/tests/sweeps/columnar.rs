//! A table by columns holds the values of the plain one, as other programs read it.
#![cfg(feature = "parquet")]

use std::process::Command;

use parquet::file::reader::{FileReader, SerializedFileReader};
use parquet::record::Field;
use vibrochain_testkit::scenes::FATE;
use vibrochain_testkit::{SCENE, TestDir};

/// Compares every value; numbers must be the same to the last bit, and what is missing must be missing.
const COMPARE: &str = r#"
import csv, sys
import pyarrow.parquet
columns = pyarrow.parquet.read_table("map.parquet").to_pydict()
rows = list(csv.DictReader(open("map.csv")))
assert list(columns) == list(rows[0]), list(columns)
words = {"class", "mechanism", "status"}
counts = {"solutions", "mode1", "mode2", "harmonic"}
for name, values in columns.items():
    assert len(values) == len(rows)
    kind = str if name in words else int if name in counts else float
    for row, value in zip(rows, values):
        assert value == (kind(row[name]) if row[name] else None), (name, row, value)
print(len(rows))
"#;

/// Holds every value of map.parquet against map.csv; how many there are, and columns.
fn alike(dir: &TestDir) -> (usize, usize) {
    let reader = SerializedFileReader::new(std::fs::File::open(dir.path("map.parquet")).unwrap()).unwrap();
    let mut rows = csv::Reader::from_path(dir.path("map.csv")).unwrap();
    let names: Vec<String> = rows.headers().unwrap().iter().map(str::to_owned).collect();
    let mut values = 0;
    for (row, plain) in reader.get_row_iter(None).unwrap().zip(rows.records()) {
        let (row, plain) = (row.unwrap(), plain.unwrap());
        for (((name, field), wanted), text) in row.get_column_iter().zip(&names).zip(&plain) {
            let same = match field {
                Field::Null => text.is_empty(),
                Field::Str(word) => word == text,
                Field::Double(number) => text.parse().is_ok_and(|plain: f64| plain.to_bits() == number.to_bits()),
                count => count.to_string() == text,
            };
            assert!(same && name == wanted, "{name} {field:?}, {wanted} {text}");
            values += 1;
        }
    }
    (values, names.len())
}

#[test]
fn values_of_a_structures_map_come_back_by_columns() {
    let dir = TestDir::with_scene(
        "omega = 0.9\n[structure]\nmass = [[1, 0], [0, 1.4]]\nstiffness = [[1, -0.3], [-0.3, 0.8]]\n\
         damping = [[0.02, 0], [0, 0.02]]\n[[contact]]\nat = 1\nlower = -0.7\nupper = 1.3\nrestitution = 0.8\n\
         [force]\nload = [0.5, 0]\n[sweep]\nx = { parameter = \"omega\", from = 0.4, to = 2.0, points = 12 }\n\
         y = { parameter = \"contact.0.upper\", from = 0.2, to = 1.4, points = 10 }\n\
         [compute]\nfamilies = [\"0+\", \"0+,0-\"]\n",
    );
    dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
    dir.run("sweep scene.toml --out map.parquet --quiet").with(0, &[]);
    let (values, columns) = alike(&dir);
    assert_eq!(values, 120 * columns);
}

/// Rows of breathers, of cells without any, and the chunks of an interrupted run.
#[test]
fn values_of_fates_come_back_by_columns() {
    let dir = TestDir::with_scene(FATE);
    let line = "fate scene.toml --breathers every --starts 2 --periods 40 --quiet";
    ["map.csv", "map.parquet"].iter().for_each(|name| drop(dir.run(&format!("{line} --out {name}")).with(0, &[])));
    let (values, columns) = alike(&dir);
    let rows = String::from_utf8(dir.read("map.csv")).unwrap().lines().count() - 1;
    assert!(columns > 20 && rows > 12 && values == rows * columns, "{values} {rows} {columns}");
    dir.run(&format!("{line} --out parts --shard 0/1")).with(0, &[]);
    dir.run("merge parts --out merged.parquet --quiet").with(0, &[]);
    assert!(dir.read("map.parquet") == dir.read("merged.parquet"));
}

#[test]
fn values_come_back_by_columns() {
    let scene = SCENE
        .replace("points = 300", "points = 100")
        .replace("families", "stability = true\ncollisions = true\nimpulse = true\nfamilies");
    let dir = TestDir::with_scene(&scene);
    dir.run("sweep scene.toml --out map.csv --quiet").with(0, &[]);
    dir.run("sweep scene.toml --out map.parquet --quiet").with(0, &[]);
    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    dir.run("merge parts --out merged.parquet --quiet").with(0, &[]);
    assert!(dir.read("map.parquet") == dir.read("merged.parquet"));
    assert!(dir.read("map.parquet").len() * 2 < dir.read("map.csv").len());

    let reader = SerializedFileReader::new(std::fs::File::open(dir.path("map.parquet")).unwrap()).unwrap();
    assert_eq!(reader.metadata().file_metadata().num_rows(), 160_000);
    assert_eq!(reader.metadata().num_row_groups(), 2);
    let (values, columns) = alike(&dir);
    assert_eq!(values, 160_000 * columns);

    // The same as a library reads it that shares no code with ours.
    let python = std::env::var("PYTHON").unwrap_or("python3".to_owned());
    let ready = Command::new(&python).args(["-c", "import pyarrow.parquet"]).output();
    if !ready.is_ok_and(|ready| ready.status.success()) {
        eprintln!("skipped: no Python with pyarrow (PYTHON names another)");
        return;
    }
    let compared = Command::new(&python).current_dir(dir.path(".")).args(["-c", COMPARE]).output().unwrap();
    assert!(compared.status.success(), "{}", String::from_utf8_lossy(&compared.stderr));
    assert_eq!(compared.stdout, b"160000\n");
}
