//! The loop over the trials of a study: rows times seeds, those of a shard.

use std::collections::BTreeMap;
use std::time::Instant;

use anyhow::{Context, Result};
use evpose_cli::progress::say;
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{StudyArgs, StudyReport};

/// Results of the rows that are complete, by their names, in the order of the seeds.
pub(crate) type Trials<T> = BTreeMap<String, Vec<T>>;

/// A row and a seed by their indices.
pub(crate) type TrialIndex = (usize, usize);

/// A study: rows, each under every seed, or over whatever else it is repeated.
pub(crate) trait Study {
    type Trial: Serialize + DeserializeOwned;
    /// Content of the JSON file of the study.
    type Outcome: Serialize;

    fn path(&self, trial: TrialIndex) -> String;

    /// Whether a stored result is of these arguments.
    fn is_current(&self, _trial: TrialIndex, _stored: &Self::Trial) -> Result<bool> {
        Ok(true)
    }

    /// Makes what several of these trials need.
    fn prepare(&self, _trials: &[TrialIndex]) -> Result<()> {
        Ok(())
    }

    /// Runs the unfinished steps of a trial. Returns its result, and that in a line.
    fn run(&self, trial: TrialIndex) -> Result<(Self::Trial, String)>;

    /// The outcome of the rows that are complete, and its tables; none while they say nothing.
    fn outcome(&self, trials: &Trials<Self::Trial>) -> Result<Written<Self::Outcome>>;
}

/// An outcome and its tables.
pub(crate) type Written<O> = Option<(O, StudyReport)>;

/// The trials of a study and their directory.
pub(crate) struct StudyPlan<'a> {
    pub(crate) args: &'a StudyArgs,
    pub(crate) seed: u64,
    /// Files that say what the study is of, name and text.
    pub(crate) inputs: Vec<(&'a str, String)>,
    /// Names of the rows, and of what they are repeated over.
    pub(crate) rows: Vec<String>,
    pub(crate) seeds: Vec<String>,
    /// Names of the files of values, table and page.
    pub(crate) files: [&'static str; 3],
}

impl StudyPlan<'_> {
    /// Claims the directory for the study, and finishes it.
    pub(crate) fn run<S: Study>(&self, study: &S) -> Result<Option<S::Outcome>> {
        let paths = self.trials().map(|trial| study.path(trial));
        self.args.directory().claim(self.args, self.seed, &self.inputs, paths)?;
        self.args.say_location();
        self.finish(study)
    }

    /// Runs the missing trials of the shard, and writes and prints the outcome of all that are there. Returns it,
    /// unless the rows that are complete say nothing yet.
    pub(crate) fn finish<S: Study>(&self, study: &S) -> Result<Option<S::Outcome>> {
        let started = Instant::now();
        let (shard, directory) = (self.args.shard, self.args.directory());
        let name = |trial: TrialIndex| format!("{}, {}", self.rows[trial.0], self.seeds[trial.1]);
        let mut pending = Vec::new();
        // All trials are counted, finished or not, so that none changes its shard.
        for (index, trial) in (0..).zip(self.trials()) {
            if shard.owns(index) && self.stored(study, trial)?.is_none() {
                pending.push(trial);
            }
        }
        study.prepare(&pending)?;
        for (index, &trial) in pending.iter().enumerate() {
            say(format!("{}/{}: {}", index + 1, pending.len(), name(trial)));
            let begun = Instant::now();
            let (result, line) = study.run(trial).with_context(|| name(trial))?;
            directory.write_result(&study.path(trial), &result)?;
            say(format!("    {line}, {:.1} min", begun.elapsed().as_secs_f64() / 60.0));
            // After every row, so that an interrupted study has results.
            if pending.get(index + 1).is_some_and(|next| next.0 != trial.0) {
                self.write(study, &self.gather(study)?.0)?;
            }
        }
        // Of several processes the one that writes last has seen all trials, and if two write at once each sees
        // what came in between.
        let (mut trials, mut missing) = self.gather(study)?;
        let written = loop {
            let written = self.write(study, &trials)?;
            let now = self.gather(study)?;
            if now.1 == missing {
                break written;
            }
            (trials, missing) = now;
        };
        if let Some((_, report)) = &written {
            say(format!("\n{}", report.markdown()));
            let files = self.files.map(|file| directory.path(file));
            files.iter().for_each(|file| say(format!("written: {}", file.display())));
        }
        if !missing.is_empty() {
            let names: Vec<String> = missing.into_iter().map(name).collect();
            say(format!(
                "trials of other shards are not finished: {}\nwhen they are, the same command with --resume goes on, \
                 and without --shard it runs what is missing",
                names.join("; ")
            ));
        }
        say(format!("done in {:.1} minutes", started.elapsed().as_secs_f64() / 60.0));
        Ok(written.map(|(outcome, _)| outcome))
    }

    /// All trials, row after row.
    fn trials(&self) -> impl Iterator<Item = TrialIndex> {
        let seeds = self.seeds.len();
        (0..self.rows.len()).flat_map(move |row| (0..seeds).map(move |seed| (row, seed)))
    }

    /// The result of a trial; none while it is not finished, or of other arguments.
    fn stored<S: Study>(&self, study: &S, trial: TrialIndex) -> Result<Option<S::Trial>> {
        match self.args.directory().result(&study.path(trial))? {
            Some(result) if study.is_current(trial, &result)? => Ok(Some(result)),
            _ => Ok(None),
        }
    }

    /// The rows that are complete, and the trials that are missing.
    fn gather<S: Study>(&self, study: &S) -> Result<(Trials<S::Trial>, Vec<TrialIndex>)> {
        let (mut trials, mut missing) = (BTreeMap::<usize, Vec<S::Trial>>::new(), Vec::new());
        for trial in self.trials() {
            match self.stored(study, trial)? {
                Some(result) => trials.entry(trial.0).or_default().push(result),
                None => missing.push(trial),
            }
        }
        // A mean over some of the seeds would change when the others are there.
        trials.retain(|row, _| missing.iter().all(|trial| trial.0 != *row));
        let named = trials.into_iter().map(|(row, of_row)| (self.rows[row].clone(), of_row));
        Ok((named.collect(), missing))
    }

    /// Writes the outcome, the file of values last: it marks the table and the page as written.
    fn write<S: Study>(&self, study: &S, trials: &Trials<S::Trial>) -> Result<Written<S::Outcome>> {
        let written = study.outcome(trials)?;
        if let Some((outcome, report)) = &written {
            let ([values, table, page], directory) = (self.files, self.args.directory());
            directory.write(table, &report.markdown())?;
            directory.write(page, &report.html())?;
            directory.write_result(values, outcome)?;
        }
        Ok(written)
    }
}

