//! `cargo xtask setup`: installs libtorch, once per user.
//!
//! tch requires one version of libtorch, which the Python package index offers as wheels.
//! The wheels are downloaded by pip, since it knows the user's proxies, mirrors and certificates;
//! it keeps complete downloads and verifies checksums.
//! The files that a build needs are unpacked into the user's cache, completely or not at all.
//! `.libtorch` in the checkout is a link to them; `.cargo/config.toml` sets LIBTORCH to that link,
//! so that builds from a shell and from an editor find it.
//! A LIBTORCH set by the user takes precedence.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

use crate::workspace;

/// The version that tch 0.26 requires.
const VERSION: &str = "2.13.0";

/// A wheel of the package index: name, version and SHA-256 checksum.
type Wheel = (&'static str, &'static str, &'static str);

/// Wheels that every build needs.
///
/// The libraries in the wheel of torch are the same for all Python versions; the wheel for 3.12 is
/// used. libtorch links the other two wheels even on machines without a graphics card.
const WHEELS: [Wheel; 3] = [
    ("torch", VERSION, "796633c4cdf0fe2cdced72d8f88f22e73dbcfce83132763162f6d4bff13b820b"),
    (
        "nvidia-cuda-cupti",
        "13.0.85",
        "4eb01c08e859bf924d222250d2e8f8b8ff6d3db4721288cf35d14252a4d933c8",
    ),
    (
        "nvidia-cuda-runtime",
        "13.0.96",
        "7f82250d7782aa23b6cfe765ecc7db554bd3c2870c43f3d1821f1d18aebf0548",
    ),
];

/// Additional wheels for graphics cards: the dependencies that the wheel of torch declares.
const CUDA_WHEELS: [Wheel; 12] = [
    (
        "nvidia-cublas",
        "13.1.1.3",
        "37936a16db8fe4ac1f065c2139360608a543a09275cb1a1af612e08cfa065436",
    ),
    (
        "nvidia-cuda-nvrtc",
        "13.0.88",
        "ad9b6d2ead2435f11cbb6868809d2adeeee302e9bb94bcf0539c7a40d80e8575",
    ),
    (
        "nvidia-cudnn-cu13",
        "9.20.0.48",
        "0c45dd8eeb50b603f07995b1b300c62ffe6a1980482b82b3bcf94a4ca9d49304",
    ),
    (
        "nvidia-cufft",
        "12.0.0.61",
        "6c44f692dce8fd5ffd3e3df134b6cdb9c2f72d99cf40b62c32dde45eea9ddad3",
    ),
    (
        "nvidia-cufile",
        "1.15.1.6",
        "08a3ecefae5a01c7f5117351c64f17c7c62efa5fffdbe24fc7d298da19cd0b44",
    ),
    (
        "nvidia-curand",
        "10.4.0.35",
        "1aee33a5da6e1db083fe2b90082def8915f30f3248d5896bcec36a579d941bfc",
    ),
    (
        "nvidia-cusolver",
        "12.0.4.66",
        "0a759da5dea5c0ea10fd307de75cdeb59e7ea4fcb8add0924859b944babf1112",
    ),
    (
        "nvidia-cusparse",
        "12.6.3.3",
        "2b3c89c88d01ee0e477cb7f82ef60a11a4bcd57b6b87c33f789350b59759360b",
    ),
    (
        "nvidia-cusparselt-cu13",
        "0.8.1",
        "786ce87568c303fadb5afcc7102d454cd3040d75f6f8626f5db460d1871f4dd0",
    ),
    (
        "nvidia-nccl-cu13",
        "2.29.7",
        "edd81538446786ec3b73972543e53bb43bcaf0bfc8ef76cb679fcc390ffe136d",
    ),
    (
        "nvidia-nvjitlink",
        "13.5.37",
        "280d7cb9649704145f074b8dbde500de04ce02d0872e066e20a83c17bcaa93eb",
    ),
    (
        "nvidia-nvshmem-cu13",
        "3.4.5",
        "290f0a2ee94c9f3687a02502f3b9299a9f9fe826e6d0287ee18482e78d495b80",
    ),
];

/// Platform tags of the wheels, the most specific first.
const PLATFORMS: [&str; 8] = [
    "manylinux_2_28_x86_64",
    "manylinux_2_27_x86_64",
    "manylinux_2_25_x86_64",
    "manylinux_2_18_x86_64",
    "manylinux_2_17_x86_64",
    "manylinux2014_x86_64",
    "manylinux_2_12_x86_64",
    "manylinux2010_x86_64",
];

/// Files that every build needs.
const NEEDED: [&str; 4] = [
    "include/torch/csrc/api/include/torch/torch.h",
    "lib/libtorch.so",
    "lib/libtorch_cpu.so",
    "lib/libc10.so",
];

/// File that only a libtorch for graphics cards contains.
const CUDA: &str = "lib/libtorch_cuda.so";

const ALTERNATIVE: &str = "set LIBTORCH to a folder with libtorch 2.13.0 instead";

/// The hardware that libtorch computes on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// The processor only.
    Cpu,
    /// The processor and graphics cards.
    Cuda,
}

