//! An allocator setting that keeps freed memory between training steps.

/// Allocates blocks of up to 32 MiB (the maximum of all glibc versions) on the heap, never trims
/// the heap below 16 GiB, and uses huge pages where the system has them.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const KEEP: &str = "glibc.malloc.mmap_threshold=33554432:\
                    glibc.malloc.trim_threshold=17179869184:\
                    glibc.malloc.hugetlb=1";

/// Restarts the process with an allocator that keeps freed memory, unless the user has set
/// `GLIBC_TUNABLES`.
///
/// A training step frees all its features at its end.
/// By default the C library returns that memory to the system, the next step requests it again, and
/// the system clears it page by page, which takes an eighth of the step.
/// A running process can change these settings only with unsafe code, so it replaces itself
/// (`exec`).
/// If that fails, it continues with the default settings.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub fn keep_freed() {
    use std::os::unix::process::CommandExt;

    // Read by the C library at the start of a process.
    const VARIABLE: &str = "GLIBC_TUNABLES";
    if std::env::var_os(VARIABLE).is_some() {
        return;
    }
    let Ok(own) = std::env::current_exe() else { return };
    let mut arguments = std::env::args_os();
    let mut process = std::process::Command::new(own);
    process.arg0(arguments.next().unwrap_or_default()).args(arguments).env(VARIABLE, KEEP);
    // `exec` returns only if it fails.
    let _ = process.exec();
}

/// Does nothing: other C libraries lack these settings.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub fn keep_freed() {}
