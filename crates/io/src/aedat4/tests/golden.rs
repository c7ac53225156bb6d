//! Files that the camera maker's own library wrote, against what that library reads from them.

use std::fmt::Write as _;

use super::*;
use crate::golden::{event_lines, listed, sha256};

/// From `tests/golden/aedat4/README.md`.
const EVENTS: &str = "651d28e5f2273da880792bdc14a0671a4e1cd783934472284e1db6aac561b6a0";
const FRAMES: &str = "fd4a56764e38cd7f79c2c53e26ddedc632d6cf28f746438a87e4eb210a04e015";
const IMU: &str = "36d51426dc6284a7e3de7d8f39ccbed37408f31f15e3751f5b317e5ec03b3953";
const TRIGGERS: &str = "fd553fd929f0206d53c3ab204dffbc11ec418ae6d3b24edff8e2f151ccaf3344";
const FILES: [(&str, Compression); 5] = [
    ("dv_none.aedat4", Compression::None),
    ("dv_lz4.aedat4", Compression::Lz4),
    ("dv_lz4_high.aedat4", Compression::Lz4High),
    ("dv_zstd.aedat4", Compression::Zstd),
    ("dv_zstd_high.aedat4", Compression::ZstdHigh),
];

#[test]
fn files_of_dv_processing_are_read_as_it_reads_them() {
    for (name, compression) in FILES {
        let (bytes, _) = listed("aedat4", name);
        let [mut events, mut frames, mut imu, mut triggers] = [const { String::new() }; 4];
        let packets = Packets::from_input(Input::memory(name, bytes.clone())).unwrap();
        assert_eq!(packets.compression(), compression);
        let kinds: Vec<StreamKind> = packets.streams().iter().map(|stream| stream.kind).collect();
        assert_eq!(
            kinds,
            [StreamKind::Events, StreamKind::Frames, StreamKind::Imu, StreamKind::Triggers]
        );
        assert_eq!(packets.streams()[0].source, "DAVIS346_00000001");
        for packet in packets {
            match packet.unwrap().content {
                Content::Events(columns) => events += &event_lines(columns.iter()),
                Content::Frame(f) => {
                    let Frame { width, height, origin, .. } = f;
                    let (start, end) = (f.exposure_start.0, f.exposure_end.0);
                    let ((x, y), channels) = (f.position, f.format.channels);
                    write!(frames, "{start} {end} {width} {height} {x} {y} {origin} {channels} ")
                        .unwrap();
                    f.pixels.iter().for_each(|byte| write!(frames, "{byte:02x}").unwrap());
                    frames.push('\n');
                }
                Content::Imu(samples) => {
                    for s in samples {
                        let three = [s.acceleration_g, s.rotation_deg_per_s, s.field_ut];
                        write!(imu, "{} {:08x}", s.t.0, s.temperature_c.to_bits()).unwrap();
                        let rest = three.as_flattened().iter();
                        rest.for_each(|f| write!(imu, " {:08x}", f.to_bits()).unwrap());
                        imu.push('\n');
                    }
                }
                Content::Triggers(found) => {
                    for t in found {
                        writeln!(triggers, "{} {}", t.t.0, t.kind.number()).unwrap();
                    }
                }
                Content::Other(letters, _) => panic!("{}", letters.escape_ascii()),
            }
        }
        assert_eq!(sha256(events.as_bytes()), EVENTS, "{name}");
        assert_eq!(sha256(frames.as_bytes()), FRAMES, "{name}:\n{frames}");
        assert_eq!(sha256(imu.as_bytes()), IMU, "{name}:\n{imu}");
        assert_eq!(sha256(triggers.as_bytes()), TRIGGERS, "{name}:\n{triggers}");
        let read = open(&bytes, &OpenOptions::default()).unwrap();
        assert_eq!(sha256(event_lines(read.stream.iter()).as_bytes()), EVENTS, "{name}");
        assert_eq!((read.stream.sensor(), read.remarks.len()), (SENSOR, 0));
    }
}
