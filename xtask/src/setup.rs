//! `cargo xtask setup`: libtorch, once for each user.
//!
//! tch is built against one version of libtorch, which the Python package index has as wheels.
//! Pip fetches them, for it knows the user's proxies, mirrors and certificates; it keeps those that
//! are whole, and compares checksums.
//! What a build needs is unpacked into the user's cache, whole or not at all, and `.libtorch` in
//! the checkout points there: that is where `.cargo/config.toml` has builds look, from a shell or
//! from an editor.
//! Who sets LIBTORCH has it used instead.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

use crate::workspace;

/// The version that tch 0.26 is made for.
const VERSION: &str = "2.13.0";

/// A wheel of the index: name, version and checksum.
type Wheel = (&'static str, &'static str, &'static str);

/// What every build needs.
/// All builds of torch hold the same libraries, whatever the Python that they are for; this one is
/// for Python 3.12.
/// The other two are asked for by libtorch even where no graphics card is.
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

/// What graphics cards need beside them: the libraries that torch's own wheel names as its
/// dependencies.
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

/// What the wheels are built for, the narrowest first.
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

/// Files without which no build succeeds.
const NEEDED: [&str; 4] = [
    "include/torch/csrc/api/include/torch/torch.h",
    "lib/libtorch.so",
    "lib/libtorch_cpu.so",
    "lib/libc10.so",
];

/// What a build for graphics cards is known by.
const CUDA: &str = "lib/libtorch_cuda.so";

const OWN: &str = "set LIBTORCH to a folder with libtorch 2.13.0 instead";

/// What libtorch is to compute on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Target {
    /// The processor.
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

    /// Whether a folder holds the right libtorch for it.
    fn check(self, folder: &Path) -> Result<()> {
        let cuda = folder.join(CUDA);
        ensure!(self == Self::Cpu || cuda.is_file(), "'{}' has no {CUDA}", folder.display());
        check(folder)
    }
}

/// Provides libtorch for the processor, unless builds find one already, for whatever it is made.
pub(crate) fn provide_any() -> Result<()> {
    let link = workspace::root().join(".libtorch");
    if own(&link).is_none() && check(&link).is_ok() { Ok(()) } else { run(Target::Cpu) }
}

/// The folder that the user has chosen.
/// Cargo itself sets the variable to the link, for what it runs.
fn own(link: &Path) -> Option<PathBuf> {
    std::env::var_os("LIBTORCH").map(PathBuf::from).filter(|own| own != link)
}

/// Provides libtorch, unless it is there.
pub(crate) fn run(target: Target) -> Result<()> {
    let link = workspace::root().join(".libtorch");
    if let Some(own) = own(&link) {
        target.check(&own).with_context(|| format!("LIBTORCH is set to '{}'", own.display()))?;
        eprintln!("xtask: libtorch {VERSION}: '{}', as LIBTORCH says", own.display());
        return Ok(());
    }
    ensure!(
        cfg!(all(target_os = "linux", target_arch = "x86_64")),
        "only Linux on x86-64 is provided for: {OWN}"
    );
    let cache = cache()?;
    let folder = cache.join(format!("libtorch-{VERSION}-{}", target.name()));
    if let Err(lack) = target.check(&folder) {
        if folder.exists() {
            eprintln!("xtask: {lack:#}: it is made anew");
            fs::remove_dir_all(&folder).with_context(|| format!("'{}'", folder.display()))?;
        }
        provide(&cache, &folder, target, OsStr::new("python3"))?;
        target.check(&folder)?;
    }
    if point(&link, &folder)? {
        forget_builds()?;
    }
    eprintln!("xtask: libtorch {VERSION}: '{}'", folder.display());
    Ok(())
}

/// The project's folder in the user's cache.
fn cache() -> Result<PathBuf> {
    let set =
        |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let cache = set("XDG_CACHE_HOME").or_else(|| set("HOME").map(|home| home.join(".cache")));
    Ok(cache
        .context("neither XDG_CACHE_HOME nor HOME tells where a cache could be")?
        .join("beadwork"))
}

/// Whether a folder holds the right libtorch.
fn check(folder: &Path) -> Result<()> {
    for file in NEEDED {
        ensure!(
            folder.join(file).is_file(),
            "'{}' is no libtorch: it has no {file}",
            folder.display()
        );
    }
    let file = folder.join("build-version");
    let text = fs::read_to_string(&file)
        .with_context(|| format!("'{}' tells no version", file.display()))?;
    // Official packages add what they were built for, as in 2.13.0+cpu.
    let version = text.trim().split('+').next().unwrap_or_default();
    ensure!(
        version == VERSION,
        "'{}' holds libtorch {version}: {VERSION} is needed",
        folder.display()
    );
    Ok(())
}

