//! The command `pldi`: recognises furniture in RGB-D recordings and before live sensors.
//!
//! Results go to stdout, messages and progress to stderr. Exit codes: 0 done, 1 failed on the data, 2 wrong usage,
//! 130 interrupted.

mod args;
mod bench;
mod demo;
mod describe;
mod devices;
mod inspect;
mod print;
mod progress;
mod record;
#[cfg_attr(not(feature = "rerun"), path = "rerun_absent.rs")]
mod rerun;
mod run;
mod serial;
mod stages;
mod templates;
mod trial;

use std::process::ExitCode;

use clap::Parser;

/// Recognise furniture-sized objects in RGB-D frames by projective light diffusion.
#[derive(Debug, Parser)]
#[command(name = "pldi", version, propagate_version = true)]
struct Cli {
    /// Say more on stderr (twice: even more)
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, clap::Subcommand)]
enum Command {
    /// Make a recording, recognise what is in it and compare with the truth
    Demo(demo::Demo),
    /// Recognise the objects in each frame of a recording or sensor: JSON Lines on stdout
    Run(run::Run),
    /// Keep what a sensor or any recording gives, as a folder or as an MCAP file
    Record(record::Record),
    /// Tell what a recording is like, and whether its depth belongs to its colour
    Inspect(inspect::Inspect),
    /// List the sensors that are there, with their modes
    Devices(devices::Devices),
    /// Write every stage of one frame as files
    Stages(stages::Stages),
    /// Print the 58 numbers of a 128x128 16-bit image as JSON
    Describe(describe::Describe),
    /// Print the Canberra distance of two descriptors
    Match(describe::Match),
    /// Make template sets from meshes, show them, try them
    #[command(subcommand)]
    Templates(templates::Templates),
    /// Time each stage on one thread
    Bench(bench::Bench),
    /// Try the templates on generated recordings with truth
    Trial(trial::Trial),
}

fn main() -> ExitCode {
    let cli = Cli::parse();
    let level = match cli.verbose {
        0 => tracing::Level::WARN,
        1 => tracing::Level::INFO,
        _ => tracing::Level::DEBUG,
    };
    tracing_subscriber::fmt()
        .with_max_level(level)
        .with_writer(std::io::stderr)
        .without_time()
        .with_target(false)
        .init();
    progress::watch_interrupts();
    let result = match cli.command {
        Command::Demo(command) => command.run(),
        Command::Run(command) => command.run(),
        Command::Record(command) => command.run(),
        Command::Inspect(command) => command.run(),
        Command::Devices(command) => command.run(),
        Command::Stages(command) => command.run(),
        Command::Describe(command) => command.run(),
        Command::Match(command) => command.run(),
        Command::Templates(command) => command.run(),
        Command::Bench(command) => command.run(),
        Command::Trial(command) => command.run(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => fail(&error),
    }
}

/// Says what went wrong, in one line, and with which code to leave.
fn fail(error: &anyhow::Error) -> ExitCode {
    let broken_pipe = |e: &std::io::Error| e.kind() == std::io::ErrorKind::BrokenPipe;
    if error.chain().filter_map(|cause| cause.downcast_ref()).any(broken_pipe) {
        // Whoever read our output has seen enough.
        return ExitCode::SUCCESS;
    }
    eprintln!("pldi: {error:#}");
    match error.downcast_ref() {
        // As shells report a process that an interrupt ended.
        Some(pldi_host::Error::Interrupted) => ExitCode::from(130),
        Some(error) => ExitCode::from(error.exit_code()),
        None => ExitCode::FAILURE,
    }
}
