//! The thread that waits for the source.

use std::ops::Range;
use std::sync::Arc;
use std::thread::JoinHandle;
use std::time::Instant;

use evpose_core::{EventStream, Micros};
use evpose_io::Columns;

use crate::source::{MAX_TIME, RESTART_JUMP, Source};
use crate::{LiveError, Meter, Packet, PacketQueue};

/// The thread, and a function that wakes it.
pub(super) struct Feeder {
    thread: JoinHandle<Result<(), LiveError>>,
    wake: Option<Box<dyn Fn() + Send + Sync>>,
}

impl Feeder {
    pub(super) fn start(
        mut source: Box<dyn Source>,
        queue: Arc<PacketQueue>,
        meter: Arc<Meter>,
    ) -> Self {
        let wake = source.waker();
        let thread = std::thread::spawn(move || {
            let fed = feed(source.as_mut(), &queue, &meter);
            // The queue closes after a fault, too, so that its reader comes to an end.
            queue.close();
            fed
        });
        Self { thread, wake }
    }

    /// Joins the thread. An abandoned thread that cannot be woken, such as one that reads a
    /// terminal, is detached.
    pub(super) fn end(self, is_abandoned: bool) -> Result<(), LiveError> {
        if is_abandoned {
            let Some(wake) = self.wake else { return Ok(()) };
            wake();
            // Errors of a connection that we closed ourselves carry no information.
            let _ = self.thread.join();
            return Ok(());
        }
        self.thread.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
    }
}

/// Maximum event time of a packet of a source without a pace: an input of the network is of the end
/// of a packet.
const PACKET: Micros = Micros(1_000);

fn feed(source: &mut dyn Source, queue: &PacketQueue, meter: &Meter) -> Result<(), LiveError> {
    let sensor = source.sensor();
    let (mut columns, mut latest) = (Columns::new(), None);
    let (mut malformed, mut lost, mut slipped_us) = (0, 0, 0);
    // A repetition may come while all events of a packet are rejected.
    let (mut repetition, mut is_repeated) = (0, false);
    let is_lossless = source.is_lossless();
    let is_cut = is_lossless && source.pace().is_none();
    loop {
        columns.clear();
        let read = source.next(&mut columns);
        meter.malformed.add(increase(&mut malformed, source.malformed()));
        meter.dropped_packets.add(increase(&mut lost, source.lost()));
        let slipped = u64::try_from(source.slipped().as_micros()).unwrap_or(u64::MAX);
        meter.slipped_us.add(increase(&mut slipped_us, slipped));
        // Events before a fault are valid.
        let host_time = match read {
            Ok(None) => {
                meter.remark(source.remarks());
                return Ok(());
            }
            Ok(Some(host_time)) => host_time,
            Err(_) => Instant::now(),
        };
        is_repeated |= increase(&mut repetition, source.repetition()) > 0;
        // Usually one piece: time jumps back rarely.
        let mut from = 0;
        while from < columns.len() {
            let jumps = latest.is_some_and(|latest| is_restart(columns.t[from], latest));
            let restarts = jumps || is_repeated;
            let before = latest.filter(|_| !restarts);
            let mut end = piece_end(&columns.t, from, before);
            if is_cut {
                end = cut(&columns.t, from, end);
            }
            let events = checked(&columns, from..end, before, queue.buffer(sensor));
            meter.rejected.add((end - from - events.len()) as u64);
            from = end;
            // A piece of rejected events alone does not begin another recording.
            let Some(&newest) = events.t().last() else {
                queue.recycle(events);
                continue;
            };
            latest = Some(newest);
            is_repeated = false;
            meter.restarts.add(u64::from(restarts));
            meter.packets.add(1);
            meter.events.add(events.len() as u64);
            let packet = Packet { events, host_time, is_restart: restarts };
            if is_lossless {
                queue.push_waiting(packet);
                continue;
            }
            let dropped = queue.push(packet);
            meter.dropped_packets.add(dropped.packets);
            meter.dropped_events.add(dropped.events);
        }
        // The fault itself, behind the events that came before it.
        read?;
        if queue.is_abandoned() {
            return Ok(());
        }
    }
}

/// Increase of a counter since `before`, which is set to `now`.
fn increase(before: &mut u64, now: u64) -> u64 {
    now.saturating_sub(std::mem::replace(before, now))
}

/// Whether another recording begins at `t`.
fn is_restart(t: Micros, latest: Micros) -> bool {
    t.0 < latest.0.saturating_sub(RESTART_JUMP.0)
}

/// Index of the next backward jump of time, or of the end of the events.
fn piece_end(t: &[Micros], from: usize, latest: Option<Micros>) -> usize {
    let mut newest = latest.unwrap_or(t[from]);
    let jumps = |t: &Micros| {
        let jumps = is_restart(*t, newest);
        newest = newest.max(*t);
        jumps
    };
    // The caller has checked the first event of the piece.
    t[from + 1..].iter().position(jumps).map_or(t.len(), |more| from + 1 + more)
}

/// Index of the first event of `from..end` that is a packet or more behind the first, or `end`.
fn cut(t: &[Micros], from: usize, end: usize) -> usize {
    let packet_end = t[from].0.saturating_add(PACKET.0);
    t[from..end].iter().position(|t| t.0 >= packet_end).map_or(end, |more| from + more)
}

/// The events of `range` that lie on the sensor, in time order after `latest` and within
/// [`MAX_TIME`], in the buffer of a packet.
fn checked(
    columns: &Columns,
    range: Range<usize>,
    latest: Option<Micros>,
    mut events: EventStream,
) -> EventStream {
    let fits = |t: Micros| {
        latest.is_none_or(|latest| t >= latest) && t.0.unsigned_abs() <= MAX_TIME.0.unsigned_abs()
    };
    let columns_of = |range: Range<usize>| {
        (
            &columns.t[range.clone()],
            &columns.x[range.clone()],
            &columns.y[range.clone()],
            &columns.polarity[range],
        )
    };
    let (t, x, y, polarity) = columns_of(range.clone());
    // Both ends fit, so that in an ordered packet all do.
    let ends_fit = fits(t[0]) && fits(t[t.len() - 1]);
    if ends_fit && events.extend_columns(t, x, y, polarity).is_ok() {
        return events;
    }
    for event in range.map(|index| columns.event(index)).filter(|event| fits(event.t)) {
        // The caller counts rejected events by how many are missing.
        let _ = events.push(event);
    }
    events
}