/// Fetches and unpacks into a new folder of the cache.
fn provide(cache: &Path, folder: &Path, target: Target, python: &OsStr) -> Result<()> {
    let works = |words: &[&str]| {
        let mut python = Command::new(python);
        python.args(words).stdout(Stdio::null()).stderr(Stdio::null());
        python.status().is_ok_and(|status| status.success())
    };
    ensure!(
        works(&["-c", ""]),
        "python3 is needed to fetch libtorch, and does not run: install it, or {OWN}"
    );
    ensure!(
        works(&["-m", "pip", "--version"]),
        "pip for python3 is needed to fetch libtorch: install it, or {OWN}"
    );
    let wheels = cache.join("wheels");
    fs::create_dir_all(&wheels)
        .with_context(|| format!("'{}' could not be made", wheels.display()))?;
    eprintln!(
        "xtask: fetching libtorch {VERSION} ({}, once) into '{}'",
        target.size(),
        cache.display()
    );
    fetch(&wheels, target, python)?;
    eprintln!("xtask: unpacking");
    let part =
        cache.join(format!("libtorch-{VERSION}-{}.{}.part", target.name(), std::process::id()));
    let unpacked = unpack(&wheels, &part, target, python).and_then(|()| {
        fs::write(part.join("build-version"), format!("{VERSION}\n"))?;
        fs::rename(&part, folder)
            .with_context(|| format!("'{}' could not be made", folder.display()))
    });
    if unpacked.is_err() {
        // What is left of it is of no use; the error that led here is the one to tell.
        let _ = fs::remove_dir_all(&part);
        return unpacked;
    }
    fs::remove_dir_all(&wheels)
        .with_context(|| format!("'{}' could not be removed", wheels.display()))
}

/// Fetches the wheels one by one, so that each that is whole stays, whatever becomes of the next.
/// Pip knows those that are there already, and fetches anew what has another checksum.
fn fetch(wheels: &Path, target: Target, python: &OsStr) -> Result<()> {
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
        // Later versions take up a connection that broke; earlier ones would refuse the option.
        pip.env("PIP_RESUME_RETRIES", "20");
        let status = pip.status().context("pip could not be started")?;
        ensure!(
            status.success(),
            "pip did not fetch {name}, see above; run this again, what is whole is kept, or {OWN}"
        );
    }
    Ok(())
}

/// The wheels of a folder that are wanted: others may have been left there by a fetch of another
/// version.
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
    let status = unpack.status().context("python3 could not be started")?;
    ensure!(status.success(), "the wheels in '{}' could not be unpacked", wheels.display());
    Ok(())
}

/// Has the next build ask anew what there is to link: what LIBTORCH says is the same link, so cargo
/// sees no change.
fn forget_builds() -> Result<()> {
    for profile in ["dev", "release"] {
        let mut clean = workspace::cargo();
        clean.current_dir(workspace::root()).args([
            "clean",
            "--quiet",
            "--locked",
            "--profile",
            profile,
        ]);
        clean.args(["-p", "torch-sys", "-p", "beadwork-learn", "-p", "beadwork-cli"]);
        let status = clean.status().context("cargo could not be started")?;
        ensure!(
            status.success(),
            "builds against another libtorch could not be removed: run 'cargo clean'"
        );
    }
    Ok(())
}

/// Has the link point to a folder; tells whether it pointed elsewhere before.
#[cfg(unix)]
fn point(link: &Path, folder: &Path) -> Result<bool> {
    let before = fs::read_link(link).ok();
    if before.as_deref() == Some(folder) {
        return Ok(false);
    }
    let new = link.with_extension(std::process::id().to_string());
    let made = std::os::unix::fs::symlink(folder, &new).and_then(|()| fs::rename(&new, link));
    made.with_context(|| {
        format!("'{}' could not be made to point to '{}'", link.display(), folder.display())
    })?;
    Ok(before.is_some())
}

