//! Signatures: properties of events that one effect moves and its relatives do not.

use evpose_sensor::EffectConfig;

use super::value::Value;
use super::{light, pixels, timing};
use crate::View;

/// A property of events that an effect is known by.
#[derive(Debug)]
pub(crate) struct Signature {
    /// The quantity that is measured, as it is read in a sentence.
    pub(crate) quantity: &'static str,
    pub(crate) unit: &'static str,
    /// The sign that the recording would have to show, after "it would have to".
    pub(crate) must: &'static str,
    /// The recording that shows it best.
    pub(crate) recording: &'static str,
    /// Whether the light has to be known exactly.
    pub(crate) needs_light: bool,
    /// The quantity of a recording, for an effect with its parameters; none where there are too few
    /// events.
    pub(crate) measure: fn(&View<'_>, &EffectConfig) -> Option<Value>,
}

/// Thresholds that differ for good.
pub(crate) static FIXED_PATTERN: Signature = Signature {
    quantity: "variance between neighbouring pixels that both halves agree on",
    unit: "",
    must: "make the same pixels have more events in the first and in the last half of the recording",
    recording: "the same moving texture twice, some seconds each: what stays in a pixel is mismatch, \
                what does not is noise",
    needs_light: true,
    measure: |view, _| pixels::fixed_pattern(view),
};

/// Also thresholds that drift or that neighbours share.
pub(crate) static LASTING_PATTERN: Signature = Signature {
    quantity: "variance of pixels that neighbouring parts of the time agree on",
    unit: "",
    must: "be independent from event to event, not alike in neighbouring pixels or for a while",
    recording: "the same moving texture for a minute: drift shows between its beginning and its end",
    needs_light: true,
    measure: |view, _| pixels::lasting_pattern(view),
};

pub(crate) static LATE_COUNT: Signature = Signature {
    quantity: "log of events over expected, in the last third of the time minus in the first",
    unit: "",
    must: "change with time",
    recording: "the same moving texture for a minute",
    needs_light: true,
    measure: |view, _| light::late(view),
};

pub(crate) static STEP_SPREAD: Signature = Signature {
    quantity: "spread of the change of light from event to event",
    unit: "ln",
    must: "scatter the change of light from event to event of a pixel",
    recording: "a slow edge of high contrast: the slower, the more noise of thresholds scatters times",
    needs_light: true,
    measure: |view, _| timing::step_spread(view),
};

pub(crate) static STEP_ASYMMETRY: Signature = Signature {
    quantity: "change of light behind an event of the same polarity minus behind one of the other",
    unit: "ln",
    must: "make the next event of the same polarity come sooner or later than that of the other",
    recording: "slow ramps of light up and down, under a lamp on direct current",
    needs_light: true,
    measure: |view, _| timing::step_asymmetry(view),
};

pub(crate) static FAST_STEPS: Signature = Signature {
    quantity: "change of light per event where it is fast minus where it is slow",
    unit: "ln",
    must: "lose more light between two events where it changes faster",
    recording: "the same edge at two speeds that differ by ten",
    needs_light: true,
    measure: |view, _| timing::fast_steps(view),
};

pub(crate) static ALTERNATION: Signature = Signature {
    quantity: "pairs of opposite polarity minus pairs of one polarity, at rest",
    unit: "",
    must: "make ON and OFF events of pixels at rest alternate",
    recording: "a static grey card for ten seconds, at two brightnesses: noise of the photoreceptor \
                alternates, that of the comparator does not",
    needs_light: false,
    measure: |view, _| light::alternation(view),
};

pub(crate) static LAG: Signature = Signature {
    quantity: "delay of all events",
    unit: "ms",
    must: "delay all events alike and lose none",
    recording: "a light that is switched in view of the camera by a trigger with its own stamp",
    needs_light: true,
    measure: |view, _| timing::lag(view),
};

pub(crate) static DARK_LAG: Signature = Signature {
    quantity: "delay in the dark minus that in bright light",
    unit: "ms",
    must: "delay events in the dark more than in bright light",
    recording: "the same moving edge at two brightnesses that differ by ten: an offset of the clock \
                delays both alike, a slow photoreceptor the dark one more",
    needs_light: true,
    measure: |view, _| timing::dark_lag(view),
};

pub(crate) static LAG_GROWTH: Signature = Signature {
    quantity: "delay in the last third of the time minus in the first",
    unit: "ms",
    must: "delay events more and more from the beginning to the end",
    recording: "a longer recording: a drift grows with it, an offset does not",
    needs_light: true,
    measure: |view, _| timing::lag_growth(view),
};

pub(crate) static LAG_SPREAD: Signature = Signature {
    quantity: "spread of delays",
    unit: "ms",
    must: "scatter the times of events",
    recording: "a fast edge of high contrast, where noise of thresholds hardly scatters times",
    needs_light: true,
    measure: |view, _| timing::lag_spread(view),
};

pub(crate) static BUSY_LAG: Signature = Signature {
    quantity: "delay while many pixels have events minus that in calm moments",
    unit: "ms",
    must: "delay events while many pixels have some",
    recording: "a scene that is busy and calm in turn, such as a flash every tenth of a second",
    needs_light: true,
    measure: |view, _| timing::busy_lag(view),
};

pub(crate) static ROW_ORDER: Signature = Signature {
    quantity: "fraction of the events of bursts in the row of the event before",
    unit: "",
    must: "serve events of bursts row by row",
    recording: "a scene that is busy and calm in turn, such as a flash every tenth of a second",
    needs_light: false,
    measure: |view, _| timing::row_order(view),
};

pub(crate) static BUSY_COUNT: Signature = Signature {
    quantity: "log of events over expected while many pixels have events minus in calm moments",
    unit: "",
    must: "lose events while many pixels have some, and none in calm moments",
    recording: "a scene that is busy and calm in turn, such as a flash every tenth of a second",
    needs_light: true,
    measure: |view, _| light::busy(view),
};

pub(crate) static FAST_COUNT: Signature = Signature {
    quantity: "log of events over expected where light changes fast minus where it changes slowly",
    unit: "",
    must: "change the number of events with the speed of the light",
    recording: "the same edge at two speeds that differ by ten",
    needs_light: true,
    measure: |view, _| light::fast(view),
};

pub(crate) static FINE_COUNT: Signature = Signature {
    quantity: "log of events over expected on fine structure minus on even light",
    unit: "",
    must: "change the number of events on fine structure, at any speed",
    recording: "bars of several widths that move at one speed",
    needs_light: true,
    measure: |view, _| light::fine(view),
};

pub(crate) static DARK_COUNT: Signature = Signature {
    quantity: "log of events over expected in the dark minus in bright light",
    unit: "",
    must: "change the number of events in the dark against that in bright light",
    recording: "the same moving contrast at two brightnesses that differ by ten",
    needs_light: true,
    measure: |view, _| light::dark(view),
};

pub(crate) static REST_ON: Signature = Signature {
    quantity: "rate of ON minus that of OFF events of a pixel at rest",
    unit: "Hz",
    must: "make ON events, and no OFF events, of pixels at rest",
    recording: "a static grey card for ten seconds",
    needs_light: false,
    measure: |view, _| light::rest_on(view),
};

pub(crate) static REST_ON_IN_LIGHT: Signature = Signature {
    quantity: "rate of ON events of a pixel at rest, in bright light minus in the dark",
    unit: "Hz",
    must: "make more ON events of pixels at rest in bright light than in the dark",
    recording: "a static scene with bright and dark parts for ten seconds",
    needs_light: true,
    measure: |view, _| light::rest_on_in_light(view),
};

pub(crate) static REST_IN_DARK: Signature = Signature {
    quantity: "rate of events of a pixel at rest, in the dark minus in bright light",
    unit: "Hz",
    must: "make more events of pixels at rest in the dark than in bright light",
    recording: "a static scene with bright and dark parts for ten seconds",
    needs_light: true,
    measure: |view, _| light::rest_in_dark(view),
};

pub(crate) static SHORT_INTERVALS: Signature = Signature {
    quantity: "fraction of the intervals of pixels that are shorter than the period",
    unit: "",
    must: "leave hardly any interval of a pixel that is shorter than the period",
    recording: "fast edges of high contrast, which make several events of a pixel at once",
    needs_light: false,
    measure: timing::short_intervals,
};

pub(crate) static SILENT_PIXELS: Signature = Signature {
    quantity: "pixels without any event among neighbours that have some",
    unit: "",
    must: "leave single pixels without any event from beginning to end",
    recording: "a texture that moves over every pixel for some seconds, slowly: a cap on the rate \
                spares it, dead pixels stay silent",
    needs_light: true,
    measure: |view, _| pixels::silent(view),
};

pub(crate) static HOT_PIXELS: Signature = Signature {
    quantity: "pixels with a rate above 3 Hz and far above their neighbours', in both halves",
    unit: "",
    must: "give single pixels a rate above 3 Hz and four times that of their neighbours, all the time",
    recording: "the lens covered, for ten seconds: hot pixels go on, all others are silent",
    needs_light: false,
    measure: |view, _| pixels::hot(view),
};

pub(crate) static RADIAL_SHIFT: Signature = Signature {
    quantity: "displacement away from the centre, at the corner",
    unit: "px",
    must: "move events away from the centre, or towards it",
    recording: "a grid of points over the whole image",
    needs_light: true,
    measure: |view, _| pixels::radial(view),
};

pub(crate) static LAMP_LINE: Signature = Signature {
    quantity: "line of ON against OFF events at the frequency",
    unit: "",
    must: "make ON and OFF events alternate at the frequency",
    recording: "a static scene under the same lamp, and in daylight",
    needs_light: false,
    measure: timing::line,
};

pub(crate) static SCAN_LOCK: Signature = Signature {
    quantity: "fraction of events locked to the lines of the scan",
    unit: "",
    must: "stamp the events of a line at one phase of the scan",
    recording: "a busy scene: every line of a scan then has events at its own time",
    needs_light: false,
    measure: timing::scan,
};

pub(crate) static STAMP_GRID: Signature = Signature {
    quantity: "fraction of stamps at one phase of the period",
    unit: "",
    must: "stamp events at multiples of the period",
    recording: "any recording with the camera's own driver, without conversion",
    needs_light: false,
    measure: timing::grid,
};

/// The signs that a delay leaves alone.
pub(crate) static COUNT: Signature = Signature {
    quantity: "log of events over expected, where light changes",
    unit: "",
    must: "change the number of events",
    recording: "slow and fast edges of known contrast",
    needs_light: true,
    measure: |view, _| light::count(view),
};
