//! `evpose`: pose estimation from event cameras, on the command line.

mod commands;

use std::process::ExitCode;

use clap::Parser;

/// Pose estimation from event cameras: simulate, train, evaluate, infer.
#[derive(Debug, Parser)]
#[command(
    name = "evpose",
    version,
    arg_required_else_help = true,
    after_help = "Start with:\n  evpose demo\n\nThen, step by step:\n  \
        evpose simulate quick --out data/train\n  \
        evpose simulate quick --out data/test --seed 2 --held-out\n  \
        evpose train quick --data data/train --out runs/hand\n  \
        evpose eval --checkpoint runs/hand --data data/test\n  \
        evpose infer --checkpoint runs/hand --events data/test/0000.evc --out poses.csv"
)]
struct Args {
    #[command(subcommand)]
    command: commands::Command,
}

fn main() -> ExitCode {
    match commands::run(&Args::parse().command) {
        Ok(code) => code,
        Err(error) => {
            say_error(&format!("evpose: {}", message_of(&error)));
            if error.is::<evpose_app::bad_input::BadInput>() {
                ExitCode::from(2)
            } else {
                ExitCode::FAILURE
            }
        }
    }
}

/// An error with its causes. Messages that end with their cause do not repeat it.
fn message_of(error: &anyhow::Error) -> String {
    error
        .chain()
        .map(ToString::to_string)
        .reduce(
            |message, cause| {
                if message.ends_with(&cause) { message } else { format!("{message}: {cause}") }
            },
        )
        .unwrap_or_default()
}

#[expect(clippy::print_stderr, reason = "the one place where errors reach the user")]
fn say_error(message: &str) {
    eprintln!("{message}");
}

#[cfg(test)]
mod tests {
    use std::io::{Error, ErrorKind};

    use anyhow::Context as _;

    use super::*;

    #[test]
    fn a_cause_is_said_once() {
        let cause = || Error::from(ErrorKind::NotFound);
        let text = cause().to_string();
        let io = evpose_task::TaskError::Io { path: "nofile".into(), source: cause() };
        assert_eq!(message_of(&io.into()), format!("nofile: {text}"));
        let read = Err::<(), _>(cause()).context("reading nofile").expect_err("an error");
        assert_eq!(message_of(&read), format!("reading nofile: {text}"));
    }
}
