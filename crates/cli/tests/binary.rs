//! The binary starts.
//!
//! What it does is tested in the workspace's `tests`.
//! For their sake too this test is here: it makes cargo build the binary together with the tests,
//! in the same profile, and so most of it once.

use std::process::Command;

#[test]
fn it_tells_its_version() {
    let output =
        Command::new(env!("CARGO_BIN_EXE_beadwork")).arg("--version").output().expect("it starts");
    assert!(output.status.success());
    assert_eq!(output.stdout, concat!("beadwork ", env!("CARGO_PKG_VERSION"), "\n").as_bytes());
}
