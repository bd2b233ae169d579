//! `sma completions` and `sma man`: what a shell and its manual know of the program.

use std::path::PathBuf;

use anyhow::{Context, bail};
use clap::{Args, CommandFactory};
use clap_complete::Shell;

use crate::Cli;
use crate::outcome::Outcome;
use crate::terminal::write_stdout;

/// Write completions for a shell to stdout.
#[derive(Debug, Args)]
#[command(before_help = "Example:\n  \
    sma completions bash > ~/.local/share/bash-completion/completions/sma\n  \
    sma completions zsh > ~/.zfunc/_sma\n  \
    sma completions fish > ~/.config/fish/completions/sma.fish")]
pub(crate) struct CompletionsArgs {
    /// The shell.
    shell: Shell,
}

/// Write manual pages into a folder, one a subcommand.
#[derive(Debug, Args)]
#[command(before_help = "Example:\n  \
    sma man ~/.local/share/man/man1 && man sma-diagnose")]
pub(crate) struct ManArgs {
    /// A folder that exists.
    folder: PathBuf,
}

/// Runs `sma completions`.
pub(crate) fn completions(args: &CompletionsArgs) -> anyhow::Result<Outcome> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "sma", &mut script);
    write_stdout(&String::from_utf8(script)?)?;
    Ok(Outcome::Done)
}

/// Runs `sma man`.
pub(crate) fn man(args: &ManArgs) -> anyhow::Result<Outcome> {
    let folder = &args.folder;
    if !folder.is_dir() {
        bail!("{}: no such folder; make it first", folder.display());
    }
    // A manual page ends with its examples, where help begins with one.
    let command = Cli::command().mut_subcommands(|command| {
        let texts = [command.get_before_help(), command.get_after_help()];
        let text: Vec<String> = texts
            .into_iter()
            .flatten()
            .map(ToString::to_string)
            .collect();
        command.after_help(text.join("\n\n"))
    });
    clap_mangen::generate_to(command, folder)
        .with_context(|| format!("{}: cannot be written", folder.display()))?;
    Ok(Outcome::Done)
}
