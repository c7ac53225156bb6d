//! Runs a shipped checkpoint on events: a hand is simulated, and its predicted wrist is compared
//! with the truth.
//!
//! ```console
//! $ cargo run --release --example run_checkpoint [CHECKPOINT]
//! ```

#![allow(clippy::print_stdout, reason = "a program")]

use std::path::Path;

use anyhow::Result;
use evpose_camera::Calibration;
use evpose_nn::DeviceKind;
use evpose_pose::stream::{InferenceSchedule, StreamFrontend as _};
use evpose_sim::Simulator;
use evpose_task::hand::{HandCheckpoint, hand_stream};

/// Milliseconds that are simulated.
const STEPS: u64 = 600;

fn main() -> Result<()> {
    let default = Path::new(env!("CARGO_MANIFEST_DIR")).join("checkpoints/hand-quick.bpk");
    let path = std::env::args().nth(1).map_or(default, Into::into);
    let device = DeviceKind::default().resolve()?;
    let checkpoint = HandCheckpoint::load(&path, &device)?;

    let mut simulator = Simulator::new(&checkpoint.config.simulation, 77)?;
    let sensor = simulator.advance()?.events.sensor();
    let predictor = checkpoint.predictor(device)?;
    // Events → representation → network → Kalman filter → pose, one window per inference.
    let (camera, schedule) = (Calibration::guessed(sensor), InferenceSchedule::NewestWhenFree);
    let mut stream = hand_stream(&checkpoint.config, predictor, &camera, schedule, 1)?;
    println!("   t (ms)   predicted wrist (m)          error (mm)");
    let (mut errors, mut shown) = (Vec::new(), 0);
    for _ in 0..STEPS {
        let step = simulator.advance()?;
        stream.frontend.push(step.events)?;
        for (t, pose) in stream.infer(step.t)? {
            let predicted = pose.filtered.params.translation_m;
            let error_mm = 1e3 * predicted.distance(step.label.translation_m);
            errors.push(error_mm);
            if t.0 >= shown {
                println!("{:>9.0}   {predicted:>.3}   {error_mm:>9.1}", 1e3 * t.as_seconds());
                shown = t.0 + 100_000;
            }
        }
    }
    let mean = errors.iter().sum::<f32>() / errors.len().max(1) as f32;
    println!("{} poses, mean error of the wrist {mean:.1} mm", errors.len());
    Ok(())
}
