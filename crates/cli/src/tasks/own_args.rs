//! Arguments that a task brings to a command.
//!
//! The command line knows those of every task. The task of a config or of a checkpoint is looked up while arguments
//! are parsed ([`command_of_task`]), so that those of others are refused before anything else is opened.

use std::ffi::OsString;
use std::marker::PhantomData;
use std::path::PathBuf;

use anyhow::{Result, bail};
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgAction, ArgMatches, Args, Command, FromArgMatches};

use super::{PoseTask, TASKS, task_of_checkpoint, task_of_config};
use crate::shipped::checkpoint_path;

/// A command as a type.
pub trait OfCommand {
    /// Command that the arguments are added to.
    const COMMAND: TaskCommand;
}

macro_rules! commands {
    ($($name:ident $word:literal)*) => {
        /// The commands to which tasks bring arguments of their own.
        #[derive(Debug, Clone, Copy, PartialEq, Eq)]
        pub enum TaskCommand {
            $(#[doc = concat!("`evpose ", $word, "`")] $name,)*
        }

        impl TaskCommand {
            fn by_name(name: &str) -> Option<Self> {
                match name {
                    $($word => Some(Self::$name),)*
                    _ => None,
                }
            }
        }

        $(
            #[doc = concat!("`evpose ", $word, "` as a type.")]
            #[derive(Debug, Clone, Copy)]
            pub struct $name;

            impl OfCommand for $name {
                const COMMAND: TaskCommand = TaskCommand::$name;
            }
        )*
    };
}
commands!(Simulate "simulate" Train "train" Eval "eval" Infer "infer" Live "live");

/// Arguments that tasks bring to a command, as given: each task takes its own.
///
/// Tasks may bring the same argument: the command line has the one that takes several values, if there is one, and a
/// task's own definition counts as soon as the task is known. Groups of arguments (`ArgGroup`) are not taken over.
#[derive(Debug, Clone)]
pub struct TaskArgs<C> {
    matches: ArgMatches,
    command: PhantomData<C>,
}

/// The group of a task that brings nothing.
#[derive(Debug, Clone, Copy, Args)]
pub struct NoArgs {}

impl TaskArgs<Live> {
    /// Parses the arguments of tasks alone.
    ///
    /// # Errors
    /// If they are of no task, or not valid.
    pub fn parse<'a>(words: impl IntoIterator<Item = &'a str>) -> Result<Self> {
        let command = Self::augment_args(Command::new("arguments").no_binary_name(true));
        Ok(Self::from_arg_matches(&command.try_get_matches_from(words)?)?)
    }
}

impl<C: OfCommand> TaskArgs<C> {
    /// The group `G` of `task`.
    ///
    /// # Errors
    /// If an argument of other tasks was given to a checkpoint that names none, or one of `G` is missing.
    pub fn of<G: Args>(&self, task: &str) -> Result<G> {
        let own = G::augment_args(Command::new("arguments"));
        match refusal(C::COMMAND, task, &own, &self.matches) {
            Some(message) => bail!(message),
            None => Ok(G::from_arg_matches(&self.matches)?),
        }
    }
}

/// The command line for `words`: of a command whose config or checkpoint names a task, with the arguments as that
/// task takes them.
///
/// # Errors
/// If there is an argument that only other tasks take; the message names them.
pub fn command_of_task(mut command: Command, words: &[OsString]) -> Result<Command, clap::Error> {
    // What else is wrong is the parser's to say, as is the help.
    let Ok(matches) = command.clone().ignore_errors(true).try_get_matches_from(words) else {
        return Ok(command);
    };
    let Some((name, matches)) = matches.subcommand() else { return Ok(command) };
    let Some((of, task)) = TaskCommand::by_name(name).zip(named_task(matches)) else {
        return Ok(command);
    };
    let own = task.arguments(of, Command::new("arguments"));
    if let Some(message) = refusal(of, task.name(), &own, matches) {
        // Only a command that is built shows the usage of its subcommand in an error.
        command.build();
        return Err(match command.find_subcommand_mut(name) {
            Some(command) => command.error(ErrorKind::ArgumentConflict, message),
            None => command.error(ErrorKind::ArgumentConflict, message),
        });
    }
    let of_task = |arg: Arg| {
        own.get_arguments().find(|own| own.get_id() == arg.get_id()).cloned().unwrap_or(arg)
    };
    Ok(command.mut_subcommand(name, |command| command.mut_args(of_task)))
}

