//! Conventions: small deviations from the ideal pixel that every camera of a plan has several of,
//! and that no description mentions.
//!
//! A real camera differs from its model in its time grid, its tone curve, the mismatch of its
//! thresholds, its latency, its background and its resets, whatever else one is looking for. Each
//! camera has three to five of these, from barely to clearly visible. To name one is right, and to
//! pass over it in silence is no miss.

use serde::Serialize;

use crate::catalogue::Parameter;
use crate::circuit::{Bend, Circuit, Timer};
use crate::draw::Sequence;
use crate::slot::Slot;

/// Fewest and most conventions of a camera.
pub const CONVENTIONS_PER_CAMERA: [usize; 2] = [3, 5];

/// Periods of time-stamp grids, us; the last is that of the frames.
const GRIDS_US: [f64; 7] = [10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1000.0];

/// Kinds of conventions; a camera has at most one of each.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum ConventionKind {
    /// Time stamps are multiples of a period.
    TimeGrid,
    /// The photoreceptor is not exactly logarithmic.
    ToneCurve,
    /// Weak spread of the thresholds.
    Mismatch,
    /// A delay, of all pixels or with a spread over them.
    Latency,
    /// Background events above the nominal rates.
    Background,
    /// A reset that ends late or early.
    Reset,
}

/// All kinds.
pub const CONVENTION_KINDS: [ConventionKind; 6] = [
    ConventionKind::TimeGrid,
    ConventionKind::ToneCurve,
    ConventionKind::Mismatch,
    ConventionKind::Latency,
    ConventionKind::Background,
    ConventionKind::Reset,
];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Form {
    Grid,
    AddedCurrent,
    Bend,
    Offsets,
    CommonDelay,
    SpreadDelay,
    Rates,
    ClosedSwitch,
    Unsettled,
}

/// One convention of a camera.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Convention {
    /// Its kind.
    pub kind: ConventionKind,
    /// Its values in catalogue units.
    pub parameters: Vec<Parameter>,
    /// Names of the catalogue that are right for it.
    pub names: &'static [&'static str],
    #[serde(skip)]
    form: Form,
}

impl ConventionKind {
    fn forms(self) -> &'static [Form] {
        match self {
            Self::TimeGrid => &[Form::Grid],
            Self::ToneCurve => &[Form::AddedCurrent, Form::Bend],
            Self::Mismatch => &[Form::Offsets],
            Self::Latency => &[Form::CommonDelay, Form::SpreadDelay],
            Self::Background => &[Form::Rates],
            Self::Reset => &[Form::ClosedSwitch, Form::Unsettled],
        }
    }

    fn free_forms(self, taken: &[Slot]) -> Vec<Form> {
        let is_free = |form: &Form| form.slots().iter().all(|slot| !taken.contains(slot));
        self.forms().iter().copied().filter(is_free).collect()
    }
}

impl Form {
    fn slots(self) -> &'static [Slot] {
        match self {
            Self::Grid => &[Slot::Counter],
            Self::AddedCurrent => &[Slot::AddedCurrent],
            Self::Bend => &[Slot::Slope],
            Self::Offsets => &[Slot::Offsets],
            Self::CommonDelay => &[Slot::Delay],
            Self::SpreadDelay => &[Slot::Delay, Slot::Jitter],
            Self::Rates => &[Slot::BackgroundRate],
            Self::ClosedSwitch => &[Slot::Reset],
            // After the first event of an edge, all steps are shorter.
            Self::Unsettled => &[Slot::Reset, Slot::Thresholds],
        }
    }

    fn names(self) -> &'static [&'static str] {
        match self {
            Self::Grid => &["timestamp_quantisation"],
            Self::AddedCurrent => &["logarithmic", "dark_current", "lin_log", "tone_curve"],
            Self::Bend => &["tone_curve", "lin_log", "logarithmic"],
            Self::Offsets => &["threshold_mismatch", "fixed_pattern"],
            Self::CommonDelay => &["pixel_latency", "clock_offset_drift"],
            Self::SpreadDelay => &["pixel_latency", "timestamp_jitter", "clock_offset_drift"],
            Self::Rates => &["uniform_noise"],
            Self::ClosedSwitch => &["refractory", "reset_overshoot"],
            Self::Unsettled => &["reset_overshoot"],
        }
    }
}

