//! Representations against other programs on the same events: see `golden/README.md`.

#![allow(clippy::unwrap_used, reason = "tests")]

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use evpose_repr::{
    ChannelOrder, Eros, ErosConfig, ErosFramer, Representation, StreamWindow,
    representation_by_name,
};
use sha2::{Digest, Sha256};

const SMALL: SensorSize = SensorSize { width: 24, height: 24 };
const LARGE: SensorSize = SensorSize { width: 640, height: 480 };

/// An edge that moves to the right, noise within it, as `golden/README.md` says.
fn events(count: usize, sensor: SensorSize) -> EventStream {
    let (width, height) = (u64::from(sensor.width), u64::from(sensor.height));
    let (mut state, mut t) = (1u64, 0);
    let mut stream = EventStream::empty(sensor);
    for i in 0..count as u64 {
        state = state.wrapping_mul(6_364_136_223_846_793_005);
        state = state.wrapping_add(1_442_695_040_888_963_407);
        let r = state >> 33;
        t += r % 64;
        let x = ((i / 8) % width + (r >> 6) % 8) % width;
        let y = (r >> 9) % height;
        let polarity = Polarity::from_on((r >> 20) & 1 == 1);
        let event = Event { t: Micros(t as i64), x: x as u16, y: y as u16, polarity };
        stream.push(event).unwrap();
    }
    stream
}

fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// `name` on all events, at the time of the last or later.
fn started(name: &str, events: &EventStream, at: Option<Micros>) -> Box<dyn Representation> {
    let window =
        StreamWindow::new(events.sensor(), StreamWindow::MAX_LENGTH, ChannelOrder::OffFirst);
    let mut representation = representation_by_name(name).unwrap().start(window.unwrap());
    representation.push(events);
    representation.advance(at.unwrap_or(Micros(0)));
    representation
}

fn planes(name: &str, events: &EventStream, at: Option<Micros>) -> Vec<f32> {
    let representation = started(name, events, at);
    let mut out = vec![f32::NAN; representation.channels() * events.sensor().pixels()];
    representation.render(&mut out);
    out
}

/// Values that are integers up to 255.
fn whole(planes: &[f32]) -> Vec<u8> {
    assert!(planes.iter().all(|&value| value == f32::from(value as u8)));
    planes.iter().map(|&value| value as u8).collect()
}

fn f64_bytes(representation: &Eros, sensor: SensorSize) -> Vec<u8> {
    let mut out = vec![f64::NAN; sensor.pixels()];
    representation.render_f64(&mut out);
    out.iter().flat_map(|value| value.to_le_bytes()).collect()
}

#[test]
fn the_events_are_those_that_the_other_programs_had() {
    let mut records = Vec::new();
    for event in events(900, SMALL).iter() {
        records.extend((event.t.0 as u32).to_le_bytes());
        records.extend(event.x.to_le_bytes());
        records.extend(event.y.to_le_bytes());
        records.extend([event.polarity as u8, 0, 0, 0]);
    }
    let want = "b9d7a4594ebdb3c4289df6ec9fb2006b11dcc25c5ffdf3cf156c64b4f17e6b04";
    assert_eq!(sha256(&records), want);
}

#[test]
fn representations_of_small_integers_are_those_of_the_other_programs() {
    let (small, large) = (events(900, SMALL), events(200_000, LARGE));
    #[rustfmt::skip]
    let cases = [
        ("eros-python", &small, "54ae592f933ada03588802d6a9a2d5ca56fe1fdb45e78075d820700886c1d055"),
        ("eros-python", &large, "0b64ada7b931b3178fe3c5d9975f89a150f3958d212d0216ff0e9e98b5789130"),
        ("eros-python:kernel=6,decay=0.6", &small, "bb6896bccb8a547498ae15b546d70f0145d34fe1a2d463873b5564d09ae64db3"),
        ("tos", &small, "4e158ca1b1b585a1af7fc94c899e2c07df382cf7434fae44fe0b68d332eacc7f"),
        ("tos", &large, "48a896faebe862b4d4c616b0a2f772acdc1282a5cb456ccdfff1c59ff611a009"),
        ("sits-hpe-core", &small, "408fad5e8eb1fd321f21d752a82249fb90a43f26349778d9f4524f1b81f4ef95"),
        ("sits-hpe-core", &large, "64460f6c16d621fda78a89474bd82d1ee715c3aef18d58fa668e300598981d9d"),
        ("sits", &small, "e42dba4fc107e5d34881308107a774658a507749619e4958a5258f4da207c3ac"),
        ("event-count", &small, "757e3ab0fc5bc898136d81d57d5a1c6d1a5772ec3ab018b5564175f0723715c9"),
        // Of Tonic, whose counts have 16 bits, in 8.
        ("eci", &small, "c8c6aab48b1dede2bf52a7b0ed3924e2b169b7868a88b5b941bb6aebb7b6d589"),
    ];
    for (name, events, want) in cases {
        assert_eq!(sha256(&whole(&planes(name, events, None))), want, "{name}");
    }
}