#[cfg(test)]
mod tests {
    use std::cell::RefCell;
    use std::path::Path;

    use super::super::directory::tests::args;
    use super::super::{StudyTable, strings};
    use super::*;

    /// Two rows under three seeds, whose results are their indices.
    #[derive(Default)]
    struct Indices {
        ran: RefCell<Vec<TrialIndex>>,
    }

    impl Study for Indices {
        type Trial = TrialIndex;
        type Outcome = Trials<TrialIndex>;

        fn path(&self, (row, seed): TrialIndex) -> String {
            format!("rows/{row}/{seed}.json")
        }

        fn is_current(&self, trial: TrialIndex, stored: &TrialIndex) -> Result<bool> {
            Ok(*stored == trial)
        }

        fn prepare(&self, trials: &[TrialIndex]) -> Result<()> {
            assert!(trials.is_sorted());
            Ok(())
        }

        fn run(&self, trial: TrialIndex) -> Result<(TrialIndex, String)> {
            self.ran.borrow_mut().push(trial);
            Ok((trial, String::new()))
        }

        fn outcome(&self, trials: &Trials<TrialIndex>) -> Result<Written<Self::Outcome>> {
            let rows = trials.iter().map(|(row, of)| vec![row.clone(), of.len().to_string()]);
            let table = StudyTable::new("", ["row", "trials"], rows, "");
            let (title, about) = (String::new(), String::new());
            let report = StudyReport { title, about, tables: vec![table], details: Vec::new() };
            Ok((!trials.is_empty()).then(|| (trials.clone(), report)))
        }
    }

    const FILES: [&str; 3] = ["indices.json", "indices.md", "indices.html"];

    /// Runs a shard; returns the trials that it ran and the names of the rows that are complete.
    fn ran(out: &Path, shard: &str) -> Result<(Vec<TrialIndex>, Vec<String>)> {
        let (study, args) = (Indices::default(), args(out, shard, true));
        let (rows, seeds) = (strings(["b", "a"]), strings(["seed 1", "seed 2", "seed 3"]));
        let inputs = vec![("config.toml", String::new())];
        let plan = StudyPlan { args: &args, seed: 1, inputs, rows, seeds, files: FILES };
        let outcome = plan.run(&study)?;
        Ok((study.ran.into_inner(), outcome.into_iter().flatten().map(|(row, _)| row).collect()))
    }

    #[test]
    fn shards_run_their_trials_and_the_command_without_them_merges_the_results() -> Result<()> {
        let (shards, whole) = (tempfile::tempdir()?, tempfile::tempdir()?);
        let none: [String; 0] = [];
        assert_eq!(ran(shards.path(), "1/2")?, (vec![(0, 0), (0, 2), (1, 1)], none.to_vec()));
        // No row is complete yet.
        assert!(!shards.path().join("indices.json").exists());
        assert_eq!(ran(shards.path(), "2/3")?.0, [(0, 1)], "(1, 1) is there");
        let names = strings(["a", "b"]);
        assert_eq!(ran(shards.path(), "1/1")?, (vec![(1, 0), (1, 2)], names.clone()));
        assert_eq!(ran(shards.path(), "2/2")?, (vec![], names));
        ran(whole.path(), "1/1")?;
        for file in FILES {
            let [one, other] = [&shards, &whole].map(|out| std::fs::read(out.path().join(file)));
            assert_eq!(one?, other?, "{file}");
        }
        Ok(())
    }

    #[test]
    fn a_result_of_other_arguments_is_made_again() -> Result<()> {
        let out = tempfile::tempdir()?;
        ran(out.path(), "1/1")?;
        std::fs::write(out.path().join("rows/1/2.json"), "[7, 7]")?;
        assert_eq!(ran(out.path(), "1/1")?.0, [(1, 2)]);
        Ok(())
    }
}
