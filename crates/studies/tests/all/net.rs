//! The numbers behind every figure, which must not change unless on purpose.

use std::fs;
use std::path::Path;

use vibrochain_testkit::{Net, TestDir};

/// The figures of forced maps take as long as all others ten times.
fn is_long(name: &str) -> bool {
    name.contains("figure-10")
}

fn are_those_of_before(figures: &str, wanted: impl Fn(&str) -> bool) {
    let net = Net::open(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/net.json"));
    let mut net = net.only(&wanted);
    let dir = TestDir::of("studies");
    dir.run(&format!("figures --out figures --only {figures}")).with(0, &[]);
    for name in dir.names("figures").iter().filter(|name| name.ends_with(".csv")) {
        net.take(&format!("figure {name}"), &fs::read_to_string(dir.path(&format!("figures/{name}"))).unwrap());
    }
    net.finish();
}

#[test]
fn numbers_behind_the_figures_are_those_of_before() {
    are_those_of_before("1,2,3,4,5,6,7,8,9,11,12,13,15", |name| !is_long(name));
}

#[test]
#[ignore = "half a minute: cargo test --workspace --test all -- --ignored slow"]
fn slow_numbers_behind_the_figures_of_forced_maps_are_those_of_before() {
    are_those_of_before("10,10-strict", is_long);
}
