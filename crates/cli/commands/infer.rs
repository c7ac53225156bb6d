//! `evpose infer`.

use std::fmt::Write as _;

use anyhow::{Context, Result, bail};
use burn::tensor::Device;
use evpose_core::{EventStream, Micros, TimeWindow, atomic_write};
use evpose_pose::HandParams;
use evpose_pose::filter::HandFilter;
use evpose_repr::{StreamWindow, representation_called};
use evpose_task::hand::{HandCheckpoint, HandConfig, NetworkPredictor, Predictor as _, HandEstimate, SlowMotionTracker, HandView};

use super::{body, hand_joints};
use evpose_app::args::DeviceArgs;
use evpose_app::progress::{bar, say};
use evpose_app::{body_checkpoint, hand_predictor};
use evpose_infer::Precision;
use std::path::PathBuf;

#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  evpose infer --checkpoint runs/hand \
    --events hand.evc --out poses.csv --joints joints.csv\n  evpose infer --checkpoint runs/hand \
    --events slow.npz --out poses.csv --mode slow-motion")]
pub(crate) struct InferArgs {
    /// A run directory, or a .bpk file with its .toml beside it
    #[arg(long)]
    pub(crate) checkpoint: PathBuf,
    /// Recording, of any format
    #[arg(long)]
    pub(crate) events: PathBuf,
    /// Hands: time and the 12 parameters, a line every millisecond, or for each surface of slow motion.
    /// Bodies: time, delay and 13 joints in pixels, as hpe-core has them
    #[arg(long)]
    pub(crate) out: PathBuf,
    /// `plain`: a pose every millisecond. `slow-motion`: where enough events came, in batches; at
    /// rest the last ones again; smoothed less where the hand is fast
    #[arg(long, default_value = "plain", value_parser = ["plain", "slow-motion"])]
    pub(crate) mode: String,
    /// Time and the 21 evaluated joints in pixels and in metres
    #[arg(long)]
    pub(crate) joints: Option<PathBuf>,
    /// Bodies: milliseconds between poses [the config's]
    #[arg(long)]
    pub(crate) stride_ms: Option<u32>,
    /// Bodies: joints of a lower score are not found
    #[arg(long, default_value_t = 0.01)]
    pub(crate) confidence: f32,
    /// Bodies: also write skeletons as a folder of YARP's
    #[arg(long, value_name = "DIR")]
    pub(crate) skeletons: Option<PathBuf>,
    /// Bodies: also write poses at 500 Hz, carried on between those of the network by velocities of
    /// events
    #[arg(long, value_name = "FILE")]
    pub(crate) fused: Option<PathBuf>,
    /// Write the network's poses as they are, without the Kalman filter
    #[arg(long)]
    pub(crate) unfiltered: bool,
    /// Bits that the network computes in: f32, bf16, or int8 after `evpose quantize`
    #[arg(long, default_value = "f32")]
    pub(crate) precision: Precision,
    #[command(flatten)]
    pub(crate) device: DeviceArgs,
}

/// Windows predicted at once.
const BATCH: usize = 64;

/// Events that the slow-motion mode takes at once.
const PACKET: Micros = Micros(100_000);

/// Column names of the 12 parameters.
const PARAMETER_NAMES: [&str; 12] = [
    "articulation_1",
    "articulation_2",
    "articulation_3",
    "articulation_4",
    "articulation_5",
    "articulation_6",
    "translation_x_m",
    "translation_y_m",
    "translation_z_m",
    "rotation_x_rad",
    "rotation_y_rad",
    "rotation_z_rad",
];

pub(crate) fn run(args: &InferArgs) -> Result<()> {
    if let Some(checkpoint) = body_checkpoint::checkpoint(&args.checkpoint, &Device::flex())? {
        return body::infer(&checkpoint, args);
    }
    if args.skeletons.is_some() || args.fused.is_some() || args.stride_ms.is_some() {
        bail!("--skeletons, --fused and --stride-ms are for bodies");
    }
    let device = args.device.open()?;
    let checkpoint = HandCheckpoint::load(&args.checkpoint, &device)?;
    let config = checkpoint.config;
    let recording = evpose_io::open_with(&args.events, Some(config.simulation.image_size()))?;
    if recording.rejected.total() > 0 {
        say(format!(
            "warning: {}: left out {} events outside the sensor and {} out of order",
            args.events.display(),
            recording.rejected.outside_sensor,
            recording.rejected.out_of_order
        ));
    }
    let events = recording.stream;
    if events.sensor() != config.simulation.image_size() {
        bail!(
            "{}: recorded at {}, but the network was trained for {}",
            args.events.display(),
            events.sensor(),
            config.simulation.image_size()
        );
    }
    let mut predictor =
        hand_predictor::predictor(&args.checkpoint, checkpoint.network, args.precision, device)?;
    let estimate = if args.mode == "slow-motion" { slow_motion } else { predict };
    let poses = estimate(&config, &events, &mut predictor, !args.unfiltered)?;

    let mut csv = format!("t_us,{}\n", PARAMETER_NAMES.join(","));
    for (t, pose) in &poses {
        let values: Vec<String> = pose.to_array().iter().map(f32::to_string).collect();
        let _ = writeln!(csv, "{},{}", t.0, values.join(","));
    }
    atomic_write(&args.out, csv.as_bytes())
        .with_context(|| format!("writing {}", args.out.display()))?;
    say(format!("{} poses: {}", poses.len(), args.out.display()));

    if let Some(path) = &args.joints {
        let stage = HandView::new(&config)?;
        // A network of both hands does not say which it saw.
        let side = config.simulation.hands.side(0);
        let mut csv = hand_joints::header();
        for (t, pose) in &poses {
            hand_joints::push(&mut csv, *t, &stage.points(side, pose, &[]));
        }
        atomic_write(path, csv.as_bytes())
            .with_context(|| format!("writing {}", path.display()))?;
        say(format!("joints: {}", path.display()));
    }
    Ok(())
}

