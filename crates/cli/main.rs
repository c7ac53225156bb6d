//! `evpose`: pose estimation from event cameras, on the command line.

mod args;
mod commands;
mod contest;
mod machine;
mod progress;
mod report;
mod run_info;
mod timing;

use std::process::ExitCode;

use clap::Parser as _;

fn main() -> ExitCode {
    match commands::run(args::Args::parse()) {
        Ok(code) => code,
        Err(error) => {
            say_error(&format!("evpose: {error:#}"));
            if error.is::<commands::gap::BadInput>() {
                ExitCode::from(2)
            } else {
                ExitCode::FAILURE
            }
        }
    }
}

#[expect(clippy::print_stderr, reason = "the one place where errors reach the user")]
fn say_error(message: &str) {
    eprintln!("{message}");
}
