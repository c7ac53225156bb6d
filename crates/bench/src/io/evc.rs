//! `.evc` and `.meta`, as data sets for training have them.

use std::hint::black_box;
use std::io::Read;
use std::path::{Path, PathBuf};

use anyhow::Result;
use evpose_core::{CounterRng, Event, EventStream, Micros, Polarity, SensorSize};
use evpose_io::{EvcReader, EvcWindow, EvcWriter, MetaReader, MetaWriter};
use evpose_pose::HandParams;

use crate::peer_bench::{Case, Run};

const SENSOR: SensorSize = SensorSize::DAVIS240C;
/// Frames read at a time.
const WINDOW: u64 = 1024;

/// Cases of them.
pub(super) const NAMES: [&str; 3] =
    ["evc into reused records", "evc into a reused EventStream", "evc records and meta labels"];

/// Ours, and what they are held against; how many frames and events there are.
pub(super) fn cases(folder: &Path, frames: u64, events_per_frame: u32) -> Result<Vec<Case>> {
    let stem = folder.join("bench");
    let events = make(&stem, frames, events_per_frame)? as usize;
    let (evc, meta) = (stem.with_extension("evc"), stem.with_extension("meta"));
    let reader = || EvcReader::open_with(&evc, SENSOR);
    // A reader for each case, whose closure owns it.
    let (records, streams, both) = (reader()?, reader()?, reader()?);
    let labels = MetaReader::open(&meta)?;
    let (mut window, mut scratch, mut beside) =
        (EvcWindow::new(), EvcWindow::new(), EvcWindow::new());
    let mut stream = EventStream::empty(SENSOR);
    Ok(vec![
        Case::of_events(NAMES[0], events, Box::new(move || read_records(&records, &mut window)))
            .with_peer("unchecked bytes, no frames", plain_bytes(evc.clone()))
            .with_peer("record by record, as published", record_by_record(evc)),
        Case::of_events(
            NAMES[1],
            events,
            Box::new(move || {
                stream.clear();
                streams.read_into(0..streams.frames(), &mut scratch, &mut stream)?;
                black_box(stream.len());
                Ok(())
            }),
        ),
        Case::of_events(
            NAMES[2],
            events,
            Box::new(move || {
                read_records(&both, &mut beside)?;
                for start in (0..labels.records()).step_by(WINDOW as usize) {
                    let end = labels.records().min(start + WINDOW);
                    black_box(labels.read_hands(start..end)?);
                }
                Ok(())
            }),
        ),
    ])
}

fn read_records(reader: &EvcReader, window: &mut EvcWindow) -> Result<()> {
    for start in (0..reader.frames()).step_by(WINDOW as usize) {
        reader.read_frames(start..reader.frames().min(start + WINDOW), window)?;
        black_box(window.records());
    }
    Ok(())
}

/// Copies the file out of the page cache into reused memory: the lower bound of any reader.
fn plain_bytes(path: PathBuf) -> Run {
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
fn record_by_record(path: PathBuf) -> Run {
    let mut block = vec![0; 4 * 512 * 512 * 64];
    let mut frames: Vec<Vec<[u8; 3]>> = Vec::new();
    Box::new(move || {
        let mut file = std::fs::File::open(&path)?;
        frames.clear();
        loop {
            let mut filled = 0;
            // A read may return less than it was asked for, and a record must not be cut in two.
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
            // As published: coordinates are bytes, since that sensor has fewer than 256 columns.
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
        // Uniform up to twice the mean: frames have different numbers, as those of a camera.
        let count = rng.below(2 * events_per_frame as usize + 1);
        for _ in 0..count {
            let x = rng.below(usize::from(SENSOR.width)) as u16;
            let y = rng.below(usize::from(SENSOR.height)) as u16;
            let polarity = Polarity::from_on(rng.below(2) == 1);
            // The format stores no times: all events of a frame share its millisecond.
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
