//! Tests of the checks, downloads and links of `setup`, with temporary folders and fake programs.

use super::*;

/// A temporary folder, removed when dropped.
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
fn required_version_is_accepted() {
    for version in ["2.13.0\n", "2.13.0+cpu\n", "2.13.0+cu130"] {
        check(&Folder::new("right").with_libtorch(version).0).unwrap();
    }
}

#[test]
fn error_names_another_version() {
    let folder = Folder::new("other").with_libtorch("2.6.0+cpu\n");
    let error = format!("{:#}", check(&folder.0).unwrap_err());
    assert!(error.contains("holds libtorch 2.6.0, but 2.13.0 is required"), "{error}");
}

#[test]
fn libtorch_for_the_processor_does_not_serve_graphics_cards() {
    let folder = Folder::new("cuda").with_libtorch("2.13.0");
    Target::Cpu.check(&folder.0).unwrap();
    let error = format!("{:#}", Target::Cuda.check(&folder.0).unwrap_err());
    assert!(error.contains(CUDA), "{error}");
    fs::write(folder.0.join(CUDA), "").unwrap();
    Target::Cuda.check(&folder.0).unwrap();
}

#[test]
fn error_names_a_missing_file() {
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
fn nothing_is_written_without_python_or_pip() {
    let folder = Folder::new("python");
    let cache = folder.0.join("cache");
    let error =
        install(&cache, &cache.join("x"), Target::Cpu, OsStr::new("no-such-python")).unwrap_err();
    assert!(format!("{error:#}").contains("python3 is required"), "{error:#}");
    // Like a Python without modules, a shell accepts `-c` and has no pip.
    let error = install(&cache, &cache.join("x"), Target::Cpu, OsStr::new("sh")).unwrap_err();
    assert!(format!("{error:#}").contains("pip for python3 is required"), "{error:#}");
    assert!(!cache.exists());
}

#[test]
fn error_of_a_failed_download_says_what_to_do() {
    let folder = Folder::new("fetch");
    let error = download(&folder.0, Target::Cpu, OsStr::new("false")).unwrap_err();
    assert!(format!("{error:#}").contains("run this again"), "{error:#}");
}

#[test]
fn wheels_of_other_versions_are_ignored() {
    let folder = Folder::new("wheels");
    let names = [
        "nvidia_cuda_cupti-13.0.85-py3-none-manylinux_2_25_x86_64.whl",
        "torch-2.13.0-cp312-cp312-manylinux_2_28_x86_64.whl",
    ];
    for name in
        names.iter().chain(&["torch-2.12.1-cp312-cp312-manylinux_2_28_x86_64.whl", "wanted.txt"])
    {
        fs::write(folder.0.join(name), "").unwrap();
    }
    let mut found = wheels_of_target(&folder.0, Target::Cpu).unwrap();
    found.sort();
    assert_eq!(found, names.map(|name| folder.0.join(name)));
}

#[test]
fn partial_installation_is_removed() {
    let folder = Folder::new("part");
    // A program that reports success without downloading or unpacking anything.
    assert!(install(&folder.0, &folder.0.join("x"), Target::Cpu, OsStr::new("true")).is_err());
    let left: Vec<_> =
        fs::read_dir(&folder.0).unwrap().map(|entry| entry.unwrap().file_name()).collect();
    assert_eq!(left, ["wheels"]);
}

#[cfg(unix)]
#[test]
fn link_follows_the_folder() {
    let folder = Folder::new("link");
    let link = folder.0.join(".libtorch");
    for target in ["a", "b", "b"] {
        set_link(&link, &folder.0.join(target)).unwrap();
        assert_eq!(fs::read_link(&link).unwrap(), folder.0.join(target));
    }
    assert_eq!(fs::read_dir(&folder.0).unwrap().count(), 1);
}
