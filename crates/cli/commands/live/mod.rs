//! `evpose live`: poses while events come.

mod args;
mod rerun;
mod told;

use std::fs::File;
use std::io::{BufWriter, Write};
use std::net::TcpStream;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, Result};
use evpose_core::Micros;
use evpose_live::page::{Page, PageInfo, Subject};
use evpose_live::sink::{JsonLines, Sinks, Table};
use evpose_live::source::{self, ReplayOptions, Source, SourceOptions};
use evpose_pose::stream::StreamFrontend;
use evpose_pose::stream::InferenceWorker;
use evpose_pose::stream::PoseStream;
use evpose_live::{Control, LiveOptions, Observer, hand_mesh, run as run_live};
use evpose_task::hand::HandConfig;

pub(crate) use args::LiveArgs;
use evpose_app::live_task::{AnyTask, TaskOptions};

use evpose_app::json::write_json;
use evpose_app::progress::note;

pub(crate) fn run(args: &LiveArgs) -> Result<()> {
    let replay = ReplayOptions {
        speed: args.speed,
        times: args.times,
        open: args.opening.options(Path::new(&args.source)),
        ..ReplayOptions::default()
    };
    let source = source::open(&args.source, &SourceOptions { replay, ..SourceOptions::default() })?;
    let sensor = source.sensor();
    note(format!("source: {}, {sensor}", source.name()));
    let options = TaskOptions {
        precision: args.precision,
        device: &args.device,
        batch: args.batch,
        confidence: args.confidence,
    };
    let task = AnyTask::load(&args.checkpoint, args.task, sensor, &options)?;
    let usual_hz = task.usual_between_hz();
    match task {
        AnyTask::Body(task) => play(source, *task, args, usual_hz, None),
        AnyTask::Hand(task, config) => play(source, *task, args, usual_hz, Some(&config)),
    }
}

fn play<E: StreamFrontend, N: InferenceWorker<Input = F::Input, Output = F::Output>>(
    source: impl Source,
    task: Task<E, N>,
    args: &LiveArgs,
    usual_hz: f64,
    hand: Option<&HandConfig>,
) -> Result<()> {
    let mut control = Control::default();
    let mut sinks = Sinks::new();
    let (mut observers, sensor): (Vec<Observer>, _) = (Vec::new(), source.sensor());
    let page = match args.serve {
        None => None,
        Some(address) => {
            let info = PageInfo {
                title: "evpose live".to_owned(),
                source: source.name(),
                sensor,
                subject: if hand.is_some() { Subject::Hand } else { Subject::Body },
                hand_mesh: hand.map(hand_mesh).transpose()?,
            };
            let page = Page::serve(address, info, control.meter.clone())?;
            note(format!("page:   http://{}", page.local_addr()));
            let view = page.view();
            observers.push(Arc::new(move |events| view.push(events)));
            sinks.add(page.sink());
            Some(page)
        }
    };
    let viewer = match &args.rerun {
        None => None,
        Some(place) => {
            let watched = rerun::Watched {
                name: &source.name(),
                sensor,
                mesh: hand.map(hand_mesh).transpose()?,
                meter: control.meter.clone(),
                observers: &mut observers,
                sinks: &mut sinks,
            };
            Some(rerun::Viewer::open(place.as_deref(), watched)?)
        }
    };
    if !observers.is_empty() {
        control.observer =
            Some(Arc::new(move |events| observers.iter().for_each(|show| show(events))));
    }
    if let Some(place) = &args.json {
        sinks.add(JsonLines::new(place, writer(place)?));
    }
    if let Some(place) = &args.csv {
        sinks.add(Table::new(place, writer(place)?));
    }
    let options = LiveOptions {
        propagate_hz: args.propagate_hz.unwrap_or(usual_hz),
        stride: Micros((args.stride_ms * 1e3).round() as i64),
        most_packets: usize::from(args.queue),
        give_up: args.give_up.map(Duration::from_secs_f64),
        ..LiveOptions::default()
    };
    told::each_second(&control);
    let at_the_end = control.clone();
    ctrlc::set_handler(move || {
        // Whoever insists is let go.
        if at_the_end.is_stopped() {
            std::process::exit(130);
        }
        at_the_end.stop();
    })
    .context("listening for Ctrl-C")?;
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
    drop(page);
    let shown = viewer.map_or(Ok(()), rerun::Viewer::finish);
    write_json(args.report.as_deref(), &report)?;
    ended?;
    shown?;
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