/// The task that the config or the checkpoint of a command names.
fn named_task(matches: &ArgMatches) -> Option<&'static dyn PoseTask> {
    if let Ok(Some(config)) = matches.try_get_one::<String>("config") {
        return task_of_config(config).ok();
    }
    let checkpoint = matches.try_get_one::<PathBuf>("checkpoint").ok()??;
    task_of_checkpoint(&checkpoint_path(checkpoint).ok()?).ok()?
}

/// The arguments that tasks bring to a command, each with the name of its task.
fn brought(command: TaskCommand) -> Vec<(&'static str, Arg)> {
    let of_task = |task: &&'static dyn PoseTask| {
        let group = task.arguments(command, Command::new("arguments"));
        let args = group.get_arguments().map(|arg| (task.name(), arg.clone()));
        args.collect::<Vec<_>>()
    };
    TASKS.iter().flat_map(of_task).collect()
}

fn takes_several(arg: &Arg) -> bool {
    matches!(arg.get_action(), ArgAction::Append)
}

/// The message about the first argument given that `task`, whose arguments are `own`, does not take, or not so often.
fn refusal(of: TaskCommand, task: &str, own: &Command, matches: &ArgMatches) -> Option<String> {
    let brought = brought(of);
    brought.iter().find_map(|(_, arg)| {
        let id = arg.get_id();
        // Defaults of other tasks are no choice of the user.
        if matches.value_source(id.as_str()) != Some(ValueSource::CommandLine) {
            return None;
        }
        let own = own.get_arguments().find(|own| own.get_id() == id);
        let count = matches.get_raw(id.as_str()).map_or(0, Iterator::count);
        if own.is_some_and(|own| count <= 1 || takes_several(own)) {
            return None;
        }
        let takes = |arg: &Arg| arg.get_id() == id && (own.is_none() || takes_several(arg));
        let tasks = brought.iter().filter(|(_, arg)| takes(arg)).map(|(task, _)| *task);
        let (tasks, flag) = (listed(tasks), arg.get_long().unwrap_or(id.as_str()));
        Some(match own {
            None => format!("--{flag} is not for the task `{task}`: it is for {tasks}"),
            Some(_) => {
                format!("several --{flag} are not for the task `{task}`: they are for {tasks}")
            }
        })
    })
}

/// Names of tasks, as in a sentence.
fn listed<'a>(tasks: impl Iterator<Item = &'a str>) -> String {
    tasks.map(|task| format!("`{task}`")).collect::<Vec<_>>().join(" and ")
}

impl<C: OfCommand> FromArgMatches for TaskArgs<C> {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, clap::Error> {
        Ok(Self { matches: matches.clone(), command: PhantomData })
    }

    fn update_from_arg_matches(&mut self, _: &ArgMatches) -> Result<(), clap::Error> {
        Err(clap::Error::new(ErrorKind::UnknownArgument))
    }
}

impl<C: OfCommand> Args for TaskArgs<C> {
    fn augment_args(command: Command) -> Command {
        let brought = brought(C::COMMAND);
        let is_first =
            |k: usize| brought[..k].iter().all(|(_, arg)| arg.get_id() != brought[k].1.get_id());
        (0..brought.len()).filter(|k| is_first(*k)).fold(command, |command, k| {
            let same = || brought.iter().filter(|(_, arg)| arg.get_id() == brought[k].1.get_id());
            let widest = same().map(|(_, arg)| arg).find(|arg| takes_several(arg));
            let arg = widest.unwrap_or(&brought[k].1).clone();
            // What every task needs is the command's own. Of others, the task that has the turn needs it.
            if same().count() == TASKS.len() && same().all(|(_, arg)| arg.is_required_set()) {
                return command.arg(arg);
            }
            let heading = format!("Options of {}", listed(same().map(|(task, _)| *task)));
            command.arg(arg.required(false).help_heading(heading))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

#[cfg(test)]
mod tests;
