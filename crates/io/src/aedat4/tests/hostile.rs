//! Files that were cut, changed, or made to harm.

use proptest::prelude::*;

use super::*;

const WRITABLE: [Compression; 3] = [Compression::None, Compression::Lz4, Compression::Zstd];

/// The readable part of a file, and its fault.
fn salvaged(bytes: &[u8]) -> (Columns, Option<IoError>) {
    let mut columns = Columns::new();
    let input = Input::memory("recording.aedat4", bytes.to_vec());
    let mut source = match crate::source(input, &OpenOptions::default()) {
        Ok((_, source)) => source,
        Err(error) => return (columns, Some(error)),
    };
    loop {
        let before = columns.len();
        match source.next(&mut columns) {
            Ok(()) if columns.len() == before => return (columns, None),
            Ok(()) => {}
            Err(error) => return (columns, Some(error)),
        }
    }
}

#[test]
fn a_file_cut_at_any_byte_gives_an_error_or_the_exact_prefix() {
    let whole: Columns = (0..90).map(event).collect();
    for compression in WRITABLE {
        let bytes = file(compression, &streams(), &recording());
        let table = header::read(&mut Input::memory("x", bytes.clone())).unwrap().table.unwrap();
        let mut most = 0;
        for cut in 0..bytes.len() {
            let (found, error) = salvaged(&bytes[..cut]);
            assert!(found.iter().eq(whole.iter().take(found.len())), "{compression} at {cut}");
            assert!(found.len() >= most, "{compression} at {cut}: fewer events than before");
            most = found.len();
            assert_eq!(error.is_some(), cut < table as usize, "{compression} at {cut}");
            match error {
                Some(IoError::Damaged { byte, events, .. }) => {
                    assert!(byte <= cut as u64 && events == found.len() as u64, "at {cut}");
                }
                Some(IoError::UnknownFormat { .. }) => assert!(cut < MAGIC.len()),
                Some(other) => assert!(cut < 20, "{other}"),
                None => assert_eq!(found, whole),
            }
        }
        assert_eq!(most, 90);
    }
}

#[test]
fn events_before_the_cut_of_a_packet_are_kept() {
    let bytes = killed(file(Compression::None, &streams(), &recording()));
    // 16 bytes an event, and up to 7 of padding at the end of a packet.
    let (found, error) = salvaged(&bytes[..bytes.len() - 10 * 16]);
    assert!((78..=81).contains(&found.len()), "{}", found.len());
    assert!(error.unwrap().to_string().contains("bytes into a body of"));
}

#[test]
fn after_damage_the_same_damage_is_found_again() {
    let mut bytes = killed(file(Compression::None, &streams(), &recording()));
    bytes.truncate(bytes.len() - 100);
    let mut source = source(&bytes);
    let mut columns = Columns::new();
    let messages: Vec<String> = (0..20)
        .filter_map(|_| source.next(&mut columns).err())
        .map(|error| error.to_string())
        .collect();
    assert!(messages.len() > 5 && messages.windows(2).all(|pair| pair[0] == pair[1]));
}

#[test]
fn a_packet_that_claims_more_than_the_file_has_fills_no_memory() {
    let mut bytes = file(Compression::None, &streams(), &[]);
    bytes.extend_from_slice(&0_i32.to_le_bytes());
    bytes.extend_from_slice(&i32::MAX.to_le_bytes());
    bytes.extend_from_slice(b"some bytes");
    let table = header::read(&mut Input::memory("x", bytes.clone())).unwrap().table.unwrap();
    let place = bytes.windows(8).position(|eight| eight == table.to_le_bytes()).unwrap();
    bytes[place..place + 8].copy_from_slice(&(-2_i64).to_le_bytes());
    // The old table stands where the first packet should be.
    assert!(salvaged(&bytes).1.unwrap().is_damage());
}

#[test]
fn packets_of_ever_new_streams_are_no_recording() {
    let mut bytes = killed(file(Compression::None, &streams(), &[]));
    // A FlatBuffer of no fields that calls itself frames.
    let body = [16, 0, 0, 0, 8, 0, 0, 0, b'F', b'R', b'M', b'E', 4, 0, 0, 0, 4, 0, 4, 0];
    for stream in 100..1_000_i32 {
        bytes.extend_from_slice(&stream.to_le_bytes());
        bytes.extend_from_slice(&(body.len() as i32).to_le_bytes());
        bytes.extend_from_slice(&body);
    }
    let (_, error) = salvaged(&bytes);
    let error = error.unwrap();
    assert!(error.is_damage() && error.to_string().contains("more streams"), "{error}");
}

#[test]
fn a_zstandard_bomb_is_stopped() {
    // One block of 128 KiB out of one byte, again and again: 4 bytes each.
    let mut frame = vec![0x28, 0xb5, 0x2f, 0xfd, 0x00, 0x58];
    for _ in 0..4000 {
        let header: u32 = (1 << 17) << 3 | 1 << 1;
        frame.extend_from_slice(&header.to_le_bytes()[..3]);
        frame.push(7);
    }
    let mut inflater = Inflater::new();
    let fault = inflater.inflate(Compression::Zstd, &frame).unwrap_err();
    assert!(fault.contains("256 MiB"), "{fault}");
}

#[test]
fn a_zstandard_window_that_the_packet_cannot_fill_is_refused() {
    // 128 MiB, of 6 bytes; the first frame is without harm.
    let mut inflater = Inflater::new();
    inflater.inflate(Compression::Zstd, b"\x28\xb5\x2f\xfd\x20\x01\x09\0\0a").unwrap();
    assert_eq!(inflater.out.filled(), b"a");
    let frame = [0x28, 0xb5, 0x2f, 0xfd, 0x00, 0x88];
    assert!(inflater.inflate(Compression::Zstd, &frame).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(400))]

    #[test]
    fn changed_bytes_never_panic(
        which in 0..3_usize, changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        t in START..START + 1_000, table in any::<bool>(),
    ) {
        static FILES: std::sync::OnceLock<Vec<Vec<u8>>> = std::sync::OnceLock::new();
        let files = FILES.get_or_init(|| {
            WRITABLE.map(|compression| file(compression, &streams(), &recording())).to_vec()
        });
        let mut bytes = files[which].clone();
        // Most of a small file is its XML: half of the changes are behind it.
        let packets_at = bytes.windows(5).position(|end| end == b"</dv>").unwrap();
        for (place, value) in changes {
            let from = if table { packets_at } else { 0 };
            let place = from + place.index(bytes.len() - from);
            bytes[place] = value;
        }
        salvaged(&bytes);
        let input = || Input::memory("recording.aedat4", bytes.clone());
        if let Ok(packets) = Packets::from_input(input()) {
            prop_assert!(packets.count() < 1000);
        }
        if let Ok((_, mut source)) = crate::source(input(), &OpenOptions::default()) {
            let mut columns = Columns::new();
            let _ = (source.seek(Micros(t)), source.next(&mut columns), source.remarks());
        }
    }
}
