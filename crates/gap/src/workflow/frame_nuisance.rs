//! Nuisance parameters of a comparison with the camera's own frames, which sample the light
//! coarsely, through the same lens, with a response curve that may be another than the assumed one.

use super::Nuisance;
use crate::search_spec::SceneSource;

/// Nuisance parameters of frames.
pub static FRAME_NUISANCE: Nuisance = Nuisance {
    note: "the light is that of the camera's own frames: an exposure long, in steps, a few dozen a \
           second. What happens between frames is left open, as are thresholds and everything that \
           frames share or hide; other differences count where they are larger than those between \
           light that gives such frames",
    source: SceneSource::Frames,
    thresholds: "an exponent of the response curve and thresholds are one thing",
    instead_of_thresholds: "other thresholds explain part of it, and so would another exponent of the \
                            frames' response curve",
    begins_at_rest: true,
    place: "with what happens between frames",
};
