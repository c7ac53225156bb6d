//! The results as a table, the score against each parameter, and curves of each rung.

use anyhow::Result;
use evpose_report::chart::{self, Chart, ChartAxis, Mark, Series};
use evpose_report::colour::{Colour, palette};
use evpose_train::LOSS;

use crate::study::{StudyReport, StudyTable};
use crate::tune::distribution::Distribution;
use crate::tune::outcome::{SearchOutcome, TrialOutcome};
use crate::tune::space::{Parameter, SearchSpace, inline};

/// Curves that end at a rung.
const ENDED: Colour = (190, 194, 203);
/// Size of a chart of the scores, pixels.
const SCATTER: (u32, u32) = (370, 290);

/// The tables of a search; `config` is that of trial 0.
pub(crate) fn report(
    outcome: &SearchOutcome,
    space: &SearchSpace,
    config: String,
) -> Result<StudyReport> {
    let rank = &outcome.rank;
    let columns = outcome.header().into_iter().map(|name| short_name(outcome, name));
    let trials = StudyTable::new("Trials", columns, rows(outcome), &introduction(outcome));
    let better = if outcome.higher_is_better { "higher" } else { "lower" };
    let scatters = space.parameters().iter().map(|parameter| scatter(outcome, parameter));
    let scatters = StudyTable::charts(
        &format!("Validation {rank} against each parameter"),
        &format!(
            "One point a trial, in the last rung that it reached: {better} is better, and points of different rungs \
             have been trained for different times. Trials that diverged are left out."
        ),
        scatters.collect::<Result<_>>()?,
    );
    let rungs = (1..=outcome.rungs.len()).filter_map(|rung| curves(outcome, rung).transpose());
    let curves = StudyTable::charts(
        &format!("Validation {rank} of each rung"),
        "A curve a trial. The learning rate at each step is that of a whole training, so a curve goes on in the next \
         rung where it ended.",
        rungs.collect::<Result<_>>()?,
    );
    Ok(StudyReport {
        title: "Hyper-parameter search".to_owned(),
        about: format!("evpose tune, task {}: {}", outcome.task, outcome.network),
        tables: vec![trials, scatters, curves],
        details: vec![
            ("Ranges".to_owned(), space.text().to_owned()),
            ("Config of trial 0".to_owned(), config),
        ],
    })
}

fn introduction(outcome: &SearchOutcome) -> String {
    let diverged = outcome.trials.iter().filter(|trial| trial.score.is_none()).count();
    let is_best =
        |best: &TrialOutcome| format!("best is trial {}: {}", best.trial, outcome.score(best));
    let state = match (outcome.is_complete, outcome.best()) {
        (_, None) => "No trial has a score yet.".to_owned(),
        (true, Some(best)) => format!("The {}.", is_best(best)),
        (false, Some(best)) => format!("Not finished. So far the {}.", is_best(best)),
    };
    let (done, count) = (outcome.trials.len(), outcome.count);
    format!(
        "{state} {done} of {count} trials have results, {diverged} of them diverged. Trial 0 is the config as it is. \
         Values are those of validation at the checkpoint that a training keeps, the one of the lowest loss. The same \
         validation data chose the best of {count} trials, so its value is better than it will be on other data: \
         evaluate it on held-out recordings.",
    )
}

fn rows(outcome: &SearchOutcome) -> impl Iterator<Item = Vec<String>> {
    // Behind trial, fields, rung, steps, status and step come the logged values.
    let fields = outcome.parameters.len();
    let short = move |(index, cell): (usize, String)| {
        let value = (index > fields + 4).then(|| cell.parse::<f64>().ok()).flatten();
        value.map_or(cell, |value| format!("{value:.4}"))
    };
    outcome
        .trials
        .iter()
        .map(move |trial| outcome.row(trial).into_iter().enumerate().map(short).collect())
}

/// The last part of a field's dotted name, unless two fields share it: columns are narrow.
fn short_name<'a>(outcome: &SearchOutcome, name: &'a str) -> &'a str {
    let last = |name: &'a str| name.rsplit('.').next().unwrap_or(name);
    let namesakes =
        outcome.parameters.iter().filter(|field| field.rsplit('.').next() == Some(last(name)));
    if namesakes.count() > 1 { name } else { last(name) }
}

/// The axis of the ranking value.
fn score_axis(outcome: &SearchOutcome) -> ChartAxis {
    // Losses fall by orders of magnitude.
    let name = format!("validation {}", outcome.rank);
    if outcome.rank == LOSS { ChartAxis::log(&name) } else { ChartAxis::new(&name) }
}

