//! Conventions shared by all crates of beadwork: control of long calls, and enums with names.
//!
//! - [`Control`]: the threads a long call works on, how it is cancelled, and how it reports
//!   progress.
//! - [`named_enum!`]: names of an enum's variants, for configuration files and the command line.
//!
//! # Example
//! ```
//! use beadwork_base::{CancelToken, Control, Interrupted, Threads};
//!
//! /// Sums squares, in parallel where the caller allows it.
//! fn sum_of_squares(items: &[u64], control: &Control<'_>) -> Result<u64, Interrupted> {
//!     control.check()?;
//!     let squares = control.threads.map(items, |item| item * item);
//!     control.report(items.len(), items.len());
//!     Ok(squares.iter().sum())
//! }
//!
//! let cancel = CancelToken::new();
//! let control = Control { cancel: Some(&cancel), ..Control::on(Threads::Current) };
//! assert_eq!(sum_of_squares(&[1, 2, 3], &control), Ok(14));
//! cancel.cancel();
//! assert_eq!(sum_of_squares(&[1, 2, 3], &control), Err(Interrupted::Cancelled));
//! ```
//!
//! # Guarantees
//! Nothing here does I/O, reads a clock or starts a thread.
//! Results do not depend on [`Threads`].

mod control;
mod named;
mod threads;

pub use control::{CancelToken, Control, Interrupted, Progress};
pub use named::UnknownName;
pub use threads::Threads;
