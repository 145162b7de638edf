//! Numbers and comments as they are written to a file.

use beadwork_gcode::{Line, Number};

/// Decimals of positions, speeds and temperatures, as in the output of common slicers.
pub(super) const DECIMALS: u32 = 3;

/// Decimals of filament lengths.
pub(super) const FILAMENT_DECIMALS: u32 = 5;

/// Rounds a value that comes from the settings or from a position on the bed.
pub(super) fn number(value: f64, decimals: u32) -> Number {
    Number::from_f64(value, decimals)
        .expect("validated settings and positions on a bed are far below the limit")
}

/// A line with a comment.
///
/// Line breaks and other control characters become blanks, so that a part or tool name cannot
/// inject a command.
pub(super) fn comment(text: String) -> Line {
    let text =
        if text.contains(char::is_control) { text.replace(char::is_control, " ") } else { text };
    Line::new(None, Some(text)).expect("the text has no line break")
}
