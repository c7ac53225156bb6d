//! A verdict in words that a person understands.

use evpose_gap::report::{Ablation, ModelChange};
use evpose_gap::verdict::{Answer, Finding, FindingKind, GapValue, Quantity, Verdict};
use evpose_gap::{StatisticBlock, parameters::ModelParameter};
use evpose_sensor::STAGES;

use super::explained;
use evpose_report::format::{percent, short};

/// The answer as a heading.
pub fn headline(verdict: &Verdict) -> String {
    let of = |kind| names(verdict, |finding| finding.kind == kind);
    if verdict.is_scene_free() {
        let names = names(verdict, |_| true);
        return match verdict.verdict {
            Answer::Effects => format!("The recording alone is consistent with: {names}"),
            Answer::NoGap => "The recording alone shows nothing that the model lacks".to_owned(),
            _ => "The recording alone shows something, but not what".to_owned(),
        };
    }
    let (effects, wrong) = (of(FindingKind::Effect), of(FindingKind::Parameter));
    // Names are joined by a plus sign: with one, there are several.
    let plural = if effects.contains('+') { "s" } else { "" };
    let also = if wrong.is_empty() { wrong.clone() } else { format!(" (and set wrong: {wrong})") };
    match verdict.verdict {
        Answer::NoGap => "No gap: the model explains the recording".to_owned(),
        Answer::Parameter if wrong.is_empty() => "A parameter of the model is set wrong".to_owned(),
        Answer::Parameter => format!("Nothing is missing, but set wrong: {wrong}"),
        Answer::Effects => format!("Missing effect{plural}: {effects}{also}"),
        Answer::Partial => {
            let left = percent(verdict.unexplained.fraction);
            match names(verdict, |_| true) {
                none if none.is_empty() => format!("A gap of which {left} is unexplained"),
                names => format!("Explained in part, by {names}; {left} is unexplained"),
            }
        }
        Answer::NoneOfCatalogue if !of(FindingKind::Formula).is_empty() => {
            "Something is missing that the catalogue does not hold; a formula is found".to_owned()
        }
        Answer::NoneOfCatalogue => match demoted(verdict) {
            none if none.is_empty() => {
                "Something is missing that the catalogue does not hold".to_owned()
            }
            names => format!("Something is missing that is like {names}, but is not it"),
        },
        Answer::Undecided => "There is a gap, but this recording does not determine why".to_owned(),
    }
}

/// Names that explain but failed their tests, joined.
fn demoted(verdict: &Verdict) -> String {
    let names: Vec<&str> = verdict.demoted.iter().map(|finding| finding.name.as_str()).collect();
    names.join(" + ")
}

/// The sign that a name that failed its test would have to show, beside that of the recording.
pub fn failed(finding: &Finding) -> Option<String> {
    let test = finding.signature.as_ref().filter(|test| !test.passes)?;
    Some(format!("explains, but is not it: it would have to {}; {}", test.must, test.shows))
}

/// A formula with the stage that it acts at, and what it may come from; none of a name.
pub fn formula(finding: &Finding) -> Option<String> {
    let found = finding.formula.as_ref()?;
    Some(format!("{} = {} ({})", found.stage, found.expression, found.reading))
}

/// The line of a run whose time was over.
pub const OUT_OF_TIME: &str = "OUT OF TIME: the search ended because the time of --budget was over; there \
                               may be other or further effects";

/// The meanings of the four words of a report.
pub const DEFINITIONS: [&str; 4] = [
    "Discrepancy: the sum, over all compared statistics, of how far measured events are from runs of the \
     model.",
    "Gap: the mean of the same by family of statistics, in units of chance: 1 is that of two runs of one \
     model.",
    "Closed: the fraction of the discrepancy of the model as given, beyond that of its own runs, which the \
     corrected model does not have; the rest is unexplained.",
    "Significant: beyond what replicates of the model have by chance, at .01, and with a gap above 1.",
];

/// Names of what was found, joined.
fn names(verdict: &Verdict, is_wanted: impl Fn(&&Finding) -> bool) -> String {
    let found = verdict.effects.iter().filter(is_wanted);
    let names: Vec<&str> = found.map(|finding| finding.name.as_str()).collect();
    names.join(" + ")
}

