//! What commands have printed.

/// A conservative map of a short ring with stripes of instability.
pub const STRIPES_SCENE: &str = r#"
[model]
sites = 6
gamma1 = 0.2
asymmetry = 0.4
[sweep]
x = { parameter = "omega", from = 1.1, to = 2.3, points = 150 }
y = { parameter = "gamma2", from = 0.1, to = 0.3, points = 40 }
[compute]
families = ["double-sided", "single-sided"]
stability = true
"#;

/// The standard output of a command that has succeeded.
pub fn output(assert: assert_cmd::assert::Assert) -> String {
    String::from_utf8(assert.success().get_output().stdout.clone()).unwrap()
}

/// The numbers of a row of the table under a heading.
pub fn printed_numbers(text: &str, heading: &str, row: &str) -> Vec<f64> {
    let lines = text.lines().skip_while(|line| !line.starts_with(heading)).skip(1);
    let line = lines.take_while(|line| !line.is_empty()).find(|line| line.trim_start().starts_with(row));
    let words = line.unwrap_or_else(|| panic!("no {row} in\n{text}")).split_whitespace();
    words.filter_map(|word| word.parse().ok()).collect()
}
