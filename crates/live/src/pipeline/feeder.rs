//! The thread that waits for the source.

use std::ops::Range;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Instant;

use evpose_core::{EventStream, Micros};
use evpose_io::Columns;

use crate::source::{FARTHEST, JUMP, Source};
use crate::{LiveError, Meter, Packet, PacketQueue};

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
    let (mut malformed, mut lost, mut slipped_us) = (0, 0, 0);
    loop {
        columns.clear();
        let read = source.next(&mut columns);
        meter.malformed.add(risen(&mut malformed, source.malformed()));
        meter.dropped_packets.add(risen(&mut lost, source.lost()));
        let slipped = u64::try_from(source.slipped().as_micros()).unwrap_or(u64::MAX);
        meter.slipped_us.add(risen(&mut slipped_us, slipped));
        // Events that came before a fault are whole.
        let happened = match read {
            Ok(None) => return Ok(()),
            Ok(Some(happened)) => happened,
            Err(_) => Instant::now(),
        };
        // Usually one piece: time jumps back once in a while, if ever.
        let mut from = 0;
        while from < columns.len() {
            let restarts = latest.is_some_and(|latest| is_back(columns.t[from], latest));
            let before = latest.filter(|_| !restarts);
            let end = piece_end(&columns.t, from, before);
            let events = checked(&columns, from..end, before, queue.memory(sensor));
            meter.rejected.add((end - from - events.len()) as u64);
            from = end;
            // Nothing begins anew with events that are none.
            let Some(&newest) = events.t().last() else {
                queue.give_back(events);
                continue;
            };
            latest = Some(newest);
            meter.restarts.add(u64::from(restarts));
            meter.packets.add(1);
            meter.events.add(events.len() as u64);
            let dropped = queue.push(Packet { events, happened, restarts });
            meter.dropped_packets.add(dropped.packets);
            meter.dropped_events.add(dropped.events);
        }
        read?;
        if queue.is_left() {
            return Ok(());
        }
    }
}

/// By how much a count has risen.
fn risen(before: &mut u64, now: u64) -> u64 {
    now.saturating_sub(std::mem::replace(before, now))
}

/// Whether another recording begins at `t`.
fn is_back(t: Micros, latest: Micros) -> bool {
    t.0 < latest.0.saturating_sub(JUMP.0)
}

/// Where time jumps back next, or the events end.
fn piece_end(t: &[Micros], from: usize, latest: Option<Micros>) -> usize {
    let mut newest = latest.unwrap_or(t[from]);
    let jumps = |t: &Micros| {
        let jumps = is_back(*t, newest);
        newest = newest.max(*t);
        jumps
    };
    // The first event of a piece has been asked for.
    t[from + 1..].iter().position(jumps).map_or(t.len(), |more| from + 1 + more)
}

/// The events of `range` that are on the sensor, in order behind `latest`, and of a time that can be, in the memory of a packet.
fn checked(
    columns: &Columns,
    range: Range<usize>,
    latest: Option<Micros>,
    mut events: EventStream,
) -> EventStream {
    let fits = |t: Micros| {
        latest.is_none_or(|latest| t >= latest) && t.0.unsigned_abs() <= FARTHEST.0.unsigned_abs()
    };
    let of = |range: Range<usize>| {
        (
            &columns.t[range.clone()],
            &columns.x[range.clone()],
            &columns.y[range.clone()],
            &columns.polarity[range],
        )
    };
    let (t, x, y, polarity) = of(range.clone());
    let ends_fit = fits(t[0]) && fits(t[t.len() - 1]);
    if ends_fit && events.extend_columns(t, x, y, polarity).is_ok() {
        return events;
    }
    for event in range.map(|index| columns.event(index)).filter(|event| fits(event.t)) {
        // What is refused is told by how many are missing.
        let _ = events.push(event);
    }
    events
}
