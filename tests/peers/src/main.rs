//! Runs trisap and its peers side by side: in one process, on the same recordings, frame by frame in turn, each
//! pair set checked in every frame. See README.md.

mod clock;
mod once;
mod options;
mod oracle;
mod ours;
mod peers;
mod queries;
mod recording;
mod report;
mod run;
mod scenes;

use std::process::ExitCode;

fn main() -> ExitCode {
    let options = match options::Options::parse(std::env::args().skip(1)) {
        Ok(options) => options,
        Err(message) => {
            eprintln!("{message}\n\n{}", options::USAGE);
            return ExitCode::from(2);
        }
    };
    if let Some([side, count]) = options.once_side {
        once::child(side, count, options.clock);
        return ExitCode::SUCCESS;
    }
    if options.once {
        return match once::table(&options) {
            Ok(table) => {
                print!("{table}");
                ExitCode::SUCCESS
            }
            Err(message) => {
                eprintln!("{message}");
                ExitCode::FAILURE
            }
        };
    }
    let kernels = match ours::kernels(&options) {
        Ok(kernels) => kernels,
        Err(message) => {
            eprintln!("{message}");
            return ExitCode::from(2);
        }
    };
    let mut report = report::Report::new(kernels.name(), &options);
    for scene in &options.scenes {
        match recording::Recording::open(scene) {
            Ok(recording) if options.queries => match queries::scene(&recording, &options) {
                Ok(table) => print!("{table}"),
                Err(message) => {
                    eprintln!("{message}");
                    return ExitCode::FAILURE;
                }
            },
            Ok(recording) => run::scene(&recording, &options, &mut report),
            Err(error) => {
                eprintln!("{error}");
                return ExitCode::from(2);
            }
        }
    }
    if options.queries {
        return ExitCode::SUCCESS;
    }
    print!("{}", if options.table { report.table() } else { report.markdown() });
    if let Some(path) = &options.json
        && let Err(error) = std::fs::write(path, report.json())
    {
        eprintln!("{}: {error}", path.display());
        return ExitCode::from(2);
    }
    if report.all_right() { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}
