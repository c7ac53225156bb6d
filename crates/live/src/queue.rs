//! Between the source and all else: packets wait here, and the oldest are dropped when there are too many.

use std::collections::VecDeque;
use std::sync::{Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use evpose_core::{EventStream, SensorSize};

use crate::Packet;

/// Packets on their way from the source to whoever follows events.
///
/// What waits is bounded in packets and in events. Somebody who cannot keep up is given the newest: the
/// oldest packets are dropped, whole, and counted.
#[derive(Debug)]
pub struct PacketQueue {
    state: Mutex<State>,
    changed: Condvar,
    most_packets: usize,
    most_events: usize,
}

#[derive(Debug, Default)]
struct State {
    packets: VecDeque<Packet>,
    /// Events in `packets`.
    events: usize,
    /// Memory of packets that somebody is done with.
    spare: Vec<EventStream>,
    is_closed: bool,
    is_left: bool,
    is_nudged: bool,
}

/// What did not fit.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dropped {
    /// Packets.
    pub packets: u64,
    /// Their events.
    pub events: u64,
}

/// What somebody who waits for a packet gets.
#[derive(Debug)]
pub enum Popped {
    /// A packet.
    Packet(Packet),
    /// Nothing yet: time is up, or somebody else has something to say.
    Nothing,
    /// No packet will come any more.
    Closed,
}

impl PacketQueue {
    /// A queue of at most so many packets with at most so many events. A single packet of more events is
    /// let through.
    pub fn new(most_packets: usize, most_events: usize) -> Self {
        Self {
            state: Mutex::default(),
            changed: Condvar::new(),
            most_packets: most_packets.max(1),
            most_events,
        }
    }

    /// Adds a packet, and drops the oldest until there is room for it.
    pub fn push(&self, mut packet: Packet) -> Dropped {
        let mut state = self.lock();
        let mut dropped = Dropped::default();
        let new = packet.events.len();
        while !state.packets.is_empty()
            && (state.packets.len() >= self.most_packets || state.events + new > self.most_events)
        {
            let Some(oldest) = state.packets.pop_front() else { break };
            dropped.packets += 1;
            dropped.events += oldest.events.len() as u64;
            state.events -= oldest.events.len();
            // Whoever comes next is the first of what began here.
            match state.packets.front_mut() {
                Some(next) => next.restarts |= oldest.restarts,
                None => packet.restarts |= oldest.restarts,
            }
            keep(&mut state.spare, oldest.events);
        }
        state.events += new;
        state.packets.push_back(packet);
        drop(state);
        self.changed.notify_all();
        dropped
    }

    /// The oldest packet, as soon as there is one, or nothing after `wait` or [`Self::nudge`].
    pub fn pop(&self, wait: Duration) -> Popped {
        let end = Instant::now() + wait;
        let mut state = self.lock();
        loop {
            if let Some(packet) = state.packets.pop_front() {
                state.events -= packet.events.len();
                return Popped::Packet(packet);
            }
            if std::mem::take(&mut state.is_nudged) {
                return Popped::Nothing;
            }
            if state.is_closed {
                return Popped::Closed;
            }
            let Some(left) = end.checked_duration_since(Instant::now()).filter(|d| !d.is_zero())
            else {
                return Popped::Nothing;
            };
            let waited = self.changed.wait_timeout(state, left);
            state = waited.unwrap_or_else(PoisonError::into_inner).0;
        }
    }

    /// Has whoever waits look elsewhere.
    pub fn nudge(&self) {
        self.lock().is_nudged = true;
        self.changed.notify_all();
    }

    /// No packet will come any more; those that are there stay.
    pub fn close(&self) {
        self.lock().is_closed = true;
        self.changed.notify_all();
    }

    /// Nobody will ask for packets any more.
    pub fn leave(&self) {
        self.lock().is_left = true;
    }

    /// Whether nobody will ask for packets any more.
    pub fn is_left(&self) -> bool {
        self.lock().is_left
    }

    /// Empty memory for events of `sensor`.
    pub fn memory(&self, sensor: SensorSize) -> EventStream {
        let spare = self.lock().spare.pop();
        spare
            .filter(|events| events.sensor() == sensor)
            .unwrap_or_else(|| EventStream::empty(sensor))
    }

    /// Takes memory back.
    pub fn give_back(&self, events: EventStream) {
        keep(&mut self.lock().spare, events);
    }

    /// How many packets wait.
    pub fn len(&self) -> usize {
        self.lock().packets.len()
    }

    /// Whether none waits.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn lock(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// More memory than this is not kept for later.
const MOST_SPARE: usize = 8;

fn keep(spare: &mut Vec<EventStream>, mut events: EventStream) {
    if spare.len() < MOST_SPARE {
        events.clear();
        spare.push(events);
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]

    use evpose_core::{Event, Micros, Polarity};

    use super::*;

    const SENSOR: SensorSize = SensorSize { width: 4, height: 3 };

    fn packet(t: i64, events: i64) -> Packet {
        let event = |k| Event { t: Micros(t + k), x: 1, y: 1, polarity: Polarity::On };
        let events = EventStream::from_events(SENSOR, (0..events).map(event)).unwrap();
        Packet { events, happened: Instant::now(), restarts: false }
    }

    fn times(queue: &PacketQueue) -> Vec<i64> {
        std::iter::from_fn(|| match queue.pop(Duration::ZERO) {
            Popped::Packet(packet) => Some(packet.events.t()[0].0),
            Popped::Nothing | Popped::Closed => None,
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
        assert_eq!(queue.push(packet(0, 6)), Dropped::default());
        assert_eq!(queue.push(packet(10, 6)), Dropped { packets: 1, events: 6 });
        assert_eq!(queue.push(packet(20, 40)), Dropped { packets: 1, events: 6 });
        assert_eq!(times(&queue), [20]);
    }

    #[test]
    fn a_restart_is_not_lost_with_its_packet() {
        let queue = PacketQueue::new(2, 100);
        queue.push(Packet { restarts: true, ..packet(0, 1) });
        queue.push(packet(10, 1));
        queue.push(packet(20, 1));
        let Popped::Packet(first) = queue.pop(Duration::ZERO) else { panic!("two wait") };
        assert!(first.restarts && first.events.t()[0] == Micros(10));
        let Popped::Packet(second) = queue.pop(Duration::ZERO) else { panic!("one waits") };
        assert!(!second.restarts);
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
                assert!(matches!(queue.pop(long), Popped::Closed));
            });
            let next = || waits.recv_timeout(Duration::from_secs(10)).unwrap();
            for wake in [0, 1, 0] {
                next();
                if wake == 0 {
                    queue.push(packet(0, 1));
                } else {
                    queue.nudge();
                }
                next();
            }
            queue.close();
        });
        assert!(matches!(queue.pop(Duration::ZERO), Popped::Closed));
    }
}
