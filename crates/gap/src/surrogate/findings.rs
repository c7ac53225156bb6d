//! Results of the tests of a recording without a scene.

use std::fmt;

use serde::Serialize;

use crate::verdict::SignatureTest;

/// A statistic of the recording with its distribution over surrogates.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneFreeStatistic {
    /// Name.
    pub name: &'static str,
    /// The structure that is randomised in the surrogates.
    pub null: &'static str,
    /// Value of the recording.
    pub observed: f64,
    /// Mean over the surrogates.
    pub mean: f64,
    /// Standard deviation over the surrogates.
    pub sd: f64,
    /// p-value of this statistic alone.
    pub p: f64,
    /// p-value corrected for all statistics; none for a repetition with surrogates of another
    /// window, which shows the time scale.
    pub adjusted_p: Option<f64>,
    /// Effect that it is evidence for.
    pub effect: Option<&'static str>,
}

/// A parameter of an effect.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneFreeParameter {
    /// Name in the catalogue, or a description where the catalogue's parameter cannot be estimated.
    pub name: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Estimate from the whole recording.
    pub value: f64,
    /// Lower end of the 90 % interval from the two halves.
    pub lo90: f64,
    /// Upper end.
    pub hi90: f64,
    /// Estimates from the first and the second half; none for counts over the whole.
    pub halves: Option<[f64; 2]>,
}

/// An effect that the recording is consistent with.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneFreeEffect {
    /// Name in the catalogue.
    pub name: &'static str,
    /// Variant, as words.
    pub variant: Option<&'static str>,
    /// Estimated parameters.
    pub parameters: Vec<SceneFreeParameter>,
    /// Smallest corrected p-value of its statistics; none for a background that is only estimated.
    pub p: Option<f64>,
    /// Effects that a recording without a scene does not distinguish from it.
    pub confusable_with: Vec<&'static str>,
    /// Affected pixels (column, row), for effects of single pixels.
    pub pixels: Vec<(u16, u16)>,
    /// Test of the name; none without one.
    pub test: Option<SignatureTest>,
}

/// An effect that is not testable in this recording.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Untestable {
    /// Name in the catalogue.
    pub name: &'static str,
    /// Reason.
    pub why: String,
}

/// Results of all tests of a recording without a scene.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SceneFreeFindings {
    /// Number of tested events.
    pub events: usize,
    /// From the first event to the last, in seconds.
    pub seconds: f64,
    /// Number of surrogates of each kind.
    pub replicates: usize,
    /// All statistics.
    pub statistics: Vec<SceneFreeStatistic>,
    /// Effects that both halves of the recording agree on.
    pub effects: Vec<SceneFreeEffect>,
    /// Effects that were tested and are not significant.
    pub absent: Vec<&'static str>,
    /// Effects that were not testable.
    pub untestable: Vec<Untestable>,
    /// Notes for the user.
    pub notes: Vec<String>,
}

impl fmt::Display for SceneFreeFindings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} events in {:.3} s, {} surrogates of each kind",
            self.events, self.seconds, self.replicates
        )?;
        for effect in &self.effects {
            write!(f, "consistent with {}", effect.name)?;
            if let Some(variant) = effect.variant {
                write!(f, " ({variant})")?;
            }
            for p in &effect.parameters {
                write!(f, ", {} {:.4} [{:.4}, {:.4}] {}", p.name, p.value, p.lo90, p.hi90, p.unit)?;
            }
            if let Some(p) = effect.p {
                write!(f, ", p = {p:.3}")?;
            }
            if !effect.confusable_with.is_empty() {
                write!(f, "; or {}", effect.confusable_with.join(", "))?;
            }
            writeln!(f)?;
        }
        if self.effects.is_empty() {
            writeln!(f, "no effect that both halves agree on")?;
        }
        writeln!(f, "not found: {}", self.absent.join(", "))?;
        let names: Vec<_> = self.untestable.iter().map(|untestable| untestable.name).collect();
        writeln!(f, "untestable: {}", names.join(", "))?;
        self.notes.iter().try_for_each(|note| writeln!(f, "{note}"))
    }
}
