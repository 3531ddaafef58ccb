//! `facerecon params`, `facerecon completions`.

use clap::CommandFactory as _;

use super::shared::load_params;
use crate::args::{Cli, ParamArgs};
use crate::failure::Failure;
use crate::output::Terminal;

/// Prints all parameters as commented TOML.
pub(super) fn print(args: &ParamArgs, terminal: &Terminal) -> Result<(), Failure> {
    terminal.result(&load_params(args)?.to_toml()?);
    Ok(())
}

/// Prints the completion script for a shell.
pub(super) fn completions(shell: clap_complete::Shell, terminal: &Terminal) -> Result<(), Failure> {
    let mut script = Vec::new();
    clap_complete::generate(shell, &mut Cli::command(), "facerecon", &mut script);
    terminal.result(&String::from_utf8_lossy(&script));
    Ok(())
}
