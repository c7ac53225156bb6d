//! What the viewer shows where: names of entities, colours, and the views to begin with.

use evpose_core::{Polarity, SensorSize};
use re_sdk::blueprint::{Blueprint, ContainerLike, Horizontal, Spatial2DView, TimePanel};
use re_sdk::blueprint::{TimeSeriesView, Vertical};
use re_sdk::{RecordingStream, RecordingStreamResult};
use re_sdk_types::archetypes::{Boxes2D, Points2D, SeriesLines};
use re_sdk_types::components::{Color, Radius};

/// The timeline of all data: the sensor's time since the first event of the recording.
pub const TIMELINE: &str = "sensor_time";

pub(crate) const PICTURE: &str = "picture";
const EVENTS: &str = "events";
const SENSOR: &str = "events/sensor";
const RATE: &str = "rate";

/// How large a part of the window pictures get, for one of the curve.
const PICTURES_HEIGHT: f32 = 3.0;

/// One polarity in the viewer.
pub(crate) struct Side {
    pub(crate) polarity: Polarity,
    pub(crate) events: &'static str,
    pub(crate) rate: &'static str,
    name: &'static str,
    rgb: [u8; 3],
}

/// Blue is ON, red is OFF, as in every picture of ours; lighter, since the viewer is dark.
pub(crate) const SIDES: [Side; 2] = [
    Side {
        polarity: Polarity::On,
        events: "events/on",
        rate: "rate/on",
        name: "ON events/s",
        rgb: [80, 150, 255],
    },
    Side {
        polarity: Polarity::Off,
        events: "events/off",
        rate: "rate/off",
        name: "OFF events/s",
        rgb: [240, 90, 90],
    },
];

/// The picture beside the events, their rate below.
pub(crate) fn blueprint() -> Blueprint {
    let picture = Spatial2DView::new("picture").with_origin(PICTURE);
    let events = Spatial2DView::new("events").with_origin(EVENTS);
    let rate = TimeSeriesView::new("events a second").with_origin(RATE);
    let pictures = Horizontal::new([ContainerLike::from(picture), events.into()]);
    let all = Vertical::new([ContainerLike::from(pictures), rate.into()]);
    Blueprint::new(all.with_row_shares([PICTURES_HEIGHT, 1.0]))
        .with_time_panel(TimePanel::new().with_timeline(TIMELINE))
        .with_auto_views(false)
}

/// What does not change with time. Points have their colour from here: it costs nothing per event.
pub(crate) fn send(stream: &RecordingStream, sensor: SensorSize) -> RecordingStreamResult<()> {
    let size = (f32::from(sensor.width), f32::from(sensor.height));
    let border = Boxes2D::from_mins_and_sizes([(0.0, 0.0)], [size])
        .with_colors([Color::from_rgb(128, 128, 128)])
        .with_radii([Radius::new_ui_points(0.5)]);
    stream.log_static(SENSOR, &border)?;
    for side in &SIDES {
        let [r, g, b] = side.rgb;
        let colour = Color::from_rgb(r, g, b);
        let points = Points2D::update_fields()
            .with_colors([colour])
            .with_radii([Radius::new_scene_units(0.5)]);
        stream.log_static(side.events, &points)?;
        let line = SeriesLines::new().with_colors([colour]).with_names([side.name]);
        stream.log_static(side.rate, &line)?;
    }
    Ok(())
}
