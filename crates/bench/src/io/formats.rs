//! Every format that can be written, and files of the user.

use std::fs;
use std::hint::black_box;
use std::path::{Path, PathBuf};

use anyhow::{Error, Result};
use evpose_core::{EventStream, SensorSize};
use evpose_io::aedat4::{self, Compression, Stream, StreamKind};
use evpose_io::evt::{Evt3Encoder, WordEncoder, synthetic};
use evpose_io::{Columns, FORMATS, Input, OpenOptions, source};

use crate::peer_bench::{Case, Run};

/// Scattered events, of which no format can save anything, and edges, as cameras see them.
pub(super) fn cases(folder: &Path, count: usize) -> Result<Vec<Case>> {
    let mut cases = Vec::new();
    for (kind, events) in
        [("scattered", synthetic::scattered(count)), ("edges", synthetic::edges(count))]
    {
        for format in FORMATS.iter().filter(|format| format.create.is_some()) {
            // The one with a case of its own, and one whose sensors are smaller.
            if matches!(format.name, "evc" | "nmnist" | "aedat4") {
                continue;
            }
            let path = folder.join(format!("{kind}.{}", format.name));
            format.write(&path, &events)?;
            cases.push(case(&path, &events)?);
        }
        // Decompression is a part of reading AEDAT 4, so that each kind is a case of its own.
        for (name, compression) in
            [("none", Compression::None), ("lz4", Compression::Lz4), ("zstd", Compression::Zstd)]
        {
            let path = folder.join(format!("{kind}.aedat4-{name}"));
            let mut writer = aedat4::Writer::create(&path, compression, &[stream(&events)])?;
            writer.events(0, &events)?;
            writer.finish()?;
            cases.push(case(&path, &events)?);
        }
        let path = folder.join(format!("{kind}.evt3-scalar"));
        fs::write(&path, scalar(&events)?)?;
        cases.push(case(&path, &events)?);
    }
    Ok(cases)
}

/// The stream of a camera's events.
fn stream(events: &EventStream) -> Stream {
    Stream {
        id: 0,
        kind: StreamKind::Events,
        name: "events".to_owned(),
        source: "bench".to_owned(),
        size: Some(events.sensor()),
    }
}

/// An EVT 3.0 file without vectors, as cameras send what moves little.
fn scalar(events: &EventStream) -> Result<Vec<u8>> {
    let SensorSize { width, height } = events.sensor();
    let mut bytes =
        format!("% evt 3.0\n% format EVT3;height={height};width={width}\n% end\n").into_bytes();
    let mut encoder = Evt3Encoder::new(events.sensor()).without_vectors();
    encoder.encode(events, &mut bytes).map_err(Error::msg)?;
    Ok(bytes)
}

fn case(path: &Path, events: &EventStream) -> Result<Case> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let case = Case::of_events(&name, events.len(), read(path.to_owned()));
    #[cfg(feature = "peers")]
    let case = super::rivals::beside(case, path)?;
    Ok(case)
}

/// Recordings that the user has.
pub(super) fn of_user(files: &[PathBuf]) -> Result<Vec<Case>> {
    let case = |path: &PathBuf| {
        let events = count(path)?;
        Ok(Case::of_events(path.display().to_string(), events, read(path.clone())))
    };
    files.iter().map(case).collect()
}

fn count(path: &Path) -> Result<usize> {
    let (_, mut source) = source(Input::file(path)?, &OpenOptions::default())?;
    let (mut columns, mut count) = (Columns::new(), 0);
    loop {
        columns.clear();
        source.next(&mut columns)?;
        if columns.is_empty() {
            return Ok(count);
        }
        count += columns.len();
    }
}

/// Opens the file and reads it to its end, into columns that are used again.
fn read(path: PathBuf) -> Run {
    let mut columns = Columns::new();
    Box::new(move || {
        let (_, mut source) = source(Input::file(&path)?, &OpenOptions::default())?;
        loop {
            columns.clear();
            source.next(&mut columns)?;
            if columns.is_empty() {
                return Ok(());
            }
            black_box(&columns);
        }
    })
}
