//! The numbers behind every figure, which must not change unless on purpose.

use std::fs;
use std::path::Path;

use vibrochain_testkit::{Desk, Net};

#[test]
fn numbers_behind_the_figures_are_those_of_before() {
    let mut net = Net::open(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/net.json"));
    let desk = Desk::of("studies");
    desk.run("figures --out figures").with(0, &[]);
    for name in desk.names("figures").iter().filter(|name| name.ends_with(".csv")) {
        net.take(&format!("figure {name}"), &fs::read_to_string(desk.path(&format!("figures/{name}"))).unwrap());
    }
    net.finish();
}
