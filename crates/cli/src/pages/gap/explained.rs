//! Fractions of a gap that effects and parameters explain, as values and sentences.

use evpose_gap::verdict::{Answer, Finding, Verdict};

use super::words::probability;
use evpose_report::format::percent;

/// Fraction below which the joint part is not mentioned.
const MENTIONED: f64 = 0.005;

/// Whether a verdict says what fraction of the gap is explained: those without a scene do not, and without a gap there is nothing to explain.
pub(crate) fn has_fractions(verdict: &Verdict) -> bool {
    verdict.verdict != Answer::NoGap && verdict.unexplained.fraction.is_finite()
}

/// Fraction that a finding explains beside the others (drop-one).
pub(crate) fn beside_others(finding: &Finding) -> f64 {
    finding.explained.map_or(0.0, |explained| explained.beside_others)
}

/// The part that neither a single finding nor the rest accounts for: positive, what several findings
/// explain only jointly, since each can stand in for another; negative, what is counted with more
/// than one of them, since it takes them all. Zero if too little to be mentioned.
pub(crate) fn jointly(verdict: &Verdict) -> f64 {
    let all = verdict.effects.iter().chain(&verdict.demoted);
    let each: f64 = all.map(beside_others).sum();
    let joint = 1.0 - each - verdict.unexplained.fraction;
    if joint.abs() < MENTIONED { 0.0 } else { joint }
}

pub(crate) fn line(verdict: &Verdict) -> String {
    let part = |finding: &Finding| format!("{} {}", finding.name, percent(beside_others(finding)));
    let parts: Vec<String> = verdict.effects.iter().map(part).collect();
    let mut text = if parts.is_empty() { "nothing".to_owned() } else { parts.join(", ") };
    let demoted: Vec<String> = verdict.demoted.iter().map(part).collect();
    if !demoted.is_empty() {
        // It closes the gap, but the recording does not show what it does.
        text += &format!("; like {}, but not by it", demoted.join(" and "));
    }
    let joint = jointly(verdict);
    if joint != 0.0 && parts.len() + demoted.len() > 0 {
        let what = if joint > 0.0 { "jointly" } else { "counted twice" };
        text += &format!("; {what} {}", percent(joint.abs()));
    }
    let left = &verdict.unexplained;
    let significant = if left.is_significant { " (significant)" } else { "" };
    text + &format!("; unexplained {}{significant}", percent(left.fraction))
}

/// The part that is left, as a sentence.
pub(crate) fn left_in_words(verdict: &Verdict) -> String {
    let left = &verdict.unexplained;
    let fraction = match left.fraction.is_finite() {
        true => format!("{} of the discrepancy", percent(left.fraction)),
        false => "Something".to_owned(),
    };
    match left.is_significant {
        true => format!("{fraction} is left, more than chance ({}).", probability(left.p)),
        false if left.fraction.is_finite() && verdict.gap_after.value < 1.0 => {
            format!("{fraction} is left, a gap below that of two runs of one model.")
        }
        false if left.fraction.is_finite() => {
            format!("{fraction} is left, no more than chance ({}).", probability(left.p))
        }
        false => "Nothing significant is left.".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use evpose_gap::verdict::Explained;

    use super::*;
    use crate::pages::gap::example;

    fn with_parts(fractions: &[f64], left: f64) -> Verdict {
        let mut verdict = example::verdict();
        let finding = verdict.effects[0].clone();
        let part = |fraction: &f64| Finding {
            name: format!("effect_{}", (100.0 * fraction) as u32),
            explained: Some(Explained { alone: *fraction, beside_others: *fraction, p: 0.001 }),
            ..finding.clone()
        };
        verdict.effects = fractions.iter().map(part).collect();
        verdict.unexplained.fraction = left;
        verdict
    }

    #[test]
    fn all_parts_of_the_gap_are_in_the_line() {
        let line = |fractions: &[f64], left| line(&with_parts(fractions, left));
        assert_eq!(line(&[0.8, 0.16], 0.04), "effect_80 80%, effect_16 16%; unexplained 4%");
        assert_eq!(line(&[0.5], 0.2), "effect_50 50%; jointly 30%; unexplained 20%");
        assert_eq!(
            line(&[0.9, 0.4], 0.0),
            "effect_90 90%, effect_40 40%; counted twice 30%; unexplained 0%"
        );
        assert_eq!(line(&[], 1.0), "nothing; unexplained 100%");
    }

    #[test]
    fn what_is_left_is_held_against_two_runs_of_one_model_or_against_chance() {
        let mut verdict = with_parts(&[0.9], 0.04);
        assert!(left_in_words(&verdict).ends_with("no more than chance (p = 0.21)."));
        verdict.gap_after.value = 0.8;
        assert!(left_in_words(&verdict).ends_with("below that of two runs of one model."));
    }

    #[test]
    fn without_a_fraction_nothing_is_claimed_of_it() {
        let mut verdict = with_parts(&[0.5], f64::NAN);
        assert!(!has_fractions(&verdict));
        assert_eq!(left_in_words(&verdict), "Nothing significant is left.");
        verdict.unexplained.fraction = 0.5;
        verdict.unexplained.is_significant = true;
        assert!(left_in_words(&verdict).starts_with("50% of the discrepancy is left"));
    }
}
