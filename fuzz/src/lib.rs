//! What every target does with the bytes it is given.

use evpose_io::{Columns, Input, OpenOptions, format_called};

/// Reads `bytes` as a file of a format, to its end, and from the middle of its time once more.
///
/// # Panics
/// If a format misbehaves: it has no end, events before a fault are miscounted, or reading again
/// gives something else.
pub fn read(format: &str, bytes: &[u8]) {
    let Some(format) = format_called(format) else { panic!("no format is called {format}") };
    let input = || Input::memory("fuzz", bytes.to_vec());
    let options = OpenOptions::default();
    let Ok(mut source) = (format.open)(input(), &options) else { return };
    let mut columns = Columns::new();
    // A byte holds at most eight events of any format, and compression a thousand times as many.
    let most = 8_000 * (bytes.len() + 64);
    loop {
        let before = columns.len();
        let read = source.next(&mut columns);
        let lengths = [columns.x.len(), columns.y.len(), columns.polarity.len()];
        assert_eq!(lengths, [columns.len(); 3], "columns of different lengths");
        assert!(columns.len() <= most, "{} events out of {} bytes", columns.len(), bytes.len());
        if read.is_err() || columns.len() == before {
            break;
        }
    }
    let _ = source.remarks();
    if let Some(&t) = columns.t.get(columns.len() / 2) {
        let mut again = Columns::new();
        if source.seek(t).is_ok() && source.next(&mut again).is_ok() && !again.is_empty() {
            let first = again.event(0);
            assert!(columns.iter().any(|event| event == first), "an event that was not there");
        }
    }
}
