//! Output to the Rerun viewer, in builds with its feature.

use std::sync::Arc;

use evpose_core::SensorSize;
use evpose_live::page::HandMesh;
use evpose_live::sink::Sinks;
use evpose_live::{Meter, Observer};

#[cfg(feature = "rerun")]
pub(super) use sdk::Viewer;

#[cfg(not(feature = "rerun"))]
pub(super) use missing::Viewer;

/// The pipeline that a viewer shows.
#[cfg_attr(not(feature = "rerun"), allow(dead_code, reason = "used by the viewer alone"))]
pub(super) struct Pipeline<'a> {
    pub(super) name: &'a str,
    pub(super) sensor: SensorSize,
    pub(super) mesh: Option<HandMesh>,
    pub(super) meter: Arc<Meter>,
    pub(super) observers: &'a mut Vec<Observer>,
    pub(super) sinks: &'a mut Sinks,
}

#[cfg(feature = "rerun")]
mod sdk {
    use std::io;
    use std::path::Path;
    use std::sync::atomic::{AtomicBool, Ordering};
    use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
    use std::thread::JoinHandle;
    use std::time::{Duration, Instant};

    use anyhow::Result;
    use evpose_core::{EventStream, Micros, Polarity};
    use evpose_live::page::HandMesh;
    use evpose_live::rerun::{PoseFrame, PoseLayout, PoseRecording, PoseStatus, RerunError};
    use evpose_live::sink::Sink;
    use evpose_live::{LatencyBaseline, LivePose, Meter, Observer, PoseOrigin};
    use evpose_pose::body::LIMBS;
    use evpose_pose::{HAND_BONES, PoseEstimate};

    use super::Pipeline;

    /// Interval of frames: 30 per second, as the viewer draws them.
    const FRAME: Duration = Duration::from_millis(33);
    /// Upper bound of the points of each polarity in a frame: the newest events.
    const MAX_POINTS: usize = 50_000;

    /// A viewer, or its file, and the thread that sends to it.
    pub(in super::super) struct Viewer {
        shared: Arc<Shared>,
        thread: JoinHandle<Result<(), RerunError>>,
    }

    #[derive(Default)]
    struct Shared {
        input: Mutex<FrameInput>,
        is_over: AtomicBool,
    }

    /// Events and poses since the last frame.
    #[derive(Default)]
    struct FrameInput {
        events: [Points; 2],
        t: Option<Micros>,
        poses: [Option<LivePose>; 2],
    }

    /// The newest events of a polarity.
    #[derive(Default)]
    struct Points {
        px: Vec<[f32; 2]>,
        count: usize,
    }

    impl Points {
        fn push(&mut self, at: [f32; 2]) {
            // This is a ring: beyond the bound, the oldest point gives way.
            match self.px.get_mut(self.count % MAX_POINTS) {
                Some(old) if self.count >= MAX_POINTS => *old = at,
                _ => self.px.push(at),
            }
            self.count += 1;
        }

        fn clear(&mut self) {
            self.px.clear();
            self.count = 0;
        }
    }

