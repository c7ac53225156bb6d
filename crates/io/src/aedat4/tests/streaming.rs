//! Streams that come piece by piece.

use super::*;
use crate::golden::{event_lines, listed, sha256};
use crate::wire::Wire;

/// From `tests/golden/aedat4-network/README.md`: what dv-processing's `NetworkWriter` sent.
const EVENTS: &str = "7f3530d051602d1e39dfbe472c7a6fac9e9141cd0d122af05ed9b2fd041d9521";
const WRITABLE: [Compression; 3] = [Compression::None, Compression::Lz4, Compression::Zstd];

fn pieces(bytes: &[u8], size: usize) -> Wire {
    Wire::new(bytes.chunks(size).map(<[u8]>::to_vec), true)
}

/// All events of camera 0, packets that were passed over, and how it ended.
fn read(bytes: &[u8], size: usize) -> (Columns, u64, Result<(), IoError>) {
    let mut columns = Columns::new();
    let mut stream = match Aedat4Stream::open("test", pieces(bytes, size), 0) {
        Ok(stream) => stream,
        Err(error) => return (columns, 0, Err(error)),
    };
    loop {
        match stream.next(&mut columns) {
            Ok(true) => {}
            Ok(false) => return (columns, stream.malformed(), Ok(())),
            Err(error) => return (columns, stream.malformed(), Err(error)),
        }
    }
}

/// A stream as the network has it: without version line and table.
fn sent(compression: Compression) -> Vec<u8> {
    killed(file(compression, &streams(), &recording())).split_off(MAGIC.len())
}

#[test]
fn streams_of_dv_processing_are_read() {
    for name in ["none", "lz4", "zstd"] {
        let (bytes, _) = listed("aedat4-network", &format!("dv_network_{name}.bin"));
        assert!(is_stream(&bytes[..SNIFF_BYTES]));
        for size in [1, 700, 1 << 20] {
            let (columns, malformed, ended) = read(&bytes, size);
            ended.unwrap();
            assert_eq!((columns.len(), malformed), (161, 0));
            assert_eq!(sha256(event_lines(columns.iter()).as_bytes()), EVENTS, "{name}");
        }
        let stream = Aedat4Stream::open("test", &bytes[..], 0).unwrap();
        assert_eq!(stream.sensor(), Some(SENSOR));
    }
}

#[test]
fn files_are_streams_too_with_and_without_their_table() {
    for compression in WRITABLE {
        let whole = file(compression, &streams(), &recording());
        for bytes in [killed(whole.clone()), whole, sent(compression)] {
            let (columns, malformed, ended) = read(&bytes, 11);
            ended.unwrap();
            assert!(columns.iter().eq((0..90).map(event)) && malformed == 0);
        }
    }
}

#[test]
fn a_packet_is_given_before_the_next_one_comes() {
    let bytes = sent(Compression::Lz4);
    let packets = killed(file(Compression::Lz4, &streams(), &recording()[..1]));
    let first = packets.len() - MAGIC.len();
    for more in [0, 1, 7] {
        // A wire that panics where somebody would wait for ever.
        let wire = Wire::new(bytes[..first + more].chunks(100).map(<[u8]>::to_vec), false);
        let mut stream = Aedat4Stream::open("test", wire, 0).unwrap();
        let mut columns = Columns::new();
        assert!(stream.next(&mut columns).unwrap());
        assert_eq!(columns.len(), 40);
    }
}

#[test]
fn another_camera_is_chosen_and_one_that_is_not_there_refused() {
    let bytes = sent(Compression::Zstd);
    let mut columns = Columns::new();
    let mut stream = Aedat4Stream::open("test", &bytes[..], 1).unwrap();
    assert!(stream.next(&mut columns).unwrap() && !stream.next(&mut columns).unwrap());
    assert_eq!(columns.len(), 3);
    let message = Aedat4Stream::open("test", &bytes[..], 2).err().unwrap().to_string();
    assert_eq!(message, "test: no camera 2: the stream has 2 of them");
}

#[test]
fn a_stream_cut_at_any_byte_gives_an_error_or_ends_between_packets() {
    let whole: Columns = (0..90).map(event).collect();
    for compression in WRITABLE {
        let bytes = sent(compression);
        let mut ends = 0;
        for cut in 0..bytes.len() {
            let (columns, malformed, ended) = read(&bytes[..cut], 64);
            assert!(columns.iter().eq(whole.iter().take(columns.len())) && malformed == 0);
            match ended {
                Ok(()) => ends += 1,
                Err(IoError::Damaged { byte, events, .. }) => {
                    assert!(byte <= cut as u64 && events == columns.len() as u64, "{cut}");
                }
                Err(other) => panic!("{cut}: {other}"),
            }
        }
        // Behind the header, and behind each packet but the last.
        assert_eq!(ends, recording().len());
    }
}

#[test]
fn a_packet_that_makes_no_sense_is_passed_over() {
    for compression in WRITABLE {
        let good = sent(compression);
        let begin = killed(file(compression, &streams(), &[])).len() - MAGIC.len();
        // The first packet: its frame of LZ4 or Zstandard, or its four letters.
        let mut bytes = good.clone();
        let place = begin + 8 + if compression == Compression::None { 8 } else { 0 };
        bytes[place] ^= 0xff;
        let (columns, malformed, ended) = read(&bytes, 50);
        ended.unwrap();
        assert_eq!((columns.len(), malformed), (50, 1), "{compression}");
        assert!(columns.iter().eq((40..90).map(event)));
        // Sizes that make no sense lose the frame.
        for (size, why) in [(-1, "a size below zero"), (i32::MAX, "more than 256 MiB")] {
            let mut bytes = good.clone();
            bytes[begin + 4..begin + 8].copy_from_slice(&i32::to_le_bytes(size));
            let message = read(&bytes, 50).2.unwrap_err().to_string();
            assert!(message.contains(&format!("byte {}: ", begin + 4)), "{message}");
            assert!(message.contains(why), "{message}");
        }
    }
}

#[test]
fn what_is_no_stream_is_refused_at_once() {
    let message = |bytes: &[u8]| read(bytes, 5).2.unwrap_err().to_string();
    assert!(message(b"#!AER-DAT3.1\r\n#Format").contains("the first line is not"));
    assert!(message(b"GET / HTTP/1.1\r\n").contains("a header of 542393671 bytes is none"));
    assert!(message(b"#!AER-").contains("byte 6: the stream ends in its header"));
    assert!(message(&[0; 40]).contains("byte 4: the header"));
    assert!(!is_stream(b"EVPOSE1\n\0\0\0\0"));
    assert!(!is_stream(b"#!AER"));
}

#[test]
fn random_bytes_behind_a_header_never_panic() {
    use proptest::prelude::*;
    let header = killed(file(Compression::None, &streams(), &[]));
    let bytes =
        prop::collection::vec(prop::sample::select(b"\0\0\0\0\x01\x10EVTS\xff".to_vec()), 0..300);
    proptest!(|(bytes in bytes, size in 1..60_usize)| {
        let _ = read(&[&header[..], &bytes].concat(), size);
        let _ = read(&bytes, size);
    });
}
