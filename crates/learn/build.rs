//! Lets the tests of this package find libtorch at run time.

mod libtorch;

fn main() {
    libtorch::link();
}
