//! Null hypotheses: the structure that surrogates randomise, and the statistics that test it.

use evpose_core::CounterRng;
use rayon::prelude::*;

use super::background::Background;
use super::evidence::Parts;
use super::findings::SceneFreeStatistic;
use super::pixel_counts::Counts;
use super::train::Train;
use super::{clock, interval, line, load, multiplicity};
use crate::recording_mark::RecordingMark;

/// The structure that surrogates randomise.
#[derive(Debug, Clone, Copy)]
enum Null {
    /// Times within windows of this length, microseconds.
    Window(i64),
    /// Times within quiet stretches.
    Stretch,
    /// Places within blocks of pixels.
    Block,
}

const NULLS: [Null; 5] =
    [Null::Window(5_000), Null::Window(20_000), Null::Window(100_000), Null::Stretch, Null::Block];

/// A statistic of one kind of surrogates.
#[derive(Debug, Clone, Copy)]
struct Listed {
    name: &'static str,
    /// Whether large values are significant, or small ones.
    is_upper: bool,
    mark: Option<RecordingMark>,
    /// Whether it counts for the correction; else it repeats a test with another window, to show
    /// the time scale.
    is_first: bool,
}

fn upper(name: &'static str, mark: Option<RecordingMark>, is_first: bool) -> Listed {
    Listed { name, is_upper: true, mark, is_first }
}

impl Null {
    /// Description. It is also the key of the surrogates' random numbers.
    fn description(self) -> &'static str {
        match self {
            Self::Window(5_000) => "time in 5 ms",
            Self::Window(20_000) => "time in 20 ms",
            Self::Window(_) => "time in 100 ms",
            Self::Stretch => "time in a quiet stretch",
            Self::Block => "place in 4x4 pixels",
        }
    }

    fn statistics(self) -> Vec<Listed> {
        let mut listed = match self {
            // The window that suits a statistic counts in the correction; for the first, each does.
            Self::Window(us) => vec![
                upper("log lower edge of intervals", Some(RecordingMark::DeadTime), true),
                upper("alternation of polarity", None, us == 20_000),
                upper("events at one stamp", Some(RecordingMark::TimeGrid), us == 5_000),
                upper("neighbours in one row", None, us == 5_000),
                upper("neighbours in one column", None, us == 5_000),
                upper("log lower edge of gaps", Some(RecordingMark::Bus), us == 5_000),
                Listed {
                    name: "unevenness of the rate",
                    is_upper: false,
                    mark: Some(RecordingMark::RateCeiling),
                    // Bins of 2 ms: budgets are per millisecond.
                    is_first: us == 20_000,
                },
            ],
            Self::Stretch => vec![
                upper("regularity of ON at rest", Some(RecordingMark::RegularOn), true),
                upper("regularity of OFF at rest", None, true),
                upper("alternation at rest", Some(RecordingMark::Alternation), true),
                upper("synchrony of neighbours at rest", None, true),
            ],
            Self::Block => vec![
                upper("excess of the hottest pixel", Some(RecordingMark::HotPixels), true),
                upper("silence of the deadest pixel", Some(RecordingMark::SilentPixels), true),
            ],
        };
        if let Self::Window(us @ (20_000 | 100_000)) = self {
            listed.push(upper("line of ON against OFF", Some(RecordingMark::Lamp), us == 100_000));
        }
        if let Self::Window(20_000) = self {
            listed.push(upper("clock of all pixels", Some(RecordingMark::TimeGrid), true));
            listed.push(upper("clock of rows", Some(RecordingMark::Scan), true));
            listed.push(upper("clock of columns", Some(RecordingMark::Scan), true));
        }
        listed
    }

    /// Computes the statistics of the recording, or of a surrogate drawn by `rng`.
    fn measure(
        self,
        train: &Train,
        background: Option<&Background>,
        mut rng: Option<CounterRng>,
    ) -> Vec<Option<f64>> {
        let rng = rng.as_mut();
        match self {
            Self::Window(window_us) => match rng {
                Some(rng) => of_window(&train.jittered(window_us, rng), window_us),
                None => of_window(train, window_us),
            },
            Self::Stretch => match (background, rng) {
                // As many values as `of_background` has: statistics are identified by their place.
                (None, _) => vec![None; 4],
                (Some(background), Some(rng)) => of_background(&background.redrawn(rng)),
                (Some(background), None) => of_background(background),
            },
            Self::Block => match rng {
                Some(rng) => of_places(&train.displaced(rng)),
                None => of_places(train),
            },
        }
    }
}

