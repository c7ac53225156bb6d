//! Arguments of each task, given to every task.

use super::*;
use crate::commands::live::LiveArgs;
use crate::tasks::args::{EvalArgs, InferArgs, SimulateArgs, TrainArgs};
use crate::tasks::body::args::BodyLiveArgs;
use crate::tasks::hand::args::HandLiveArgs;

/// Each command with words that it needs of any task.
const LINES: [(TaskCommand, &str); 5] = [
    (TaskCommand::Simulate, "simulate CONFIG --out o"),
    (TaskCommand::Train, "train CONFIG --data d --out o"),
    (TaskCommand::Eval, "eval --checkpoint CHECKPOINT --data d"),
    (TaskCommand::Infer, "infer --checkpoint CHECKPOINT --events e --out o"),
    (TaskCommand::Live, "live --checkpoint CHECKPOINT --source s"),
];

fn program() -> Command {
    Command::new("evpose").subcommands([
        SimulateArgs::augment_args(Command::new("simulate")),
        TrainArgs::augment_args(Command::new("train")),
        EvalArgs::augment_args(Command::new("eval")),
        InferArgs::augment_args(Command::new("infer")),
        LiveArgs::augment_args(Command::new("live")),
    ])
}

/// Parses a line with the config of a task, or its run directory.
fn parsed(task: &str, line: &str, more: &[&str]) -> Result<ArgMatches, clap::Error> {
    let run = tempfile::tempdir().unwrap();
    let config = run.path().join("config.toml");
    std::fs::write(&config, format!("task = \"{task}\"")).unwrap();
    let words = ["evpose"].into_iter().chain(line.split(' ')).chain(more.iter().copied());
    let words: Vec<OsString> = words
        .map(|word| match word {
            "CONFIG" => config.clone().into(),
            "CHECKPOINT" => run.path().into(),
            word => word.into(),
        })
        .collect();
    command_of_task(program(), &words)?.try_get_matches_from(&words)
}

/// A value that the argument takes.
fn value_of(arg: &Arg) -> &'static str {
    let alone = || {
        Command::new("one")
            .no_binary_name(true)
            .arg(Arg::new("one").long("one").value_parser(arg.get_value_parser().clone()))
    };
    let values = ["1", "0.5", "150", "dhp19", "true", "table", "plain", "f32", "o.csv"];
    let is_taken = |value: &&str| alone().try_get_matches_from(["--one", *value]).is_ok();
    values.into_iter().find(is_taken).unwrap()
}

#[test]
fn every_argument_is_refused_by_the_tasks_that_do_not_bring_it() {
    let mut refused = 0;
    for (of, line) in LINES {
        let brought = brought(of);
        for (_, arg) in &brought {
            let flag = format!("--{}", arg.get_long().unwrap());
            let takes = |task: &str| {
                brought.iter().any(|(of, own)| *of == task && own.get_id() == arg.get_id())
            };
            for task in TASKS.names().into_iter().filter(|task| !takes(task)) {
                let value = arg.get_action().takes_values().then(|| value_of(arg));
                let more: Vec<&str> = [flag.as_str()].into_iter().chain(value).collect();
                let error = parsed(task, line, &more).unwrap_err();
                assert_eq!(error.kind(), ErrorKind::ArgumentConflict, "{error}");
                assert_eq!(error.exit_code(), 2);
                let owners = brought.iter().filter(|(_, own)| own.get_id() == arg.get_id());
                let owners = listed(owners.map(|(task, _)| *task));
                let message = error.to_string();
                let said = format!("{flag} is not for the task `{task}`: it is for {owners}");
                assert!(message.contains(&said), "{message}");
                assert!(message.contains(&format!("Usage: evpose {}", &line[..4])), "{message}");
                refused += 1;
            }
        }
    }
    assert!(refused > 12, "{refused}");
}

#[test]
fn a_task_takes_its_arguments_as_it_defines_them() {
    for (of, line) in LINES {
        for task in TASKS.names() {
            parsed(task, line, &[]).unwrap_or_else(|error| panic!("{of:?} {task}: {error}"));
        }
    }
    let [train, infer] = [LINES[1].1, LINES[3].1];
    let message = |line, more: &[&str]| parsed("hand", line, more).unwrap_err().to_string();
    for (line, more, flag) in
        [(train, ["--data", "b"], "--data"), (infer, ["--events", "b"], "--events")]
    {
        assert!(parsed("body", line, &more).is_ok(), "{line}");
        let said = format!("several {flag} are not for the task `hand`: they are for `body`");
        assert!(message(line, &more).contains(&said), "{line}");
    }
    let format = ["--format", "hpe-core"];
    assert!(parsed("body", infer, &format).is_ok());
    assert!(message(infer, &format).contains("for the task `body`"));
    // What only hands need.
    assert!(parsed("body", "train CONFIG", &[]).is_ok());
    assert!(message("train CONFIG", &[]).contains("--data <DATA>"));
}

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