/// The answer in full sentences, for a reader who has never seen such a report.
pub fn meaning(verdict: &Verdict) -> String {
    if verdict.is_scene_free() {
        let found = match verdict.verdict {
            Answer::Effects => "What is named stands out against these, alike in both halves",
            Answer::NoGap => "Nothing stands out that the model does not have",
            _ => {
                "Times have a structure that these lack, but no effect of the catalogue that both \
                 halves agree on does it; what moved in front of the camera may"
            }
        };
        return format!("{NO_GAP} {found}; most effects need a scene to show.");
    }
    let (before, after) = (short(verdict.gap_before.value), short(verdict.gap_after.value));
    let closes = format!(
        "The gap falls from {before} to {after}; {APART}. {}",
        explained::left_in_words(verdict)
    );
    let differ = format!("Measured and simulated events differ: the gap is {before}; {APART}.");
    let what = verdict.effects.iter().filter(|f| f.kind == FindingKind::Effect);
    let what: Vec<&str> = what.filter_map(|finding| summary(&finding.name)).collect();
    let does = match what.is_empty() {
        true => "The camera does something that the model does not".to_owned(),
        false => {
            format!("The camera does something that the model does not: {}", what.join("; "))
        }
    };
    match verdict.verdict {
        Answer::NoGap => format!(
            "Measured events differ from those of the model no more than two runs of the model, or \
             two simulators of one sensor, differ from each other: the gap is {before}; {APART}."
        ),
        Answer::Parameter => {
            format!("The model has all that it needs, with other values. {closes}")
        }
        Answer::Effects => format!("{does}. {closes}"),
        Answer::Partial if what.is_empty() => {
            format!("Other values of the model explain a part of the gap, not all. {closes}")
        }
        Answer::Partial => format!("{does}. That is a part of the gap, not all. {closes}"),
        Answer::NoneOfCatalogue if verdict.effects.iter().any(|f| f.formula.is_some()) => {
            let laws: Vec<String> = verdict.effects.iter().filter_map(formula).collect();
            format!(
                "No effect that is known explains it, but a formula does: {}. {closes}",
                laws.join("; ")
            )
        }
        Answer::NoneOfCatalogue if !verdict.demoted.is_empty() => {
            let failed = verdict.demoted.iter().filter_map(|one| Some((&one.name, failed(one)?)));
            let failed: Vec<String> =
                failed.map(|(name, failed)| format!("{name} {failed}.")).collect();
            format!("{differ} {}", failed.join(" "))
        }
        Answer::NoneOfCatalogue => format!(
            "{differ} No effect that is known explains anything significant of it.{}",
            nearest_stage(verdict)
        ),
        Answer::Undecided => match alternatives(verdict) {
            Some(alternatives) => {
                format!("{differ} The recording does not distinguish: {alternatives}.")
            }
            None => format!("{differ} No cause is clear enough to be named."),
        },
    }
}

/// The unit of a gap.
pub const APART: &str = "two runs of one model are 1 apart";

/// The part of the camera whose effects come closest, as a sentence behind others.
fn nearest_stage(verdict: &Verdict) -> String {
    match verdict.unexplained.nearest_stage.as_str() {
        "" => String::new(),
        stage => format!(" The nearest part of the camera is the {stage}."),
    }
}

/// Effects that the recording does not distinguish; none if there are no such.
pub fn alternatives(verdict: &Verdict) -> Option<String> {
    let of = |finding: &Finding| {
        let mut names = vec![finding.name.as_str()];
        names.extend(finding.confusable_with.iter().map(String::as_str));
        names.join(" or ")
    };
    let alike = verdict.effects.iter().filter(|finding| !finding.confusable_with.is_empty());
    let alike: Vec<String> = alike.map(of).collect();
    (!alike.is_empty()).then(|| alike.join("; "))
}

/// The meaning of intervals and probabilities.
pub const FITTED: &str = "Intervals are meant to hold the true value in nine of ten cases, and \
                          probabilities to be the fraction of names that are right. Both are fitted to \
                          cases whose truth is known; how often they hold is in benches/gap.";
/// Why a recording alone has no gap, and what it was compared with.
pub const NO_GAP: &str = "Without a scene there is nothing to simulate, and so no gap: the \
                                 recording was compared with copies of itself in which times are \
                                 redrawn inside short windows.";

/// Summary of an effect of the catalogue or of a parameter of the model.
pub fn summary(name: &str) -> Option<&'static str> {
    let stage = STAGES.find(name).map(|stage| stage.summary);
    stage.or_else(|| {
        let parameter = ModelParameter::ALL.iter().find(|parameter| parameter.name() == name)?;
        Some(match parameter {
            ModelParameter::ThresholdOn => "rise of log light for an ON event",
            ModelParameter::ThresholdOff => "fall of log light for an OFF event",
            ModelParameter::NoiseOn => "background rate of ON events of each pixel",
            ModelParameter::NoiseOff => "background rate of OFF events of each pixel",
            ModelParameter::ClockOffset => "delay of the clock of the recording",
        })
    })
}

