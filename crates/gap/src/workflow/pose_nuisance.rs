//! Nuisance parameters of a comparison by poses alone: light and texture are synthetic, with
//! another skin, lights, background and arm in every sample.

use super::Nuisance;
use crate::search_spec::SceneSource;

/// Nuisance parameters of poses.
pub static POSE_NUISANCE: Nuisance = Nuisance {
    note: "mode B: poses are known, light and texture are not. Thresholds and everything that texture \
           can do as well are left open; other differences count where they are larger than those \
           between appearances of the scene",
    source: SceneSource::Poses,
    thresholds: "contrast of the texture and thresholds are one thing",
    instead_of_thresholds: "other thresholds explain part of it, and so would another contrast",
    begins_at_rest: false,
    place: "with what light and texture do",
};
