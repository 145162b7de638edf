//! The threads that a long call works on.

use rayon::ThreadPool;
use rayon::prelude::*;

/// The threads that a long call works on.
/// They affect how long it takes, never its result.
///
/// Rayon's global pool is used only if the caller asks for it, with [`Threads::Current`] outside of
/// any pool.
#[derive(Clone, Copy, Debug, Default)]
pub enum Threads<'a> {
    /// The calling thread alone.
    #[default]
    One,
    /// The rayon pool that the calling thread belongs to, or rayon's global pool if it belongs to
    /// none.
    Current,
    /// This thread pool.
    Pool(&'a ThreadPool),
}

impl<'a> Threads<'a> {
    /// The threads of a pool, or the calling thread if there is none.
    pub fn of(pool: Option<&'a ThreadPool>) -> Self {
        pool.map_or(Self::One, Self::Pool)
    }

    /// The number of threads, at least 1.
    pub fn count(self) -> usize {
        match self {
            Self::One => 1,
            Self::Current => rayon::current_num_threads(),
            Self::Pool(pool) => pool.current_num_threads(),
        }
    }

    /// Maps items to results, which keep the order of the items.
    pub fn map<T: Sync, R: Send>(self, items: &[T], map: impl Fn(&T) -> R + Sync) -> Vec<R> {
        self.map_with(items, || (), |(), item| map(item))
    }

    /// Maps items to results, which keep the order of the items.
    ///
    /// `init` makes a state, such as a buffer, that a thread reuses for several items.
    /// Results must not depend on what earlier items left in the state.
    pub fn map_with<T: Sync, R: Send, S>(
        self,
        items: &[T],
        init: impl Fn() -> S + Sync,
        map: impl Fn(&mut S, &T) -> R + Sync,
    ) -> Vec<R> {
        let serial = || {
            let mut state = init();
            items.iter().map(|item| map(&mut state, item)).collect()
        };
        self.either(serial, || items.par_iter().map_init(&init, &map).collect())
    }

    /// Maps items, which `map` may change, and their indices to results in the same order.
    pub fn map_mut<T: Send, R: Send>(
        self,
        items: &mut [T],
        map: impl Fn(usize, &mut T) -> R + Sync,
    ) -> Vec<R> {
        let parallel = |items: &mut [T]| {
            items.par_iter_mut().enumerate().map(|(index, item)| map(index, item)).collect()
        };
        match self {
            Self::One => {
                items.iter_mut().enumerate().map(|(index, item)| map(index, item)).collect()
            }
            Self::Current => parallel(items),
            Self::Pool(pool) => pool.install(|| parallel(items)),
        }
    }

    /// Maps the numbers `0..count` to results, in order.
    pub fn map_numbers<R: Send>(self, count: usize, map: impl Fn(usize) -> R + Sync) -> Vec<R> {
        let serial = || (0..count).map(&map).collect();
        self.either(serial, || (0..count).into_par_iter().map(&map).collect())
    }

    /// Runs both, at the same time if there are several threads, and returns both results.
    pub fn join<A: Send, B: Send>(
        self,
        a: impl FnOnce() -> A + Send,
        b: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        match self {
            Self::One => (a(), b()),
            Self::Current => rayon::join(a, b),
            Self::Pool(pool) => pool.join(a, b),
        }
    }

    /// Runs `serial` if there is only the calling thread, otherwise `parallel` inside the pool.
    pub fn either<R: Send>(
        self,
        serial: impl FnOnce() -> R,
        parallel: impl FnOnce() -> R + Send,
    ) -> R {
        match self {
            Self::One => serial(),
            Self::Current => parallel(),
            Self::Pool(pool) => pool.install(parallel),
        }
    }
}

#[cfg(test)]
mod tests {
    use rayon::ThreadPoolBuilder;

    use super::*;

    #[test]
    fn results_do_not_depend_on_the_threads() {
        let pool = ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        let items: Vec<u64> = (0..1000).collect();
        let expected: Vec<u64> = items.iter().map(|item| item * 3).collect();
        for threads in [Threads::One, Threads::Current, Threads::Pool(&pool)] {
            assert_eq!(threads.map(&items, |item| item * 3), expected);
            assert_eq!(threads.map_numbers(1000, |number| number as u64 * 3), expected);
            let with_buffer = threads.map_with(&items, Vec::new, |buffer, &item| {
                buffer.clear();
                buffer.extend([item; 3]);
                buffer.iter().sum::<u64>()
            });
            assert_eq!(with_buffer, expected);
            let mut changed = items.clone();
            let old = threads.map_mut(&mut changed, |index, item| {
                *item *= 3;
                index as u64
            });
            assert_eq!((changed, old), (expected.clone(), items.clone()));
        }
    }

    #[test]
    fn count_is_that_of_the_pool() {
        let pool = ThreadPoolBuilder::new().num_threads(3).build().unwrap();
        assert_eq!(Threads::default().count(), 1);
        assert_eq!(Threads::of(None).count(), 1);
        assert_eq!(Threads::of(Some(&pool)).count(), 3);
        assert_eq!(pool.install(|| Threads::Current.count()), 3);
    }
}