/// A pose for every millisecond from the end of the first full window on; only the last one where
/// the recording is shorter. The pose at `k` ms is that of the events before `k + 1` ms, as in
/// training.
fn predict(
    config: &HandConfig,
    events: &EventStream,
    predictor: &mut NetworkPredictor,
    filtered: bool,
) -> Result<Vec<(Micros, HandParams)>> {
    let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) else {
        return Ok(Vec::new());
    };
    let sensor = events.sensor();
    let window_ms = i64::from(config.representation.window_ms);
    let last_ms = last.0.div_euclid(1000);
    let first_ms = (first.0.div_euclid(1000) + window_ms).min(last_ms);
    let times_ms: Vec<i64> = (first_ms..=last_ms).collect();

    let order = config.representation.channel_order;
    let window = StreamWindow::new(sensor, Micros(window_ms * 1000), order)?;
    let mut surface = representation_called(&config.representation.name)?.start(window);
    let mut filter = HandFilter::new(&config.filter)?;
    let size = (usize::from(sensor.height), usize::from(sensor.width));
    let mut surfaces = vec![0.0; BATCH * 2 * sensor.pixels()];
    let mut poses = Vec::with_capacity(times_ms.len());
    let mut pushed = Micros(i64::MIN);
    let progress = bar("inferring", times_ms.len() as u64, "poses");
    for chunk in times_ms.chunks(BATCH) {
        let planes = surfaces.chunks_exact_mut(2 * sensor.pixels());
        for (&ms, planes) in chunk.iter().zip(planes) {
            let end = Micros((ms + 1) * 1000);
            surface.push(&events.slice(TimeWindow { start: pushed, end }));
            pushed = end;
            surface.advance(end - Micros(1));
            let (own, copy) = planes.split_at_mut(surface.channels() * sensor.pixels());
            surface.render(own);
            // The network has two input channels: a representation of one fills both.
            copy.copy_from_slice(&own[..copy.len()]);
        }
        let used = &surfaces[..chunk.len() * 2 * sensor.pixels()];
        for (&ms, pose) in chunk.iter().zip(predictor.predict(used, size)?) {
            let t = Micros(ms * 1000);
            poses.push((t, if filtered { filter.update(t, &pose) } else { pose }));
        }
        progress.inc(chunk.len() as u64);
    }
    progress.finish_and_clear();
    Ok(poses)
}

/// The poses of the slow-motion mode, each at the time of its surface.
fn slow_motion(
    config: &HandConfig,
    events: &EventStream,
    predictor: &mut NetworkPredictor,
    filtered: bool,
) -> Result<Vec<(Micros, HandParams)>> {
    let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) else {
        return Ok(Vec::new());
    };
    let mut tracker = SlowMotionTracker::new(config, events.sensor())?;
    let mut poses = Vec::new();
    let progress = bar("inferring", (last - first).0 as u64 / 1000, "ms");
    let mut start = first;
    while start <= last {
        let end = start + PACKET;
        tracker.push(&events.slice(TimeWindow { start, end }), predictor, &mut poses)?;
        start = end;
        progress.inc(PACKET.0 as u64 / 1000);
    }
    tracker.finish(predictor, &mut poses)?;
    progress.finish_and_clear();
    let repeated = poses.iter().filter(|pose| pose.repeated).count();
    say(format!("slow motion: {} surfaces, {repeated} of a scene at rest", poses.len()));
    let pose = |pose: HandEstimate| if filtered { pose.filtered } else { pose.measured };
    Ok(poses.into_iter().map(|each| (each.t, pose(each))).collect())
}
