//! The job files say what this program understands.

use clap::Parser as _;
use evpose_sim::{SequenceSet, Shard};

use super::Command;
use crate::Args;
use evpose_cli::configs;
use evpose_task::hand::HandConfig;

const SLURM: &str = include_str!("../../configs/jobs/simulate.slurm");
const KUBERNETES: &str = include_str!("../../configs/jobs/simulate.k8s.yaml");
const TRAIN: &str = include_str!("../../configs/jobs/train.slurm");
const TUNE: &str = include_str!("../../configs/jobs/tune.slurm");

/// The command lines of `text` that begin with one of `prompts`, continued lines joined.
fn commands(text: &str, prompts: &[&str]) -> Vec<String> {
    let joined = text.replace("\\\n", " ");
    let lines = joined.lines().map(str::trim);
    let commands = lines.filter_map(|line| prompts.iter().find_map(|p| line.strip_prefix(p)));
    commands.filter(|command| command.starts_with("evpose ")).map(str::to_owned).collect()
}

/// Parses a command line, with the words of `values` filled in, and reads its config.
fn parse(command: &str, values: &[(&str, &str)]) -> Result<Command, String> {
    let mut text = command.to_owned();
    for (word, value) in values {
        text = text.replace(word, value);
    }
    let text = text.split(" #").next().unwrap_or_default().replace('"', "");
    if text.contains('$') {
        return Err(format!("{text}: a variable that nobody sets"));
    }
    let args = Args::try_parse_from(text.split_whitespace()).map_err(|e| e.to_string())?;
    let read = |config: &str, set: &[String]| configs::load::<HandConfig>(config, set).map(|_| ());
    match &args.command {
        Command::Simulate(args) => read(&args.config.config, &args.config.overrides),
        Command::Train(args) => read(&args.config.config, &args.config.overrides),
        Command::Tune(args) => read(&args.config, &args.study.overrides),
        _ => Ok(()),
    }
    .map_err(|error| format!("{text}: {error:#}"))?;
    Ok(args.command)
}

fn number_behind(text: &str, key: &str) -> Option<u64> {
    let digits = text.split_once(key)?.1;
    digits.split(|c: char| !c.is_ascii_digit()).next()?.parse().ok()
}

#[test]
fn the_tasks_of_both_array_jobs_record_every_sequence_once() {
    for (file, prompt, last) in
        [(SLURM, "srun ", "--array=1-"), (KUBERNETES, "exec ", "completions: ")]
    {
        let shards = number_behind(file, last).unwrap_or_default();
        assert_eq!(number_behind(file, "SHARDS="), Some(shards), "the two counts differ");
        let found = commands(file, &[prompt]);
        assert_eq!(found.len(), 1, "{found:?}");
        let mut recorded = Vec::new();
        let mut sequences = 0;
        for task in 1..=shards {
            let (task, shards) = (task.to_string(), shards.to_string());
            let values = [
                ("$((JOB_COMPLETION_INDEX + 1))", task.as_str()),
                ("$SLURM_ARRAY_TASK_ID", &task),
                ("$SLURM_CPUS_PER_TASK", "4"),
                ("$SHARDS", &shards),
                ("$OUT", "data"),
            ];
            let command = parse(&found[0], &values);
            let Ok(Command::Simulate(args)) = command else { panic!("{command:?}") };
            assert!(args.resume, "a task that is started again must resume");
            let Some(shard) = args.shard else { panic!("no shard") };
            sequences = args.sequences.unwrap_or_default();
            recorded.extend(shard.sequences_of(sequences as u64));
        }
        recorded.sort_unstable();
        assert_eq!(recorded, (0..sequences as u64).collect::<Vec<_>>());
        assert_eq!(SequenceSet::new("data", sequences).unfinished(Shard::WHOLE), recorded);
    }
}

#[test]
fn the_tasks_of_a_search_train_every_trial_once() {
    let shards = number_behind(TUNE, "--array=1-").unwrap_or_default();
    assert_eq!(number_behind(TUNE, "SHARDS="), Some(shards), "the two counts differ");
    let commands = commands(TUNE, &["srun "]);
    assert_eq!(commands.len(), 1, "{commands:?}");
    let (mut trained, mut trials) = (Vec::new(), 0);
    for task in 1..=shards {
        let (task, shards) = (task.to_string(), shards.to_string());
        let values = [
            ("$SLURM_ARRAY_TASK_ID", task.as_str()),
            ("$SLURM_CPUS_PER_TASK", "4"),
            ("$SHARDS", &shards),
            ("$OVER", "over.toml"),
            ("$DATA", "data"),
            ("$OUT", "search"),
        ];
        let command = parse(&commands[0], &values);
        let Ok(Command::Tune(args)) = command else { panic!("{command:?}") };
        assert!(args.study.resume && args.data.is_some());
        trials = args.trials;
        trained.extend(args.study.shard.sequences_of(trials));
    }
    trained.sort_unstable();
    assert_eq!(trained, (0..trials).collect::<Vec<_>>());
}

#[test]
fn the_training_job_is_understood_and_resumes() {
    let found = commands(TRAIN, &["srun "]);
    assert_eq!(found.len(), 1, "{found:?}");
    let command = parse(&found[0], &[("$DATA", "data"), ("$RUN", "run")]);
    let Ok(Command::Train(args)) = command else { panic!("{command:?}") };
    assert!(args.resume && args.plain);
    let config = configs::load::<HandConfig>(&args.config.config, &args.config.overrides);
    let devices = config.map_or(0, |config| config.training.devices as u64);
    assert_eq!(number_behind(TRAIN, "--gres=gpu:"), Some(devices));
}
