//! `evpose sensor`: lists, tables and plots of sensor models.

mod args;
mod gallery;
mod input;
mod list;
mod show;
mod tap;

use anyhow::Result;

pub use args::SensorCommand;

/// Runs `evpose sensor`.
pub fn run(command: &SensorCommand) -> Result<()> {
    match command {
        SensorCommand::List(args) => list::run(args),
        SensorCommand::Show(args) => show::run(args),
        SensorCommand::Tap(args) => tap::run(args),
        SensorCommand::Gallery(args) => gallery::run(args),
    }
}
