//! Effects with which the search does something special. All others it treats as
//! [`PLAIN`] says.

use super::strict_limit::{JITTER_LACKS, LATENCY_LACKS, NOISE_LACKS, OFFSET_LACKS};
use super::{Onset, PLAIN, SceneSource, SearchSpec, SecondStrength, StageRole, Substeps};
use crate::common_parameter::CommonParameter;
use crate::goodness::signature;
use crate::recording_mark::RecordingMark;

/// In the order of the signal.
pub(super) static EFFECTS: &[SearchSpec] = &[
    SearchSpec {
        effect: "lamp_flicker",
        shows: &[&signature::LAMP_LINE],
        choices: &[("memory", &["now", "trough"])],
        substeps: Some(Substeps { screened: 2.0, fitted: 4.0 }),
        onset: Onset::Sudden,
        mark: Some(RecordingMark::Lamp),
        // Events lag behind the wave of the light.
        rough: &["phase_turns"],
        ..PLAIN
    },
    SearchSpec {
        effect: "lens_distortion",
        shows: &[&signature::RADIAL_SHIFT],
        // Of a small sensor with a long lens, in units of its focal length, a corner is near.
        reach: &[("k1", (-6.0, 6.0))],
        hidden_by: &[(SceneSource::Frames, "frames have the distortion of the same lens")],
        ..PLAIN
    },
    SearchSpec {
        effect: "psf_blur",
        shows: &[&signature::FINE_COUNT],
        hidden_by: &[
            (SceneSource::Frames, "frames have the blur of the same lens, and of motion"),
            (SceneSource::Poses, "blur and coarse texture are one thing"),
        ],
        ..PLAIN
    },
    SearchSpec {
        effect: "veiling_glare",
        shows: &[&signature::DARK_COUNT],
        hidden_by: &[
            (SceneSource::Frames, "frames have the glare of the same lens"),
            (SceneSource::Poses, "glare and faint texture are one thing"),
        ],
        ..PLAIN
    },
    SearchSpec {
        effect: "vignetting",
        hidden_by: &[
            (SceneSource::Frames, "frames have the fall-off of the same lens"),
            (SceneSource::Poses, "vignetting and fall-off of the light are one thing"),
        ],
        ..PLAIN
    },
    SearchSpec {
        effect: "tone_curve",
        hidden_by: &[
            (
                SceneSource::Frames,
                "the response curve of the frames is not known to be the one it is taken for",
            ),
            (SceneSource::Poses, "contrast of the texture and tone curve are one thing"),
        ],
        ..PLAIN
    },
    SearchSpec {
        effect: "quantisation",
        mark: Some(RecordingMark::LightSteps),
        reach: &[("levels", (8.0, 1023.0))],
        hidden_by: &[
            (SceneSource::Frames, "frames have steps themselves"),
            (SceneSource::Poses, "steps of the tone curve and texture are one thing"),
        ],
        ..PLAIN
    },
    SearchSpec {
        effect: "dark_current",
        shows: &[&signature::DARK_COUNT],
        // Stray light that is even, and offsets of other programs, are one thing with it.
        reach: &[("current", (1e-5, 0.4))],
        hidden_by: &[
            (SceneSource::Frames, "the black of the frames is not known"),
            (SceneSource::Poses, "dark current and faint texture in the dark are one thing"),
        ],
        ..PLAIN
    },
    SearchSpec {
        effect: "logarithmic",
        role: StageRole::EveryModel,
        common: &[(CommonParameter::DarkOffset, "dark_offset")],
        ..PLAIN
    },
    SearchSpec {
        effect: "photoreceptor_noise",
        shows: &[&signature::ALTERNATION],
        lacks: &NOISE_LACKS,
        substeps: Some(Substeps { screened: 2.0, fitted: 8.0 }),
        mark: Some(RecordingMark::Alternation),
        resembles: &["lamp_flicker", "brownian_passage"],
        ..PLAIN
    },
    SearchSpec {
        effect: "lateral_coupling",
        shows: &[&signature::FINE_COUNT],
        second_strength: Some(SecondStrength { param: "surround", needs: &[] }),
        hidden_by: &[
            (SceneSource::Frames, "coupling of pixels and blur of the frames are one thing"),
            (SceneSource::Poses, "coupling of pixels and fine texture are one thing"),
        ],
        ..PLAIN
    },
    SearchSpec {
        effect: "level_crossing",
        role: StageRole::EveryModel,
        common: &[
            (CommonParameter::ThresholdOn, "threshold_on"),
            (CommonParameter::ThresholdOff, "threshold_off"),
        ],
        ..PLAIN
    },
    SearchSpec {
        effect: "threshold_mismatch",
        shows: &[&signature::FIXED_PATTERN],
        common: &[(CommonParameter::ThresholdMismatch, "sigma")],
        dither: &[("sigma", 0.004)],
        ..PLAIN
    },
    SearchSpec {
        effect: "threshold_temporal_noise",
        shows: &[&signature::STEP_SPREAD],
        lacks: &NOISE_LACKS,
        choices: &[("redraw", &["event", "exposure"])],
        usual: &[("redraw", "event")],
        dither: &[("sigma", 0.004)],
        ..PLAIN
    },
    SearchSpec {
        effect: "leak_on",
        shows: &[&signature::REST_ON],
        choices: &[("phase", &["random", "aligned"])],
        is_slow: true,
        mark: Some(RecordingMark::RegularOn),
        resembles: &["parasitic_photo_leak"],
        ..PLAIN
    },
    SearchSpec {
        effect: "parasitic_photo_leak",
        shows: &[&signature::REST_ON_IN_LIGHT],
        choices: &[("phase", &["random", "aligned"])],
        // Programs leak at some hertz in light that is a fraction of white.
        reach: &[("hz_per_white", (1e-3, 16.0))],
        ..PLAIN
    },
    SearchSpec {
        effect: "refractory",
        shows: &[&signature::SHORT_INTERVALS],
        hides_in_readout: Some("period_us"),
        choices: &[("mode", &["hold", "defer", "drop"])],
        mark: Some(RecordingMark::DeadTime),
        ..PLAIN
    },
    SearchSpec {
        effect: "reset_overshoot",
        shows: &[&signature::STEP_ASYMMETRY, &signature::FAST_STEPS],
        hides_in_readout: Some("delay_us"),
        hidden_by: &[
            (SceneSource::Frames, "events lost on an edge and blur of the frames are one thing"),
            (SceneSource::Poses, "events lost on an edge and lower contrast are one thing"),
        ],
        ..PLAIN
    },
    SearchSpec {
        effect: "dead_pixels",
        shows: &[&signature::SILENT_PIXELS],
        mark: Some(RecordingMark::SilentPixels),
        reach: &[("fraction", (1e-6, 0.3))],
        ..PLAIN
    },
    SearchSpec {
        effect: "uniform_noise",
        role: StageRole::EveryModel,
        common: &[(CommonParameter::NoiseOn, "on_hz"), (CommonParameter::NoiseOff, "off_hz")],
        mark: Some(RecordingMark::RandomRest),
        resembles: &["shot_noise_poisson"],
        dither: &[("on_hz", 0.05), ("off_hz", 0.05)],
        ..PLAIN
    },
    SearchSpec {
        effect: "arbiter",
        shows: &[&signature::BUSY_LAG, &signature::ROW_ORDER],
        choices: &[("order", &["arrival", "rows"]), ("waiting", &["reset", "free"])],
        usual: &[("order", "rows"), ("waiting", "free")],
        // A time per row makes sense only if the bus serves row by row.
        second_strength: Some(SecondStrength { param: "row_ns", needs: &[("order", "rows")] }),
        per_sensor: &["rate_hz", "row_ns"],
        // The queue grows evenly with the time per event.
        onset: Onset::Even,
        mark: Some(RecordingMark::Bus),
        // Stamps are whole microseconds.
        rough: &["rate_hz", "row_ns"],
        ..PLAIN
    },
    SearchSpec {
        effect: "scanned_readout",
        shows: &[&signature::SCAN_LOCK],
        choices: &[("waiting", &["reset", "latched", "kept"])],
        usual: &[("waiting", "latched")],
        mark: Some(RecordingMark::Scan),
        ..PLAIN
    },
    SearchSpec {
        effect: "event_rate_control",
        shows: &[&signature::BUSY_COUNT],
        choices: &[("drop", &["random", "late"])],
        per_sensor: &["rate_hz"],
        mark: Some(RecordingMark::RateCeiling),
        resembles: &["arbiter"],
        ..PLAIN
    },
    SearchSpec {
        effect: "timestamp_jitter",
        shows: &[&signature::LAG_SPREAD],
        lacks: &JITTER_LACKS,
        hides_in_readout: Some("sigma_us"),
        choices: &[("side", &["either", "late"])],
        usual: &[("side", "either")],
        reach: &[("sigma_us", (0.1, 1e4))],
        dither: &[("sigma_us", 100.0)],
        ..PLAIN
    },
    SearchSpec {
        effect: "clock_offset_drift",
        shows: &[&signature::LAG_GROWTH],
        common_lacks: &[(CommonParameter::ClockOffset, OFFSET_LACKS)],
        role: StageRole::EveryModel,
        common: &[(CommonParameter::ClockOffset, "offset_us")],
        own: Some("drift_ppm"),
        // Frames that are played at another rate than the stated one run away by percents.
        reach: &[("drift_ppm", (-5e4, 5e4))],
        ..PLAIN
    },
    SearchSpec {
        effect: "timestamp_quantisation",
        shows: &[&signature::STAMP_GRID],
        choices: &[("rounding", &["up", "down"])],
        mark: Some(RecordingMark::TimeGrid),
        resembles: &["frame_grid"],
        ..PLAIN
    },
    SearchSpec {
        effect: "photoreceptor_lowpass",
        shows: &[&signature::DARK_LAG, &signature::FAST_COUNT],
        choices: &[("signal", &["small", "large"])],
        ..PLAIN
    },
    SearchSpec {
        effect: "adaptive_highpass",
        shows: &[&signature::FAST_COUNT],
        is_slow: true,
        ..PLAIN
    },
    SearchSpec {
        effect: "source_follower",
        shows: &[&signature::LAG, &signature::FAST_COUNT],
        ..PLAIN
    },
    SearchSpec { effect: "hysteresis", shows: &[&signature::STEP_ASYMMETRY], ..PLAIN },
    SearchSpec { effect: "shot_noise_poisson", shows: &[&signature::REST_IN_DARK], ..PLAIN },
    SearchSpec { effect: "exposure_blur", role: StageRole::Scene, ..PLAIN },
    SearchSpec {
        effect: "pixel_latency",
        shows: &[&signature::LAG],
        lacks: &LATENCY_LACKS,
        hides_in_readout: Some("delay_us"),
        same_as: Some(CommonParameter::ClockOffset),
        ..PLAIN
    },
    SearchSpec {
        effect: "hot_pixels",
        shows: &[&signature::HOT_PIXELS],
        mark: Some(RecordingMark::HotPixels),
        ..PLAIN
    },
    SearchSpec {
        effect: "formula",
        hidden_by: &[
            (SceneSource::Frames, "a formula could follow the errors of the frames"),
            (SceneSource::Poses, "a formula could follow the errors of the appearance"),
        ],
        ..PLAIN
    },
];
