//! Pictures of dots in a terminal.

use std::io::{self, IsTerminal};

use clap::Args;

use crate::terminal::say;

/// Flags of pictures in a terminal.
#[derive(Debug, Args)]
pub(crate) struct Pictures {
    /// Draw the recording that is met worst in the terminal; where there is none, nothing is drawn.
    #[arg(long)]
    pub(crate) plot: bool,
    /// Accepted for earlier calls: nothing is drawn unless --plot asks for it.
    #[arg(long, hide = true, conflicts_with = "plot")]
    no_plot: bool,
}

impl Pictures {
    /// The pictures, if they are asked for and stdout is a terminal; else nothing.
    pub(crate) fn of(&self, quiet: bool, draw: impl FnOnce() -> String) -> io::Result<String> {
        if !self.plot {
            return Ok(String::new());
        }
        if io::stdout().is_terminal() {
            return Ok(draw());
        }
        let note = "--plot draws in a terminal, and stdout is none; --report FILE writes a page with figures";
        say(quiet, &[note.to_owned()])?;
        Ok(String::new())
    }
}
