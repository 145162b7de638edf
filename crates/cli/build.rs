//! Has the binary find libtorch, if it learns.

#[path = "../learn/libtorch.rs"]
mod libtorch;

fn main() {
    if std::env::var_os("CARGO_FEATURE_LEARN").is_some() {
        libtorch::link();
    }
}
