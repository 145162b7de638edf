//! Memory that stays with the process between two steps of training.

/// Blocks up to 32 MiB, the most that all versions allow, come from the heap; what is free at its
/// end stays there; and its pages are large ones where the system has them.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
const KEEP: &str = "glibc.malloc.mmap_threshold=33554432:glibc.malloc.trim_threshold=17179869184:glibc.malloc.hugetlb=1";

/// Begins the process anew with an allocator that keeps what is freed, unless the caller has
/// settings of their own.
///
/// A step of training frees all its features at its end.
/// By default the C library then gives the memory back, the next step asks for it again, and the
/// system clears it page by page: an eighth of the step.
/// Settings can't be changed from within without unsafe code, so the process takes its own place.
/// Where that fails it goes on as it is.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
pub fn keep() {
    use std::os::unix::process::CommandExt;

    // What the C library reads when a process begins.
    const VARIABLE: &str = "GLIBC_TUNABLES";
    if std::env::var_os(VARIABLE).is_some() {
        return;
    }
    let Ok(own) = std::env::current_exe() else { return };
    let mut arguments = std::env::args_os();
    let mut process = std::process::Command::new(own);
    process.arg0(arguments.next().unwrap_or_default()).args(arguments).env(VARIABLE, KEEP);
    // It only comes back if it failed.
    let _ = process.exec();
}

/// Other C libraries have no such settings.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
pub fn keep() {}
