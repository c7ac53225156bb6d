//! What the viewer shows where: names of entities, colours, and the views to begin with.

use evpose_core::{Polarity, SensorSize};
use re_sdk::blueprint::{Blueprint, ContainerLike, Horizontal, Spatial2DView, Spatial3DView};
use re_sdk::blueprint::{TimePanel, TimeSeriesView, Vertical};
use re_sdk::{RecordingStream, RecordingStreamResult};
use re_sdk_types::archetypes::{Boxes2D, LineStrips2D, Points2D, SeriesLines};
use re_sdk_types::components::{Color, Radius};

/// The timeline of all data: the sensor's time since the first event of the recording.
pub const TIMELINE: &str = "sensor_time";

pub(crate) const PICTURE: &str = "picture";
const EVENTS: &str = "events";
const SENSOR: &str = "events/sensor";
const RATE: &str = "rate";
pub(crate) const SURFACE: &str = "hand";
const LATENCY: &str = "latency";
const POSES: &str = "poses";

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
pub(crate) fn of_recordings() -> Blueprint {
    let picture = Spatial2DView::new("picture").with_origin(PICTURE);
    let rate = TimeSeriesView::new("events a second").with_origin(RATE);
    let pictures = Horizontal::new([ContainerLike::from(picture), events_view()]);
    blueprint(pictures.into(), rate.into())
}

/// Events with poses over them, beside them the surface of a hand; below, figures.
pub(crate) fn of_poses(has_surface: bool) -> Blueprint {
    let above = if has_surface {
        let surface = Spatial3DView::new("hand").with_origin(SURFACE);
        Horizontal::new([events_view(), surface.into()]).into()
    } else {
        events_view()
    };
    let figures = [
        TimeSeriesView::new("latency, ms").with_origin(LATENCY),
        TimeSeriesView::new("poses a second").with_origin(POSES),
        TimeSeriesView::new("events a second").with_origin(RATE),
    ];
    blueprint(above, Horizontal::new(figures.map(ContainerLike::from)).into())
}

fn events_view() -> ContainerLike {
    Spatial2DView::new("events").with_origin(EVENTS).into()
}

fn blueprint(above: ContainerLike, below: ContainerLike) -> Blueprint {
    Blueprint::new(Vertical::new([above, below]).with_row_shares([PICTURES_HEIGHT, 1.0]))
        .with_time_panel(TimePanel::new().with_timeline(TIMELINE))
        .with_auto_views(false)
}

/// One origin of poses in the viewer.
pub(crate) struct Lane {
    pub(crate) bones: &'static str,
    pub(crate) latency: &'static str,
    pub(crate) poses: &'static str,
    name: &'static str,
    rgb: [u8; 3],
}

/// Poses of the network, and those between them, in the colours of the page.
pub(crate) const LANES: [Lane; 2] = [
    Lane {
        bones: "events/network",
        latency: "latency/network",
        poses: "poses/network",
        name: "network",
        rgb: [255, 160, 60],
    },
    Lane {
        bones: "events/between",
        latency: "latency/between",
        poses: "poses/between",
        name: "between",
        rgb: [90, 220, 140],
    },
];

/// What does not change with time of poses.
pub(crate) fn send_lanes(stream: &RecordingStream) -> RecordingStreamResult<()> {
    for lane in &LANES {
        let [r, g, b] = lane.rgb;
        let colour = Color::from_rgb(r, g, b);
        let bones = LineStrips2D::update_fields()
            .with_colors([colour])
            .with_radii([Radius::new_ui_points(1.5)]);
        stream.log_static(lane.bones, &bones)?;
        for series in [lane.latency, lane.poses] {
            let line = SeriesLines::new().with_colors([colour]).with_names([lane.name]);
            stream.log_static(series, &line)?;
        }
    }
    Ok(())
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
