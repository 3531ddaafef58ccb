//! The command line of facerecon as a library, so that the binary and the Python wheel run the
//! same code: [`run`] takes the arguments and gives the exit code (0 done, 1 the input could not
//! be read or reconstructed, 2 wrong usage).

mod args;
mod commands;
mod failure;
mod output;
mod progress;

use std::ffi::OsString;

use clap::Parser;

/// Runs the command line. Results go to stdout, progress and messages to stderr.
pub fn run(arguments: impl IntoIterator<Item = OsString>) -> u8 {
    let cli = match args::Cli::try_parse_from(arguments) {
        Ok(cli) => cli,
        Err(error) => {
            // clap prints help and version to stdout, usage errors to stderr
            let printed = error.print();
            return if printed.is_ok() && !error.use_stderr() { 0 } else { 2 };
        }
    };
    let terminal = output::Terminal::new(cli.quiet, cli.json);
    match in_threads(cli.threads, || commands::run(&cli, &terminal)) {
        Ok(()) => 0,
        Err(failure) => {
            terminal.failure(&failure);
            failure.exit_code()
        }
    }
}

/// Runs in a thread pool of the given size (`None`: one thread per core); results do not depend on it.
fn in_threads<T: Send>(
    threads: Option<u16>,
    work: impl FnOnce() -> Result<T, failure::Failure> + Send,
) -> Result<T, failure::Failure> {
    let builder = rayon::ThreadPoolBuilder::new().num_threads(threads.map_or(0, usize::from));
    match builder.build() {
        Ok(pool) => pool.install(work),
        Err(error) => Err(failure::Failure::usage(format!("--threads: {error}"))),
    }
}
