//! How large a structure may be, however it is given; and structures of some of their modes.
#![allow(clippy::unwrap_used, clippy::panic, reason = "a test stops at the first surprise")]

use std::fs;

use vibrochain_maps::structure::{MOST_COORDINATES, StructureScene};

fn listed(number: &str, count: usize) -> String {
    vec![number; count].join(", ")
}

fn read(text: &str, files: &[(&str, String)]) -> Result<StructureScene, String> {
    let dir = tempfile::tempdir().unwrap();
    files.iter().for_each(|(name, text)| fs::write(dir.path().join(name), text).unwrap());
    let path = dir.path().join("scene.toml");
    fs::write(&path, text).unwrap();
    let scene = StructureScene::read(&path).map_err(|error| error.to_string())?;
    Ok(scene.unwrap())
}

/// What a structure is given by, its scene, and the files that the scene names, with their texts.
type Scene<'a> = (&'a str, String, &'a [(&'a str, String)]);

/// One more than the most is refused by one sentence whichever way it comes, before any work.
#[test]
fn one_limit_holds_however_a_structure_is_given() {
    let (n, contact) = (MOST_COORDINATES + 1, "[[contact]]\nat = 0\nupper = 1\n");
    let rows = format!("[{}]", listed("[1]", n));
    let diagonal = format!("%%MatrixMarket matrix coordinate real symmetric\n{n} {n} 1\n1 1 1\n");
    let free = "[[contact]]\nupper = 1\n";
    let ways: [Scene<'_>; 8] = [
        ("masses", format!("[structure]\nmasses = [{}]\nstiffness = [[1]]\n{contact}", listed("1", n)), &[]),
        ("rows", format!("[structure]\nmass = {rows}\nstiffness = [[1]]\n{contact}"), &[]),
        ("rows of the stiffness", format!("[structure]\nmasses = [1]\nstiffness = {rows}\n{contact}"), &[]),
        (
            "Matrix Market",
            format!("[structure]\nmass = \"m.mtx\"\nstiffness = [[1]]\n{contact}"),
            &[("m.mtx", diagonal)],
        ),
        (
            "frequencies",
            format!("[structure]\nfrequencies = [{}]\ncontact_shapes = [[1]]\n{free}", listed("1", n)),
            &[],
        ),
        (
            "a table of modes",
            format!("[structure]\nmodes = \"m.csv\"\n{free}"),
            &[("m.csv", format!("frequency,contact0\n{}", "1,1\n".repeat(n)))],
        ),
        ("a damped chain", format!("[model]\nsites = {n}\ngamma1 = 1\ngamma2 = 1\ndamping = 0.1\nupper = 1\n"), &[]),
        ("contacts", format!("[structure]\nmasses = [1]\nstiffness = [[1]]\n{}", contact.repeat(n)), &[]),
    ];
    let sentence = "are too many: a structure has at most 1000 coordinates, 1000 modes and 1000 contacts";
    for (way, text, files) in ways {
        let told = read(&text, files).unwrap_err();
        assert!(told.contains(sentence) && told.len() < 300, "{way}: {told}");
    }
}

/// A chain may have more masses than other structures have coordinates, where it has few contacts or keeps few modes.
#[test]
fn a_chain_is_as_large_as_its_modes_let_it_be() {
    let scene = |sites: usize, modes: &str, contacts: usize| {
        let chain = format!("chain = {{ sites = {sites}, gamma1 = 1, gamma2 = 1, damping = 0.1 }}");
        read(
            &format!("omega = 1\n[structure]\n{chain}\n{modes}{}", "[[contact]]\nat = 0\nupper = 1\n".repeat(contacts)),
            &[],
        )
    };
    let n = 1990;
    let whole = scene(n, "", 1).unwrap().model().unwrap();
    assert!(whole.structure().modes().len() == n && (whole.structure().effective_mass(0) - 1.0).abs() < 1e-12);
    let slowest = scene(40_000, "modes = 50\n", 1).unwrap();
    let (all, masses) = slowest.whole().unwrap();
    assert!(all == 40_000 && masses == [1.0] && slowest.model().unwrap().structure().modes().len() == 50);
    for (sites, modes, contacts, told) in [
        (
            2000,
            "",
            1,
            "2000 sites are too many for 2000 modes and 1 contacts: keep the slowest, modes = 1997 in [structure]",
        ),
        (MOST_COORDINATES + 1, "", MOST_COORDINATES, "modes = 999 in [structure], or give fewer contacts"),
        (40_000, "modes = 100\n", 1, "modes = 99 in"),
        (100_001, "modes = 1\n", 1, "a chain has at most 100000 masses"),
        (3, "modes = 4\n", 1, "the structure has 3"),
    ] {
        let error = scene(sites, modes, contacts).unwrap_err();
        assert!(error.contains(told), "{error}");
    }
}

