//! Arguments that a task brings to a command.

use std::marker::PhantomData;

use anyhow::{Result, bail};
use clap::error::ErrorKind;
use clap::parser::ValueSource;
use clap::{Arg, ArgMatches, Args, Command, FromArgMatches};

use super::TASKS;

/// The commands to which tasks bring arguments of their own.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TaskCommand {
    /// `evpose simulate`
    Simulate,
    /// `evpose eval`
    Eval,
    /// `evpose infer`
    Infer,
    /// `evpose live`
    Live,
}

/// A command as a type.
pub trait OfCommand {
    /// Command that the arguments are added to.
    const COMMAND: TaskCommand;
}

macro_rules! commands {
    ($($name:ident)*) => {$(
        /// The command of this name, as a type.
        #[derive(Debug, Clone, Copy)]
        pub struct $name;

        impl OfCommand for $name {
            const COMMAND: TaskCommand = TaskCommand::$name;
        }
    )*};
}
commands!(Simulate Eval Infer Live);

/// Arguments that tasks bring to a command, as given: each task takes its own.
///
/// Tasks may bring the same argument, from one struct that both flatten. Groups of arguments (`ArgGroup`) are not
/// taken over.
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
    /// If an argument was given that only other tasks bring, or one of `G` is missing.
    pub fn of<G: Args>(&self, task: &str) -> Result<G> {
        let own = G::augment_args(Command::new("arguments"));
        let is_given = |id: &str| self.matches.value_source(id) == Some(ValueSource::CommandLine);
        for (arg, tasks) in brought(C::COMMAND) {
            let is_own = own.get_arguments().any(|own| own.get_id() == arg.get_id());
            if !is_own && is_given(arg.get_id().as_str()) {
                let name = arg.get_long().unwrap_or(arg.get_id().as_str());
                bail!("--{name} is not for the task `{task}`: it is for {}", listed(&tasks));
            }
        }
        Ok(G::from_arg_matches(&self.matches)?)
    }
}

/// The arguments that tasks bring to a command, each with the names of those that do.
fn brought(command: TaskCommand) -> Vec<(Arg, Vec<&'static str>)> {
    let mut brought: Vec<(Arg, Vec<&str>)> = Vec::new();
    for task in &TASKS {
        let group = task.arguments(command, Command::new("arguments"));
        for arg in group.get_arguments() {
            match brought.iter_mut().find(|(known, _)| known.get_id() == arg.get_id()) {
                Some((_, tasks)) => tasks.push(task.name()),
                None => brought.push((arg.clone(), vec![task.name()])),
            }
        }
    }
    brought
}

/// Names of tasks, as in a sentence.
fn listed(tasks: &[&str]) -> String {
    let names: Vec<String> = tasks.iter().map(|task| format!("`{task}`")).collect();
    names.join(" and ")
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
        brought(C::COMMAND).into_iter().fold(command, |command, (arg, tasks)| {
            // Only the task that has the turn needs it: `of` reports what is missing.
            let arg = arg.required(false);
            command.arg(arg.help_heading(format!("Options of {}", listed(&tasks))))
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tasks::body::args::BodyLiveArgs;
    use crate::tasks::hand::args::HandLiveArgs;

    #[test]
    fn a_task_takes_its_own_arguments_and_names_the_task_of_others() {
        let args = TaskArgs::<Live>::parse(["--min-score", "0.5", "--camera", "evk4"]).unwrap();
        let own: BodyLiveArgs = args.of("body").unwrap();
        assert_eq!((own.min_score, own.own.camera.as_deref()), (Some(0.5), Some("evk4")));
        let error = args.of::<HandLiveArgs>("hand").unwrap_err().to_string();
        assert_eq!(error, "--min-score is not for the task `hand`: it is for `body`");
        let error = args.of::<NoArgs>("blob").unwrap_err().to_string();
        assert!(error.contains("not for the task `blob`"), "{error}");
    }

    #[test]
    fn what_no_task_brings_is_unknown() {
        let error = TaskArgs::<Live>::parse(["--skeletons", "out"]).unwrap_err().to_string();
        assert!(error.contains("unexpected argument"), "{error}");
    }
}
