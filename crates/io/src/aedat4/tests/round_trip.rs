//! Round trips: reading returns the written content.

use std::io::Write as _;

use lz4_flex::frame::{BlockMode, BlockSize, FrameEncoder, FrameInfo};
use proptest::prelude::*;

use super::super::compression::{Inflater, Scratch};
use super::super::lz4;
use super::*;

fn any_events() -> impl Strategy<Value = Columns> {
    let event = (any::<i64>(), 0..32_768_u16, 0..32_768_u16, any::<bool>());
    let event = event.prop_map(|(t, x, y, on)| Event {
        t: Micros(t),
        x,
        y,
        polarity: Polarity::from_on(on),
    });
    prop::collection::vec(event, 0..60).prop_map(Columns::from_iter)
}

prop_compose! {
    fn any_frame()(
        times in any::<[i64; 5]>(), depth in 0..7_usize, channels in 1..=4_u8, width in 0..9_u16,
        height in 0..9_u16, position in any::<(i16, i16)>(), origin in any::<i8>(), seed in any::<u8>(),
    ) -> Frame {
        let format = PixelFormat { depth: Depth::ALL[depth], channels };
        let bytes = usize::from(width * height) * format.bytes();
        let [t, readout_start, readout_end, exposure_start, exposure_end] = times.map(Micros);
        let pixels = (0..bytes).map(|k| (k as u8).wrapping_mul(seed)).collect();
        Frame {
            t, readout_start, readout_end, exposure_start, exposure_end, format, width, height,
            position, origin, pixels,
        }
    }
}

fn any_imu() -> impl Strategy<Value = ImuSample> {
    let three = || prop::array::uniform3(any::<f32>());
    (any::<i64>(), any::<f32>(), three(), three(), three()).prop_map(
        |(t, temperature_c, a, g, m)| ImuSample {
            t: Micros(t),
            temperature_c,
            acceleration_g: a,
            rotation_deg_per_s: g,
            field_ut: m,
        },
    )
}

fn any_packet() -> impl Strategy<Value = Aedat4Packet> {
    let trigger = any::<(i64, i8)>();
    let trigger =
        trigger.prop_map(|(t, n)| Trigger { t: Micros(t), kind: TriggerKind::from_code(n) });
    let other = prop::collection::vec(any::<u8>(), 8..50).prop_map(|mut bytes| {
        // A size that fits, and letters of its own.
        bytes.splice(4..4, *b"\x08\0\0\0BBOX");
        let size = bytes.len() as u32 - 4;
        bytes[..4].copy_from_slice(&size.to_le_bytes());
        // A root table without any field.
        bytes[12..16].copy_from_slice(&[0; 4]);
        bytes
    });
    prop_oneof![
        any_events().prop_map(|events| (0, Content::Events(events))),
        any_frame().prop_map(|frame| (1, Content::Frame(frame))),
        prop::collection::vec(any_imu(), 0..20).prop_map(|samples| (2, Content::Imu(samples))),
        prop::collection::vec(trigger, 0..20).prop_map(|found| (3, Content::Triggers(found))),
        other.prop_map(|bytes| (4, Content::Other(*b"BBOX", bytes))),
    ]
    .prop_map(|(stream, content)| Aedat4Packet { stream, content })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn packets_of_every_kind_survive_every_compression(
        written in prop::collection::vec(any_packet(), 0..12),
    ) {
        let mut streams = streams();
        streams.insert(4, stream(4, StreamKind::Other(*b"BBOX")));
        for compression in Compression::ALL.into_iter().filter(|c| c.is_writable()) {
            let bytes = file(compression, &streams, &written);
            let read: Vec<Aedat4Packet> = packets(&bytes).into_iter().map(Result::unwrap).collect();
            prop_assert_eq!(&read, &written);
            let of = Packets::from_input(Input::memory("x", bytes)).unwrap();
            prop_assert_eq!((of.compression(), of.streams()), (compression, &streams[..]));
        }
    }

    #[test]
    fn a_stream_survives_the_file_batch_by_batch(
        mut times in prop::collection::vec(any::<i64>(), 1..200), cut in any::<prop::sample::Index>(),
        repeated in 1..400_usize,
    ) {
        times.sort_unstable();
        let sensor = SensorSize { width: 4_096, height: 4_096 };
        let event = |(k, &t): (usize, &i64)| Event {
            t: Micros(t), x: (k * 677 % 4_096) as u16, y: (k * 31 % 4_096) as u16,
            polarity: Polarity::from_on(t % 3 == 0),
        };
        let times: Vec<i64> = times.iter().flat_map(|&t| vec![t; repeated]).collect();
        let events: Vec<Event> = times.iter().enumerate().map(event).collect();
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join("recording.aedat4");
        let mut sink = FORMAT.create(&path, sensor).unwrap();
        let (first, second) = events.split_at(cut.index(events.len()));
        for part in [first, second] {
            sink.write(&EventStream::from_events(sensor, part.iter().copied())?).unwrap();
        }
        sink.finish().unwrap();
        let read = crate::open(&path).unwrap();
        // Times of any year are doubted, and nothing else.
        let is_doubt = |remark: &String| remark.contains("another unit");
        prop_assert!(read.format == "aedat4" && read.remarks.iter().all(is_doubt));
        prop_assert_eq!(read.stream, EventStream::from_events(sensor, events)?);
    }

    #[test]
    fn lz4_frames_of_every_make_are_read(
        seed in prop::collection::vec(any::<u8>(), 1..64), repeated in 1..6_000_usize,
        linked in any::<bool>(), sums in any::<(bool, bool, bool)>(), size in 0..4_usize,
    ) {
        let bytes: Vec<u8> = seed.iter().copied().cycle().take(seed.len() * repeated).enumerate()
            .map(|(k, byte)| if k % 97 == 0 { k as u8 } else { byte }).collect();
        let sizes = [BlockSize::Max64KB, BlockSize::Max256KB, BlockSize::Max1MB, BlockSize::Max4MB];
        let info = FrameInfo::new()
            .block_size(sizes[size])
            .block_mode(if linked { BlockMode::Linked } else { BlockMode::Independent })
            .block_checksums(sums.0)
            .content_checksum(sums.1)
            .content_size(sums.2.then_some(bytes.len() as u64));
        let mut encoder = FrameEncoder::with_frame_info(info, Vec::new());
        encoder.write_all(&bytes).unwrap();
        let mut frame = encoder.finish().unwrap();
        let mut out = Scratch::default();
        lz4::inflate(&frame, &mut out).unwrap();
        prop_assert_eq!(out.filled(), &bytes[..]);
        if sums.1 {
            *frame.last_mut().unwrap() ^= 1;
            prop_assert!(lz4::inflate(&frame, &mut Scratch::default()).is_err());
        }
    }
}

#[test]
fn memory_of_a_packet_before_is_no_part_of_the_next() {
    let mut inflater = Inflater::new();
    for text in ["a packet that is long", "short", ""] {
        inflater.inflate(Compression::None, text.as_bytes()).unwrap();
        assert_eq!(inflater.out.filled(), text.as_bytes());
    }
}
