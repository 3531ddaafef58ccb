//! The `facerecon` command.

use std::process::ExitCode;

fn main() -> ExitCode {
    ExitCode::from(facerecon_cli::run(std::env::args_os()))
}
