//! The binary starts.
//!
//! Its commands are tested in the workspace's `tests`.
//! This test makes cargo build the binary together with the tests, in the same profile.

use std::process::Command;

#[test]
fn version_is_printed() {
    let output =
        Command::new(env!("CARGO_BIN_EXE_beadwork")).arg("--version").output().expect("it runs");
    assert!(output.status.success());
    assert_eq!(output.stdout, concat!("beadwork ", env!("CARGO_PKG_VERSION"), "\n").as_bytes());
}