    impl Shared {
        fn input(&self) -> MutexGuard<'_, FrameInput> {
            self.input.lock().unwrap_or_else(PoisonError::into_inner)
        }
    }

    impl Viewer {
        /// Sends to the viewer at `place`, or to a file if that ends in `.rrd`.
        pub(in super::super) fn open(place: Option<&str>, pipeline: Pipeline<'_>) -> Result<Self> {
            let Pipeline { name, sensor, mesh, meter, observers, sinks } = pipeline;
            let layout = match &mesh {
                None => PoseLayout { bones: LIMBS.to_vec(), faces: Vec::new() },
                Some(mesh) => PoseLayout { bones: HAND_BONES.to_vec(), faces: mesh.faces.clone() },
            };
            let recording = match place.filter(|place| place.ends_with(".rrd")) {
                Some(file) => PoseRecording::create(Path::new(file), name, sensor, layout)?,
                None => PoseRecording::connect(place, name, sensor, layout)?,
            };
            // The pipeline must not wait for a viewer: a thread sends what is newest.
            let shared = Arc::<Shared>::default();
            observers.push(event_observer(shared.clone()));
            sinks.add(ViewerSink(shared.clone()));
            let sender = Sender { shared: shared.clone(), recording, mesh, meter };
            Ok(Self { shared, thread: std::thread::spawn(move || sender.work()) })
        }

        /// Waits until everything is sent; a file gets its final name.
        pub(in super::super) fn finish(self) -> Result<()> {
            self.shared.is_over.store(true, Ordering::Relaxed);
            let sent = self.thread.join();
            Ok(sent.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?)
        }
    }

    fn event_observer(shared: Arc<Shared>) -> Observer {
        Arc::new(move |events: &EventStream| {
            let mut input = shared.input();
            let places = events.x().iter().zip(events.y()).zip(events.polarity());
            for ((&x, &y), &polarity) in places {
                // Pixel 0 reaches from 0 to 1.
                let at = [f32::from(x) + 0.5, f32::from(y) + 0.5];
                input.events[polarity as usize].push(at);
            }
            input.t = events.t().last().copied().or(input.t);
        })
    }

    /// A sink that keeps the newest pose of each origin.
    struct ViewerSink(Arc<Shared>);

    impl Sink for ViewerSink {
        fn name(&self) -> String {
            "Rerun viewer".to_owned()
        }

        fn write(&mut self, pose: &LivePose) -> io::Result<()> {
            let origin =
                usize::from(matches!(pose.origin, PoseOrigin::Propagated | PoseOrigin::Held));
            self.0.input().poses[origin] = Some(pose.clone());
            Ok(())
        }
    }

    /// The thread that sends frames.
    struct Sender {
        shared: Arc<Shared>,
        recording: PoseRecording,
        mesh: Option<HandMesh>,
        meter: Arc<Meter>,
    }

    impl Sender {
        fn work(mut self) -> Result<(), RerunError> {
            let mut frame = FrameInput::default();
            let mut latencies = LatencyBaseline::default();
            let mut before = Instant::now();
            loop {
                // Read first, so that what came before the end is sent, too.
                let is_over = self.shared.is_over.load(Ordering::Relaxed);
                std::mem::swap(&mut *self.shared.input(), &mut frame);
                let passed_s = before.elapsed().as_secs_f64().max(1e-3);
                before = Instant::now();
                self.send(&frame, passed_s, &mut latencies)?;
                frame.events.iter_mut().for_each(Points::clear);
                (frame.t, frame.poses) = (None, [None, None]);
                if is_over {
                    return self.recording.finish();
                }
                std::thread::sleep(FRAME.saturating_sub(before.elapsed()));
            }
        }

        fn send(
            &mut self,
            frame: &FrameInput,
            passed_s: f64,
            latencies: &mut LatencyBaseline,
        ) -> Result<(), RerunError> {
            // A frame may hold events alone, or poses alone.
            let newest = frame.poses.iter().flatten().map(|pose| pose.t).max();
            let Some(t) = frame.t.max(newest) else { return Ok(()) };
            let latencies_ms = self.meter.latencies_since(latencies);
            let joints = [0, 1].map(|origin| joints_px(frame.poses[origin].as_ref()));
            let status = [0, 1].map(|origin| PoseStatus {
                joints_px: &joints[origin],
                // A quantile of no latency is unknown, not zero.
                p99_ms: (latencies_ms[origin].poses > 0).then_some(latencies_ms[origin].p99_ms),
                per_s: latencies_ms[origin].poses as f64 / passed_s,
            });
            let mesh_vertices = self.mesh_vertices(frame);
            let points = |polarity: Polarity| &frame.events[polarity as usize];
            let (off, on) = (points(Polarity::Off), points(Polarity::On));
            self.recording.send(&PoseFrame {
                t,
                events_px: [&off.px, &on.px],
                events_per_s: [off, on].map(|points| points.count as f64 / passed_s),
                poses: status,
                mesh_vertices: mesh_vertices.as_deref(),
            })
        }

        fn mesh_vertices(&mut self, frame: &FrameInput) -> Option<Vec<[f32; 3]>> {
            // Propagated poses are later than those of the network, where there are any.
            let newest = frame.poses[1].as_ref().or(frame.poses[0].as_ref())?;
            let PoseEstimate::Hand { params, .. } = &newest.pose else { return None };
            let vertices = (self.mesh.as_mut()?.vertices)(params)?;
            vertices
                .iter()
                .all(|vertex| vertex.is_finite())
                .then(|| vertices.iter().map(|vertex| vertex.to_array()).collect())
        }
    }

    fn joints_px(pose: Option<&LivePose>) -> Vec<Option<[f32; 2]>> {
        let joints: &[_] = match pose.map(|pose| &pose.pose) {
            // What is drawn is bones, which other tasks have none of.
            None | Some(PoseEstimate::Values { .. }) => &[],
            Some(PoseEstimate::Body { joints_px, .. }) => joints_px,
            Some(PoseEstimate::Hand { points, .. }) => &points.image_px,
        };
        joints.iter().map(|at| at.filter(|at| at.is_finite()).map(|at| at.to_array())).collect()
    }
}

#[cfg(not(feature = "rerun"))]
mod missing {
    use anyhow::{Result, bail};

    use super::Pipeline;

    /// A viewer that cannot be opened in this build.
    pub(in super::super) struct Viewer;

    impl Viewer {
        pub(in super::super) fn open(_place: Option<&str>, _watched: Pipeline<'_>) -> Result<Self> {
            bail!(
                "--rerun: this build has no support for the Rerun viewer: build it with `--features rerun`, or use \
                 the web page of --serve"
            )
        }

        pub(in super::super) fn finish(self) -> Result<()> {
            Ok(())
        }
    }
}
