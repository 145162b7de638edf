//! Linker arguments for executables that use libtorch: this package's tests, and the binary
//! `beadwork` with the feature `learn`.
//! Included by the build scripts of both.

use std::path::Path;

/// Sets the run-time search path of the executable to the libtorch it is built with.
pub(crate) fn link() {
    println!("cargo::rerun-if-env-changed=LIBTORCH");
    let Some(libtorch) = std::env::var_os("LIBTORCH") else { return };
    let lib = Path::new(&libtorch).join("lib");
    // `.libtorch` in the checkout is a symbolic link that may later point elsewhere.
    let lib = lib.canonicalize().unwrap_or(lib);
    println!("cargo::rustc-link-arg=-Wl,-rpath,{}", lib.display());
    if lib.join("libtorch_cuda.so").exists() {
        // The linker drops libraries from which no symbol is used. libtorch_cuda registers itself
        // with libtorch when it is loaded, so it must be linked nevertheless.
        println!("cargo::rustc-link-arg=-Wl,--push-state,--no-as-needed,-ltorch_cuda,--pop-state");
    }
}