/// Dashpots that couple many modes are refused before the eigenvalues that would take minutes, unless fewer modes are kept.
#[test]
fn many_modes_that_dashpots_couple_are_refused() {
    let n = 301;
    let dashpots = (1..=n).map(|i| format!("{i} {i} {}\n", 0.01 + 1e-4 * f64::from(i % 7))).collect::<String>();
    let springs = (1..=n).map(|i| format!("{i} {i} {}\n", 3.0 + 0.01 * f64::from(i % 11))).collect::<String>();
    let neighbours = (2..=n).map(|i| format!("{i} {} -1\n", i - 1)).collect::<String>();
    let head = |entries: i32| format!("%%MatrixMarket matrix coordinate real symmetric\n{n} {n} {entries}\n");
    let files = [
        ("c.mtx", head(n) + &dashpots),
        ("k.mtx", head(2 * n - 1) + &springs + &neighbours),
        ("m.mtx", head(n) + &(1..=n).map(|i| format!("{i} {i} 1\n")).collect::<String>()),
    ];
    let scene = |modes: &str| {
        format!(
            "omega = 1\n[structure]\nmass = \"m.mtx\"\nstiffness = \"k.mtx\"\ndamping = \"c.mtx\"\n{modes}\
             [[contact]]\nat = 0\nupper = 1\n"
        )
    };
    let told = read(&scene(""), &files).unwrap_err();
    assert!(told.contains("dashpots couple 301 modes, at most 300 are worked out together"), "{told}");
    assert_eq!(read(&scene("modes = 20\n"), &files).unwrap().model().unwrap().structure().modes().len(), 20);
}

/// Two masses: of the slower of two modes alone a contact has the mass 1/φ², all modes give it its own.
#[test]
fn modes_that_are_left_out_are_told() {
    let of = |modes: &str, at: usize| {
        let text = format!(
            "omega = 1\n[structure]\nmasses = [1, 3]\nstiffness = [[2, -1], [-1, 2]]\n{modes}\
             [[contact]]\nat = {at}\nupper = 1\n"
        );
        read(&text, &[])
    };
    let whole = of("", 0).unwrap();
    assert!(whole.whole().is_none() && whole.fixed().starts_with("2 modes, 1 contact"), "{}", whole.fixed());
    for at in [0, 1] {
        let kept = of("modes = 1\n", at).unwrap();
        let (all, masses) = kept.whole().unwrap();
        assert!(all == 2 && (masses[0] - [1.0, 3.0][at]).abs() < 1e-15, "{masses:?}");
        assert!(kept.fixed().starts_with("1 of 2 modes, 1 contact"), "{}", kept.fixed());
        // By hand: Ω² of det(K − Ω²M) = 3Ω⁴ − 8Ω² + 3, φ ~ (1, 2 − Ω²), φᵀMφ = 1.
        let square = (4.0 - 7f64.sqrt()) / 3.0;
        let shape = [1.0, 2.0 - square];
        let scale = shape[0] * shape[0] + 3.0 * shape[1] * shape[1];
        let structure = kept.model().unwrap().structure().clone();
        let mass = structure.effective_mass(0);
        assert!((mass - scale / (shape[at] * shape[at])).abs() < 1e-13 * mass, "{mass}");
        assert!((structure.modes()[0].rate - square.sqrt()).abs() < 1e-15);
    }
    for (modes, why) in [
        ("modes = 0\n", "a whole number from 1"),
        ("modes = 3\n", "the structure has 2"),
        ("modes = 1.5\n", "how many modes are kept"),
    ] {
        let told = of(modes, 0).unwrap_err();
        assert!(told.contains(why), "{told}");
    }
    let listed = "[structure]\nfrequencies = [1, 2]\ncontact_shapes = [[1, 1]]\nmodes = 1\n[[contact]]\nupper = 1\n";
    assert!(read(listed, &[]).unwrap_err().contains("give the frequencies that are kept"));
    // The second mass stands still in the first mode.
    let still = "omega = 1\n[structure]\nmasses = [1, 1]\nstiffness = [[1, 0], [0, 2]]\nmodes = 1\n[[contact]]\nat = 1\nupper = 1\n";
    assert!(read(still, &[]).unwrap_err().contains("contact 0 does not move in the first 1 modes"));
}
