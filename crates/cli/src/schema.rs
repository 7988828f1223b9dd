//! `mapgen schema`: prints the form of a JSON, or lists all.

use std::fmt::Write as _;

use crate::args::SchemaArgs;
use crate::common::console::Console;
use crate::common::error::CliError;
use crate::common::schemas::{names, schema};

/// Runs the subcommand: prints the schema, or without a name lists all.
///
/// # Errors
/// [`CliError`] if the answer cannot be written. A name that is unknown is refused by the command line.
pub fn run(args: &SchemaArgs, console: &mut Console<'_>) -> Result<(), CliError> {
    if let Some(schema) = args.name.as_deref().and_then(schema) {
        return console.print(&format!("{schema:#}\n"));
    }
    let mut list = String::new();
    for name in names() {
        let told = schema(name).and_then(|schema| schema["title"].as_str().map(str::to_owned)).unwrap_or_default();
        // Writing to a String cannot fail.
        let _ = writeln!(list, "{name:<9} {told}");
    }
    console.print(&list)
}
