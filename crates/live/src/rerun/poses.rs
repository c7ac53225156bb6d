//! Online poses for the viewer.

use std::path::Path;

use evpose_core::{Micros, SensorSize};
use re_sdk_types::archetypes::{LineStrips2D, Mesh3D, Points2D, Scalars};

use crate::rerun::RerunError;
use crate::rerun::layout::{self, MESH, ORIGINS, POLARITIES};
use crate::rerun::output::Output;

/// A recording of events, poses, latencies and rates, to a file or a viewer.
///
/// Dropped before [`finish`](Self::finish), a file does not appear.
pub struct PoseRecording {
    output: Output,
    bones: Vec<[usize; 2]>,
    /// Triangles of the mesh.
    faces: Vec<[u32; 3]>,
}

/// Topology of the poses.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct PoseLayout {
    /// Bones, as pairs of joint indices.
    pub bones: Vec<[usize; 2]>,
    /// Triangles of the mesh, as indices of its vertices; empty without a mesh.
    pub faces: Vec<[u32; 3]>,
}

/// Data of one time stamp.
#[derive(Debug, Clone, Copy)]
pub struct PoseFrame<'a> {
    /// Time of the newest event.
    pub t: Micros,
    /// Pixel centres of OFF and of ON events, in pixels.
    pub events_px: [&'a [[f32; 2]]; 2],
    /// OFF and ON events per second.
    pub events_per_s: [f64; 2],
    /// Inferred and propagated poses.
    pub poses: [PoseStatus<'a>; 2],
    /// Vertices of the mesh: pixels to the right, down, and away from the camera.
    pub mesh_vertices: Option<&'a [[f32; 3]]>,
}

/// The newest pose of an origin, its latency and its rate.
#[derive(Debug, Clone, Copy, Default)]
pub struct PoseStatus<'a> {
    /// Joints in pixels, none for undetected ones; empty without a pose.
    pub joints_px: &'a [Option<[f32; 2]>],
    /// 0.99 quantile of latency since the frame before; none without poses.
    pub p99_ms: Option<f64>,
    /// Poses per second.
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
        let views = layout::pose_views(!layout.faces.is_empty());
        Self::begin(Output::create(path, name, views)?, sensor, layout)
    }

    /// Connects to the viewer at `address`, `HOST:PORT` or a URL; none is the viewer's default.
    ///
    /// # Errors
    /// If the address is malformed, or no viewer answers.
    pub fn connect(
        address: Option<&str>,
        name: &str,
        sensor: SensorSize,
        layout: PoseLayout,
    ) -> Result<Self, RerunError> {
        let views = layout::pose_views(!layout.faces.is_empty());
        Self::begin(Output::connect(address, name, views)?, sensor, layout)
    }

    fn begin(output: Output, sensor: SensorSize, layout: PoseLayout) -> Result<Self, RerunError> {
        layout::send(&output.stream, sensor)?;
        layout::send_origins(&output.stream)?;
        let PoseLayout { bones, faces } = layout;
        Ok(Self { output, bones, faces })
    }

    /// Sends a frame.
    ///
    /// # Errors
    /// If the SDK refuses the data. Errors of the transport are returned by
    /// [`finish`](Self::finish).
    pub fn send(&mut self, frame: &PoseFrame<'_>) -> Result<(), RerunError> {
        self.output.set_time(frame.t);
        let stream = &self.output.stream;
        for paths in &POLARITIES {
            let index = paths.polarity as usize;
            let points = frame.events_px[index].iter().copied();
            stream.log(paths.events, &Points2D::update_fields().with_positions(points))?;
            stream.log(paths.rate, &Scalars::single(frame.events_per_s[index]))?;
        }
        for (origin, status) in ORIGINS.iter().zip(&frame.poses) {
            let joint = |index: usize| status.joints_px.get(index).copied().flatten();
            let bones = self.bones.iter().filter_map(|&[a, b]| Some([joint(a)?, joint(b)?]));
            // Bones are sent even if there are none, or the viewer would go on showing the last
            // pose.
            stream.log(origin.bones, &LineStrips2D::update_fields().with_strips(bones))?;
            // Without a pose there is no latency, which is not one of zero.
            if let Some(p99_ms) = status.p99_ms {
                stream.log(origin.latency, &Scalars::single(p99_ms))?;
            }
            stream.log(origin.poses, &Scalars::single(status.per_s))?;
        }
        if let Some(vertices) = frame.mesh_vertices {
            let mesh = Mesh3D::new(vertices.iter().copied())
                .with_triangle_indices(self.faces.iter().copied());
            stream.log(MESH, &mesh)?;
        }
        Ok(())
    }

    /// Waits until everything has arrived, and gives a file its final name.
    ///
    /// # Errors
    /// If the file could not be written, or the connection was lost.
    pub fn finish(self) -> Result<(), RerunError> {
        self.output.finish()
    }
}
