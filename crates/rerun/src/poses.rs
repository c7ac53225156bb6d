//! Poses on their way to the viewer while they are found.

use std::path::Path;

use evpose_core::{Micros, SensorSize};
use re_sdk_types::archetypes::{LineStrips2D, Mesh3D, Points2D, Scalars};

use crate::RerunError;
use crate::layout::{self, LANES, SIDES, SURFACE};
use crate::outlet::Outlet;

/// Events, poses, latencies and rates, on their way to a file or a viewer.
///
/// Dropped before [`finish`](Self::finish), a file does not appear.
pub struct PoseRecording {
    outlet: Outlet,
    bones: Vec<[usize; 2]>,
    /// Triangles of the surface.
    faces: Vec<[u32; 3]>,
}

/// What poses are made of.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PoseLayout {
    /// Joints that belong together, as indices.
    pub bones: Vec<[usize; 2]>,
    /// Triangles of a surface, as indices of its vertices; none without a surface.
    pub faces: Vec<[u32; 3]>,
}

/// What the viewer gets at one time.
#[derive(Debug, Clone, Copy)]
pub struct PoseMoment<'a> {
    /// Time of the newest event.
    pub t: Micros,
    /// Middles of the pixels of OFF and of ON events, in pixels.
    pub events_px: [&'a [[f32; 2]]; 2],
    /// Events a second, OFF and ON.
    pub events_per_s: [f64; 2],
    /// Poses of the network, and those between.
    pub poses: [PoseFigures<'a>; 2],
    /// Vertices of the surface: pixels to the right, down, and away from the camera.
    pub surface: Option<&'a [[f32; 3]]>,
}

/// The newest pose of an origin, and how it does.
#[derive(Debug, Clone, Copy, Default)]
pub struct PoseFigures<'a> {
    /// Joints in pixels, none that is not known; empty where there is no pose.
    pub joints_px: &'a [Option<[f32; 2]>],
    /// 99 of 100 poses since the moment before were at most so late; none without poses.
    pub p99_ms: Option<f64>,
    /// Poses a second.
    pub per_s: f64,
}

impl PoseRecording {
    /// Begins the file `path`, which appears with [`finish`](Self::finish).
    ///
    /// # Errors
    /// If it cannot be written.
    pub fn create(
        path: &Path,
        name: &str,
        sensor: SensorSize,
        layout: PoseLayout,
    ) -> Result<Self, RerunError> {
        let views = layout::of_poses(!layout.faces.is_empty());
        Self::begin(Outlet::create(path, name, views)?, sensor, layout)
    }

    /// Connects to the viewer at `address`, `HOST:PORT` or a URL; none is the viewer's default.
    ///
    /// # Errors
    /// If the address is none, or nobody answers there.
    pub fn connect(
        address: Option<&str>,
        name: &str,
        sensor: SensorSize,
        layout: PoseLayout,
    ) -> Result<Self, RerunError> {
        let views = layout::of_poses(!layout.faces.is_empty());
        Self::begin(Outlet::connect(address, name, views)?, sensor, layout)
    }

    fn begin(outlet: Outlet, sensor: SensorSize, layout: PoseLayout) -> Result<Self, RerunError> {
        layout::send(&outlet.stream, sensor)?;
        layout::send_lanes(&outlet.stream)?;
        let PoseLayout { bones, faces } = layout;
        Ok(Self { outlet, bones, faces })
    }

    /// Sends what is known now.
    ///
    /// # Errors
    /// If the SDK refuses the data. What goes wrong on the way is told by [`finish`](Self::finish).
    pub fn send(&mut self, moment: &PoseMoment<'_>) -> Result<(), RerunError> {
        self.outlet.set_time(moment.t);
        let stream = &self.outlet.stream;
        for side in &SIDES {
            let of = side.polarity as usize;
            let points = moment.events_px[of].iter().copied();
            stream.log(side.events, &Points2D::update_fields().with_positions(points))?;
            stream.log(side.rate, &Scalars::single(moment.events_per_s[of]))?;
        }
        for (lane, figures) in LANES.iter().zip(&moment.poses) {
            let joint = |index: usize| figures.joints_px.get(index).copied().flatten();
            let bones = self.bones.iter().filter_map(|&[a, b]| Some([joint(a)?, joint(b)?]));
            stream.log(lane.bones, &LineStrips2D::update_fields().with_strips(bones))?;
            if let Some(p99_ms) = figures.p99_ms {
                stream.log(lane.latency, &Scalars::single(p99_ms))?;
            }
            stream.log(lane.poses, &Scalars::single(figures.per_s))?;
        }
        if let Some(vertices) = moment.surface {
            let surface = Mesh3D::new(vertices.iter().copied())
                .with_triangle_indices(self.faces.iter().copied());
            stream.log(SURFACE, &surface)?;
        }
        Ok(())
    }

    /// Waits until everything has arrived; a file gets its name.
    ///
    /// # Errors
    /// If the file could not be written, or the viewer went away.
    pub fn finish(self) -> Result<(), RerunError> {
        self.outlet.finish()
    }
}
