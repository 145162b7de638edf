//! G-code.
mod arc;
mod command;
mod feature;
mod number;
mod parse;
mod program;
mod time;
mod trace;

pub use command::{Arc, Command, Move, Verbatim, VerbatimError};
pub use feature::Feature;
pub use number::{Number, NumberError};
pub use parse::{ParseError, ParseFault};
pub use program::{CommentError, Line, Program};
pub use time::{Limits, Stopwatch};
pub use trace::{Event, Motion, Trace, TraceError};
