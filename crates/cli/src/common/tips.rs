//! What is said of a flag or a command that is not there: the one that was meant, where it belongs, or why there is none.

use std::ffi::OsString;

use clap::Command;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use vibrochain_maps::hints::said;
use vibrochain_maps::text::closest;

/// Flags of what the model has not, and how it is.
const NOT_THERE: [(&[&str], &str); 2] = [
    (
        &["dissipation", "viscosity"],
        "what a chain loses between impacts is --damping of each mass and --coupling-damping of each spring",
    ),
    (
        &["mass", "masses"],
        "all masses of a chain are 1, and how many there are is --sites; others are a structure's: --scene with [structure]",
    ),
];

/// Flags that are called otherwise here, and how.
const CALLED: [(&[&str], &str, &str); 3] = [
    (&["png", "svg", "pdf", "picture"], "plot", "pictures are --plot FILE, whose name ends in .png, .svg or .pdf"),
    (&["csv", "output", "table"], "out", "tables are --out FILE"),
    (&["color", "colour"], "show", "what a picture shows is --show"),
];

/// Commands that are flags of another, or another program's.
const WITHIN: [(&[&str], &str); 3] = [
    (&["animate", "animation", "movie", "gif"], "a run that moves is `mapgen simulate … --animate run.gif`"),
    (
        &["validate", "figures", "errata", "accuracy"],
        "validate, figures, errata and accuracy are studies, a program of their own: cargo run --locked --release -p vibrochain-studies -- --help",
    ),
    (&["plot", "picture"], "a table is drawn by `mapgen draw`, an answer by --plot of its own command"),
];

/// The same error, with the tip that helps instead of the one that merely sounds alike.
pub(crate) fn told(mut error: clap::Error, program: &Command, arguments: &[OsString]) -> clap::Error {
    let kind = match error.kind() {
        ErrorKind::UnknownArgument => ContextKind::InvalidArg,
        ErrorKind::InvalidSubcommand => ContextKind::InvalidSubcommand,
        _ => return error,
    };
    let Some(ContextValue::String(given)) = error.get(kind) else { return error };
    let tip = match kind {
        ContextKind::InvalidArg => of_flag(program, given, arguments),
        _ => of_command(program, given),
    };
    for sounds_alike in [ContextKind::SuggestedArg, ContextKind::SuggestedSubcommand, ContextKind::Suggested] {
        let _ = error.remove(sounds_alike);
    }
    // Usage has been written with the flag that sounds alike in it.
    let mut program = program.clone();
    program.build();
    let named = named(&program, arguments).map(|command| command.get_name().to_owned());
    let usage = match named.and_then(|name| program.find_subcommand_mut(name)) {
        Some(command) => command.render_usage(),
        None => program.render_usage(),
    };
    error.insert(ContextKind::Usage, ContextValue::StyledStr(usage));
    if let Some(tip) = tip {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(vec![tip.into()]));
    }
    error
}

/// Those that help lists.
fn visible(program: &Command) -> impl Iterator<Item = &Command> {
    program.get_subcommands().filter(|command| !command.is_hide_set())
}

/// The command that is asked for.
fn named<'a>(program: &'a Command, arguments: &[OsString]) -> Option<&'a Command> {
    visible(program).find(|command| arguments.iter().skip(1).any(|argument| argument == command.get_name()))
}

/// The long flags that help shows.
fn flags(command: &Command) -> impl Iterator<Item = &str> {
    command.get_arguments().filter(|argument| !argument.is_hide_set()).filter_map(clap::Arg::get_long)
}

fn of_flag(program: &Command, given: &str, arguments: &[OsString]) -> Option<String> {
    let name = given.strip_prefix("--")?;
    let command = named(program, arguments).unwrap_or(program);
    let has = |wanted: &str| flags(command).any(|flag| flag == wanted);
    if let Some((_, words)) = NOT_THERE.iter().find(|(names, _)| names.contains(&name)) {
        return Some((*words).to_owned());
    }
    if let Some((.., words)) = CALLED.iter().find(|(names, own, _)| names.contains(&name) && has(own)) {
        return Some((*words).to_owned());
    }
    let own = flags(command).chain(flags(program));
    // A flag of another command that is spelt right is no slip.
    let others: Vec<&str> =
        visible(program).filter(|other| flags(other).any(|flag| flag == name)).map(Command::get_name).collect();
    match (others.as_slice(), closest(name, own)) {
        ([], Some(meant)) => Some(format!("did you mean --{meant}?")),
        ([], None) => {
            let near =
                |(names, own, _): &&(&[&str], &str, &str)| has(own) && closest(name, names.iter().copied()).is_some();
            let called = CALLED.iter().find(near).map(|(.., words)| (*words).to_owned());
            called.or_else(|| said(name).map(str::to_owned))
        }
        (others, _) => Some(format!("--{name} is of {}, not of {}", others.join(", "), command.get_name())),
    }
}

fn of_command(program: &Command, given: &str) -> Option<String> {
    if let Some((_, words)) = WITHIN.iter().find(|(names, _)| names.contains(&given)) {
        return Some((*words).to_owned());
    }
    closest(given, visible(program).map(Command::get_name)).map(|meant| format!("did you mean `{meant}`?"))
}