impl Target {
    fn name(self) -> &'static str {
        match self {
            Self::Cpu => "cpu",
            Self::Cuda => "cuda",
        }
    }

    fn wheels(self) -> impl Iterator<Item = Wheel> {
        let more = match self {
            Self::Cpu => [].as_slice(),
            Self::Cuda => &CUDA_WHEELS,
        };
        WHEELS.iter().chain(more).copied()
    }

    fn size(self) -> &'static str {
        match self {
            Self::Cpu => "540 MB",
            Self::Cuda => "2.4 GB",
        }
    }

    /// Checks that a folder holds libtorch for this hardware.
    fn check(self, folder: &Path) -> Result<()> {
        let cuda = folder.join(CUDA);
        ensure!(self == Self::Cpu || cuda.is_file(), "'{}': {CUDA} is missing", folder.display());
        check(folder)
    }
}

/// Installs libtorch for the processor, unless builds already find a libtorch of either kind.
pub(crate) fn provide_any() -> Result<()> {
    let link = workspace::root().join(".libtorch");
    if user_folder(&link).is_none() && check(&link).is_ok() { Ok(()) } else { run(Target::Cpu) }
}

/// The folder to which the user has set LIBTORCH.
/// `.cargo/config.toml` sets the variable to the link in the checkout; that does not count.
fn user_folder(link: &Path) -> Option<PathBuf> {
    std::env::var_os("LIBTORCH").map(PathBuf::from).filter(|own| own != link)
}

/// Installs libtorch, unless it is installed.
pub(crate) fn run(target: Target) -> Result<()> {
    let link = workspace::root().join(".libtorch");
    if let Some(own) = user_folder(&link) {
        target.check(&own).with_context(|| format!("LIBTORCH is set to '{}'", own.display()))?;
        eprintln!("xtask: libtorch {VERSION}: '{}', set by LIBTORCH", own.display());
        return Ok(());
    }
    ensure!(
        cfg!(all(target_os = "linux", target_arch = "x86_64")),
        "setup supports Linux on x86-64 only: {ALTERNATIVE}"
    );
    let cache = cache()?;
    let folder = cache.join(format!("libtorch-{VERSION}-{}", target.name()));
    if let Err(error) = target.check(&folder) {
        if folder.exists() {
            eprintln!("xtask: {error:#}; installing it again");
            fs::remove_dir_all(&folder).with_context(|| format!("'{}'", folder.display()))?;
        }
        install(&cache, &folder, target, OsStr::new("python3"))?;
        target.check(&folder)?;
    }
    if set_link(&link, &folder)? {
        remove_builds()?;
    }
    eprintln!("xtask: libtorch {VERSION}: '{}'", folder.display());
    Ok(())
}

/// The project's folder in the user's cache.
fn cache() -> Result<PathBuf> {
    let set =
        |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let cache = set("XDG_CACHE_HOME").or_else(|| set("HOME").map(|home| home.join(".cache")));
    Ok(cache.context("no cache folder: neither XDG_CACHE_HOME nor HOME is set")?.join("beadwork"))
}

/// Checks that a folder holds the required version of libtorch.
fn check(folder: &Path) -> Result<()> {
    for file in NEEDED {
        ensure!(
            folder.join(file).is_file(),
            "'{}' is not a libtorch: {file} is missing",
            folder.display()
        );
    }
    let file = folder.join("build-version");
    let text = fs::read_to_string(&file).with_context(|| {
        format!("cannot read the version of libtorch from '{}'", file.display())
    })?;
    // Official packages append the hardware, as in 2.13.0+cpu.
    let version = text.trim().split('+').next().unwrap_or_default();
    ensure!(
        version == VERSION,
        "'{}' holds libtorch {version}, but {VERSION} is required",
        folder.display()
    );
    Ok(())
}

/// Downloads libtorch and unpacks it into a new folder of the cache.
fn install(cache: &Path, folder: &Path, target: Target, python: &OsStr) -> Result<()> {
    let works = |words: &[&str]| {
        let mut python = Command::new(python);
        python.args(words).stdout(Stdio::null()).stderr(Stdio::null());
        python.status().is_ok_and(|status| status.success())
    };
    ensure!(
        works(&["-c", ""]),
        "python3 is required to download libtorch, but does not run: install it, or {ALTERNATIVE}"
    );
    ensure!(
        works(&["-m", "pip", "--version"]),
        "pip for python3 is required to download libtorch: install it, or {ALTERNATIVE}"
    );
    let wheels = cache.join("wheels");
    fs::create_dir_all(&wheels).with_context(|| format!("cannot create '{}'", wheels.display()))?;
    eprintln!(
        "xtask: downloading libtorch {VERSION} ({}, once) to '{}'",
        target.size(),
        cache.display()
    );
    download(&wheels, target, python)?;
    eprintln!("xtask: unpacking");
    let part =
        cache.join(format!("libtorch-{VERSION}-{}.{}.part", target.name(), std::process::id()));
    let unpacked = unpack(&wheels, &part, target, python).and_then(|()| {
        fs::write(part.join("build-version"), format!("{VERSION}\n"))?;
        fs::rename(&part, folder).with_context(|| format!("cannot create '{}'", folder.display()))
    });
    if unpacked.is_err() {
        // The partial folder is useless; a failure to remove it must not hide the first error.
        let _ = fs::remove_dir_all(&part);
        return unpacked;
    }
    fs::remove_dir_all(&wheels).with_context(|| format!("cannot remove '{}'", wheels.display()))
}

