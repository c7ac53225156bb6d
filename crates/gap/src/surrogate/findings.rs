//! What is found in a recording alone.

use std::fmt;

use serde::Serialize;

/// A statistic of the recording against its surrogates.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BareStatistic {
    /// What it is.
    pub name: &'static str,
    /// What the surrogates forget.
    pub null: &'static str,
    /// Its value.
    pub observed: f64,
    /// Mean over the surrogates.
    pub mean: f64,
    /// Standard deviation over the surrogates.
    pub sd: f64,
    /// p-value of this statistic alone.
    pub p: f64,
    /// p-value over all statistics; none for a second look at the same number, with surrogates of
    /// another window, which tells the time scale.
    pub adjusted_p: Option<f64>,
    /// The effect that it is evidence for.
    pub effect: Option<&'static str>,
}

/// A parameter of an effect.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BareParameter {
    /// The name in the catalogue, or what it is where the catalogue's cannot be had.
    pub name: &'static str,
    /// Its unit.
    pub unit: &'static str,
    /// Over the whole recording.
    pub value: f64,
    /// Lower end of the 90 % interval from the two halves.
    pub lo90: f64,
    /// Upper end.
    pub hi90: f64,
    /// In the first half and in the second; none for what is counted over the whole.
    pub halves: Option<[f64; 2]>,
}

/// An effect that the recording is consistent with.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BareEffect {
    /// The name in the catalogue.
    pub name: &'static str,
    /// Its variant, in words.
    pub variant: Option<&'static str>,
    /// What is known of its strength.
    pub parameters: Vec<BareParameter>,
    /// The least adjusted p-value of its statistics; none for a background that is only measured.
    pub p: Option<f64>,
    /// Effects that a recording alone does not tell from it.
    pub confusable_with: Vec<&'static str>,
    /// The pixels concerned, column and row, where it is about single ones.
    pub pixels: Vec<(u16, u16)>,
}

/// An effect that this recording alone says nothing about.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Untestable {
    /// The name in the catalogue.
    pub name: &'static str,
    /// Why.
    pub why: String,
}

/// All that is found in a recording alone.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BareFindings {
    /// Events looked at.
    pub events: usize,
    /// From the first event to the last, in seconds.
    pub seconds: f64,
    /// Surrogates of each kind.
    pub replicates: usize,
    /// Every statistic.
    pub statistics: Vec<BareStatistic>,
    /// Effects that both halves of the recording agree on.
    pub effects: Vec<BareEffect>,
    /// Effects that were looked for and not found.
    pub absent: Vec<&'static str>,
    /// Effects that could not be looked for.
    pub untestable: Vec<Untestable>,
    /// What a user should know.
    pub notes: Vec<String>,
}

impl fmt::Display for BareFindings {
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
