//! Ctrl-C as a cancel token.

use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};

use anyhow::Context;

/// A token that Ctrl-C (or a polite kill) sets; a second Ctrl-C ends the process at once.
pub(crate) fn token() -> anyhow::Result<&'static AtomicBool> {
    static TOKEN: AtomicBool = AtomicBool::new(false);
    static INSTALLED: OnceLock<()> = OnceLock::new();
    if INSTALLED.set(()).is_ok() {
        ctrlc::set_handler(|| {
            if TOKEN.swap(true, Ordering::Relaxed) {
                std::process::exit(1);
            }
            eprintln!("beadwork: stopping; once more to stop at once");
        })
        .context("cannot listen for Ctrl-C")?;
    }
    Ok(&TOKEN)
}
