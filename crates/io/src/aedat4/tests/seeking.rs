//! Going to a time.

use super::*;

/// Packets of 50 events, among those of other streams.
fn long() -> Vec<Aedat4Packet> {
    let part = |k: i64| {
        let other = Aedat4Packet { stream: 7, content: events(0..2) };
        [Aedat4Packet { stream: 0, content: events(50 * k..50 * k + 50) }, other]
    };
    (0..40).flat_map(part).collect()
}

/// The first events from `t` on.
fn from(source: &mut dyn EventSource, t: i64) -> Columns {
    source.seek(Micros(t)).unwrap();
    let mut columns = Columns::new();
    for _ in 0..3 {
        source.next(&mut columns).unwrap();
    }
    columns
}

fn is_there(source: &mut dyn EventSource, k: i64) {
    let found = from(source, START + 10 * k);
    let first = (found.t[0].0 - START) / 10;
    assert!(first <= k && k - first < 50, "event {k}: from event {first} on");
    assert!(found.iter().eq((first..first + found.len() as i64).map(event)));
}

#[test]
fn a_time_is_found_with_the_data_table_and_without() {
    for compression in [Compression::None, Compression::Lz4] {
        let bytes = file(compression, &streams(), &long());
        for bytes in [bytes.clone(), killed(bytes)] {
            let mut source = source(&bytes);
            for k in [1999, 0, 50, 49, 1234, 1200, 3, 1998, 51] {
                is_there(source.as_mut(), k);
            }
            let mut columns = Columns::new();
            source.seek(Micros(i64::MIN)).unwrap();
            source.next(&mut columns).unwrap();
            assert_eq!(columns.event(0), event(0));
            source.seek(Micros(START + 20_000)).unwrap();
            let mut rest = Columns::new();
            source.next(&mut rest).unwrap();
            assert!(rest.len() <= 50 && rest.iter().all(|event| event.t.0 < START + 20_000));
        }
    }
}

#[test]
fn a_data_table_that_does_not_fit_the_packets_is_not_used() {
    let mut bytes = file(Compression::None, &streams(), &long());
    let table = header::read(&mut Input::memory("x", bytes.clone())).unwrap().table.unwrap();
    let entries = table::decode(&bytes[table as usize..]).unwrap();
    // Every place in the table is moved by some bytes.
    for entry in &entries {
        let from = table as usize
            + bytes[table as usize..]
                .windows(8)
                .position(|b| b == entry.body.to_le_bytes())
                .unwrap();
        bytes[from..from + 8].copy_from_slice(&(entry.body + 3).to_le_bytes());
    }
    let mut source = source(&bytes);
    for k in [1999, 0, 50, 1234] {
        is_there(source.as_mut(), k);
    }
    assert!(source.remarks().iter().any(|remark| remark.contains("data table")));
}

#[test]
fn the_data_table_has_offsets_times_and_counts() {
    let bytes = file(Compression::None, &streams(), &recording());
    let table = header::read(&mut Input::memory("x", bytes.clone())).unwrap().table.unwrap();
    let entries = table::decode(&bytes[table as usize..]).unwrap();
    let listed: Vec<_> = entries
        .iter()
        .map(|e| (e.stream, e.elements, e.first.0 - START, e.last.0 - START))
        .collect();
    let want = [
        (0, 40, 0, 390),
        (1, 1, 50, 50),
        (7, 3, 0, 20),
        (2, 3, 60, 60),
        (0, 1, 400, 400),
        (3, 2, 70, 70),
        (0, 49, 410, 890),
    ];
    assert_eq!(listed, want);
    for entry in entries {
        let head = entry.body as usize - 8;
        assert_eq!(bytes[head..head + 4], entry.stream.to_le_bytes());
        assert_eq!(bytes[head + 4..head + 8], entry.size.to_le_bytes());
    }
}
