//! `evpose`: pose estimation from event cameras, on the command line.
//!
//! [`main`] is the whole program, for programs that register effects, representations, cleaners and
//! backbones of their own before they call it. All else is in the crates below.

mod args;
mod commands;
#[cfg(feature = "networks")]
mod networks;

use std::io::{Write as _, stdout};
use std::process::ExitCode;

use clap::{Command, CommandFactory as _, FromArgMatches as _};

use args::Args;

/// Runs the command that the arguments of the process name.
pub fn main() -> ExitCode {
    // A program that calls this again has them.
    #[cfg(feature = "networks")]
    let _ = evpose_cli::shipped::NETWORKS.register(networks::NETWORKS);
    let args = match arguments() {
        Ok(args) => args,
        // Help goes to standard output, which may be full or closed.
        Err(error) => {
            let printed = error.print();
            let code = u8::try_from(error.exit_code()).unwrap_or(2);
            return end(ExitCode::from(code), if error.use_stderr() { Ok(()) } else { printed });
        }
    };
    match evpose_cli::threads::check_threads().and_then(|()| commands::run(&args.command)) {
        Ok(code) => end(code, stdout().flush()),
        Err(error) => report_error(&error),
    }
}

/// The command line: all commands with their arguments.
pub fn command() -> Command {
    Args::command()
}

/// The arguments of the process. What the task of its config or checkpoint does not take is refused here, and files
/// that two of them name, before any other is opened.
fn arguments() -> Result<Args, clap::Error> {
    let words: Vec<_> = std::env::args_os().collect();
    let mut command = evpose_cli::tasks::command_of_task(command(), &words)?;
    let matches = command.try_get_matches_from_mut(words)?;
    evpose_cli::outputs::refuse_shared(&command, &matches)?;
    Args::from_arg_matches(&matches)
}

/// The exit code of a program whose last lines were `written` to standard output.
fn end(code: ExitCode, written: std::io::Result<()>) -> ExitCode {
    match written {
        Ok(()) => code,
        Err(error) => {
            evpose_cli::progress::say_unwritten(&error);
            ExitCode::FAILURE
        }
    }
}

/// Prints an error with its causes; returns the exit code that it has.
pub fn report_error(error: &anyhow::Error) -> ExitCode {
    say_error(&format!("evpose: {}", message_of(error)));
    if error.is::<evpose_cli::bad_input::BadInput>() {
        ExitCode::from(2)
    } else if error.is::<evpose_cli::bad_input::NobodyInView>() {
        ExitCode::from(3)
    } else {
        ExitCode::FAILURE
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
        .map(|message| message.lines().map(shortened).collect::<Vec<_>>().join("\n"))
        .unwrap_or_default()
}

/// A line of a message, which may quote a file that is one line of a megabyte.
fn shortened(line: &str) -> String {
    /// Characters of a line that are printed: the longest list of names has 740.
    const SHOWN: usize = 900;
    match line.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{} … ({} characters)", &line[..end], line.chars().count()),
        None => line.to_owned(),
    }
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
        let long = format!("a\n{}\nb", "x".repeat(1_000_000));
        let message = message_of(&anyhow::anyhow!(long));
        assert!(message.ends_with(&format!("\n{} … (1000000 characters)\nb", "x".repeat(900))));
        let read = Err::<(), _>(cause()).context("reading nofile").expect_err("an error");
        assert_eq!(message_of(&read), format!("reading nofile: {text}"));
    }
}
