//! `trisap`: steps recorded and synthetic scenes through the broad phase, checks and measures it.

mod args;
mod check;
mod drive;
mod dump;
mod figures;
mod layout;
mod pairs;
mod progress;
mod record;
mod report;
mod run;
mod scene_name;
mod setup;
#[cfg(feature = "record")]
mod simulate;
mod source;
#[cfg(feature = "record")]
mod split;
mod stopwatch;
mod summary;
mod tally;
mod view;
mod workers;

use clap::Parser;
use std::io;
use std::process::ExitCode;

/// What a command that did its work has to say.
enum Outcome {
    Good,
    CheckFailed,
}

fn main() -> ExitCode {
    let result = match args::Args::parse().command.unwrap_or_else(args::Command::shipped) {
        args::Command::Run(args) => run::run(&args),
        args::Command::View(args) => view::view(&args),
        args::Command::Pairs(args) => pairs::pairs(&args),
        args::Command::Record(args) => record::record(&args),
        args::Command::Layout(args) => layout::layout(&args),
        args::Command::Report(args) => report::report(&args),
    };
    match result {
        Ok(Outcome::Good) => ExitCode::SUCCESS,
        Ok(Outcome::CheckFailed) => ExitCode::from(1),
        // The reader of a pipe has seen enough.
        Err(error) if is_broken_pipe(&error) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn is_broken_pipe(error: &anyhow::Error) -> bool {
    error.downcast_ref::<io::Error>().is_some_and(|error| error.kind() == io::ErrorKind::BrokenPipe)
}
