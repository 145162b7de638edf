//! Ctrl-C as a cancel token.

use std::sync::OnceLock;

use anyhow::Context;
use beadwork_base::CancelToken;

/// Returns the token that Ctrl-C and SIGTERM cancel; a second signal ends the process at once.
pub fn token() -> anyhow::Result<&'static CancelToken> {
    static TOKEN: OnceLock<CancelToken> = OnceLock::new();
    static INSTALLED: OnceLock<()> = OnceLock::new();
    let token = TOKEN.get_or_init(CancelToken::new);
    if INSTALLED.set(()).is_ok() {
        ctrlc::set_handler(|| {
            if token.cancel() {
                std::process::exit(1);
            }
            eprintln!("beadwork: stopping; press Ctrl-C again to stop at once");
        })
        .context("cannot listen for Ctrl-C")?;
    }
    Ok(token)
}
