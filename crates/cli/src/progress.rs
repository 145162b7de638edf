//! Progress bars on stderr, drawn only where it is a terminal.

use indicatif::{ProgressBar, ProgressStyle};

/// A bar over so many items with their rate and the time left.
pub(crate) fn bar(items: u64, what: &'static str) -> ProgressBar {
    let bar = ProgressBar::new(items);
    let template = "{prefix} {wide_bar} {human_pos}/{human_len} {msg}  {per_sec}  {eta} left";
    bar.set_style(ProgressStyle::with_template(template).expect("the template is sound"));
    bar.set_prefix(what);
    bar
}