#[cfg(not(unix))]
fn point(_: &Path, _: &Path) -> Result<bool> {
    anyhow::bail!("only Linux is provided for: {OWN}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder of a test's own, gone with it.
    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let path =
                std::env::temp_dir().join(format!("xtask-setup-{}-{name}", std::process::id()));
            fs::create_dir_all(&path).unwrap();
            Self(path)
        }

        fn with_libtorch(self, version: &str) -> Self {
            for file in NEEDED {
                let path = self.0.join(file);
                fs::create_dir_all(path.parent().unwrap()).unwrap();
                fs::write(path, "").unwrap();
            }
            fs::write(self.0.join("build-version"), version).unwrap();
            self
        }
    }

    impl Drop for Folder {
        fn drop(&mut self) {
            fs::remove_dir_all(&self.0).unwrap();
        }
    }

    #[test]
    fn the_right_libtorch_is_known() {
        for version in ["2.13.0\n", "2.13.0+cpu\n", "2.13.0+cu130"] {
            check(&Folder::new("right").with_libtorch(version).0).unwrap();
        }
    }

    #[test]
    fn another_version_is_named() {
        let folder = Folder::new("other").with_libtorch("2.6.0+cpu\n");
        let error = format!("{:#}", check(&folder.0).unwrap_err());
        assert!(error.contains("holds libtorch 2.6.0: 2.13.0 is needed"), "{error}");
    }

    #[test]
    fn what_is_made_for_the_processor_is_not_for_graphics_cards() {
        let folder = Folder::new("cuda").with_libtorch("2.13.0");
        Target::Cpu.check(&folder.0).unwrap();
        let error = format!("{:#}", Target::Cuda.check(&folder.0).unwrap_err());
        assert!(error.contains(CUDA), "{error}");
        fs::write(folder.0.join(CUDA), "").unwrap();
        Target::Cuda.check(&folder.0).unwrap();
    }

    #[test]
    fn what_is_missing_is_named() {
        let folder = Folder::new("lacking").with_libtorch("2.13.0");
        for file in NEEDED.iter().rev().chain(&["build-version"]) {
            fs::rename(folder.0.join(file), folder.0.join("elsewhere")).unwrap();
            let error = format!("{:#}", check(&folder.0).unwrap_err());
            assert!(error.contains(file), "{error}");
            fs::rename(folder.0.join("elsewhere"), folder.0.join(file)).unwrap();
        }
        assert!(check(&folder.0.join("nowhere")).is_err());
    }

    #[test]
    fn without_python_or_pip_nothing_is_left_behind() {
        let folder = Folder::new("python");
        let cache = folder.0.join("cache");
        let error = provide(&cache, &cache.join("x"), Target::Cpu, OsStr::new("no-such-python"))
            .unwrap_err();
        assert!(format!("{error:#}").contains("python3 is needed"), "{error:#}");
        // Like a Python without modules, a shell runs what `-c` says, and finds no pip.
        let error = provide(&cache, &cache.join("x"), Target::Cpu, OsStr::new("sh")).unwrap_err();
        assert!(format!("{error:#}").contains("pip for python3 is needed"), "{error:#}");
        assert!(!cache.exists());
    }

    #[test]
    fn a_failed_fetch_says_what_to_do() {
        let folder = Folder::new("fetch");
        let error = fetch(&folder.0, Target::Cpu, OsStr::new("false")).unwrap_err();
        assert!(format!("{error:#}").contains("run this again"), "{error:#}");
    }

    #[test]
    fn wheels_of_other_versions_are_left_alone() {
        let folder = Folder::new("wheels");
        let names = [
            "nvidia_cuda_cupti-13.0.85-py3-none-manylinux_2_25_x86_64.whl",
            "torch-2.13.0-cp312-cp312-manylinux_2_28_x86_64.whl",
        ];
        for name in names
            .iter()
            .chain(&["torch-2.12.1-cp312-cp312-manylinux_2_28_x86_64.whl", "wanted.txt"])
        {
            fs::write(folder.0.join(name), "").unwrap();
        }
        let mut found = wheels_of_target(&folder.0, Target::Cpu).unwrap();
        found.sort();
        assert_eq!(found, names.map(|name| folder.0.join(name)));
    }

    #[test]
    fn what_is_not_whole_does_not_stay() {
        let folder = Folder::new("part");
        // A program that claims to have fetched and unpacked, and did neither.
        assert!(provide(&folder.0, &folder.0.join("x"), Target::Cpu, OsStr::new("true")).is_err());
        let left: Vec<_> =
            fs::read_dir(&folder.0).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, ["wheels"]);
    }

    #[cfg(unix)]
    #[test]
    fn the_link_follows() {
        let folder = Folder::new("link");
        let link = folder.0.join(".libtorch");
        for target in ["a", "b", "b"] {
            point(&link, &folder.0.join(target)).unwrap();
            assert_eq!(fs::read_link(&link).unwrap(), folder.0.join(target));
        }
        assert_eq!(fs::read_dir(&folder.0).unwrap().count(), 1);
    }
}