/// The parameters of a finding.
pub fn parameters(finding: &Finding) -> String {
    let quantities: Vec<String> = finding
        .parameters
        .iter()
        .map(|(name, value)| format!("{name} = {}", quantity(value)))
        .collect();
    quantities.join(", ")
}

/// A number with its interval and unit.
pub fn quantity(quantity: &Quantity) -> String {
    let Quantity { value, lo90, hi90, unit, halves } = quantity;
    let unit = if unit.is_empty() { String::new() } else { format!(" {unit}") };
    let interval = format!("{}{unit} [{}, {}]", short(*value), short(*lo90), short(*hi90));
    match halves {
        Some([early, late]) => {
            format!("{interval}, halves {} and {}", short(*early), short(*late))
        }
        // Counted, not estimated.
        None if lo90 == hi90 => format!("{}{unit}", short(*value)),
        None => interval,
    }
}

/// A gap with its interval.
pub fn gap(gap: &GapValue) -> String {
    format!("{} [{}, {}]", short(gap.value), short(gap.lo), short(gap.hi))
}

/// How much of a gap is closed. All of it is said only where nothing is left.
pub fn closed(verdict: &Verdict) -> String {
    let closed = verdict.grr.min(1.0);
    if (0.995..1.0).contains(&closed) { "over 99%".to_owned() } else { percent(closed) }
}

/// Area under the ROC curve from which a classifier separates what no statistic does.
const SEPARATED: f64 = 0.6;

/// The share that a classifier still separates after the correction; empty where it is no better than chance.
pub fn separated(verdict: &Verdict) -> Option<String> {
    let after = verdict.c2st_after.filter(|after| after.p < 0.05 && after.auc > SEPARATED)?;
    let auc = format!("{:.2}", after.auc);
    Some(format!(
        "a classifier still separates events (AUC {auc}): something is left that no statistic measures"
    ))
}

/// A probability; small ones as a bound, because they rest on few runs.
pub fn probability(p: f64) -> String {
    if p < 0.001 { "p < 0.001".to_owned() } else { format!("p = {}", short(p)) }
}

/// The variable that distinguishes events; pairs are joined with `x`.
pub fn axis(name: &str) -> String {
    let words = |name: &str| match name {
        "age" => "time since light changed".to_owned(),
        "speed" => "speed of change".to_owned(),
        "contrast" => "contrast of the edge".to_owned(),
        "interval of pixel" => "time since the pixel's last event".to_owned(),
        name => name.to_owned(),
    };
    name.split(" x ").map(words).collect::<Vec<_>>().join(" x ")
}

/// Property that a block of statistics measures.
pub fn block(block: StatisticBlock) -> &'static str {
    match block {
        StatisticBlock::Quiet => "pixels at rest",
        StatisticBlock::Crossing => "events per change of light",
        StatisticBlock::Timing => "delays",
        StatisticBlock::LogIntensityStep => "change of light per event",
        StatisticBlock::Interval => "times between events of a pixel",
        StatisticBlock::Tail => "events behind an edge",
        StatisticBlock::Spatial => "differences between pixels",
        StatisticBlock::Spectrum => "frequencies",
        StatisticBlock::Readout => "marks of readout and clock",
        StatisticBlock::Load => "busy moments",
        StatisticBlock::Geometry => "position in the image",
    }
}

/// Change to the model.
pub fn change(ablation: &Ablation) -> String {
    match ablation.change {
        ModelChange::None => "model as given".to_owned(),
        ModelChange::Added if ablation.effect.is_empty() => "corrected".to_owned(),
        ModelChange::Added => format!("{} added", ablation.effect),
        ModelChange::Dropped => format!("{} dropped", ablation.effect),
        ModelChange::Swapped => format!("swapped for {}", ablation.effect),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pages::gap::example;

    #[test]
    fn all_is_closed_only_where_nothing_is_left() {
        let mut verdict = example::verdict();
        for (fraction, expected) in [(1.0, "100%"), (0.997, "over 99%"), (0.96, "96%")] {
            verdict.grr = fraction;
            assert_eq!(closed(&verdict), expected);
        }
    }

    #[test]
    fn a_classifier_that_still_separates_is_named_beside_what_is_closed() {
        let mut verdict = example::verdict();
        assert_eq!(separated(&verdict), None);
        verdict.c2st_after = Some(evpose_gap::verdict::TwoSample { auc: 0.94, p: 0.01 });
        assert!(separated(&verdict).is_some_and(|text| text.contains("AUC 0.94")));
    }
}
