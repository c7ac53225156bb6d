//! The bounded queue of packets behind the source.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use evpose_core::{EventStream, SensorSize};

use crate::Packet;

/// A queue of packets from the source to the front end, bounded in packets and in events.
///
/// A consumer that cannot keep up gets the newest packets: with [`Self::push`], the oldest are
/// dropped whole, and counted. With [`Self::push_waiting`], the source waits.
#[derive(Debug)]
pub struct PacketQueue {
    state: Mutex<State>,
    changed: Condvar,
    max_packets: usize,
    max_events: usize,
}

#[derive(Debug, Default)]
struct State {
    packets: VecDeque<Packet>,
    events: usize,
    /// Buffers of consumed packets.
    spare: Vec<EventStream>,
    is_closed: bool,
    is_abandoned: bool,
    is_notified: bool,
}

/// Counts of dropped packets and events.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DropCounts {
    /// Packets.
    pub packets: u64,
    /// Events of these packets.
    pub events: u64,
}

/// Outcome of waiting for a packet.
#[derive(Debug)]
pub enum PopOutcome {
    /// A packet.
    Packet(Packet),
    /// No packet: the wait timed out, or [`PacketQueue::notify`] was called.
    Empty,
    /// The queue is closed and empty.
    Closed,
}

impl PacketQueue {
    /// A queue with a capacity in packets and in events. A single packet may exceed the latter.
    pub fn new(max_packets: usize, max_events: usize) -> Self {
        Self {
            state: Mutex::default(),
            changed: Condvar::new(),
            max_packets: max_packets.max(1),
            max_events,
        }
    }

    /// Adds a packet, and drops the oldest until there is room for it.
    pub fn push(&self, mut packet: Packet) -> DropCounts {
        let mut state = self.lock();
        let mut dropped = DropCounts::default();
        let new = packet.events.len();
        while !self.has_room(&state, new) {
            let Some(oldest) = state.packets.pop_front() else { break };
            dropped.packets += 1;
            dropped.events += oldest.events.len() as u64;
            state.events -= oldest.events.len();
            // The next packet is now the first of the recording that began here.
            match state.packets.front_mut() {
                Some(next) => next.is_restart |= oldest.is_restart,
                None => packet.is_restart |= oldest.is_restart,
            }
            // Buffers of dropped packets serve new ones.
            store_spare(&mut state.spare, oldest.events);
        }
        state.events += new;
        state.packets.push_back(packet);
        // Unlocked first, or those who wake would wait again.
        drop(state);
        self.changed.notify_all();
        dropped
    }

    /// Adds a packet as soon as there is room for it, and drops none. An abandoned queue takes
    /// nothing.
    pub fn push_waiting(&self, packet: Packet) {
        let new = packet.events.len();
        let mut state = self.lock();
        // A condition variable may wake without a reason.
        while !state.is_abandoned && !self.has_room(&state, new) {
            state = self.changed.wait(state).unwrap_or_else(PoisonError::into_inner);
        }
        if state.is_abandoned {
            return;
        }
        state.events += new;
        state.packets.push_back(packet);
        drop(state);
        self.changed.notify_all();
    }

    /// Whether a packet of `new` events fits. An empty queue takes any.
    fn has_room(&self, state: &State, new: usize) -> bool {
        let fits = state.packets.len() < self.max_packets && state.events + new <= self.max_events;
        fits || state.packets.is_empty()
    }