#[test]
fn eros_of_the_online_program_is_the_same_to_the_last_bit() {
    #[rustfmt::skip]
    let cases = [
        (900, SMALL, "49655eb9a9364a967f8901748b7cabeabac4f0349cfb716982887ee323948853"),
        (200_000, LARGE, "477c7c48ea0ae322c140feb4a509c9c836dd242e9eb8d1e2f2d78f348f37362f"),
    ];
    for (count, sensor, want) in cases {
        let mut representation = Eros::hpe_core(sensor, ErosConfig::ONLINE);
        representation.push(&events(count, sensor));
        assert_eq!(sha256(&f64_bytes(&representation, sensor)), want);
    }
}

#[test]
fn eros_by_definition_is_that_of_the_online_program_but_for_rounding() {
    let (large, mut values) = (events(200_000, LARGE), vec![0.0; LARGE.pixels()]);
    let mut representation = Eros::hpe_core(LARGE, ErosConfig::ONLINE);
    representation.push(&large);
    representation.render_f64(&mut values);
    let mut fired = 0;
    for (ours, theirs) in planes("eros", &large, None).into_iter().zip(values) {
        // Half a unit in the last place, and what is too small for an f32.
        assert!((f64::from(ours) - theirs).abs() <= theirs * 6.1e-8 + 1.2e-38, "{ours} {theirs}");
        fired += usize::from(ours > 0.0);
    }
    assert!(fired > 100_000, "{fired}");
}

#[test]
fn the_image_sent_to_the_network_is_that_of_opencv() {
    let mut representation = Eros::hpe_core(LARGE, ErosConfig::ONLINE);
    representation.push(&events(200_000, LARGE));
    let mut framer = ErosFramer::new(LARGE, 192, 192);
    let mut blurred = vec![0; LARGE.pixels()];
    framer.blurred(&representation, &mut blurred);
    let want = "68b70a21c9c51cddf199e2624d3e3157fb86eb3dfc755b495909b4fa9de0f606";
    assert_eq!(sha256(&blurred), want);
    #[rustfmt::skip]
    let cases = [
        (192, 192, "255653422fb70183d0698fe017da34820d1deb30f612c8302fb0fa0d89be8060"),
        (300, 700, "7d22437aacb69a222e6a6650f5152d5633a4dc40dcb43a20aee7cbe0cf7f9ef8"),
    ];
    for (width, height, want) in cases {
        let mut framer = ErosFramer::new(LARGE, width, height);
        let mut resized = vec![0; width * height];
        framer.resized(&representation, &mut resized);
        // The framer has no state from the frame before.
        framer.resized(&representation, &mut resized);
        assert_eq!(sha256(&resized), want, "{width}x{height}");
    }
}

#[test]
fn representations_of_fractions_are_those_of_the_other_programs_but_for_rounding() {
    let events = events(900, SMALL);
    let (first, last) = (events.t()[0], events.t()[899]);
    let cases: [(&str, &[u8], Option<Micros>); 4] = [
        ("pim:rate=50", include_bytes!("golden/pim-rate-50.f32"), None),
        ("fixed-count:n=400", include_bytes!("golden/fixed-count-n-400.f32"), None),
        ("voxel-grid:bins=5", include_bytes!("golden/voxel-grid-bins-5.f32"), None),
        // Tonic's time surface is that of one microsecond after the last event.
        (
            "time-surface:tau_ms=5",
            include_bytes!("golden/time-surface-tau-5ms.f32"),
            Some(Micros(last.0 + 1)),
        ),
    ];
    assert_eq!((first, last), (Micros(22), Micros(28_618)));
    for (name, bytes, at) in cases {
        let (theirs, rest) = bytes.as_chunks::<4>();
        let theirs: Vec<_> = theirs.iter().copied().map(f32::from_le_bytes).collect();
        let ours = planes(name, &events, at);
        assert!(rest.is_empty() && ours.len() == theirs.len(), "{name}");
        let largest = theirs.iter().fold(0.0f32, |most, value| value.abs().max(most));
        for (ours, theirs) in ours.iter().zip(&theirs) {
            // Sums of some ten values, each rounded to 24 bits.
            assert!((ours - theirs).abs() <= 1e-6 * largest, "{name}: {ours} {theirs}");
        }
    }
}

#[test]
fn a_polarity_integrated_image_has_the_grey_values_of_the_published_program() {
    let events = events(900, SMALL);
    let mut grey = vec![0; SMALL.pixels()];
    started("pim:rate=50", &events, None).render_u8(&mut grey);
    let want = "ae65143b15a658a92a0bd6adb36b25b8394462ce66df478804e41c341bda35f1";
    assert_eq!(sha256(&grey), want);
}
