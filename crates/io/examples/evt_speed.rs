//! How fast Prophesee's formats are decoded from memory into reused columns:
//! `cargo run --release --example evt_speed [FOLDER]`. With a folder, the streams are written there
//! as files, for other programs.
#![allow(clippy::unwrap_used, clippy::print_stdout, reason = "an example")]

use std::time::Instant;

use evpose_core::EventStream;
use evpose_io::dat::DatDecoder;
use evpose_io::evt::{
    Evt2Decoder, Evt2Encoder, Evt3Decoder, Evt3Encoder, Evt21Decoder, Evt21Encoder, WordEncoder,
    synthetic,
};
use evpose_io::{Columns, Decoder, format_called};

const EVENTS: usize = 2_000_000;
const RUNS: usize = 30;

fn main() {
    let folder = std::env::args().nth(1);
    for (name, stream) in
        [("scattered", synthetic::scattered(EVENTS)), ("edges", synthetic::edges(EVENTS))]
    {
        if let Some(folder) = &folder {
            for format in ["evt2", "evt2.1", "evt3", "dat"] {
                let format = format_called(format).unwrap();
                let path = format!("{folder}/{name}.{}", format.name.replace('.', ""));
                format.write(path, &stream).unwrap();
            }
        }
        let mut scalar = Vec::new();
        Evt3Encoder::new(stream.sensor()).without_vectors().encode(&stream, &mut scalar).unwrap();
        time(name, "EVT 3.0 scalar", &Evt3Decoder::new(None), &scalar, &stream);
        let words = encoded::<Evt3Encoder>(&stream);
        time(name, "EVT 3.0", &Evt3Decoder::new(None), &words, &stream);
        let words = encoded::<Evt2Encoder>(&stream);
        time(name, "EVT 2.0", &Evt2Decoder::default(), &words, &stream);
        let words = encoded::<Evt21Encoder>(&stream);
        time(name, "EVT 2.1", &Evt21Decoder::new(false), &words, &stream);
        let records: Vec<u8> = stream
            .iter()
            .flat_map(|e| {
                let place = u32::from(e.x) | u32::from(e.y) << 14 | (e.polarity as u32) << 28;
                [e.t.0 as u32, place]
            })
            .flat_map(u32::to_le_bytes)
            .collect();
        time(name, "DAT", &DatDecoder::new(12, 8, None).unwrap(), &records, &stream);
    }
}

fn encoded<E: WordEncoder>(events: &EventStream) -> Vec<u8> {
    let mut words = Vec::new();
    E::new(events.sensor()).encode(events, &mut words).unwrap();
    words
}

/// Prints the best of some runs, in blocks as a file is read in.
fn time(stream: &str, format: &str, decoder: &impl Decoder, bytes: &[u8], want: &EventStream) {
    let mut columns = Columns::new();
    let mut best_s = f64::MAX;
    for _ in 0..RUNS {
        columns.clear();
        let mut decoder = decoder.clone();
        let start = Instant::now();
        for block in bytes.chunks(1 << 18) {
            decoder.decode(block, true, &mut columns).unwrap();
        }
        best_s = best_s.min(start.elapsed().as_secs_f64());
    }
    assert!(columns.iter().eq(want.iter()));
    let bytes_per_event = bytes.len() as f64 / want.len() as f64;
    let rate = want.len() as f64 / best_s * 1e-6;
    println!("{stream:10} {format:15} {bytes_per_event:5.2} bytes/event {rate:7.1} M events/s");
}
