//! The steps that take events away before a network, for messages.

use evpose_camera::ViewAdaptor;
use evpose_pose::stream::RemainingEvents;

pub(crate) fn pooled(adaptor: &ViewAdaptor, events: u64) -> RemainingEvents {
    let (sensor, view) = (adaptor.sensor(), adaptor.view().sensor);
    RemainingEvents {
        step: format!("in the network's view of {view}, where ON and OFF of a pixel cancel"),
        events,
        // Of a coarser sensor, each event is one of several pixels of the view.
        edge_share: (view.pixels() as f64 / sensor.pixels() as f64).min(1.0),
        advice: "see whether the polarities are noise (`evpose view`), and whether --camera is that of the \
                 recording",
    }
}

/// The events that a noise filter has left.
pub(crate) fn denoised(events: u64) -> RemainingEvents {
    RemainingEvents {
        step: "after the noise filter, to which an event without neighbours is noise".to_owned(),
        events,
        edge_share: 1.0,
        advice: "record edges that fire in company: nearer, in more light, or with lower thresholds",
    }
}