/// Downloads the wheels one by one, so that complete ones are kept if a later download fails.
///
/// Present wheels are skipped by pip, and those with a wrong checksum are downloaded again.
fn download(wheels: &Path, target: Target, python: &OsStr) -> Result<()> {
    for (name, version, sha256) in target.wheels() {
        let wanted = wheels.join("wanted.txt");
        fs::write(&wanted, format!("{name}=={version} --hash=sha256:{sha256}\n"))?;
        let mut pip = Command::new(python);
        pip.args(["-m", "pip", "download", "--no-deps", "--require-hashes", "--only-binary=:all:"]);
        pip.args([
            "--python-version",
            "3.12",
            "--implementation",
            "cp",
            "--abi",
            "cp312",
            "--abi",
            "none",
        ]);
        pip.args(PLATFORMS.iter().flat_map(|platform| ["--platform", platform]));
        pip.arg("--dest").arg(wheels).arg("-r").arg(&wanted);
        // Recent versions of pip resume broken downloads; older ones ignore the variable, but would
        // refuse an option.
        pip.env("PIP_RESUME_RETRIES", "20");
        let status = pip.status().context("cannot start pip")?;
        ensure!(
            status.success(),
            "pip did not download {name}, see above; \
             run this again (complete files are kept), or {ALTERNATIVE}"
        );
    }
    Ok(())
}

/// The required wheels in a folder, which may also hold wheels of another version.
fn wheels_of_target(wheels: &Path, target: Target) -> Result<Vec<PathBuf>> {
    let wanted: Vec<_> = target
        .wheels()
        .map(|(name, version, _)| format!("{}-{version}-", name.replace('-', "_")))
        .collect();
    let mut files = Vec::new();
    for entry in fs::read_dir(wheels)? {
        let entry = entry?;
        let name = entry.file_name();
        let name = name.to_string_lossy();
        if name.ends_with(".whl") && wanted.iter().any(|wanted| name.starts_with(wanted)) {
            files.push(entry.path());
        }
    }
    Ok(files)
}

fn unpack(wheels: &Path, part: &Path, target: Target, python: &OsStr) -> Result<()> {
    let files = wheels_of_target(wheels, target)?;
    let mut unpack = Command::new(python);
    unpack.args(["-c", include_str!("unpack.py"), target.name()]).arg(part).args(&files);
    let status = unpack.status().context("cannot start python3")?;
    ensure!(status.success(), "cannot unpack the wheels in '{}'", wheels.display());
    Ok(())
}

/// Removes builds that link the previous libtorch: LIBTORCH still names the same link, so cargo
/// would not notice the change.
fn remove_builds() -> Result<()> {
    for profile in ["dev", "release"] {
        let mut clean = workspace::cargo();
        clean.current_dir(workspace::root()).args([
            "clean",
            "--quiet",
            "--locked",
            "--profile",
            profile,
        ]);
        clean.args([
            "-p",
            "torch-sys",
            "-p",
            "beadwork-learn",
            "-p",
            "beadwork-lab",
            "-p",
            "beadwork-cli",
        ]);
        let status = clean.status().context("cannot start cargo")?;
        ensure!(
            status.success(),
            "cannot remove builds against another libtorch: run 'cargo clean'"
        );
    }
    Ok(())
}

/// Makes the link point to a folder; returns whether it pointed elsewhere before.
#[cfg(unix)]
fn set_link(link: &Path, folder: &Path) -> Result<bool> {
    let before = fs::read_link(link).ok();
    if before.as_deref() == Some(folder) {
        return Ok(false);
    }
    let new = link.with_extension(std::process::id().to_string());
    let made = std::os::unix::fs::symlink(folder, &new).and_then(|()| fs::rename(&new, link));
    made.with_context(|| format!("cannot link '{}' to '{}'", link.display(), folder.display()))?;
    Ok(before.is_some())
}

#[cfg(not(unix))]
fn set_link(_: &Path, _: &Path) -> Result<bool> {
    anyhow::bail!("setup supports Linux only: {ALTERNATIVE}")
}

#[cfg(test)]
mod tests;
