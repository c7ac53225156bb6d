//! Many statistics of a recording alone, each against surrogates that forget one thing.
//!
//! | surrogates forget | and keep | structure that shows |
//! |---|---|---|
//! | when in 5, 20 or 100 ms an event was | counts of every pixel and window | dead times, clocks, scans, queues, ceilings, lamps |
//! | when in a quiet stretch it was | counts of every pixel and stretch | leaks, noise of the photoreceptor |
//! | where in 4 x 4 pixels it was | all times | hot and dead pixels |
//!
//! An effect is reported if one of its statistics is significant over all of them, and if the whole
//! recording and both of its halves give it the same parameters.

use evpose_core::EventStream;
use evpose_sensor::STAGES;

use super::evidence::Parts;
use super::findings::{BareFindings, BareStatistic, Untestable};
use super::load;
use super::null::statistics;
use super::places::Counts;
use super::train::Train;

/// Level over all statistics.
const LEVEL: f64 = 0.05;
/// More events are not looked at: the middle of the recording tells.
const MOST_EVENTS: usize = 300_000;
/// Fewer say nothing.
const LEAST_EVENTS: usize = 100;

/// What a recording alone can show, in the names of the catalogue.
const TESTED: [&str; 11] = [
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

/// Stages that every sensor has one of, or that say how one is computed: no effects.
const MODELS: [&str; 9] = [
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

/// Looks at a recording alone, with `replicates` surrogates of each kind: 199 for p-values down to
/// a two-hundredth, and at least 39, since with fewer one odd surrogate hides an effect.
pub fn examine(events: &EventStream, replicates: usize, seed: u64) -> BareFindings {
    let train = Train::of(events).middle(MOST_EVENTS);
    let mut notes = Vec::new();
    if train.marks.len() < events.len() {
        notes.push(format!("only {MOST_EVENTS} of {} events are looked at", events.len()));
    }
    let parts = Parts::of(train);
    let statistics = statistics(&parts, replicates, seed);
    let mut effects = Vec::new();
    let mut untestable = untestable(&parts, &statistics);
    if parts.whole.marks.len() >= LEAST_EVENTS {
        let (found, hidden) = parts.effects();
        for (name, why) in hidden {
            if untestable.iter().all(|untestable| untestable.name != name) {
                untestable.push(Untestable { name, why: why.to_owned() });
            }
        }
        for mut effect in found {
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
    let absent = TESTED.into_iter().filter(|name| !is_settled(name)).collect();
    let (events, seconds) = (parts.whole.marks.len(), parts.whole.seconds());
    BareFindings { events, seconds, replicates, statistics, effects, absent, untestable, notes }
}

/// Effects that need a scene, and those that this recording does not exercise.
fn untestable(parts: &Parts, statistics: &[BareStatistic]) -> Vec<Untestable> {
    let mut found: Vec<Untestable> = STAGES
        .iter()
        .map(|stage| stage.name)
        .filter(|name| !TESTED.contains(name) && !MODELS.contains(name))
        .map(|name| Untestable { name, why: "only a known scene tells".to_owned() })
        .collect();
    let has = |name: &str| statistics.iter().any(|row| row.effect == Some(name));
    let mut add = |name, why: String| found.push(Untestable { name, why });
    let few = parts.whole.marks.len() < LEAST_EVENTS;
    for name in TESTED {
        let at_rest = ["leak_on", "photoreceptor_noise", "uniform_noise"].contains(&name);
        if few {
            add(name, format!("{} events are too few", parts.whole.marks.len()));
        } else if at_rest && parts.background.is_none() {
            add(name, "no part of image and time is at rest".to_owned());
        } else if name == "event_rate_control" && load::busiest(&parts.whole) < load::LEAST_CEILING
        {
            add(name, format!("at most {} events in a millisecond", load::busiest(&parts.whole)));
        } else if name == "arbiter" && !load::is_dense(&parts.whole) {
            add(name, "events are too far apart".to_owned());
        } else if name == "dead_pixels" && Counts::of(&parts.whole).is_sparse() {
            add(name, "pixels have too few events".to_owned());
        } else if name != "uniform_noise" && !has(name) {
            add(name, "too few events of this kind".to_owned());
        }
    }
    found
}
