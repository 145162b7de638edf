//! Links libtorch into the binary, if the feature `learn` is on.

#[path = "../learn/libtorch.rs"]
mod libtorch;

fn main() {
    if std::env::var_os("CARGO_FEATURE_LEARN").is_some() {
        libtorch::link();
    }
}
