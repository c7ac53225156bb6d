//! Evaluation protocol of bodies: the instants compared, and the treatment of missing joints.

use serde::{Deserialize, Serialize};

use crate::PoseError;

/// Limit of instants, above those of any sequence: nine hours at 1 kHz.
const MAX_INSTANTS: f64 = 33_554_432.0;

/// Treatment of joints that were not detected or not labelled.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case", deny_unknown_fields)]
pub enum MissingJoints {
    /// A labelled joint that was not detected is wrong for the PCK; distances leave it out and
    /// count it. Joints without a label are not evaluated. Interpolation needs the joint at both
    /// instants.
    #[default]
    Counted,
    /// As in the published program, which knows positions only. A joint that was not detected lies
    /// at minus the size of the image, which its decoder makes of -1, and one that is not labelled
    /// at (-1, -1); interpolation runs through those places. The PCK leaves out labels with a
    /// column of exactly -1, the MPJPE labels without two positive coordinates and predictions with
    /// one that is exactly 0, the RMSE nothing. A sequence without any prediction is left out.
    Published {
        /// Width of the image.
        width_px: f32,
        /// Height of the image.
        height_px: f32,
    },
}

/// Instants of a sequence that are compared.
///
/// # Model
/// A sequence begins at 0 and ends at `T`, one second after its last label; its first label holds
/// before it and its last one after it. Predictions in `skipped_share · T < t < T` count, whichever
/// order they come in. Labels are interpolated linearly at their instants (`raw`), and both at the
/// instants `i / rate_hz` from 0 to before `T` (`resampled`), where the first prediction holds
/// before it and the last one after it.
///
/// # Source
/// hpe-core's `evaluate_hpe`.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct BodyProtocol {
    /// Instants a second at which both are resampled.
    pub rate_hz: f64,
    /// Share of a sequence at its beginning whose predictions do not count.
    pub skipped_share: f64,
    /// Treatment of missing joints.
    pub missing: MissingJoints,
}

impl Default for BodyProtocol {
    fn default() -> Self {
        Self { rate_hz: 1_000.0, skipped_share: 0.1, missing: MissingJoints::Counted }
    }
}

impl BodyProtocol {
    /// As in the published program, for images of this size.
    pub fn published(width_px: f32, height_px: f32) -> Self {
        Self { missing: MissingJoints::Published { width_px, height_px }, ..Self::default() }
    }

    /// The instants of a sequence that ends at `end_s`, in seconds.
    ///
    /// # Errors
    /// If a setting is out of its range, or the instants would be too many to be a sequence's.
    pub(super) fn instants(
        &self,
        end_s: f64,
    ) -> Result<impl Iterator<Item = f64> + use<>, PoseError> {
        let (rate_hz, share) = (self.rate_hz, self.skipped_share);
        PoseError::unless(rate_hz > 0.0 && rate_hz.is_finite(), "rate_hz", rate_hz, "above 0")?;
        let is_share = (0.0..1.0).contains(&share);
        PoseError::unless(is_share, "skipped_share", share, "from 0 to below 1")?;
        // As NumPy's `arange`, rounding included.
        let step_s = 1.0 / self.rate_hz;
        let count = (end_s / step_s).ceil();
        PoseError::unless(
            (0.0..=MAX_INSTANTS).contains(&count),
            "end of the sequence in seconds",
            end_s,
            "that of nine hours at 1 kHz at most",
        )?;
        // Instants are multiples, not sums, so that rounding does not add up.
        Ok((0..count as u64).map(move |i| i as f64 * step_s))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn instants_are_evenly_spaced_and_end_before_the_end() {
        let at = |rate_hz, end_s| {
            let protocol = BodyProtocol { rate_hz, ..BodyProtocol::default() };
            protocol.instants(end_s).unwrap().collect::<Vec<_>>()
        };
        assert_eq!(at(4.0, 1.0), [0.0, 0.25, 0.5, 0.75]);
        assert_eq!(at(4.0, 1.01), [0.0, 0.25, 0.5, 0.75, 1.0]);
        assert_eq!(at(1_000.0, 2.5).len(), 2_500);
    }

    #[test]
    fn settings_without_sense_are_refused() {
        let fails = |rate_hz, skipped_share, end_s| {
            let protocol = BodyProtocol { rate_hz, skipped_share, ..BodyProtocol::default() };
            protocol.instants(end_s).is_err()
        };
        assert!(!fails(1_000.0, 0.0, 30_000.0));
        assert!(
            fails(0.0, 0.1, 1.0) && fails(f64::NAN, 0.1, 1.0) && fails(f64::INFINITY, 0.1, 1.0)
        );
        assert!(fails(1e3, 1.0, 1.0) && fails(1e3, -0.1, 1.0) && fails(1e3, f64::NAN, 1.0));
        assert!(fails(1e3, 0.1, 1.7e9), "times of day are no sequence's");
    }
}
