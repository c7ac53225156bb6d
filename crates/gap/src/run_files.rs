//! Names of the files of a run, for programs that read them.

/// The answer: [`Verdict`](crate::verdict::Verdict).
pub const VERDICT: &str = "verdict.json";
/// Its evidence: [`AnswerEvidence`](crate::workflow::AnswerEvidence).
pub const EVIDENCE: &str = "evidence.json";
/// Data of the page: [`ReportData`](crate::report::ReportData).
pub const REPORT: &str = "report.json";
/// How all of it was made.
pub const RUN: &str = "run.json";
/// The model that was compared, with nominal values.
pub const MODEL: &str = "model.toml";
/// The model with what was found.
pub const CORRECTED: &str = "corrected.toml";
