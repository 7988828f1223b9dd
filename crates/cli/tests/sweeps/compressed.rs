//! Compressed tables hold the bytes of plain ones.
#![cfg(feature = "compress")]

use std::io::Read;
use std::process::Command;

use vibrochain_testkit::{Desk, SCENE, undisturbed};

/// Packing takes longer than computing.
fn four_chunks() -> String {
    SCENE.replace("points = 1600", "points = 400")
}

/// What a program other than ours makes of a file, if there is one.
fn unpacked_by(desk: &Desk, program: &str, file: &str) -> Option<Vec<u8>> {
    let run = Command::new(program).arg("-dc").arg(desk.path(file)).output();
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
    let desk = Desk::with_scene(&scene);
    desk.run("sweep scene.toml --out parts --shard 0/1 --quiet").with(0, &[]);
    for (end, program) in [("gz", "gzip"), ("zst", "zstd")] {
        let file = format!("map.csv.{end}");
        desk.run(&format!("sweep scene.toml --out {file} --quiet")).with(0, &[]);
        assert_eq!(desk.names("."), [&file, "map.manifest.json", "parts", "scene.toml"]);
        let packed = desk.read(&file);
        assert!(packed.len() < expected.len() / 3, "{end}: {} of {}", packed.len(), expected.len());
        let mut unpacked = Vec::new();
        match end {
            "gz" => drop(flate2::read::GzDecoder::new(&packed[..]).read_to_end(&mut unpacked).unwrap()),
            _ => unpacked = zstd::decode_all(&packed[..]).unwrap(),
        }
        assert!(unpacked == expected);
        assert!(unpacked_by(&desk, program, &file).is_none_or(|table| table == expected));
        // Merged, to the byte; on other threads as well.
        desk.run(&format!("merge parts --out merged.csv.{end} --quiet")).with(0, &[]);
        assert!(desk.read(&format!("merged.csv.{end}")) == packed);
        for left in
            [file, "map.manifest.json".to_owned(), format!("merged.csv.{end}"), "merged.manifest.json".to_owned()]
        {
            std::fs::remove_file(desk.path(&left)).unwrap();
        }
    }
}

#[cfg(unix)]
#[test]
fn a_compressed_table_that_does_not_fit_loses_no_chunk() {
    let desk = Desk::with_scene(&four_chunks());
    for end in ["gz", "zst"] {
        desk.run(&format!("sweep scene.toml --out whole.csv.{end} --quiet")).with(0, &[]);
        desk.run(&format!("sweep scene.toml --out map.csv.{end}.parts --shard 0/1 --quiet")).with(0, &[]);
        let blocks = desk.read(&format!("whole.csv.{end}")).len() / 2 / 512;
        let line = format!("mapgen sweep scene.toml --out map.csv.{end} --quiet --resume");
        let told = [&format!("map.csv.{end}: File too large"), "4 of 4 chunks are finished, in map.csv."];
        desk.shell(&format!("ulimit -f {blocks}; exec {line}")).with(1, &told);
        assert!(!desk.path(&format!("map.csv.{end}")).exists());
        desk.shell(&line).with(0, &[]);
        assert!(desk.read(&format!("map.csv.{end}")) == desk.read(&format!("whole.csv.{end}")));
    }
}
