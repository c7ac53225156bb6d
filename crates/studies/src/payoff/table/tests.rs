//! Tables whose values follow from the closed form.

#![allow(clippy::unwrap_used, reason = "tests")]

use evpose_cli::tasks::RecordingScores;
use evpose_core::CounterRng;

use super::*;

const QUICK: BootstrapConfig = BootstrapConfig { resamples: 500, seed: 1 };

const METRICS: [Metric; 2] = [
    Metric { key: "auc", heading: "AUC", digits: 3, is_error: false },
    Metric { key: "mpjpe", heading: "MPJPE", digits: 1, is_error: true },
];

/// Scores of recordings, each of its own difficulty: the value of recording `i` is its difficulty
/// plus `gain(i)`.
fn scores(count: usize, gain: impl Fn(usize) -> f64) -> EvaluationScores {
    let recording = |i: usize| {
        let difficulty = f64::from(CounterRng::new(7, "difficulty", i as u64).normal());
        let value = 10.0 + difficulty + gain(i);
        let totals = vec![Totals { sum: 100.0 * value, count: 100 }];
        RecordingScores { recording: format!("{i:04}"), totals: vec![totals; METRICS.len()] }
    };
    EvaluationScores { metrics: &METRICS, recordings: (0..count).map(recording).collect() }
}

fn model(model: &'static str, by_seed: Vec<EvaluationScores>) -> ModelScores {
    ModelScores { model, by_seed }
}

fn table(models: &[ModelScores]) -> PairedTable {
    PairedTable::new(models, &QUICK).unwrap()
}

fn bounds(interval: Option<Interval>) -> [f64; 3] {
    let interval = interval.unwrap();
    [interval.estimate, interval.low.unwrap(), interval.high.unwrap()]
}

#[test]
fn the_difficulty_of_a_recording_cancels_in_the_difference() {
    let models =
        [model("given", vec![scores(20, |_| 0.0)]), model("corrected", vec![scores(20, |_| 0.5)])];
    let table = table(&models);
    assert_eq!((table.recordings, table.rows.len()), (20, 2));
    let row = &table.rows[0];
    assert!(bounds(row.difference).iter().all(|d| (d - 0.5).abs() < 1e-9), "{:?}", row.difference);
    assert!(row.difference_by_recording.iter().all(|d| (d.unwrap() - 0.5).abs() < 1e-9));
    // The scores themselves are uncertain, as recordings differ.
    let [_, low, high] = bounds(row.scores["given"]);
    assert!(high - low > 0.4, "{low} {high}");
    // More is better of a share, and worse of an error.
    assert_eq!(table.rows[0].worth(), Worth::Better);
    assert_eq!(table.rows[1].worth(), Worth::Worse);
}

#[test]
fn a_difference_that_changes_sign_among_recordings_is_undecided() {
    let noise = |i: usize| f64::from(CounterRng::new(3, "gain", i as u64).normal());
    let models =
        [model("given", vec![scores(20, |_| 0.0)]), model("corrected", vec![scores(20, noise)])];
    let [estimate, low, high] = bounds(table(&models).rows[0].difference);
    assert!(low < 0.0 && 0.0 < high && low < estimate && estimate < high, "{low} {high}");
    assert_eq!(table(&models).rows[0].worth(), Worth::Undecided);
    // One recording has a difference without an interval.
    let alone = table(&[
        model("given", vec![scores(1, |_| 0.0)]),
        model("corrected", vec![scores(1, |_| 1.0)]),
    ]);
    assert_eq!(alone.rows[0].difference.unwrap().low, None);
    assert_eq!(alone.rows[0].worth(), Worth::Undecided);
}

#[test]
fn seeds_are_pooled_and_listed() {
    let by_seed = |gains: [f64; 2]| gains.map(|gain| scores(12, |_| gain)).to_vec();
    let models = [model("given", by_seed([0.0, 0.2])), model("corrected", by_seed([1.0, 0.4]))];
    let row = table(&models).rows[0].clone();
    assert!((row.difference.unwrap().estimate - 0.6).abs() < 1e-9, "{row:?}");
    let [first, second] = row.difference_by_seed[..] else { panic!("{row:?}") };
    assert!((first.unwrap() - 1.0).abs() < 1e-9 && (second.unwrap() - 0.2).abs() < 1e-9);
}

#[test]
fn an_upper_bound_gives_a_fraction_where_there_is_something_to_gain() {
    let of = |corrected: f64, camera: f64| {
        let row = table(&[
            model("given", vec![scores(16, |_| 0.0)]),
            model("corrected", vec![scores(16, |_| corrected)]),
            model("camera", vec![scores(16, |_| camera)]),
        ]);
        row.rows[0].fraction_of_upper_bound
    };
    assert!(bounds(of(0.6, 0.8)).iter().all(|fraction| (fraction - 0.75).abs() < 1e-9));
    assert_eq!(of(0.0, 0.0), None);
}

#[test]
fn joints_weigh_alike_and_recordings_without_a_value_have_no_pair() {
    let of = |joints: [[(f64, u64); 2]; 2]| {
        let totals = |(mean, count): (f64, u64)| Totals { sum: mean * count as f64, count };
        let recording = |(i, joints): (usize, [(f64, u64); 2])| RecordingScores {
            recording: i.to_string(),
            totals: vec![joints.map(totals).to_vec(); METRICS.len()],
        };
        let recordings = joints.into_iter().enumerate().map(recording).collect();
        EvaluationScores { metrics: &METRICS, recordings }
    };
    // The second joint is labelled ten times as often, and counts the same.
    let given = of([[(1.0, 10), (3.0, 100)], [(1.0, 10), (3.0, 100)]]);
    let corrected = of([[(2.0, 10), (3.0, 100)], [(2.0, 10), (3.0, 100)]]);
    let row = table(&[model("given", vec![given.clone()]), model("corrected", vec![corrected])])
        .rows[0]
        .clone();
    assert!((row.scores["given"].unwrap().estimate - 2.0).abs() < 1e-12);
    assert!((row.difference.unwrap().estimate - 0.5).abs() < 1e-12);
    // Nothing was found on the second recording.
    let blind = of([[(2.0, 10), (3.0, 100)], [(0.0, 0), (0.0, 0)]]);
    let row =
        table(&[model("given", vec![given]), model("corrected", vec![blind])]).rows[0].clone();
    assert_eq!(row.difference_by_recording[1], None);
    assert!((row.difference.unwrap().estimate - 0.5).abs() < 1e-12);
}

#[test]
fn networks_of_other_recordings_are_not_compared() {
    let pair = |other: usize| {
        [model("given", vec![scores(4, |_| 0.0)]), model("corrected", vec![scores(other, |_| 0.0)])]
    };
    let error = PairedTable::new(&pair(5), &QUICK).unwrap_err().to_string();
    assert!(error.contains("other recordings"), "{error}");
    assert!(PairedTable::new(&pair(4)[..1], &QUICK).is_err());
}
