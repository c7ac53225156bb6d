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
use evpose_sensor::{STAGES, Stage, StageSpec, Strength};

use crate::recording_mark::RecordingMark;
use crate::search_spec::Searched;

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
const MIN_EVENTS: usize = 100;

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
        for (mark, why) in masked {
            let name = mark.effect().name;
            if untestable.iter().all(|untestable| untestable.name != name) {
                untestable.push(Untestable { name, why: why.to_owned() });
            }
        }
        for mut effect in agreed {
            let own = statistics.iter().filter(|row| row.effect == Some(effect.name));
            // The effect of any of its statistics is enough, since their p-values are corrected
            // together.
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
    let testable = RecordingMark::ALL.into_iter().map(|mark| mark.effect().name);
    let absent = testable.filter(|name| !is_settled(name)).collect();
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

/// Fraction of pixels and time that is at rest, without hot pixels; none where too little is.
pub(crate) fn quiet_share(events: &EventStream) -> Option<f64> {
    let parts = Parts::from_train(Train::from_events(events).middle(MAX_EVENTS));
    let whole_s = parts.whole.size.pixels() as f64 * parts.whole.seconds();
    parts.background.map(|background| background.pixel_s / whole_s)
}

/// Whether a stage is an effect, rather than a stage of every sensor, or of its numerics, or what
/// files of the user say.
fn is_effect(spec: &'static StageSpec) -> bool {
    let is_law = matches!(
        spec.typical_stage(),
        Ok(Stage::Photoreceptor(_) | Stage::Detector(_) | Stage::Steps(_))
    );
    !is_law && !matches!(spec.signature.strength, Strength::Unchanging | Strength::FromFiles)
}

/// Effects that need a scene, and those that this recording does not exercise, with the reasons.
fn untestable(parts: &Parts, statistics: &[SceneFreeStatistic]) -> Vec<Untestable> {
    let needs_scene = |spec: &&'static StageSpec| spec.search().mark.is_none() && is_effect(spec);
    let mut untestable: Vec<Untestable> = STAGES
        .iter()
        .copied()
        .filter(needs_scene)
        .map(|spec| Untestable { name: spec.name, why: "needs a known scene".to_owned() })
        .collect();
    let few = parts.whole.marks.len() < MIN_EVENTS;
    for mark in RecordingMark::ALL {
        let name = mark.effect().name;
        let has = statistics.iter().any(|row| row.effect == Some(name));
        let why = if few {
            Some(format!("{} events are too few", parts.whole.marks.len()))
        } else {
            why_not_shown(mark, parts).or_else(|| {
                // What is left of a background has no statistic of its own.
                let is_missing = mark != RecordingMark::RandomRest && !has;
                is_missing.then(|| "too few events of this kind".to_owned())
            })
        };
        untestable.extend(why.map(|why| Untestable { name, why }));
    }
    untestable
}

/// Why a recording with enough events does not show a mark; none if it may.
fn why_not_shown(mark: RecordingMark, parts: &Parts) -> Option<String> {
    match mark {
        RecordingMark::RegularOn | RecordingMark::Alternation | RecordingMark::RandomRest => {
            parts.background.is_none().then(|| "no part of image and time is at rest".to_owned())
        }
        RecordingMark::RateCeiling => {
            let busiest = load::busiest(&parts.whole);
            (busiest < load::MIN_CEILING)
                .then(|| format!("at most {busiest} events in a millisecond"))
        }
        RecordingMark::Bus => {
            (!load::is_dense(&parts.whole)).then(|| "events are too far apart".to_owned())
        }
        RecordingMark::SilentPixels => Counts::from_train(&parts.whole)
            .is_sparse()
            .then(|| "pixels have too few events".to_owned()),
        _ => None,
    }
}
