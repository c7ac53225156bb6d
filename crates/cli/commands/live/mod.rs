//! `evpose live`: poses while events come.

mod args;
mod told;

use std::fs::File;
use std::io::{BufWriter, Write};
use std::net::TcpStream;
use std::path::Path;
use std::time::Duration;

use anyhow::{Context, Result, bail};
use burn::tensor::Device;
use evpose_core::Micros;
use evpose_live::sink::{JsonLines, Sinks, Table};
use evpose_live::source::{Replay, ReplayOptions, Source};
use evpose_live::{
    Control, Eye, LiveOptions, Network, Task, body_task, hand_task, run as run_live,
};
use evpose_nn::DeviceKind;
use evpose_train::Checkpoint;
use evpose_train::body::{BetweenConfig, BodyPredictorOptions};

pub(crate) use args::{LiveArgs, LiveTask};

use super::{as_json, body, device, quantize};
use crate::progress::note;

/// Poses a second between those of the network.
const BODY_HZ: f64 = 500.0;
const HAND_HZ: f64 = 1_000.0;
/// Surfaces at once where the CPU does not compute, as published.
const BATCH: usize = 16;

pub(crate) fn run(args: &LiveArgs) -> Result<()> {
    let replay = ReplayOptions {
        speed: args.speed,
        times: args.times,
        open: args.opening.options(Path::new(&args.source)),
        ..ReplayOptions::default()
    };
    let source = Replay::open(Path::new(&args.source), replay)?;
    let sensor = source.sensor();
    note(format!("source: {}, {sensor}", source.name()));
    if let Some(checkpoint) = body::checkpoint(&args.checkpoint, &Device::flex())? {
        if args.task == Some(LiveTask::Hand) {
            bail!("{}: a network of bodies, not of hands", args.checkpoint.display());
        }
        let options = BodyPredictorOptions {
            precision: args.precision,
            confidence: args.confidence,
            ..BodyPredictorOptions::default()
        };
        let task = body_task(&checkpoint, sensor, &BetweenConfig::default(), options)?;
        return play(source, task, args, BODY_HZ);
    }
    if args.task == Some(LiveTask::Body) {
        bail!("{}: a network of hands, not of bodies", args.checkpoint.display());
    }
    let device = device(&args.device)?;
    let checkpoint = Checkpoint::load(&args.checkpoint, &device)?;
    let trained_for = checkpoint.config.simulation.image_size();
    if sensor != trained_for {
        bail!("{}: {sensor}, but the network was trained for {trained_for}", args.source);
    }
    let on_cpu = args.device.device == DeviceKind::Flex;
    let batch = args.batch.map_or(if on_cpu { 1 } else { BATCH }, usize::from);
    let predictor =
        quantize::predictor(&args.checkpoint, checkpoint.network, args.precision, device)?;
    let task = hand_task(&checkpoint.config, predictor, sensor, batch)?;
    play(source, task, args, HAND_HZ)
}

fn play<E: Eye, N: Network<Image = E::Image, Found = E::Found>>(
    source: impl Source,
    task: Task<E, N>,
    args: &LiveArgs,
    usual_hz: f64,
) -> Result<()> {
    let mut sinks = Sinks::new();
    if let Some(place) = &args.json {
        sinks.add(JsonLines::new(place, writer(place)?));
    }
    if let Some(place) = &args.csv {
        sinks.add(Table::new(place, writer(place)?));
    }
    let options = LiveOptions {
        between_hz: args.between_hz.unwrap_or(usual_hz),
        stride: Micros((args.stride_ms * 1e3).round() as i64),
        most_packets: usize::from(args.queue),
        give_up: args.give_up.map(Duration::from_secs_f64),
        ..LiveOptions::default()
    };
    let control = Control::default();
    told::each_second(&control);
    if let Some(seconds) = args.seconds {
        let control = control.clone();
        std::thread::spawn(move || {
            std::thread::sleep(Duration::from_secs_f64(seconds));
            control.stop();
        });
    }
    let ended = run_live(source, task, &mut sinks, &options, &control);
    let written = sinks.finish();
    let report = control.meter.report();
    told::at_the_end(&report);
    as_json(args.report.as_deref(), &report)?;
    ended?;
    for (sink, dropped) in written?.iter().filter(|(_, dropped)| *dropped > 0) {
        note(format!("{sink}: {dropped} poses dropped"));
    }
    Ok(())
}

/// Where lines go. Files are written under their own names: what is there when somebody pulls the plug is
/// of use.
fn writer(place: &str) -> Result<Box<dyn Write + Send>> {
    if place == "-" {
        return Ok(Box::new(BufWriter::new(std::io::stdout())));
    }
    if let Some(address) = place.strip_prefix("tcp://") {
        let socket =
            TcpStream::connect(address).with_context(|| format!("connecting to {address}"))?;
        socket.set_nodelay(true)?;
        return Ok(Box::new(BufWriter::new(socket)));
    }
    let file = File::create(place).with_context(|| format!("creating {place}"))?;
    Ok(Box::new(BufWriter::new(file)))
}
