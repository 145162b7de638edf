//! `cargo xtask setup`: libtorch, once for each user.
//!
//! tch is built against one version of libtorch, which the Python package index has as wheels. Pip fetches them, for it
//! knows the user's proxies, mirrors and certificates; it keeps those that are whole, and compares checksums. What a build
//! needs is unpacked into the user's cache, whole or not at all, and `.libtorch` in the checkout points there: that is
//! where `.cargo/config.toml` has builds look, from a shell or from an editor. Who sets LIBTORCH has it used instead.

use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

use crate::workspace;

/// The version that tch 0.26 is made for.
const VERSION: &str = "2.13.0";

/// What is fetched: name, version and checksum. All builds of torch hold the same libraries, whatever the Python that they
/// are for; this one is for Python 3.12.
const WHEELS: [(&str, &str, &str); 3] = [
    ("torch", VERSION, "796633c4cdf0fe2cdced72d8f88f22e73dbcfce83132763162f6d4bff13b820b"),
    ("nvidia-cuda-cupti", "13.0.85", "4eb01c08e859bf924d222250d2e8f8b8ff6d3db4721288cf35d14252a4d933c8"),
    ("nvidia-cuda-runtime", "13.0.96", "7f82250d7782aa23b6cfe765ecc7db554bd3c2870c43f3d1821f1d18aebf0548"),
];

/// What the wheels are built for, the narrowest first.
const PLATFORMS: [&str; 4] =
    ["manylinux_2_28_x86_64", "manylinux_2_25_x86_64", "manylinux_2_17_x86_64", "manylinux2014_x86_64"];

/// Files without which no build succeeds.
const NEEDED: [&str; 4] = [
    "include/torch/csrc/api/include/torch/torch.h",
    "lib/libtorch.so",
    "lib/libtorch_cpu.so",
    "lib/libc10.so",
];

const OWN: &str = "set LIBTORCH to a folder with libtorch 2.13.0 instead";

/// Whether builds find a libtorch.
pub(crate) fn is_done() -> bool {
    let own = std::env::var_os("LIBTORCH").map_or_else(|| workspace::root().join(".libtorch"), PathBuf::from);
    check(&own).is_ok()
}

/// Provides libtorch, unless it is there.
pub(crate) fn run() -> Result<()> {
    let link = workspace::root().join(".libtorch");
    // Cargo itself sets the variable to the link, for what it runs.
    if let Some(own) = std::env::var_os("LIBTORCH").filter(|own| Path::new(own) != link) {
        check(Path::new(&own)).with_context(|| format!("LIBTORCH is set to '{}'", own.display()))?;
        eprintln!("xtask: libtorch {VERSION}: '{}', as LIBTORCH says", own.display());
        return Ok(());
    }
    ensure!(
        cfg!(all(target_os = "linux", target_arch = "x86_64")),
        "only Linux on x86-64 is provided for: {OWN}"
    );
    let cache = cache()?;
    let folder = cache.join(format!("libtorch-{VERSION}-cpu"));
    if let Err(lack) = check(&folder) {
        if folder.exists() {
            eprintln!("xtask: {lack:#}: it is made anew");
            fs::remove_dir_all(&folder).with_context(|| format!("'{}'", folder.display()))?;
        }
        provide(&cache, &folder, OsStr::new("python3"))?;
        check(&folder)?;
    }
    point(&link, &folder)?;
    eprintln!("xtask: libtorch {VERSION}: '{}'", folder.display());
    Ok(())
}

/// The project's folder in the user's cache.
fn cache() -> Result<PathBuf> {
    let set = |name: &str| std::env::var_os(name).map(PathBuf::from).filter(|path| path.is_absolute());
    let cache = set("XDG_CACHE_HOME").or_else(|| set("HOME").map(|home| home.join(".cache")));
    Ok(cache.context("neither XDG_CACHE_HOME nor HOME tells where a cache could be")?.join("beadwork"))
}

/// Whether a folder holds the right libtorch.
fn check(folder: &Path) -> Result<()> {
    for file in NEEDED {
        ensure!(folder.join(file).is_file(), "'{}' is no libtorch: it has no {file}", folder.display());
    }
    let file = folder.join("build-version");
    let text = fs::read_to_string(&file).with_context(|| format!("'{}' tells no version", file.display()))?;
    // Official packages add what they were built for, as in 2.13.0+cpu.
    let version = text.trim().split('+').next().unwrap_or_default();
    ensure!(version == VERSION, "'{}' holds libtorch {version}: {VERSION} is needed", folder.display());
    Ok(())
}

