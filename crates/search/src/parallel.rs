//! Work on many things at once.

use rayon::ThreadPool;
use rayon::prelude::*;

/// Maps items in the given threads, or one after the other; each thread begins with a state of its
/// own.
pub(crate) fn in_parallel<T: Sync, R: Send, S>(
    pool: Option<&ThreadPool>,
    items: &[T],
    begin: impl Fn() -> S + Sync,
    map: impl Fn(&mut S, &T) -> R + Sync,
) -> Vec<R> {
    if let Some(pool) = pool {
        return pool.install(|| items.par_iter().map_init(&begin, &map).collect());
    }
    let mut state = begin();
    items.iter().map(|item| map(&mut state, item)).collect()
}