/// The score of every trial over the values of a parameter.
fn scatter(outcome: &SearchOutcome, parameter: &Parameter) -> Result<String> {
    let place = |trial: &TrialOutcome| -> Option<f64> {
        let value = trial.values.get(&parameter.field)?;
        match &parameter.distribution {
            // Choices have no scale, so that their places serve.
            Distribution::Choose(values) => {
                values.iter().position(|known| known == value).map(|index| index as f64)
            }
            _ => value.as_float().or(value.as_integer().map(|v| v as f64)),
        }
    };
    // Trials without a score have no place.
    let point = |trial: &TrialOutcome| Some((place(trial)?, trial.score?));
    let dots = |label: String, colour, points: Vec<(f64, f64)>| Series {
        label,
        colour,
        mark: Mark::Discs,
        points,
    };
    let mut series: Vec<Series> = (1..=outcome.rungs.len())
        .map(|rung| {
            let trials = outcome.trials.iter().filter(|trial| trial.rung == rung);
            let label = match outcome.rungs.len() {
                1 => "trials".to_owned(),
                _ => format!("to step {}", outcome.rungs[rung - 1]),
            };
            dots(label, palette(rung + 1), trials.filter_map(point).collect())
        })
        .filter(|series| !series.points.is_empty())
        .collect();
    let alone = |label: &str, colour, trial: Option<&TrialOutcome>| {
        let point = trial.and_then(point);
        point.map(|point| dots(label.to_owned(), colour, vec![point]))
    };
    // Last, so that they are drawn over the others.
    let base = outcome.trials.iter().find(|trial| trial.trial == 0);
    series.extend(alone("as it is", palette(1), base));
    series.extend(alone("best", palette(0), outcome.best()));
    let x = axis(parameter);
    let chart = Chart { title: parameter.field.clone(), x, y: score_axis(outcome), series };
    Ok(chart::svg(&chart, SCATTER)?)
}

fn axis(parameter: &Parameter) -> ChartAxis {
    match &parameter.distribution {
        Distribution::Choose(values) => {
            let names: Vec<String> =
                values.iter().map(|value| inline(value).replace('"', "")).collect();
            let named: Vec<(f64, &str)> =
                names.iter().enumerate().map(|(i, name)| (i as f64, name.as_str())).collect();
            ChartAxis::new("").over(-0.5, values.len() as f64 - 0.5).named(&named)
        }
        Distribution::Integer(..) => ChartAxis::new("").whole(),
        other if other.is_log() => ChartAxis::log(""),
        _ => ChartAxis::new(""),
    }
}

/// Curves of the trials of a rung (from 1), those that went on or won in colour. None without any.
fn curves(outcome: &SearchOutcome, rung: usize) -> Result<Option<String>> {
    let is_last = rung == outcome.rungs.len();
    let end = outcome.rungs[rung - 1];
    let best = outcome.best().map(|best| best.trial);
    let mut series: Vec<(u8, Series)> = Vec::new();
    for trial in outcome.trials.iter().filter(|trial| trial.rung >= rung) {
        // A trial may be of another length than the config where that is searched.
        let validations = trial.validations.iter().filter(|v| is_last || v.step <= end);
        let points: Vec<(f64, f64)> = validations
            .filter_map(|v| Some((v.step as f64, *v.values.get(&outcome.rank)?)))
            .collect();
        let (layer, label, colour) = match () {
            () if is_last && Some(trial.trial) == best => (2, "best", palette(0)),
            () if !is_last && trial.rung > rung => (1, "goes on", palette(0)),
            () if trial.trial == 0 => (1, "as it is", palette(1)),
            () => (0, if is_last { "others" } else { "ends here" }, ENDED),
        };
        // The legend has each kind once.
        let label = if series.iter().any(|(_, s)| s.label == label) { "" } else { label };
        // A single validation is no line.
        let mark = if points.len() == 1 { Mark::Discs } else { Mark::Line };
        series.push((layer, Series { label: label.to_owned(), colour, mark, points }));
    }
    if series.is_empty() {
        return Ok(None);
    }
    series.sort_by_key(|(layer, _)| *layer);
    let chart = Chart {
        title: format!("Rung {rung}, to step {end}"),
        x: ChartAxis::new("optimiser steps").from_zero(),
        y: score_axis(outcome),
        series: series.into_iter().map(|(_, series)| series).collect(),
    };
    Ok(Some(chart::curves(&chart)?))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tune::outcome::RungResults;
    use crate::tune::outcome::tests::{outcome, rungs};

    #[test]
    fn there_is_a_row_a_trial_a_chart_a_parameter_and_curves_of_each_rung() -> Result<()> {
        let text = "training.learning_rate = { log_uniform = [1e-4, 1e-2] }\nnetwork.backbone = { \
                    choose = [\"net, 1\", \"net, 2\"] }\n";
        let space = SearchSpace::parse("over.toml".as_ref(), text)?;
        let report =
            |rungs: &[RungResults]| report(&outcome("loss", rungs), &space, "seed = 1".to_owned());
        let whole = report(&rungs())?;
        let counts = |report: &StudyReport| {
            report
                .tables
                .iter()
                .map(|table| (table.rows.len(), table.curves.len()))
                .collect::<Vec<_>>()
        };
        assert_eq!(counts(&whole), [(4, 0), (0, 2), (0, 2)]);
        let trials = &whole.tables[0];
        assert_eq!(trials.columns[1..3], ["learning_rate", "backbone"]);
        assert_eq!(
            trials.rows[0][..],
            ["3", "0.003", "net, 3", "2", "40", "trained", "30", "0.2000", "0.8000"]
        );
        let note = &trials.notes[0];
        assert!(note.starts_with("The best is trial 3: loss 0.2000 at step 30."), "{note}");
        assert!(note.contains("1 of them diverged") && whole.html().contains("goes on"), "{note}");

        let begun = report(&rungs()[..1])?;
        assert!(begun.tables[0].notes[0].contains("Not finished."));
        assert_eq!(counts(&begun)[2], (0, 1), "no curves of a rung without trials");
        Ok(())
    }
}
