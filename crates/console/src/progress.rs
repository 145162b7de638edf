//! Progress bars on stderr, drawn only if stderr is a terminal.

use std::fmt::Write;

pub use indicatif::ProgressBar;
use indicatif::{ProgressState, ProgressStyle};

/// A progress bar over a number of items, with their rate and the time left.
pub fn bar(items: u64, what: &'static str) -> ProgressBar {
    let template = "{prefix} {wide_bar} {human_pos}/{human_len}  {rate}  {eta} left";
    let style = ProgressStyle::with_template(template).expect("the template is valid");
    let bar = ProgressBar::new(items);
    bar.set_style(style.with_key("rate", |state: &ProgressState, out: &mut dyn Write| {
        // Failing to draw a bar must not stop the work.
        let _ = write!(out, "{:.0}/s", state.per_sec());
    }));
    bar.set_prefix(what);
    bar
}

/// A progress bar for a resumed run: starts at `done` items, which its rate does not count.
pub fn resumed(items: u64, done: u64, what: &'static str) -> ProgressBar {
    let bar = bar(items, what);
    bar.set_position(done);
    bar.reset_eta();
    bar
}
