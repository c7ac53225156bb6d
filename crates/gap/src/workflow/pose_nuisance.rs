//! Nuisance parameters of a comparison by poses alone: light and texture are synthetic, with
//! another skin, lights, background and arm in every sample.

use super::Nuisance;

/// Nuisance parameters of poses.
pub static POSE_NUISANCE: Nuisance = Nuisance {
    note: "mode B: poses are known, light and texture are not. Thresholds and everything that texture \
           can do as well are left open; other differences count where they are larger than those \
           between appearances of the scene",
    degenerate: &[
        ("tone_curve", "contrast of the texture and tone curve are one thing"),
        ("quantisation", "steps of the tone curve and texture are one thing"),
        ("dark_current", "dark current and faint texture in the dark are one thing"),
        ("veiling_glare", "glare and faint texture are one thing"),
        ("vignetting", "vignetting and fall-off of the light are one thing"),
        ("psf_blur", "blur and coarse texture are one thing"),
        ("lateral_coupling", "coupling of pixels and fine texture are one thing"),
        ("reset_overshoot", "events lost on an edge and lower contrast are one thing"),
    ],
    thresholds: "contrast of the texture and thresholds are one thing",
    instead_of_thresholds: "other thresholds explain part of it, and so would another contrast",
    begins_at_rest: false,
    place: "with what light and texture do",
};
