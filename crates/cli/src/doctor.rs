//! `doctor`: what is installed, what is missing, and how to get it.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::Command;

use beadwork_console::{machine, output};
use serde::Serialize;
use serde_json::json;

/// Report what is installed, what is missing, and how to get it.
///
/// Nothing is required to run the commands of this binary; the table names what other tasks need.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork doctor
  cargo xtask doctor --json")]
pub(crate) struct Args {
    /// Print one JSON document.
    #[arg(long)]
    json: bool,
}

/// One thing that a task may need.
#[derive(Serialize)]
struct Item {
    name: &'static str,
    /// Its version or location; `None` if it is missing.
    found: Option<String>,
    /// What needs it.
    needed_for: &'static str,
    /// How to install it.
    install: &'static str,
}

pub(crate) fn run(args: &Args) -> anyhow::Result<()> {
    let items = items();
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    if args.json {
        return output::json(&json!({
            "machine": machine::facts(),
            "vector_units": vector_units(),
            "threads": threads,
            "networks": cfg!(feature = "learn"),
            "items": items,
        }));
    }
    let mut text = String::new();
    write(&mut text, &items).expect("writing to a string succeeds");
    output::text(&text)
}

fn write(text: &mut String, items: &[Item]) -> std::fmt::Result {
    let networks = if cfg!(feature = "learn") {
        "yes"
    } else {
        "no: cargo xtask builds a binary with networks where a command needs one"
    };
    writeln!(text, "machine       {}", machine::line())?;
    writeln!(text, "vector units  {}", vector_units().join(", "))?;
    writeln!(text, "networks      {networks}\n")?;
    let width = items.iter().map(|item| item.name.len()).max().unwrap_or(0);
    for Item { name, found, needed_for, install } in items {
        let (mark, found) = match found {
            Some(found) => ("ok     ", found.as_str()),
            None => ("missing", *install),
        };
        writeln!(text, "{mark}  {name:width$}  {found}")?;
        writeln!(text, "         {:width$}  for {needed_for}", "")?;
    }
    Ok(())
}

fn items() -> Vec<Item> {
    vec![
        Item {
            name: "Rust",
            found: version("rustc", &["--version"]),
            needed_for: "building; 1.90 or later",
            install: "see https://rustup.rs",
        },
        Item {
            name: "cargo-nextest",
            found: version("cargo", &["nextest", "--version"]),
            needed_for: "faster tests; optional",
            install: "cargo install --locked cargo-nextest",
        },
        Item {
            name: "git",
            found: version("git", &["--version"]),
            needed_for: "'cargo xtask tidy' and the commit recorded with results",
            install: "apt-get install git",
        },
        Item {
            name: "C++ compiler",
            found: version("c++", &["--version"]),
            needed_for: "building networks",
            install: "apt-get install g++",
        },
        Item {
            name: "Python with pip",
            found: version("python3", &["-m", "pip", "--version"]),
            needed_for: "downloading libtorch",
            install: "apt-get install python3 python3-pip",
        },
        Item {
            name: "libtorch 2.13.0",
            found: libtorch(),
            needed_for: "train, eval fusion, bench learn, zones --method fusion, plan --planner \
                         ppo",
            install: "cargo xtask setup (540 MB); --cuda for graphics cards (2.4 GB)",
        },
        Item {
            name: "trained FusionNet",
            found: file(Path::new("models/fusion-small/best.safetensors")),
            needed_for: "zones --method fusion without --model, in the current folder",
            install: "run in a checkout, or train one: cargo xtask train fusion --help",
        },
        Item {
            name: "trained policy",
            found: file(Path::new("models/ppo-small/greedy.safetensors")),
            needed_for: "plan --planner ppo without --policy, in the current folder",
            install: "run in a checkout, or train one: cargo xtask train ppo --help",
        },
        Item {
            name: "PrusaSlicer",
            found: version("prusa-slicer", &["--help"]),
            needed_for: "comparisons with another slicer; optional",
            install: "apt-get install prusa-slicer",
        },
    ]
}

/// First line that a program prints; `None` if it does not run.
fn version(program: &str, arguments: &[&str]) -> Option<String> {
    let output = Command::new(program).args(arguments).output().ok()?;
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = text.lines().find(|line| !line.trim().is_empty())?;
    output.status.success().then(|| line.trim().to_owned())
}

fn file(path: &Path) -> Option<String> {
    path.is_file().then(|| path.display().to_string())
}

/// Where builds find libtorch: the folder that LIBTORCH names, or `.libtorch` in the checkout.
fn libtorch() -> Option<String> {
    let set = std::env::var_os("LIBTORCH").map(PathBuf::from);
    let checkout = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../.libtorch");
    let folder = [set, Some(checkout)].into_iter().flatten();
    let folder = folder.into_iter().find(|folder| folder.join("lib/libtorch.so").is_file())?;
    let folder = folder.canonicalize().unwrap_or(folder);
    let cuda = folder.join("lib/libtorch_cuda.so").is_file();
    let hardware = if cuda { "with CUDA" } else { "for the processor" };
    let version = std::fs::read_to_string(folder.join("build-version")).unwrap_or_default();
    Some(format!("{} {} ({hardware})", version.trim(), folder.display()))
}

/// Vector units of the processor that the libraries use, the widest last.
fn vector_units() -> Vec<&'static str> {
    let mut units = Vec::new();
    #[cfg(target_arch = "x86_64")]
    {
        if is_x86_feature_detected!("avx2") && is_x86_feature_detected!("fma") {
            units.push("AVX2");
        }
        if is_x86_feature_detected!("avx512f") {
            units.push("AVX-512");
        }
        if is_x86_feature_detected!("avx512bf16") {
            units.push("bf16");
        }
    }
    if units.is_empty() {
        units.push("the architecture's baseline");
    }
    units
}
