//! Nuisance parameters of a comparison with the camera's own frames, which sample the light
//! coarsely, through the same lens, with a response curve that may be another than the assumed one.

use super::Nuisance;

/// Nuisance parameters of frames.
pub static FRAME_NUISANCE: Nuisance = Nuisance {
    note: "the light is that of the camera's own frames: an exposure long, in steps, a few dozen a \
           second. What happens between frames is left open, as are thresholds and everything that \
           frames share or hide; other differences count where they are larger than those between \
           light that gives such frames",
    degenerate: &[
        (
            "tone_curve",
            "the response curve of the frames is not known to be the one it is taken for",
        ),
        ("quantisation", "frames have steps themselves"),
        ("dark_current", "the black of the frames is not known"),
        ("veiling_glare", "frames have the glare of the same lens"),
        ("vignetting", "frames have the fall-off of the same lens"),
        ("psf_blur", "frames have the blur of the same lens, and of motion"),
        ("lens_distortion", "frames have the distortion of the same lens"),
        ("lateral_coupling", "coupling of pixels and blur of the frames are one thing"),
        ("reset_overshoot", "events lost on an edge and blur of the frames are one thing"),
    ],
    thresholds: "an exponent of the response curve and thresholds are one thing",
    instead_of_thresholds: "other thresholds explain part of it, and so would another exponent of the \
                            frames' response curve",
    begins_at_rest: true,
    place: "with what happens between frames",
};
