//! What is claimed beside the commands that show it: each is run, and lines of what it prints are quoted.

use vibrochain_cli::common::console::Console;
use vibrochain_cli::common::error::CliError;
use vibrochain_cli::program;

/// A claim, what is to be said to it, and the commands that show it.
pub(super) struct Evidence {
    pub(super) title: &'static str,
    pub(super) prose: &'static str,
    /// Command lines of `mapgen`.
    pub(super) commands: &'static [&'static str],
    /// Lines of their output are quoted if they contain one of these.
    pub(super) quoted: &'static [&'static str],
}

impl Evidence {
    /// The claim as Markdown; its commands are run.
    pub(super) fn markdown(&self, console: &Console<'_>) -> Result<String, CliError> {
        let mut text = format!("\n### {}\n\n{}\n", self.title, self.prose);
        for command in self.commands {
            let (mut out, mut err) = (Vec::new(), Vec::new());
            let mut own = Console::new(&mut out, &mut err, console.interrupt);
            let line = format!("mapgen {command}");
            program::run(line.split_whitespace().map(Into::into), &mut own)?;
            let printed = String::from_utf8_lossy(&out);
            let quotation: Vec<_> =
                printed.lines().filter(|line| self.quoted.iter().any(|part| line.contains(part))).collect();
            if quotation.is_empty() {
                return Err(CliError::Computation(format!("nothing to quote from `{line}`")));
            }
            text += &format!("\n```sh\n{line}\n```\n```text\n{}\n```\n", quotation.join("\n"));
        }
        Ok(text)
    }
}
