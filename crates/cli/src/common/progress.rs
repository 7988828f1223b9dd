//! Bars that tell how far long work is, on a terminal.

use std::time::Duration;

use indicatif::{HumanCount, HumanDuration, ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};

/// How often a bar is drawn anew where nothing happens: time passes.
const TICK: Duration = Duration::from_millis(200);

/// A bar of so many steps, drawn by `template`; none unless it is wanted.
pub(crate) fn bar(length: u64, template: &str, wanted: bool) -> ProgressBar {
    bar_with(length, template, wanted, |style| style)
}

/// A bar that counts things and tells how many there are a second, `finished` of which others have done.
pub(crate) fn counter(length: u64, finished: u64, things: &str, wanted: bool) -> ProgressBar {
    let template =
        format!("{{bar:32}} {{percent:>3}}%  {{human_pos}}/{{human_len}} {things}  {{rate}} {things}/s{{left}}");
    // A broken line of progress is no reason to stop: the result of writing it is left alone.
    let rate = |state: &ProgressState, line: &mut dyn std::fmt::Write| {
        let _ = write!(line, "{}", HumanCount(state.per_sec() as u64));
    };
    // Until something is done nobody knows how long the rest will take.
    let left = move |state: &ProgressState, line: &mut dyn std::fmt::Write| {
        if state.pos() > finished && state.per_sec() > 0.0 {
            let _ = write!(line, "  {:#} left", HumanDuration(state.eta()));
        }
    };
    let keys = |style: ProgressStyle| style.with_key("rate", rate).with_key("left", left);
    let bar = bar_with(length, &template, wanted, keys).with_position(finished);
    // What earlier runs have done tells nothing of this one's speed.
    bar.reset_eta();
    bar
}

fn bar_with(
    length: u64,
    template: &str,
    wanted: bool,
    keys: impl FnOnce(ProgressStyle) -> ProgressStyle,
) -> ProgressBar {
    if !wanted {
        return ProgressBar::hidden();
    }
    let bar = ProgressBar::with_draw_target(Some(length), ProgressDrawTarget::stderr());
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(keys(style));
    }
    bar.enable_steady_tick(TICK);
    bar
}
