//! Progress bars on stderr, drawn only where it is a terminal.

use std::fmt::Write;

pub use indicatif::ProgressBar;
use indicatif::{ProgressState, ProgressStyle};

/// A bar over so many items with their rate and the time left.
pub fn bar(items: u64, what: &'static str) -> ProgressBar {
    let template = "{prefix} {wide_bar} {human_pos}/{human_len}  {rate}  {eta} left";
    let style = ProgressStyle::with_template(template).expect("the template is sound");
    let bar = ProgressBar::new(items);
    bar.set_style(style.with_key("rate", |state: &ProgressState, out: &mut dyn Write| {
        // A bar that can't be drawn is no reason to stop the work.
        let _ = write!(out, "{:.0}/s", state.per_sec());
    }));
    bar.set_prefix(what);
    bar
}

/// A bar over items of which some were done by an earlier run; its rate counts only those of this
/// one.
pub fn resumed(items: u64, done: u64, what: &'static str) -> ProgressBar {
    let bar = bar(items, what);
    bar.set_position(done);
    bar.reset_eta();
    bar
}
