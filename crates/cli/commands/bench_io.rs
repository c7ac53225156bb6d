//! `evpose bench io`: how fast recordings come from the page cache.

use std::hint::black_box;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::{Context, Result};
use evpose_core::{CounterRng, Event, EventStream, Micros, Polarity, SensorSize};
use evpose_io::{EvcReader, EvcWindow, EvcWriter, MetaReader, MetaWriter};
use evpose_pose::HandParams;
use serde::Serialize;

use super::as_json;
use crate::args::BenchIoArgs;
use crate::machine::Machine;
use crate::progress::say;
use crate::run_info::COMMIT;
use crate::timing::{outliers, quantile};

const SENSOR: SensorSize = SensorSize::DAVIS240C;
/// Frames read at a time.
const WINDOW: u64 = 1024;

/// What a benchmark measured and where.
#[derive(Debug, Serialize)]
struct Report {
    machine: Machine,
    commit: &'static str,
    frames: u64,
    events: u64,
    readers: Vec<Measured>,
}

/// One way to read the file.
#[derive(Debug, Serialize)]
struct Measured {
    reader: &'static str,
    /// Millions a second, of the median pass.
    events_m_per_s: f64,
    frames_m_per_s: f64,
    passes: usize,
    outliers: usize,
}

pub(crate) fn run(args: &BenchIoArgs) -> Result<()> {
    let scratch = match &args.scratch {
        Some(folder) => tempfile::tempdir_in(folder),
        None => tempfile::tempdir(),
    }
    .context("making a folder for the file")?;
    let stem = scratch.path().join("bench");
    let events = make(&stem, args.frames, args.events_per_frame)?;
    let mut report = Report {
        machine: Machine { threads: 1, ..Machine::this() },
        commit: COMMIT,
        frames: args.frames,
        events,
        readers: Vec::new(),
    };
    say(format!("machine   {}", report.machine));
    say(format!(
        "file      {} frames of 1 ms, {:.1} million events, in the page cache",
        report.frames,
        events as f64 / 1e6
    ));
    for (reader, mut pass) in readers(&stem)? {
        let mut times_s = Vec::new();
        // The first pass fills the page cache and makes the memory that is reused.
        for count in 0..=args.passes.max(1) {
            let begin = Instant::now();
            pass()?;
            if count > 0 {
                times_s.push(begin.elapsed().as_secs_f64());
            }
        }
        times_s.sort_by(f64::total_cmp);
        let median_s = quantile(&times_s, 0.5);
        let measured = Measured {
            reader,
            events_m_per_s: events as f64 / median_s / 1e6,
            frames_m_per_s: report.frames as f64 / median_s / 1e6,
            passes: times_s.len(),
            outliers: outliers(&times_s),
        };
        say(format!(
            "{reader:44} {:7.0} M events/s {:7.2} M frames/s",
            measured.events_m_per_s, measured.frames_m_per_s
        ));
        report.readers.push(measured);
    }
    if report.readers.iter().any(|measured| measured.outliers * 5 > measured.passes) {
        say("warning   many passes were outliers: the machine was busy, measure again");
    }
    as_json(args.json.as_deref(), &report)
}

/// Reads everything once.
type Pass = Box<dyn FnMut() -> Result<()>>;

/// Ours, and what they are held against.
fn readers(stem: &Path) -> Result<Vec<(&'static str, Pass)>> {
    let (evc, meta) = (stem.with_extension("evc"), stem.with_extension("meta"));
    let reader = || EvcReader::open_with(&evc, SENSOR);
    let (records, streams, both) = (reader()?, reader()?, reader()?);
    let labels = MetaReader::open(&meta)?;
    let (mut window, mut scratch, mut beside) =
        (EvcWindow::new(), EvcWindow::new(), EvcWindow::new());
    let mut stream = EventStream::empty(SENSOR);
    Ok(vec![
        ("evpose: .evc into reused records", Box::new(move || read_records(&records, &mut window))),
        (
            "evpose: .evc into a reused EventStream",
            Box::new(move || {
                stream.clear();
                streams.read_into(0..streams.frames(), &mut scratch, &mut stream)?;
                black_box(stream.len());
                Ok(())
            }),
        ),
        (
            "evpose: .evc records and .meta labels",
            Box::new(move || {
                read_records(&both, &mut beside)?;
                for start in (0..labels.records()).step_by(WINDOW as usize) {
                    let end = labels.records().min(start + WINDOW);
                    black_box(labels.read_hands(start..end)?);
                }
                Ok(())
            }),
        ),
        ("peer: unchecked bytes, no frames", plain_bytes(evc.clone())),
        ("peer: record by record, as the published loader", record_by_record(evc)),
    ])
}

fn read_records(reader: &EvcReader, window: &mut EvcWindow) -> Result<()> {
    for start in (0..reader.frames()).step_by(WINDOW as usize) {
        reader.read_frames(start..reader.frames().min(start + WINDOW), window)?;
        black_box(window.records());
    }
    Ok(())
}

/// What copying out of the page cache takes, into reused memory.
fn plain_bytes(path: PathBuf) -> Pass {
    let mut block = vec![0; 1 << 20];
    Box::new(move || {
        let mut file = std::fs::File::open(&path)?;
        while file.read(&mut block)? > 0 {
            black_box(&block);
        }
        Ok(())
    })
}

/// Blocks of records, looked at one by one and sorted into frames of byte triples.
fn record_by_record(path: PathBuf) -> Pass {
    let mut block = vec![0; 4 * 512 * 512 * 64];
    let mut frames: Vec<Vec<[u8; 3]>> = Vec::new();
    Box::new(move || {
        let mut file = std::fs::File::open(&path)?;
        frames.clear();
        loop {
            let mut filled = 0;
            while filled < block.len() {
                let read = file.read(&mut block[filled..])?;
                if read == 0 {
                    break;
                }
                filled += read;
            }
            if filled == 0 {
                break;
            }
            for &[x, _, y, p] in block[..filled].as_chunks::<4>().0 {
                if p == 255 {
                    frames.push(Vec::new());
                } else if let Some(frame) = frames.last_mut() {
                    frame.push([x, y, p]);
                }
            }
        }
        black_box(&frames);
        Ok(())
    })
}

/// Writes a recording of random events; gives their number.
fn make(stem: &Path, frames: u64, events_per_frame: u32) -> Result<u64> {
    let mut events = EvcWriter::create(stem.with_extension("evc"), SENSOR)?;
    let mut labels = MetaWriter::create_for_hands(stem.with_extension("meta"))?;
    let mut rng = CounterRng::new(1, "bench io", 0);
    let mut stream = EventStream::empty(SENSOR);
    for _ in 0..frames {
        stream.clear();
        let count = rng.below(2 * events_per_frame as usize + 1);
        for _ in 0..count {
            let x = rng.below(usize::from(SENSOR.width)) as u16;
            let y = rng.below(usize::from(SENSOR.height)) as u16;
            let polarity = Polarity::from_on(rng.below(2) == 1);
            stream.push(Event { t: Micros(0), x, y, polarity })?;
        }
        events.frame(&stream)?;
        let articulation = std::array::from_fn(|_| rng.uniform(-2.0, 2.0));
        labels.hand(&HandParams { articulation, ..HandParams::default() })?;
    }
    let count = events.events();
    labels.finish()?;
    events.finish()?;
    Ok(count)
}
