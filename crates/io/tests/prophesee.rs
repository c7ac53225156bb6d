//! Files of Prophesee's formats that other programs wrote.

#![allow(clippy::unwrap_used, reason = "tests")]

use std::path::Path;

use evpose_core::{Event, Micros, Polarity};
use evpose_io::open;

/// Counts and digests of `golden/expelliarmus/README.md`.
fn expelliarmus() -> impl Iterator<Item = Event> {
    (0..600).map(|k| {
        let (g, i) = (k / 12, k % 12);
        Event {
            t: Micros(100 + 20 * g * g),
            x: (91 * g % 580 + i + i * i / 4) as u16,
            y: (37 * g % 480) as u16,
            polarity: Polarity::from_on((g + i / 6) % 2 == 1),
        }
    })
}

#[test]
fn what_expelliarmus_wrote_is_read_event_by_event() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden/expelliarmus");
    for (name, format) in [("events.dat", "dat"), ("evt2.raw", "evt2")] {
        let found = open(folder.join(name)).unwrap();
        assert_eq!(found.format, format);
        assert!(found.stream.iter().eq(expelliarmus()), "{name}");
        assert!(found.remarks.is_empty() && found.outside == 0, "{name}");
    }
}
