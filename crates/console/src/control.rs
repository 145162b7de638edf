//! Control of long calls from the command line: threads, Ctrl-C and progress bars.

use anyhow::Context;
use beadwork_base::{Control, Progress, Threads};
use rayon::{ThreadPool, ThreadPoolBuilder};

use crate::{cancel, progress};

/// A thread pool of `threads` threads; 0 stands for one thread per core.
pub fn pool(threads: usize) -> anyhow::Result<ThreadPool> {
    ThreadPoolBuilder::new()
        .num_threads(thread_count(threads))
        .build()
        .context("cannot start threads")
}

/// The number of threads that `--threads N` means, where 0 stands for one thread per core.
pub fn thread_count(threads: usize) -> usize {
    let cores = || std::thread::available_parallelism().map_or(1, usize::from);
    if threads == 0 { cores() } else { threads }
}

/// A control that Ctrl-C cancels and that shows no progress.
pub fn cancellable(threads: Threads<'_>) -> anyhow::Result<Control<'_>> {
    Ok(Control { cancel: Some(cancel::token()?), ..Control::on(threads) })
}

/// Makes a long call that Ctrl-C cancels and that shows no progress.
pub fn quiet<R>(threads: Threads<'_>, call: impl FnOnce(&Control<'_>) -> R) -> anyhow::Result<R> {
    Ok(call(&cancellable(threads)?))
}

/// Makes a long call that Ctrl-C cancels, with a progress bar named `what`.
///
/// The bar counts the units of progress that the call reports; the documentation of the call names
/// them.
pub fn with_bar<R>(
    what: &'static str,
    threads: Threads<'_>,
    call: impl FnOnce(&Control<'_>) -> R,
) -> anyhow::Result<R> {
    let bar = progress::bar(0, what);
    let report = |progress: Progress| {
        bar.set_length(progress.total as u64);
        bar.set_position(progress.done as u64);
    };
    let control = Control { progress: Some(&report), ..cancellable(threads)? };
    let result = call(&control);
    bar.finish_and_clear();
    Ok(result)
}
