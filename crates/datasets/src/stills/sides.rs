//! Persons whose left and right seem to be exchanged.

use super::{Photograph, SkipReason};
use crate::check::{CheckOptions, LabelFault, LabelTrack, TrackFrame, check_labels};

/// Marks persons as not to be cut out whom the checks of labels suspect.
pub(crate) fn leave_out_exchanged(photographs: &mut [Photograph]) {
    for photograph in photographs {
        for person in photograph.persons.iter_mut().flatten() {
            let frame = TrackFrame { name: String::new(), t_s: None, joints: person.joints_px() };
            let track = LabelTrack { name: String::new(), frames: vec![frame], image_size: None };
            let report = check_labels(&[track], &CheckOptions::default());
            let is_exchanged =
                |fault: &LabelFault| matches!(fault, LabelFault::SwappedSides { .. });
            if person.fault.is_none() && report.findings.iter().any(|f| is_exchanged(&f.fault)) {
                person.fault = Some(SkipReason::SidesExchanged);
            }
        }
    }
}
