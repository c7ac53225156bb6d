//! Events, poses and figures for the Rerun viewer while they come, where the build has its feature.

use std::sync::Arc;

use evpose_core::SensorSize;
use evpose_live::page::HandMesh;
use evpose_live::sink::Sinks;
use evpose_live::{Meter, Observer};

#[cfg(feature = "rerun")]
pub(super) use sdk::Viewer;

#[cfg(not(feature = "rerun"))]
pub(super) use missing::Viewer;

/// A pipeline to be watched.
#[cfg_attr(not(feature = "rerun"), allow(dead_code, reason = "nobody watches"))]
pub(super) struct Watched<'a> {
    pub(super) name: &'a str,
    pub(super) sensor: SensorSize,
    /// Of hands.
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
    use evpose_live::sink::Sink;
    use evpose_live::{Latencies, LivePose, Meter, Observer, Origin};
    use evpose_pose::HAND_BONES;
    use evpose_pose::PoseEstimate;
    use evpose_pose::body::LIMBS;
    use evpose_rerun::{PoseFigures, PoseLayout, PoseMoment, PoseRecording, RerunError};

    use super::Watched;

    /// From one moment to the next.
    const MOMENT: Duration = Duration::from_millis(33);
    /// Events of each polarity that are points of one moment, at most: the newest.
    const MOST_POINTS: usize = 50_000;

    /// A viewer, or its file, and the thread that sends to it.
    pub(in super::super) struct Viewer {
        shared: Arc<Shared>,
        thread: JoinHandle<Result<(), RerunError>>,
    }

    #[derive(Default)]
    struct Shared {
        gathered: Mutex<Gathered>,
        is_over: AtomicBool,
    }

    /// What came since the moment before.
    #[derive(Default)]
    struct Gathered {
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
            match self.px.get_mut(self.count % MOST_POINTS) {
                Some(old) if self.count >= MOST_POINTS => *old = at,
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
        fn gathered(&self) -> MutexGuard<'_, Gathered> {
            self.gathered.lock().unwrap_or_else(PoisonError::into_inner)
        }
    }

    impl Viewer {
        /// Sends to the viewer at `place`, or to a file if it is called so.
        pub(in super::super) fn open(place: Option<&str>, watched: Watched<'_>) -> Result<Self> {
            let Watched { name, sensor, mesh, meter, observers, sinks } = watched;
            let layout = match &mesh {
                None => PoseLayout { bones: LIMBS.to_vec(), faces: Vec::new() },
                Some(mesh) => PoseLayout { bones: HAND_BONES.to_vec(), faces: mesh.faces.clone() },
            };
            let recording = match place.filter(|place| place.ends_with(".rrd")) {
                Some(file) => PoseRecording::create(Path::new(file), name, sensor, layout)?,
                None => PoseRecording::connect(place, name, sensor, layout)?,
            };
            let shared = Arc::<Shared>::default();
            observers.push(gather(shared.clone()));
            sinks.add(ViewerSink(shared.clone()));
            let sender = Sender { shared: shared.clone(), recording, mesh, meter };
            Ok(Self { shared, thread: std::thread::spawn(move || sender.work()) })
        }

        /// Waits until everything has arrived; a file gets its name.
        pub(in super::super) fn finish(self) -> Result<()> {
            self.shared.is_over.store(true, Ordering::Relaxed);
            let sent = self.thread.join();
            Ok(sent.unwrap_or_else(|panic| std::panic::resume_unwind(panic))?)
        }
    }

    /// Takes the events that are shown.
    fn gather(shared: Arc<Shared>) -> Observer {
        Arc::new(move |events: &EventStream| {
            let mut gathered = shared.gathered();
            let places = events.x().iter().zip(events.y()).zip(events.polarity());
            for ((&x, &y), &polarity) in places {
                // Pixel 0 reaches from 0 to 1.
                let at = [f32::from(x) + 0.5, f32::from(y) + 0.5];
                gathered.events[polarity as usize].push(at);
            }
            gathered.t = events.t().last().copied().or(gathered.t);
        })
    }

    /// Takes the poses that are shown.
    struct ViewerSink(Arc<Shared>);

    impl Sink for ViewerSink {
        fn name(&self) -> String {
            "Rerun viewer".to_owned()
        }

        fn take(&mut self, pose: &LivePose) -> io::Result<()> {
            let lane = usize::from(pose.origin == Origin::Propagated);
            self.0.gathered().poses[lane] = Some(pose.clone());
            Ok(())
        }
    }

    /// The thread that sends.
    struct Sender {
        shared: Arc<Shared>,
        recording: PoseRecording,
        mesh: Option<HandMesh>,
        meter: Arc<Meter>,
    }

    impl Sender {
        fn work(mut self) -> Result<(), RerunError> {
            let mut taken = Gathered::default();
            let mut latencies = Latencies::default();
            let mut before = Instant::now();
            loop {
                // What came before the end is sent, too.
                let is_over = self.shared.is_over.load(Ordering::Relaxed);
                std::mem::swap(&mut *self.shared.gathered(), &mut taken);
                let passed_s = before.elapsed().as_secs_f64().max(1e-3);
                before = Instant::now();
                self.send(&taken, passed_s, &mut latencies)?;
                taken.events.iter_mut().for_each(Points::clear);
                (taken.t, taken.poses) = (None, [None, None]);
                if is_over {
                    return self.recording.finish();
                }
                std::thread::sleep(MOMENT.saturating_sub(before.elapsed()));
            }
        }

        fn send(
            &mut self,
            taken: &Gathered,
            passed_s: f64,
            latencies: &mut Latencies,
        ) -> Result<(), RerunError> {
            let newest = taken.poses.iter().flatten().map(|pose| pose.t).max();
            let Some(t) = taken.t.max(newest) else { return Ok(()) };
            let late = self.meter.latencies_since(latencies);
            let joints = [0, 1].map(|lane| joints_px(taken.poses[lane].as_ref()));
            let figures = [0, 1].map(|lane| PoseFigures {
                joints_px: &joints[lane],
                p99_ms: (late[lane].poses > 0).then_some(late[lane].p99_ms),
                per_s: late[lane].poses as f64 / passed_s,
            });
            let surface = self.surface(taken);
            let of = |polarity: Polarity| &taken.events[polarity as usize];
            let (off, on) = (of(Polarity::Off), of(Polarity::On));
            self.recording.send(&PoseMoment {
                t,
                events_px: [&off.px, &on.px],
                events_per_s: [off, on].map(|points| points.count as f64 / passed_s),
                poses: figures,
                surface: surface.as_deref(),
            })
        }

        /// Of the newest pose.
        fn surface(&mut self, taken: &Gathered) -> Option<Vec<[f32; 3]>> {
            let newest = taken.poses[1].as_ref().or(taken.poses[0].as_ref())?;
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
            None => &[],
            Some(PoseEstimate::Body { joints_px, .. }) => joints_px,
            Some(PoseEstimate::Hand { points, .. }) => &points.image_px,
        };
        joints.iter().map(|at| at.filter(|at| at.is_finite()).map(|at| at.to_array())).collect()
    }
}

#[cfg(not(feature = "rerun"))]
mod missing {
    use anyhow::{Result, bail};

    use super::Watched;

    /// Never made.
    pub(in super::super) struct Viewer;

    impl Viewer {
        pub(in super::super) fn open(_place: Option<&str>, _watched: Watched<'_>) -> Result<Self> {
            bail!(
                "--rerun: this build knows no Rerun viewer: build it with `--features rerun`, or look at \
                 the page of --serve"
            )
        }

        pub(in super::super) fn finish(self) -> Result<()> {
            Ok(())
        }
    }
}