/// Kinds that a camera can have whose slots in `taken` hold something else.
pub fn free_kinds(taken: &[Slot]) -> Vec<ConventionKind> {
    let is_free = |kind: &ConventionKind| !kind.free_forms(taken).is_empty();
    CONVENTION_KINDS.into_iter().filter(is_free).collect()
}

/// Three to five conventions beside what occupies `taken`; fewer where fewer kinds are free.
pub fn draw_conventions(taken: &[Slot], draws: &mut Sequence) -> Vec<Convention> {
    let [fewest, most] = CONVENTIONS_PER_CAMERA;
    let mut kinds = free_kinds(taken);
    draws.shuffle(&mut kinds);
    kinds.truncate(fewest + draws.below(most - fewest + 1));
    kinds.sort_by_key(|kind| *kind as usize);
    let draw = |kind: ConventionKind| {
        let forms = kind.free_forms(taken);
        Convention::draw(kind, forms[draws.below(forms.len())], draws)
    };
    kinds.into_iter().map(draw).collect()
}

impl Convention {
    fn draw(kind: ConventionKind, form: Form, draws: &mut Sequence) -> Self {
        let value = |name, value, unit| Parameter { name, value, unit };
        let parameters = match form {
            Form::Grid => {
                vec![value("period", GRIDS_US[draws.below(GRIDS_US.len())] * 1e-6, "s")]
            }
            Form::AddedCurrent => {
                vec![value("equivalent_luminance", draws.log_between(0.001, 0.008), "1")]
            }
            Form::Bend => {
                vec![value("slope_change", draws.sign() * draws.between(0.03, 0.12), "1")]
            }
            Form::Offsets => vec![value("sigma_ln", draws.log_between(0.01, 0.04), "1")],
            Form::CommonDelay => vec![value("delay", draws.log_between(30e-6, 400e-6), "s")],
            Form::SpreadDelay => vec![
                value("delay", draws.log_between(30e-6, 400e-6), "s"),
                value("spread", draws.between(0.2, 0.5), "ln"),
            ],
            Form::Rates => vec![
                value("added_rate_on", draws.log_between(0.02, 0.15), "Hz"),
                value("added_rate_off", draws.log_between(0.01, 0.08), "Hz"),
            ],
            Form::ClosedSwitch => vec![value("period", draws.log_between(30e-6, 300e-6), "s")],
            Form::Unsettled => vec![value("share", draws.between(0.02, 0.1), "1")],
        };
        Self { kind, parameters, names: form.names(), form }
    }

    /// Slots that it occupies.
    pub fn slots(&self) -> &'static [Slot] {
        self.form.slots()
    }

    /// Puts the convention into a circuit.
    pub fn install(&self, circuit: &mut Circuit) {
        let first = self.parameters.first().map_or(0.0, |parameter| parameter.value);
        let second = self.parameters.get(1).map_or(0.0, |parameter| parameter.value);
        match self.form {
            // A product may miss the grid by a rounding error, and the counter knows whole
            // microseconds.
            Form::Grid => circuit.clock.period_us = (first * 1e6).round(),
            Form::AddedCurrent => circuit.photoreceptor.added_share = first,
            Form::Bend => circuit.photoreceptor.bend = Some(Bend { share: first }),
            Form::Offsets => circuit.detector.offset_sigma_ln = first,
            Form::CommonDelay | Form::SpreadDelay => {
                circuit.clock.latency_us = first * 1e6;
                circuit.clock.latency_spread_ln = second;
            }
            Form::Rates => {
                // Rates are added to the nominal ones, which the description of the case states.
                circuit.background.on_hz += first;
                circuit.background.off_hz += second;
            }
            Form::ClosedSwitch => {
                // 10 fC (20 fF over half a volt) taken off in this time.
                let timer = Timer { current_pa: 10e-3 / first, capacitance_ff: 20.0, swing_v: 0.5 };
                circuit.detector.refractory = Some(timer);
            }
            Form::Unsettled => circuit.detector.unsettled_share = first,
        }
    }
}