/// Fetches and unpacks into a new folder of the cache.
fn provide(cache: &Path, folder: &Path, python: &OsStr) -> Result<()> {
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
    fs::create_dir_all(&wheels).with_context(|| format!("'{}' could not be made", wheels.display()))?;
    eprintln!("xtask: fetching libtorch {VERSION} (540 MB, once) into '{}'", cache.display());
    fetch(&wheels, python)?;
    eprintln!("xtask: unpacking");
    let part = cache.join(format!("libtorch-{VERSION}-cpu.{}.part", std::process::id()));
    let unpacked = unpack(&wheels, &part, python).and_then(|()| {
        fs::write(part.join("build-version"), format!("{VERSION}\n"))?;
        fs::rename(&part, folder).with_context(|| format!("'{}' could not be made", folder.display()))
    });
    if unpacked.is_err() {
        // What is left of it is of no use; the error that led here is the one to tell.
        let _ = fs::remove_dir_all(&part);
        return unpacked;
    }
    fs::remove_dir_all(&wheels).with_context(|| format!("'{}' could not be removed", wheels.display()))
}

/// Fetches the wheels one by one, so that each that is whole stays, whatever becomes of the next. Pip knows those that are
/// there already, and fetches anew what has another checksum.
fn fetch(wheels: &Path, python: &OsStr) -> Result<()> {
    for (name, version, sha256) in WHEELS {
        let wanted = wheels.join("wanted.txt");
        fs::write(&wanted, format!("{name}=={version} --hash=sha256:{sha256}\n"))?;
        let mut pip = Command::new(python);
        pip.args(["-m", "pip", "download", "--no-deps", "--require-hashes", "--only-binary=:all:"]);
        pip.args(["--python-version", "3.12", "--implementation", "cp", "--abi", "cp312", "--abi", "none"]);
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

fn unpack(wheels: &Path, part: &Path, python: &OsStr) -> Result<()> {
    let mut files = Vec::new();
    for entry in fs::read_dir(wheels)? {
        files.extend(Some(entry?.path()).filter(|path| path.extension() == Some(OsStr::new("whl"))));
    }
    let mut unpack = Command::new(python);
    unpack.args(["-c", include_str!("unpack.py")]).arg(part).args(&files);
    let status = unpack.status().context("python3 could not be started")?;
    ensure!(status.success(), "the wheels in '{}' could not be unpacked", wheels.display());
    Ok(())
}

/// Has the link point to a folder, whatever it pointed to before.
#[cfg(unix)]
fn point(link: &Path, folder: &Path) -> Result<()> {
    if fs::read_link(link).is_ok_and(|target| target == folder) {
        return Ok(());
    }
    let new = link.with_extension(std::process::id().to_string());
    let made = std::os::unix::fs::symlink(folder, &new).and_then(|()| fs::rename(&new, link));
    made.with_context(|| format!("'{}' could not be made to point to '{}'", link.display(), folder.display()))
}

#[cfg(not(unix))]
fn point(_: &Path, _: &Path) -> Result<()> {
    anyhow::bail!("only Linux is provided for: {OWN}")
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A folder of a test's own, gone with it.
    struct Folder(PathBuf);

    impl Folder {
        fn new(name: &str) -> Self {
            let path = std::env::temp_dir().join(format!("xtask-setup-{}-{name}", std::process::id()));
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
        let error = provide(&cache, &cache.join("x"), OsStr::new("no-such-python")).unwrap_err();
        assert!(format!("{error:#}").contains("python3 is needed"), "{error:#}");
        // Like a Python without modules, a shell runs what `-c` says, and finds no pip.
        let error = provide(&cache, &cache.join("x"), OsStr::new("sh")).unwrap_err();
        assert!(format!("{error:#}").contains("pip for python3 is needed"), "{error:#}");
        assert!(!cache.exists());
    }

    #[test]
    fn a_failed_fetch_says_what_to_do() {
        let folder = Folder::new("fetch");
        let error = fetch(&folder.0, OsStr::new("false")).unwrap_err();
        assert!(format!("{error:#}").contains("run this again"), "{error:#}");
    }

    #[test]
    fn what_is_not_whole_does_not_stay() {
        let folder = Folder::new("part");
        // A program that claims to have fetched and unpacked, and did neither.
        assert!(provide(&folder.0, &folder.0.join("x"), OsStr::new("true")).is_err());
        let left: Vec<_> = fs::read_dir(&folder.0).unwrap().map(|entry| entry.unwrap().file_name()).collect();
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
