//! The thread that waits for the source.

use std::sync::Arc;
use std::thread::JoinHandle;

use evpose_core::{EventStream, Micros};
use evpose_io::Columns;

use crate::source::Source;
use crate::{LiveError, Meter, Packet, PacketQueue};

/// Time that jumps back by more than this means that another recording begins; what is earlier by less came
/// late, and is rejected.
const JUMP: Micros = Micros(100_000);

/// The thread, and how to end it.
pub(super) struct Feeder {
    thread: JoinHandle<Result<(), LiveError>>,
    wake: Option<Box<dyn Fn() + Send + Sync>>,
}

impl Feeder {
    pub(super) fn start(
        mut source: impl Source,
        queue: Arc<PacketQueue>,
        meter: Arc<Meter>,
    ) -> Self {
        let wake = source.waker();
        let thread = std::thread::spawn(move || {
            let fed = feed(&mut source, &queue, &meter);
            queue.close();
            fed
        });
        Self { thread, wake }
    }

    /// Ends it. Where nobody waits for its events any more, it is left alone if it cannot be woken: a
    /// terminal that somebody may yet type on.
    pub(super) fn end(self, is_left: bool) -> Result<(), LiveError> {
        if is_left {
            let Some(wake) = self.wake else { return Ok(()) };
            wake();
            // How a connection ends that we closed is of no interest.
            let _ = self.thread.join();
            return Ok(());
        }
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

fn feed(source: &mut impl Source, queue: &PacketQueue, meter: &Meter) -> Result<(), LiveError> {
    let sensor = source.sensor();
    let (mut columns, mut latest) = (Columns::new(), None);
    let (mut malformed, mut lost) = (0, 0);
    loop {
        columns.clear();
        let read = source.next(&mut columns);
        meter.malformed.add(risen(&mut malformed, source.malformed()));
        meter.dropped_packets.add(risen(&mut lost, source.lost()));
        let is_over = !matches!(read, Ok(Some(_)));
        if let (Ok(Some(happened)), false) = (&read, columns.is_empty()) {
            let happened = *happened;
            // Usually one piece: time jumps back once in a while, if ever.
            let mut from = 0;
            while from < columns.len() {
                let to = next_jump(&columns.t, from, &mut latest);
                let restarts = to.restarts;
                let events = checked(&columns, from..to.end, queue.memory(sensor), meter);
                from = to.end;
                if restarts {
                    meter.restarts.add(1);
                }
                meter.packets.add(1);
                meter.events.add(events.len() as u64);
                let dropped = queue.push(Packet { events, happened, restarts });
                meter.dropped_packets.add(dropped.packets);
                meter.dropped_events.add(dropped.events);
            }
        }
        if is_over {
            return read.map(|_| ());
        }
    }
}

/// By how much a count has risen.
fn risen(before: &mut u64, now: u64) -> u64 {
    now.saturating_sub(std::mem::replace(before, now))
}

/// A piece of events between two jumps of time.
struct Piece {
    end: usize,
    /// Whether time jumped back before it.
    restarts: bool,
}

fn next_jump(t: &[Micros], from: usize, latest: &mut Option<Micros>) -> Piece {
    let is_back = |t: Micros, latest: Micros| t.0 < latest.0.saturating_sub(JUMP.0);
    let restarts = latest.is_some_and(|latest| is_back(t[from], latest));
    let mut newest = if restarts { t[from] } else { latest.unwrap_or(t[from]) };
    let mut end = from;
    while end < t.len() && !is_back(t[end], newest) {
        newest = newest.max(t[end]);
        end += 1;
    }
    *latest = Some(newest);
    Piece { end, restarts }
}

/// The events of `range` that are in order and on the sensor, in the memory of a packet.
fn checked(
    columns: &Columns,
    range: std::ops::Range<usize>,
    mut events: EventStream,
    meter: &Meter,
) -> EventStream {
    let all = range.len();
    let whole = events.extend_columns(
        &columns.t[range.clone()],
        &columns.x[range.clone()],
        &columns.y[range.clone()],
        &columns.polarity[range.clone()],
    );
    if whole.is_err() {
        for index in range {
            let _ = events.push(columns.event(index));
        }
        meter.rejected.add((all - events.len()) as u64);
    }
    events
}
