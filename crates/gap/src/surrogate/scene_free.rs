//! Tests of a recording without a scene: many statistics, each against surrogates in which one
//! structure is randomised.
//!
//! | randomised | preserved | structure that is tested |
//! |---|---|---|
//! | times within 5, 20 or 100 ms | counts of every pixel and window | refractory periods, clocks, scans, queues, rate limits, lamps |
//! | times within a quiet stretch | counts of every pixel and stretch | leaks, photoreceptor noise |
//! | places within 4 x 4 pixels | all times | hot and dead pixels |
//!
//! An effect is reported if one of its statistics is significant, corrected for the number of
//! tests, and if the whole recording and both of its halves agree on its parameters.

use evpose_core::EventStream;
use evpose_sensor::STAGES;

use super::evidence::Parts;
use super::findings::{SceneFreeFindings, SceneFreeStatistic, Untestable};
use super::load;
use super::null::statistics;
use super::pixel_counts::Counts;
use super::train::Train;

/// Family-wise significance level over all statistics.
const LEVEL: f64 = 0.05;
/// Maximum events; of longer recordings the middle is tested.
const MAX_EVENTS: usize = 300_000;
/// Minimum events of a test.
const MIN_EVENTS: usize = 100;

/// Effects of the catalogue that a recording without a scene can show.
const TESTABLE: [&str; 11] = [
    "lamp_flicker",
    "photoreceptor_noise",
    "leak_on",
    "refractory",
    "dead_pixels",
    "hot_pixels",
    "uniform_noise",
    "arbiter",
    "scanned_readout",
    "event_rate_control",
    "timestamp_quantisation",
];

/// Stages of every sensor, or of its numerics, which are no effects.
const NO_EFFECTS: [&str; 9] = [
    "adaptive_steps",
    "logarithmic",
    "lin_log",
    "level_crossing",
    "frame_difference",
    "frame_count",
    "brownian_passage",
    "fixed_pattern",
    "ideal_readout",
];

/// Tests a recording with `replicates` surrogates of each kind: 199 for p-values down to 0.005, and
/// at least 39, because with fewer a single outlier among the surrogates hides an effect.
pub fn test_recording(events: &EventStream, replicates: usize, seed: u64) -> SceneFreeFindings {
    let train = Train::from_events(events).middle(MAX_EVENTS);
    let mut notes = Vec::new();
    if train.marks.len() < events.len() {
        notes.push(format!("only {MAX_EVENTS} of {} events are tested", events.len()));
    }
    let parts = Parts::from_train(train);
    let statistics = statistics(&parts, replicates, seed);
    let mut effects = Vec::new();
    let mut untestable = untestable(&parts, &statistics);
    if parts.whole.marks.len() >= MIN_EVENTS {
        let (agreed, masked) = parts.effects();
        for (name, why) in masked {
            if untestable.iter().all(|untestable| untestable.name != name) {
                untestable.push(Untestable { name, why: why.to_owned() });
            }
        }
        for mut effect in agreed {
            let own = statistics.iter().filter(|row| row.effect == Some(effect.name));
            effect.p = own.filter_map(|row| row.adjusted_p).min_by(f64::total_cmp);
            if effect.p.is_none_or(|p| p <= LEVEL) {
                effects.push(effect);
            }
        }
    }
    let is_settled = |name: &&str| {
        effects.iter().any(|effect| effect.name == *name)
            || untestable.iter().any(|untestable| untestable.name == *name)
    };
    let absent = TESTABLE.into_iter().filter(|name| !is_settled(name)).collect();
    let (events, seconds) = (parts.whole.marks.len(), parts.whole.seconds());
    SceneFreeFindings {
        events,
        seconds,
        replicates,
        statistics,
        effects,
        absent,
        untestable,
        notes,
    }
}

/// Effects that need a scene, and those that this recording does not exercise, with the reasons.
fn untestable(parts: &Parts, statistics: &[SceneFreeStatistic]) -> Vec<Untestable> {
    let mut untestable: Vec<Untestable> = STAGES
        .iter()
        .map(|stage| stage.name)
        .filter(|name| !TESTABLE.contains(name) && !NO_EFFECTS.contains(name))
        .map(|name| Untestable { name, why: "needs a known scene".to_owned() })
        .collect();
    let has = |name: &str| statistics.iter().any(|row| row.effect == Some(name));
    let mut add = |name, why: String| untestable.push(Untestable { name, why });
    let few = parts.whole.marks.len() < MIN_EVENTS;
    for name in TESTABLE {
        let at_rest = ["leak_on", "photoreceptor_noise", "uniform_noise"].contains(&name);
        if few {
            add(name, format!("{} events are too few", parts.whole.marks.len()));
        } else if at_rest && parts.background.is_none() {
            add(name, "no part of image and time is at rest".to_owned());
        } else if name == "event_rate_control" && load::busiest(&parts.whole) < load::MIN_CEILING {
            add(name, format!("at most {} events in a millisecond", load::busiest(&parts.whole)));
        } else if name == "arbiter" && !load::is_dense(&parts.whole) {
            add(name, "events are too far apart".to_owned());
        } else if name == "dead_pixels" && Counts::from_train(&parts.whole).is_sparse() {
            add(name, "pixels have too few events".to_owned());
        } else if name != "uniform_noise" && !has(name) {
            add(name, "too few events of this kind".to_owned());
        }
    }
    untestable
}