    /// Waits for the oldest packet, until `wait` has passed or [`Self::notify`] is called.
    pub fn pop(&self, wait: Duration) -> PopOutcome {
        let end = Instant::now() + wait;
        let mut state = self.lock();
        loop {
            // A packet is taken before a notification, which the caller checks for after it anyway.
            if let Some(packet) = state.packets.pop_front() {
                state.events -= packet.events.len();
                drop(state);
                // The source may wait for room.
                self.changed.notify_all();
                return PopOutcome::Packet(packet);
            }
            // Notified: something else has happened that the caller waits for.
            if std::mem::take(&mut state.is_notified) {
                return PopOutcome::Empty;
            }
            if state.is_closed {
                return PopOutcome::Closed;
            }
            let Some(left) = end.checked_duration_since(Instant::now()).filter(|d| !d.is_zero())
            else {
                return PopOutcome::Empty;
            };
            let waited = self.changed.wait_timeout(state, left);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Wakes the consumer without a packet.
    pub fn notify(&self) {
        self.lock().is_notified = true;
        self.changed.notify_all();
    }

    /// Closes the queue; queued packets can still be popped.
    pub fn close(&self) {
        self.lock().is_closed = true;
        self.changed.notify_all();
    }

    /// Marks the queue as without a consumer.
    pub fn abandon(&self) {
        self.lock().is_abandoned = true;
        self.changed.notify_all();
    }

    /// Whether the consumer has ended.
    pub fn is_abandoned(&self) -> bool {
        self.lock().is_abandoned
    }

    /// An empty buffer for events of `sensor`, recycled if possible.
    pub fn buffer(&self, sensor: SensorSize) -> EventStream {
        let spare = self.lock().spare.pop();
        spare
            .filter(|events| events.sensor() == sensor)
            .unwrap_or_else(|| EventStream::empty(sensor))
    }

    /// Returns a buffer for reuse.
    pub fn recycle(&self, events: EventStream) {
        store_spare(&mut self.lock().spare, events);
    }

    /// Number of queued packets.
    pub fn len(&self) -> usize {
        self.lock().packets.len()
    }

    /// Whether no packet is queued.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Buffers that are retained for reuse: a queue's usual depth and some more.
const MAX_SPARE_BUFFERS: usize = 8;

fn store_spare(spare: &mut Vec<EventStream>, mut events: EventStream) {
    if spare.len() < MAX_SPARE_BUFFERS {
        events.clear();
        spare.push(events);
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Micros, Polarity};

    use super::*;

    const SENSOR: SensorSize = SensorSize { width: 4, height: 3 };

    fn packet(t: i64, events: i64) -> Packet {
        let event = |k| Event { t: Micros(t + k), x: 1, y: 1, polarity: Polarity::On };
        let events = EventStream::from_events(SENSOR, (0..events).map(event)).unwrap();
        Packet { events, host_time: Instant::now(), is_restart: false }
    }

    fn times(queue: &PacketQueue) -> Vec<i64> {
        std::iter::from_fn(|| match queue.pop(Duration::ZERO) {
            PopOutcome::Packet(packet) => Some(packet.events.t()[0].0),
            PopOutcome::Empty | PopOutcome::Closed => None,
        })
        .collect()
    }

    #[test]
    fn the_oldest_are_dropped_and_counted() {
        let queue = PacketQueue::new(3, 1_000);
        let dropped: Vec<u64> = (0..5).map(|k| queue.push(packet(10 * k, 4)).events).collect();
        assert_eq!(dropped, [0, 0, 0, 4, 4]);
        assert_eq!(times(&queue), [20, 30, 40]);
    }

    #[test]
    fn events_are_bounded_too_but_one_packet_always_fits() {
        let queue = PacketQueue::new(100, 10);
        assert_eq!(queue.push(packet(0, 6)), DropCounts::default());
        assert_eq!(queue.push(packet(10, 6)), DropCounts { packets: 1, events: 6 });
        assert_eq!(queue.push(packet(20, 40)), DropCounts { packets: 1, events: 6 });
        assert_eq!(times(&queue), [20]);
    }

    #[test]
    fn a_source_that_waits_loses_nothing_and_an_abandoned_one_goes_on() {
        let queue = PacketQueue::new(2, 10);
        std::thread::scope(|scope| {
            let queue = &queue;
            scope.spawn(move || {
                (0..50).for_each(|k| queue.push_waiting(packet(10 * k, 6)));
                queue.close();
            });
            let mut seen = Vec::new();
            loop {
                match queue.pop(Duration::from_secs(10)) {
                    PopOutcome::Packet(packet) => seen.push(packet.events.t()[0].0),
                    PopOutcome::Empty => panic!("the source waits for nothing"),
                    PopOutcome::Closed => break,
                }
                assert!(queue.len() <= 1, "two packets have too many events");
            }
            assert!(seen.into_iter().eq((0..50).map(|k| 10 * k)));
        });
        let full = PacketQueue::new(1, 10);
        full.push_waiting(packet(0, 1));
        std::thread::scope(|scope| {
            let waits = scope.spawn(|| full.push_waiting(packet(10, 1)));
            full.abandon();
            waits.join().unwrap();
        });
        assert_eq!(full.len(), 1);
    }

    #[test]
    fn a_restart_is_not_lost_with_its_packet() {
        let queue = PacketQueue::new(2, 100);
        queue.push(Packet { is_restart: true, ..packet(0, 1) });
        queue.push(packet(10, 1));
        queue.push(packet(20, 1));
        let PopOutcome::Packet(first) = queue.pop(Duration::ZERO) else { panic!("two wait") };
        assert!(first.is_restart && first.events.t()[0] == Micros(10));
        let PopOutcome::Packet(second) = queue.pop(Duration::ZERO) else { panic!("one waits") };
        assert!(!second.is_restart);
    }

    #[test]
    fn who_waits_is_woken_by_a_packet_a_nudge_or_the_end() {
        let queue = PacketQueue::new(4, 100);
        let long = Duration::from_secs(20);
        std::thread::scope(|scope| {
            let (begun, waits) = std::sync::mpsc::channel();
            let queue = &queue;
            scope.spawn(move || {
                for _ in 0..3 {
                    begun.send(()).unwrap();
                    let popped = queue.pop(long);
                    begun.send(()).unwrap();
                    drop(popped);
                }
                assert!(matches!(queue.pop(long), PopOutcome::Closed));
            });
            let next = || waits.recv_timeout(Duration::from_secs(10)).unwrap();
            for wake in [0, 1, 0] {
                next();
                if wake == 0 {
                    queue.push(packet(0, 1));
                } else {
                    queue.notify();
                }
                next();
            }
            queue.close();
        });
        assert!(matches!(queue.pop(Duration::ZERO), PopOutcome::Closed));
    }
}
