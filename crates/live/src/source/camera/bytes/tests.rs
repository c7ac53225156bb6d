//! Transfers of cameras, word by word.
use evpose_io::Decoder;
use evpose_io::evt::{Evt3Decoder, Evt3Encoder, WordEncoder, synthetic};
use neuromorphic_drivers::adapters::{davis346, dvxplorer, evt3};
use neuromorphic_drivers::{inivation_davis346, inivation_dvxplorer};

use super::*;

fn event(t: i64, x: u16, y: u16, on: bool) -> Event {
    Event { t: Micros(t), x, y, polarity: Polarity::from_on(on) }
}

/// The events of words that come in transfers of so many bytes.
fn decoded(adapter: impl Into<Adapter>, bytes: &[u8], transfer: usize) -> Columns {
    let mut adapter = adapter.into();
    let mut columns = Columns::new();
    bytes.chunks(transfer).for_each(|bytes| decode(&mut adapter, bytes, &mut columns));
    columns
}

fn words(words: &[u16]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_le_bytes()).collect()
}

#[test]
fn words_of_prophesee_are_decoded_as_those_of_a_file() {
    let sensor = synthetic::SENSOR;
    for events in [synthetic::edges(40_000), synthetic::scattered(10_000)] {
        let mut bytes = Vec::new();
        Evt3Encoder::new(sensor).encode(&events, &mut bytes).unwrap();
        let mut file = Columns::new();
        Evt3Decoder::new(None).decode(&bytes, true, &mut file).unwrap();
        assert!(file.iter().eq(events.iter()));
        for transfer in [2, 998, 1 << 17] {
            let adapter = evt3::Adapter::from_dimensions(sensor.width, sensor.height);
            assert!(decoded(adapter, &bytes, transfer) == file, "{transfer}");
        }
    }
}

/// # Source
/// libcaer 3.3, `davis.c`: bit 15 marks a time stamp; else bits 14 to 12 mark 0 a special word, 1 a
/// row, 2 and 3 a column of an OFF and of an ON event, 4 a sample of a frame, 5 a byte, 7 a wrap of
/// the time.
#[test]
fn words_of_a_davis_are_decoded() {
    let bytes = words(&[
        0x8000 | 100, // time
        0x1000 | 259,
        0x2000 | 345,
        0x3000,
        0x0008, // a frame begins
        0x4000 | 77,
        0x0005, // a sample of the inertial unit begins
        0x5000 | 0x300,
        0x0007, // and ends
        0x0003, // an edge at the trigger's input
        0x7001, // the time of 15 bits begins again
        0x8000 | 5,
        0x1000 | 260, // no row of the sensor
        0x3000 | 1,
        0x1000 | 3,
        0x3000 | 346, // no column
        0x3000 | 1,
    ]);
    let aps = inivation_davis346::ApsOrientation { flip_x: false, flip_y: false, invert_xy: false };
    let imu = inivation_davis346::ImuOrientation { flip_x: false, flip_y: false, flip_z: false };
    let kind = inivation_davis346::ImuType::None;
    for transfer in [2, 6, 1 << 17] {
        let adapter = davis346::Adapter::new(false, aps, imu, kind);
        let events: Vec<Event> = decoded(adapter, &bytes, transfer).iter().collect();
        let want =
            [event(100, 345, 259, false), event(100, 0, 259, true), event(0x8005, 1, 3, true)];
        assert_eq!(events, want);
    }
}

/// # Source
/// libcaer 3.3, `dvxplorer.c`: as of a DAVIS, but 1 marks a column, 4 two groups of eight rows, of
/// which the second is given from the first (bits 10 to 6, bit 11 for backwards), and 3 and 2 mark
/// the pixels of the first and of the second that have an event, which is OFF where bit 8 is set.
#[test]
fn words_of_a_dvxplorer_are_decoded() {
    let bytes = words(&[
        0x8000 | 7,
        0x1000 | 639,
        0x4000 | 1 << 11 | 1 << 6 | 59,
        0x3000 | 0b1000_0001,
        0x2000 | 0x100 | 0b10,
        0x7001,
        0x1000 | 640, // no column of the sensor
        0x3000 | 1,
        0x1000 | 2,
        0x4000 | 2 << 6,
        0x2000 | 1,
    ]);
    let dvs =
        inivation_dvxplorer::DvsOrientation { flip_x: false, flip_y: false, invert_xy: false };
    let imu = inivation_dvxplorer::ImuOrientation { flip_x: false, flip_y: false, flip_z: false };
    for transfer in [2, 8, 1 << 17] {
        let adapter = dvxplorer::Adapter::new(dvs, imu);
        let events: Vec<Event> = decoded(adapter, &bytes, transfer).iter().collect();
        let want = [
            event(7, 639, 472, true),
            event(7, 639, 479, true),
            event(7, 639, 465, false),
            event(0x8000, 2, 16, true),
        ];
        assert_eq!(events, want);
    }
}
