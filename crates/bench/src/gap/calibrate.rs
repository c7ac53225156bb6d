//! `evpose gap calibrate`: constants of probabilities and intervals from cases whose truth is
//! known.

use evpose_gap::free_parameter::FreeParameter;
use evpose_gap::workflow::calibrate::{EstimateError, coverage, fit_errors, fit_probability};
use evpose_gap::workflow::{
    CALIBRATION, Calibration, ErrorScale, FEATURES, FindingEvidence, ParameterOwner,
};

use super::opened::Opened;
use super::stats::{bins, calibration_error};

/// Fitted constants and their quality, as lines to be pasted into the module of the constants.
pub(super) fn lines(opened: &[Opened], seed: u64) -> Vec<String> {
    let names = names(opened);
    let right = names.iter().filter(|(_, is_right)| *is_right).count();
    let (of_effect, of_model) =
        (misses(opened, ParameterOwner::OfEffect), misses(opened, ParameterOwner::OfModel));
    let mut fitted = CALIBRATION;
    let mut lines = vec![format!(
        "// From {} cases of plan {seed}: {} names, {right} right; {} values of effects, {} of the \
         model.",
        opened.len(),
        names.len(),
        of_effect.len(),
        of_model.len()
    )];
    match fit_probability(&names) {
        Some((intercept, slopes)) => (fitted.intercept, fitted.slopes) = (intercept, slopes),
        None => lines.push("// Names are all right, or there are none: odds are kept.".to_owned()),
    }
    for (scale, misses) in [(&mut fitted.of_effect, &of_effect), (&mut fitted.of_model, &of_model)]
    {
        match fit_errors(misses) {
            Some(found) => *scale = found,
            None => lines.push("// Too few values of one kind: its errors are kept.".to_owned()),
        }
    }
    lines.extend(constants(&fitted));
    lines.push("// Slopes, in their order, are of".to_owned());
    lines.extend(FEATURES.iter().map(|feature| format!("//   {feature}")));
    lines.push("// Before and after, on these very cases:".to_owned());
    lines.push(format!(
        "//   error of stated probabilities {} -> {}",
        known(off(&CALIBRATION, &names)),
        known(off(&fitted, &names))
    ));
    for (kind, before, after, misses) in [
        ("effects", &CALIBRATION.of_effect, &fitted.of_effect, &of_effect),
        ("the model", &CALIBRATION.of_model, &fitted.of_model, &of_model),
    ] {
        lines.push(format!(
            "//   values of {kind} inside their intervals {} -> {}",
            known(coverage(misses, before)),
            known(coverage(misses, after))
        ));
    }
    lines
}

/// The constants as Rust.
fn constants(fitted: &Calibration) -> Vec<String> {
    let scale = |name: &str, scale: &ErrorScale| {
        format!(
            "    {name}: ErrorScale {{ factor: {:.2}, floor: {:.2} }},",
            scale.factor, scale.floor
        )
    };
    let slopes: Vec<String> = fitted.slopes.iter().map(|slope| format!("{slope:.3}")).collect();
    vec![
        "pub const CALIBRATION: Calibration = Calibration {".to_owned(),
        format!("    intercept: {:.3},", fitted.intercept),
        format!("    slopes: [{}],", slopes.join(", ")),
        scale("of_effect", &fitted.of_effect),
        scale("of_model", &fitted.of_model),
        "};".to_owned(),
    ]
}

fn known(value: Option<f64>) -> String {
    value.map_or_else(|| "unknown".to_owned(), |value| format!("{value:.3}"))
}

/// All effects that were named, and whether each is there.
fn names(opened: &[Opened]) -> Vec<(FindingEvidence, bool)> {
    let of = |case: &Opened| -> Vec<(FindingEvidence, bool)> {
        let evidence = case.row.evidence.iter();
        evidence.map(|(name, evidence)| (*evidence, case.truth.holds(name))).collect()
    };
    opened.iter().flat_map(of).collect()
}

/// Errors of the estimated values of right names, in steps.
fn misses(opened: &[Opened], kind: ParameterOwner) -> Vec<EstimateError> {
    let of = |case: &Opened| -> Vec<EstimateError> {
        let miss = |(finding, key, truth): &(&'static str, &'static str, f64)| {
            let estimate = case.estimate(finding, key)?.value;
            let raw = case.row.errors.get(*finding)?.get(*key)?.steps();
            let free_parameter = FreeParameter::by_name(finding, key)?;
            let parameter_kind = match free_parameter {
                FreeParameter::Model(_) => ParameterOwner::OfModel,
                FreeParameter::Effect(..) => ParameterOwner::OfEffect,
            };
            (parameter_kind == kind)
                .then(|| EstimateError { steps: free_parameter.steps(*truth, estimate), raw })
        };
        case.truth.values.iter().filter_map(miss).collect()
    };
    opened.iter().filter(|case| case.counts_for_error()).flat_map(of).collect()
}

/// How far shares are from stated probabilities.
fn off(calibration: &Calibration, names: &[(FindingEvidence, bool)]) -> Option<f64> {
    let stated = |(e, is_right): &(FindingEvidence, bool)| (calibration.probability(e), *is_right);
    calibration_error(&bins(&names.iter().map(stated).collect::<Vec<_>>()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gap::example;

    #[test]
    fn values_that_are_two_percent_off_are_a_fraction_of_a_step_off() {
        let misses = misses(&example::opened(), ParameterOwner::OfEffect);
        // Steps of values on a logarithmic scale are 12 %.
        let step = 1.02_f64.ln() / 1.12_f64.ln();
        let near = misses.iter().filter(|miss| (miss.steps - step).abs() < 1e-9).count();
        assert!(near > misses.len() / 2, "{near} of {}", misses.len());
    }

    #[test]
    fn what_is_printed_is_the_constant_with_what_was_fitted() {
        let mut opened = example::opened();
        // Some names are wrong, where little was gained.
        for case in opened.iter_mut().step_by(4) {
            let evidence = std::mem::take(&mut case.row.evidence);
            let wrong = evidence.into_values().map(|e| FindingEvidence { log_odds: 1.0, ..e });
            case.row.evidence = wrong.map(|e| ("no such effect".to_owned(), e)).collect();
        }
        let lines = lines(&opened, example::PLAN.seed).join("\n");
        assert!(lines.contains("pub const CALIBRATION: Calibration = Calibration {"), "{lines}");
        assert!(lines.contains("slopes: [") && !lines.contains("kept"), "{lines}");
        let error = lines.split(" -> ").nth(1).and_then(|rest| rest.get(..5));
        assert!(error.is_some_and(|e| e.parse::<f64>().is_ok_and(|e| e < 0.1)), "{lines}");
    }

    #[test]
    fn without_a_wrong_name_odds_are_kept() {
        let lines = lines(&example::opened(), example::PLAN.seed).join("\n");
        assert!(lines.contains("odds are kept"), "{lines}");
    }
}
