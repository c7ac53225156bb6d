//! A live pipeline with a sink of one's own: a recording is replayed in real time through a
//! checkpoint, and the sink measures the speed of the wrist.
//!
//! ```console
//! $ cargo run --release --example live_sink [RECORDING]
//! ```
//!
//! Without a file, a hand is simulated and recorded first.

#![allow(clippy::print_stdout, reason = "a program")]

use std::io;
use std::path::{Path, PathBuf};

use anyhow::Result;
use evpose_core::Micros;
use evpose_live::sink::{Sink, Sinks};
use evpose_live::source::{Replay, ReplayOptions, Source};
use evpose_live::{Control, LiveOptions, LivePose, run};
use evpose_nn::DeviceKind;
use evpose_pose::PoseEstimate;
use evpose_pose::stream::InferenceSchedule;
use evpose_sim::{Simulator, record};
use evpose_task::hand::{HandCheckpoint, hand_stream};
use evpose_view::Calibration;

/// Prints the position of the wrist ten times a second, with the latency of its pose.
#[derive(Default)]
struct WristSink {
    next: Micros,
    count: usize,
}

impl Sink for WristSink {
    fn name(&self) -> String {
        "wrist".to_owned()
    }

    fn write(&mut self, pose: &LivePose) -> io::Result<()> {
        self.count += 1;
        if let PoseEstimate::Hand { params, .. } = &pose.pose
            && pose.t >= self.next
        {
            let wrist = params.translation_m;
            println!("{:>8} wrist {wrist:.3} m, {:.1?} late", pose.t.0, pose.latency);
            self.next = pose.t + Micros(100_000);
        }
        Ok(())
    }

    fn finish(&mut self) -> io::Result<()> {
        println!("{} poses", self.count);
        Ok(())
    }
}

fn main() -> Result<()> {
    let device = DeviceKind::default().resolve()?;
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("checkpoints/hand-quick.bpk");
    let checkpoint = HandCheckpoint::load(&shipped, &device)?;
    let directory = tempfile::tempdir()?;
    let recording = match std::env::args().nth(1) {
        Some(path) => PathBuf::from(path),
        None => {
            let mut simulator = Simulator::new(&checkpoint.config.simulation, 77)?;
            record(&mut simulator, 1_000, directory.path().join("hand"), &|_| {})?.events_path
        }
    };

    let source = Replay::open(&recording, ReplayOptions::default())?;
    let predictor = checkpoint.predictor(device)?;
    let camera = Calibration::guessed(source.sensor());
    let schedule = InferenceSchedule::NewestWhenFree;
    let stream = hand_stream(&checkpoint.config, predictor, &camera, schedule, 1)?;
    let mut sinks = Sinks::new();
    sinks.add(WristSink::default());
    run(source, stream, &mut sinks, &LiveOptions::default(), &Control::default())?;
    // Waits for what is under way, and for errors of sinks.
    sinks.finish()?;
    Ok(())
}
