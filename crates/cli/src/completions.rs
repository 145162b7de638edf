//! `completions`: scripts that complete commands and flags in a shell.

use beadwork_console::output;
use clap_complete::{Shell, generate};

/// Print a script that completes commands and flags in a shell.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  beadwork completions bash > ~/.local/share/bash-completion/completions/beadwork
  beadwork completions zsh > ~/.zfunc/_beadwork       # with ~/.zfunc in fpath
  beadwork completions fish > ~/.config/fish/completions/beadwork.fish")]
pub(crate) struct Args {
    /// The shell.
    shell: Shell,
}

pub(crate) fn run(args: &Args, mut command: clap::Command) -> anyhow::Result<()> {
    let mut script = Vec::new();
    generate(args.shell, &mut command, "beadwork", &mut script);
    output::text(&String::from_utf8_lossy(&script))
}
