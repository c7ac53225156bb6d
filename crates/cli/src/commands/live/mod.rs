//! `evpose live`: online pose estimation.

mod args;
mod rerun;
mod status;

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Result, bail};
use evpose_core::Micros;
use evpose_live::page::{Page, PageInfo};
use evpose_live::sink::{JsonLines, PoseCsv, Sinks};
use evpose_live::source::{self, ReplayOptions, Source, SourceOptions};
use evpose_live::{Control, LiveOptions, Observer};

use crate::tasks::online::OnlineStream;
pub use args::LiveArgs;

use crate::json::write_json;
use crate::progress::note;

/// Runs `evpose live`.
pub fn run(args: &LiveArgs) -> Result<()> {
    let path = Path::new(&args.source);
    let is_file = path.is_file();
    // A file may not state its sensor, which the stream needs before the first event.
    let open = match is_file {
        true => args.opening.options_with_sensor(path)?,
        false => args.opening.options(path)?,
    };
    let replay = ReplayOptions {
        speed: args.speed,
        times: args.times,
        span: args.seconds.map(Micros::from_seconds),
        is_real_time: args.real_time,
        open,
        ..ReplayOptions::default()
    };
    let source = source::open(&args.source, &SourceOptions { replay, ..SourceOptions::default() })?;
    let sensor = source.sensor();
    note(format!("source: {}, {sensor}", source.name()));
    let model = crate::tasks::open(&args.checkpoint, &args.device)?;
    // A checkpoint has one task, so that another one in `--task` is a mistake.
    if let Some(task) = args.task.as_deref().filter(|task| *task != model.task()) {
        let (path, is) = (args.checkpoint.display(), model.task());
        bail!("{path}: a network of the task `{is}`, not `{task}`");
    }
    play(source, model.stream(sensor, &args.own)?, args)
}

fn play(source: Box<dyn Source>, stream: Box<dyn OnlineStream>, args: &LiveArgs) -> Result<()> {
    let mut control = Control::default();
    let mut sinks = Sinks::new();
    let mut observers: Vec<Observer> = Vec::new();
    let (name, sensor) = (source.name(), source.sensor());
    let page = match args.serve {
        None => None,
        Some(address) => {
            let info = PageInfo {
                title: "evpose live".to_owned(),
                source: name.clone(),
                sensor,
                skeleton: stream.skeleton(),
                hosts: args.host.clone(),
                hand_mesh: stream.mesh()?,
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
            let pipeline = rerun::Pipeline {
                name: &name,
                sensor,
                mesh: stream.mesh()?,
                meter: control.meter.clone(),
                observers: &mut observers,
                sinks: &mut sinks,
            };
            Some(rerun::Viewer::open(place.as_deref(), pipeline)?)
        }
    };
    // The pipeline takes one observer, which stands for all of them.
    if !observers.is_empty() {
        control.observer =
            Some(Arc::new(move |events| observers.iter().for_each(|show| show(events))));
    }
    if let Some(place) = &args.json {
        sinks.add(JsonLines::open(place)?);
    }
    if let Some(place) = &args.csv {
        sinks.add(PoseCsv::open(place)?);
    }
    let options = LiveOptions {
        propagate_hz: args.propagate_hz.unwrap_or(stream.propagate_hz()),
        stride: Micros((args.stride_ms * 1e3).round() as i64),
        max_packets: usize::from(args.queue),
        give_up: args.give_up.map(Duration::from_secs_f64),
        ..LiveOptions::default()
    };
    status::print_each_second(&control);
    crate::signals::stop_on(&control)?;
    // Of a file, the replay ends by itself.
    if let Some(seconds) = args.seconds.filter(|_| source.horizon().is_none()) {
        stop_after(Duration::from_secs_f64(seconds), &control);
    }
    let ended = stream.run(source, &mut sinks, &options, &control);
    // Outputs are finished after a failure, too: poses until then are of use.
    let written = sinks.finish();
    let report = control.meter.report();
    for remark in control.meter.remarks() {
        note(format!("warning   {remark}"));
    }
    status::print_summary(&report);
    drop(page);
    let shown = viewer.map_or(Ok(()), rerun::Viewer::finish);
    // The report is written first: it is of use after a failure, too.
    write_json(args.report.as_deref(), &report)?;
    ended?;
    shown?;
    for (sink, dropped) in written?.iter().filter(|(_, dropped)| *dropped > 0) {
        note(format!("{sink}: {dropped} poses dropped"));
    }
    Ok(())
}

fn stop_after(time: Duration, control: &Control) {
    let control = control.clone();
    std::thread::spawn(move || {
        std::thread::sleep(time);
        control.stop();
    });
}
