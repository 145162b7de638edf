//! What a build script says to the linker, for whatever runs on libtorch: this package's tests, and
//! the binary if it learns.

use std::path::Path;

/// Has what is linked find libtorch where it was found to build it.
pub(crate) fn link() {
    println!("cargo::rerun-if-env-changed=LIBTORCH");
    let Some(libtorch) = std::env::var_os("LIBTORCH") else { return };
    let lib = Path::new(&libtorch).join("lib");
    // The link in the checkout may point elsewhere tomorrow.
    let lib = lib.canonicalize().unwrap_or(lib);
    println!("cargo::rustc-link-arg=-Wl,-rpath,{}", lib.display());
    if lib.join("libtorch_cuda.so").exists() {
        // Nobody calls it by name: it makes itself known to libtorch when it is loaded, and the
        // linker would leave it out.
        println!("cargo::rustc-link-arg=-Wl,--push-state,--no-as-needed,-ltorch_cuda,--pop-state");
    }
}