fn of_window(train: &Train, window_us: i64) -> Vec<Option<f64>> {
    let intervals = interval::intervals(train, window_us);
    let width = u32::from(train.size.width);
    let mut values = vec![
        interval::lower_edge(&intervals),
        interval::alternation(&intervals),
        load::fraction(train, |a, b| a.t_us == b.t_us),
        load::fraction(train, |a, b| a.pixel / width == b.pixel / width),
        load::fraction(train, |a, b| a.pixel % width == b.pixel % width),
        load::lower_gap(train),
        load::unevenness(train, window_us),
    ];
    // A lamp at 100 Hz is destroyed only by windows that are longer than its period.
    if window_us >= 20_000 {
        values.push(line::strongest(train).map(|line| line.contrast.ln_1p()));
    }
    if window_us == 20_000 {
        values.extend(clock::lines(train).map(|lines| lines.map(|lines| lines.contrast.ln_1p())));
    }
    values
}

fn of_background(background: &Background) -> Vec<Option<f64>> {
    vec![
        background.regularity(true),
        background.regularity(false),
        background.alternation(),
        background.synchrony(),
    ]
}

fn of_places(train: &Train) -> Vec<Option<f64>> {
    let counts = Counts::from_train(train);
    vec![Some(counts.hottest()), Some(counts.max_silence())]
}

/// Tests every statistic of a recording against its surrogates.
pub(super) fn statistics(parts: &Parts, replicates: usize, seed: u64) -> Vec<SceneFreeStatistic> {
    let measured = |null: Null, replicate: usize| {
        // Replicate 0 is the recording.
        let surrogate =
            (replicate > 0).then(|| CounterRng::new(seed, null.description(), replicate as u64));
        null.measure(&parts.whole, parts.background.as_ref(), surrogate)
    };
    let values: Vec<Vec<Option<f64>>> = (0..=replicates)
        .into_par_iter()
        .map(|replicate| NULLS.iter().flat_map(|null| measured(*null, replicate)).collect())
        .collect();
    let listed: Vec<(Null, Listed)> = NULLS
        .iter()
        .flat_map(|null| null.statistics().into_iter().map(|listed| (*null, listed)))
        .collect();
    let known: Vec<usize> = (0..listed.len()).filter(|j| values[0][*j].is_some()).collect();
    // An undefined statistic of a surrogate is replaced by the mean of the others.
    let usual: Vec<f64> =
        known.iter().map(|j| mean(values[1..].iter().filter_map(|v| v[*j]))).collect();
    let imputed = |row: &Vec<Option<f64>>| -> Vec<f64> {
        known.iter().zip(&usual).map(|(j, usual)| row[*j].unwrap_or(*usual)).collect()
    };
    let values: Vec<Vec<f64>> = values.iter().map(imputed).collect();
    let tests: Vec<multiplicity::Test> = known
        .iter()
        .map(|j| multiplicity::Test {
            is_upper: listed[*j].1.is_upper,
            counts: listed[*j].1.is_first,
        })
        .collect();
    let tested = multiplicity::test(&values, &tests);
    let rows = known.iter().zip(&values[0]).zip(tested);
    rows.map(|((j, observed), tested)| {
        let (null, listed) = listed[*j];
        SceneFreeStatistic {
            name: listed.name,
            null: null.description(),
            observed: *observed,
            mean: tested.mean,
            sd: tested.sd,
            p: tested.p,
            adjusted_p: tested.adjusted_p,
            effect: listed.mark.map(|mark| mark.effect().name),
        }
    })
    .collect()
}

fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, n) = values.fold((0.0, 0usize), |(sum, n), value| (sum + value, n + 1));
    sum / n.max(1) as f64
}
