//! Entity paths, colours, and the initial views.

use evpose_core::{Polarity, SensorSize};
use re_sdk::blueprint::{Blueprint, ContainerLike, Horizontal, Spatial2DView, Spatial3DView};
use re_sdk::blueprint::{TimePanel, TimeSeriesView, Vertical};
use re_sdk::{RecordingStream, RecordingStreamResult};
use re_sdk_types::archetypes::{Boxes2D, LineStrips2D, Points2D, SeriesLines};
use re_sdk_types::components::{Color, Radius};

/// The timeline of all data: the sensor's time since the first event of the recording.
pub const TIMELINE: &str = "sensor_time";

pub(crate) const EVENT_IMAGE: &str = "event_image";
const EVENTS: &str = "events";
const SENSOR: &str = "events/sensor";
const RATE: &str = "rate";
pub(crate) const MESH: &str = "hand";
const LATENCY: &str = "latency";
const POSES: &str = "poses";

/// Height of the 2D and 3D views, relative to that of the plots.
const VIEW_SHARE: f32 = 3.0;

pub(crate) struct PolarityPaths {
    pub(crate) polarity: Polarity,
    pub(crate) events: &'static str,
    pub(crate) rate: &'static str,
    name: &'static str,
    rgb: [u8; 3],
}

/// Blue is ON, red is OFF, as in all our figures; lighter here, since the viewer is dark.
pub(crate) const POLARITIES: [PolarityPaths; 2] = [
    PolarityPaths {
        polarity: Polarity::On,
        events: "events/on",
        rate: "rate/on",
        name: "ON events/s",
        rgb: [80, 150, 255],
    },
    PolarityPaths {
        polarity: Polarity::Off,
        events: "events/off",
        rate: "rate/off",
        name: "OFF events/s",
        rgb: [240, 90, 90],
    },
];

/// Views of a recording: the event image and the events side by side, their rate below.
pub(crate) fn recording_views() -> Blueprint {
    let event_image = Spatial2DView::new("event image").with_origin(EVENT_IMAGE);
    let rate = TimeSeriesView::new("events/s").with_origin(RATE);
    let above = Horizontal::new([ContainerLike::from(event_image), events_view()]);
    blueprint(above.into(), rate.into())
}

/// Views of poses: events with poses over them and the mesh of a hand; latencies and rates below.
pub(crate) fn pose_views(has_mesh: bool) -> Blueprint {
    let above = if has_mesh {
        let mesh = Spatial3DView::new("hand").with_origin(MESH);
        Horizontal::new([events_view(), mesh.into()]).into()
    } else {
        events_view()
    };
    let plots = [
        TimeSeriesView::new("latency, ms").with_origin(LATENCY),
        TimeSeriesView::new("poses/s").with_origin(POSES),
        TimeSeriesView::new("events/s").with_origin(RATE),
    ];
    blueprint(above, Horizontal::new(plots.map(ContainerLike::from)).into())
}

fn events_view() -> ContainerLike {
    Spatial2DView::new("events").with_origin(EVENTS).into()
}

fn blueprint(above: ContainerLike, below: ContainerLike) -> Blueprint {
    Blueprint::new(Vertical::new([above, below]).with_row_shares([VIEW_SHARE, 1.0]))
        .with_time_panel(TimePanel::new().with_timeline(TIMELINE))
        .with_auto_views(false)
}

pub(crate) struct OriginPaths {
    pub(crate) bones: &'static str,
    pub(crate) latency: &'static str,
    pub(crate) poses: &'static str,
    name: &'static str,
    rgb: [u8; 3],
}

/// Inferred and propagated poses, in colours that stand out from those of events.
pub(crate) const ORIGINS: [OriginPaths; 2] = [
    OriginPaths {
        bones: "events/network",
        latency: "latency/network",
        poses: "poses/network",
        name: "network",
        rgb: [255, 160, 60],
    },
    OriginPaths {
        bones: "events/propagated",
        latency: "latency/propagated",
        poses: "poses/propagated",
        name: "propagated",
        rgb: [90, 220, 140],
    },
];

/// Sends the static properties of poses: colours and names of series.
pub(crate) fn send_origins(stream: &RecordingStream) -> RecordingStreamResult<()> {
    for origin in &ORIGINS {
        let [r, g, b] = origin.rgb;
        let colour = Color::from_rgb(r, g, b);
        let bones = LineStrips2D::update_fields()
            .with_colors([colour])
            .with_radii([Radius::new_ui_points(1.5)]);
        stream.log_static(origin.bones, &bones)?;
        for series in [origin.latency, origin.poses] {
            let line = SeriesLines::new().with_colors([colour]).with_names([origin.name]);
            stream.log_static(series, &line)?;
        }
    }
    Ok(())
}

/// Sends the static properties of events: the sensor's border, and colours, which then cost nothing
/// per event.
pub(crate) fn send(stream: &RecordingStream, sensor: SensorSize) -> RecordingStreamResult<()> {
    let size = (f32::from(sensor.width), f32::from(sensor.height));
    let border = Boxes2D::from_mins_and_sizes([(0.0, 0.0)], [size])
        .with_colors([Color::from_rgb(128, 128, 128)])
        .with_radii([Radius::new_ui_points(0.5)]);
    stream.log_static(SENSOR, &border)?;
    for paths in &POLARITIES {
        let [r, g, b] = paths.rgb;
        let colour = Color::from_rgb(r, g, b);
        let points = Points2D::update_fields()
            .with_colors([colour])
            .with_radii([Radius::new_scene_units(0.5)]);
        stream.log_static(paths.events, &points)?;
        let line = SeriesLines::new().with_colors([colour]).with_names([paths.name]);
        stream.log_static(paths.rate, &line)?;
    }
    Ok(())
}
