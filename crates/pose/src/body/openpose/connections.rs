//! Connections of candidates: integrals of part-affinity fields along lines between them.

use super::OpenPoseOptions;
use super::model::Limb;
use super::peaks::Peak;
use super::upsampling::FineMap;

/// Two candidates that may be of one person.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Connection {
    /// Index of the limb.
    pub(super) limb: usize,
    /// Indices of the candidates of both parts.
    pub(super) peaks: [usize; 2],
    /// Mean of the field along the line.
    pub(super) score: f32,
}

/// The connections of a limb whose field agrees with the line between two candidates.
pub(super) fn connections(
    (index, limb): (usize, &Limb),
    peaks: &[Vec<Peak>],
    field: &[FineMap; 2],
    options: &OpenPoseOptions,
) -> Vec<Connection> {
    let [from, to] = limb.parts.map(|part| &peaks[part]);
    let mut all = Vec::new();
    // Any two may be one person's: the assembly chooses among all that agree with the field.
    for (a, start) in from.iter().enumerate() {
        for (b, end) in to.iter().enumerate() {
            if let Some(score) = agreement(start, end, field, options) {
                all.push(Connection { limb: index, peaks: [a, b], score });
            }
        }
    }
    all
}

/// Mean of the field along the line, over samples that agree; none unless nearly all do.
fn agreement(
    start: &Peak,
    end: &Peak,
    [field_x, field_y]: &[FineMap; 2],
    options: &OpenPoseOptions,
) -> Option<f32> {
    let line = end.at_px - start.at_px;
    // Two candidates at one place have no direction.
    let direction = line.try_normalize()?;
    // OpenPose's number of samples, which grows with the length of the line.
    let samples = (5.0 * line.abs().max_element()).sqrt().round().clamp(5.0, 25.0) as usize;
    let (mut sum, mut agreeing) = (0.0, 0);
    for k in 0..samples {
        let at = start.at_px + line * (k as f32 / samples as f32);
        let x = (at.x.round() as usize).min(field_x.columns - 1);
        let y = (at.y.round() as usize).min(field_x.rows - 1);
        let along = direction.x * field_x.at(x, y) + direction.y * field_y.at(x, y);
        if along > options.min_field {
            sum += along;
            agreeing += 1;
        }
    }
    // A line that crosses the limb of somebody else agrees with its field in parts only.
    (agreeing as f32 > options.min_agreement * samples as f32).then(|| sum / agreeing as f32)
}
