//! The command line of Eosphor. Results go to stdout, progress and messages to stderr.
//!
//! Exit codes: 0 done (or `compare`: identical), 1 the work failed (or `compare`: different), 2 wrong usage,
//! 128 + N ended by signal N, so 130 by Ctrl-C.

mod allocator;
mod arguments;
mod backend;
mod cluster;
mod command_line;
mod commands;
mod failure;
mod first_signal;
mod flag_hints;
mod interrupt;
mod outputs;
mod progress;
mod report;
mod requests;
mod streams;
mod text;
mod watcher;

use arguments::{Arguments, Bench, Command, Lab};
use std::process::ExitCode;

#[global_allocator]
static ALLOCATOR: allocator::Allocator = allocator::Allocator;

fn main() -> ExitCode {
    allocator::keep_memory();
    interrupt::report_file_size_limits();
    let mut arguments = match Arguments::read() {
        Ok(arguments) => arguments,
        // Of many processes with the same flags one is enough to complain, and to help.
        Err(error) if cluster::is_silent() => return ExitCode::from(error.exit_code() as u8),
        Err(error) => error.exit(),
    };
    let done = match &mut arguments.command {
        // What is not shared out is done by one of the processes of a launcher.
        command if cluster::is_silent() && !matches!(command, Command::Render(_) | Command::Course(_)) => {
            Ok(())
        }
        Command::Render(flags) => requests::obey_for_picture(flags)
            .and_then(|()| cluster::run(&flags.of_rank(), |ranks| commands::render(flags, ranks))),
        Command::Course(flags) => cluster::run(&flags.of_rank(), |ranks| commands::course(flags, ranks)),
        #[cfg(feature = "view")]
        Command::View(flags) => requests::obey(&flags.scene, &mut flags.device, &mut flags.picture.accel)
            .and_then(|_| commands::view(flags)),
        Command::Info(flags) => requests::obey_for_info(flags).and_then(|()| commands::info(flags)),
        Command::Merge(flags) => commands::merge(flags),
        Command::Compare(flags) => commands::compare(flags),
        Command::Bench(flags) => match &mut flags.what {
            Bench::Rays(flags) => requests::obey(&flags.scene, &mut flags.device, &mut flags.accel)
                .and_then(|_| commands::bench_rays(flags)),
            Bench::Render(flags) => requests::obey(&flags.scene, &mut flags.device, &mut flags.picture.accel)
                .and_then(|_| commands::bench_render(flags)),
            Bench::Noise(flags) => requests::obey(&flags.scene, &mut flags.device, &mut flags.picture.accel)
                .and_then(|_| commands::bench_noise(flags)),
        },
        Command::Lab(flags) => match &flags.what {
            Lab::List => commands::lab_list(),
            Lab::Run(flags) => commands::lab_run(flags),
            Lab::Report(flags) => commands::lab_report(flags),
            Lab::Compare(flags) => commands::lab_compare(flags),
            Lab::Schema => commands::lab_schema(),
        },
        Command::Devices(flags) => commands::devices(flags),
        Command::Schema(flags) => commands::schema(flags),
        Command::Completions(flags) => commands::completions(flags),
    };
    match done {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            if let Some(line) = failure.line().filter(|_| !cluster::is_silent()) {
                streams::error(&line);
            }
            if let Some(snippet) = failure.snippet().filter(|_| !cluster::is_silent()) {
                streams::message(&snippet.to_string());
            }
            failure.exit_code()
        }
    }
}
