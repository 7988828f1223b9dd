//! Compressed tables hold the bytes of plain ones.
#![cfg(feature = "compress")]

use std::io::Read;
use std::process::Command;

use vibrochain_testkit::{SCENE, TestDir, undisturbed};

/// Packing takes longer than computing.
fn four_chunks() -> String {
    SCENE.replace("points = 1600", "points = 400")
}

/// What a program other than ours makes of a file, if there is one.
fn unpacked_by(dir: &TestDir, program: &str, file: &str) -> Option<Vec<u8>> {
    let run = Command::new(program).arg("-dc").arg(dir.path(file)).output();
    let Ok(output) = run else {
        eprintln!("skipped: no {program} on this machine");
        return None;
    };
    assert!(output.status.success(), "{output:?}");
    Some(output.stdout)
}

#[test]
fn the_end_of_the_name_compresses_and_what_is_unpacked_is_the_table() {
    let scene = four_chunks();
    let expected = undisturbed(&scene);
    let dir = TestDir::with_scene(&scene);
    dir.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    for (end, program) in [("gz", "gzip"), ("zst", "zstd")] {
        let file = format!("map.csv.{end}");
        dir.run(&format!("sweep scene.toml --out {file} --quiet")).with(0, &[]);
        assert_eq!(dir.names("."), [&file, "map.manifest.json", "parts", "scene.toml"]);
        let packed = dir.read(&file);
        assert!(packed.len() < expected.len() / 3, "{end}: {} of {}", packed.len(), expected.len());
        let mut unpacked = Vec::new();
        match end {
            "gz" => drop(flate2::read::GzDecoder::new(&packed[..]).read_to_end(&mut unpacked).unwrap()),
            _ => unpacked = zstd::decode_all(&packed[..]).unwrap(),
        }
        assert!(unpacked == expected);
        assert!(unpacked_by(&dir, program, &file).is_none_or(|table| table == expected));
        // Merged, to the byte; on other threads as well.
        dir.run(&format!("merge parts --out merged.csv.{end} --quiet")).with(0, &[]);
        assert!(dir.read(&format!("merged.csv.{end}")) == packed);
        for left in
            [file, "map.manifest.json".to_owned(), format!("merged.csv.{end}"), "merged.manifest.json".to_owned()]
        {
            std::fs::remove_file(dir.path(&left)).unwrap();
        }
    }
}

#[cfg(unix)]
#[test]
fn a_compressed_table_that_does_not_fit_loses_no_chunk() {
    let dir = TestDir::with_scene(&four_chunks());
    for end in ["gz", "zst"] {
        dir.run(&format!("sweep scene.toml --out whole.csv.{end} --quiet")).with(0, &[]);
        dir.run(&format!("sweep scene.toml --out map.csv.{end}.parts --shard 0/1 --quiet")).with(0, &[]);
        let blocks = dir.read(&format!("whole.csv.{end}")).len() / 2 / 512;
        let line = format!("mapgen sweep scene.toml --out map.csv.{end} --quiet --resume");
        let told = [&format!("map.csv.{end}: File too large"), "4 of 4 chunks are finished, in map.csv."];
        dir.shell(&format!("ulimit -f {blocks}; exec {line}")).with(1, &told);
        assert!(!dir.path(&format!("map.csv.{end}")).exists());
        dir.shell(&line).with(0, &[]);
        assert!(dir.read(&format!("map.csv.{end}")) == dir.read(&format!("whole.csv.{end}")));
    }
}
