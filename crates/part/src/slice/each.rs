//! Work on many things at once.

use rayon::ThreadPool;
use rayon::prelude::*;

/// What `work` makes of the numbers below `count`, in their order: in the pool, or one after the
/// other in the calling thread.
pub(super) fn each<T: Send>(
    pool: Option<&ThreadPool>,
    count: usize,
    work: impl Fn(usize) -> T + Sync + Send,
) -> Vec<T> {
    match pool {
        Some(pool) => pool.install(|| (0..count).into_par_iter().map(work).collect()),
        None => (0..count).map(work).collect(),
    }
}
