//! The commands: one file each, or for a few related ones.

mod batch;
mod capture;
mod compare;
mod demo;
mod info;
mod make;
mod params;
mod pose;
mod reconstruct;
mod render;
mod shared;
mod stage;
mod template;

use crate::args::{Cli, Command};
use crate::failure::Failure;
use crate::output::Terminal;

/// Runs the command that was given.
pub(crate) fn run(cli: &Cli, terminal: &Terminal) -> Result<(), Failure> {
    match &cli.command {
        Command::Demo(args) => demo::demo(args, terminal),
        Command::New { dir } => capture::new(dir, terminal),
        Command::Check { capture } => capture::check(capture, terminal),
        Command::Reconstruct(args) => reconstruct::reconstruct(args, terminal),
        Command::Batch(args) => batch::batch(args, terminal),
        Command::Pattern(args) => make::pattern(args, terminal),
        Command::Simulate(args) => make::simulate(args, terminal),
        Command::Filter(args) => stage::filter(args, terminal),
        Command::Detect(args) => stage::detect(args, terminal),
        Command::Correspond(args) => stage::correspond(args, terminal),
        Command::Triangulate(args) => stage::triangulate(args, terminal),
        Command::Register(args) => stage::register(args, terminal),
        Command::Deform(args) => stage::deform(args, terminal),
        Command::Surface(args) => stage::surface(args, terminal),
        Command::Smooth(args) => stage::smooth(args, terminal),
        Command::Texture(args) => stage::texture(args, terminal),
        Command::Render(args) => render::render(args, terminal),
        Command::Compare(args) => compare::compare(args, terminal),
        Command::Info { file } => info::info(file, terminal),
        Command::Convert { input, output } => info::convert(input, output, terminal),
        Command::Template { action } => template::template(action, terminal),
        Command::Params(args) => params::print(args, terminal),
        Command::Completions { shell } => params::completions(*shell, terminal),
    }
}
