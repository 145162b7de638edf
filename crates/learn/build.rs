//! Has the tests of this package find libtorch.

mod libtorch;

fn main() {
    libtorch::link();
}
