//! `evpose`: pose estimation from event cameras, on the command line.
//!
//! [`main`] is the whole program, for programs that register effects, representations, cleaners and
//! backbones of their own before they call it. All else is in the crates below.

mod args;
mod commands;
#[cfg(feature = "networks")]
mod networks;

use std::process::ExitCode;

use clap::Parser;

use args::Args;

/// Runs the command that the arguments of the process name.
pub fn main() -> ExitCode {
    #[cfg(feature = "networks")]
    evpose_app::shipped::embed(networks::NETWORKS);
    match commands::run(&Args::parse().command) {
        Ok(code) => code,
        Err(error) => report_error(&error),
    }
}

/// Prints an error with its causes; returns the exit code that it has.
pub fn report_error(error: &anyhow::Error) -> ExitCode {
    say_error(&format!("evpose: {error:#}"));
    if error.is::<evpose_app::bad_input::BadInput>() {
        ExitCode::from(2)
    } else {
        ExitCode::FAILURE
    }
}

#[expect(clippy::print_stderr, reason = "the one place where errors reach the user")]
fn say_error(message: &str) {
    eprintln!("{message}");
}
