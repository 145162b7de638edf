//! Has the binary find libtorch where it was found to build it, if it learns.

use std::path::Path;

fn main() {
    println!("cargo::rerun-if-env-changed=LIBTORCH");
    let learns = std::env::var_os("CARGO_FEATURE_LEARN").is_some();
    if let Some(libtorch) = std::env::var_os("LIBTORCH").filter(|_| learns) {
        let lib = Path::new(&libtorch).join("lib");
        // The link in the checkout may point elsewhere tomorrow.
        let lib = lib.canonicalize().unwrap_or(lib);
        println!("cargo::rustc-link-arg=-Wl,-rpath,{}", lib.display());
    }
}
