//! From stamped events to a stream: order, and what waits for its turn.

use evpose_core::{EventStream, Micros, SensorSize};

use crate::stamped::{Stamped, StampedEvents};
use crate::{Origin, SensorError};

#[derive(Debug)]
pub(crate) struct Delivery {
    /// Events stamped later than the exposure that caused them, and room to sort in.
    pending: Vec<Stamped>,
    sorted: Vec<Stamped>,
    starts: Vec<u32>,
    events: EventStream,
    origins: Option<Vec<Origin>>,
}

/// Times are counted rather than compared where they span no more than this per event.
const SPAN_PER_EVENT: usize = 16;

/// Most events that wait for their stamps: one second of 32 million events per second, in 1.6 GB.
const MAX_PENDING: usize = 1 << 25;

impl Delivery {
    pub(crate) fn new(size: SensorSize) -> Self {
        Self {
            pending: Vec::new(),
            sorted: Vec::new(),
            starts: Vec::new(),
            events: EventStream::empty(size),
            origins: None,
        }
    }

    /// Whether the next deliveries say why each event happened.
    pub(crate) fn label(&mut self, is_labelled: bool) {
        self.origins = is_labelled.then(Vec::new);
    }

    pub(crate) fn events(&self) -> &EventStream {
        &self.events
    }

    pub(crate) fn origins(&self) -> Option<&[Origin]> {
        self.origins.as_deref()
    }

    /// Hands out what is due by `now`, of `bands` and of what waited: in order of time, and at equal
    /// times of pixels. Events of one pixel at one time keep their order. A band has the pixels
    /// behind those of the one before.
    ///
    /// # Errors
    /// [`SensorError::Backlog`] if more than [`MAX_PENDING`] are left.
    pub(crate) fn deliver(
        &mut self,
        bands: &[StampedEvents],
        now: Micros,
    ) -> Result<(), SensorError> {
        // Requests mostly come pixel by pixel, and a stable sort by time then leaves nothing to do.
        let is_by_pixel = self.pending.is_empty() && bands.iter().all(|band| band.is_by_pixel);
        self.merge(bands);
        if !is_by_pixel {
            for same_time in self.pending.chunk_by_mut(|a, b| a.t == b.t) {
                if !same_time.is_sorted_by_key(|event| event.position) {
                    same_time.sort_by_key(|event| event.position);
                }
            }
        }
        let due = self.pending.partition_point(|event| event.t <= now);
        self.events.clear();
        if let Some(origins) = &mut self.origins {
            origins.clear();
            origins.extend(self.pending[..due].iter().map(|event| event.origin));
        }
        self.write(due)?;
        self.pending.drain(..due);
        // A readout that is too slow would fill the memory, in the end.
        if self.pending.len() > MAX_PENDING {
            return Err(SensorError::Backlog { waiting: self.pending.len(), at_us: now.0 });
        }
        Ok(())
    }

    /// Makes the first `count` of what is pending the events.
    fn write(&mut self, count: usize) -> Result<(), SensorError> {
        let due = &self.pending[..count];
        // Columns are filled where they are: the stream checks them, and copies nothing.
        let none = EventStream::empty(self.events.sensor());
        let (mut t, mut x, mut y, mut polarity) =
            std::mem::replace(&mut self.events, none).into_columns();
        t.extend(due.iter().map(|event| event.t));
        x.extend(due.iter().map(Stamped::x));
        y.extend(due.iter().map(Stamped::y));
        polarity.extend(due.iter().map(|event| event.polarity));
        match EventStream::from_columns(self.events.sensor(), t, x, y, polarity) {
            Ok(events) => self.events = events,
            Err((t, x, y, polarity)) => self.events.extend_columns(&t, &x, &y, &polarity)?,
        }
        Ok(())
    }

    /// Puts what is pending and the events of `bands` in order of time. Requests come pixel by pixel:
    /// events of a step lie in few microseconds, and counting how many lie in each is faster than
    /// comparing.
    fn merge(&mut self, bands: &[StampedEvents]) {
        // What waits is in order.
        let low = self.pending.first().map_or(i64::MAX, |event| event.t.0);
        let high = self.pending.last().map_or(i64::MIN, |event| event.t.0);
        let (mut low, mut high, mut is_by_time) = (low, high, true);
        for band in bands {
            is_by_time &= band.is_by_time && band.low >= high;
            (low, high) = (low.min(band.low), high.max(band.high));
        }
        let count = bands.iter().fold(self.pending.len(), |sum, band| sum + band.events.len());
        // A table much longer than the events costs more than comparing them.
        if is_by_time || (high - low) as usize >= SPAN_PER_EVENT * count {
            for band in bands {
                self.pending.extend_from_slice(&band.events);
            }
            if !is_by_time {
                self.pending.sort_by_key(|event| event.t);
            }
            return;
        }
        let lists = || std::iter::once(&self.pending).chain(bands.iter().map(|band| &band.events));
        let Some(&any) = lists().flatten().next() else { return };
        let span = (high - low) as usize + 1;
        self.starts.clear();
        self.starts.resize(span + 1, 0);
        for list in lists() {
            for event in list {
                self.starts[(event.t.0 - low) as usize + 1] += 1;
            }
        }
        // Running sums turn counts into the place at which each microsecond begins.
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        // Every place is written to; what is there before does not matter.
        self.sorted.resize(count, any);
        for list in lists() {
            for event in list {
                let place = &mut self.starts[(event.t.0 - low) as usize];
                self.sorted[*place as usize] = *event;
                *place += 1;
            }
        }
        std::mem::swap(&mut self.pending, &mut self.sorted);
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Polarity;

    use super::*;
    use crate::Request;
    use crate::clock::stamp;
    use crate::stamped::RowDivision;

    #[test]
    fn counting_and_comparing_give_the_same_order() {
        let size = SensorSize { width: 7, height: 9 };
        let request = |k: u64, spread: u64| {
            let hash = k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 20;
            let t_s = (hash % spread) as f64 * 1e-6;
            let polarity = Polarity::from_on(hash & 1 == 1);
            Request { t_s, pixel: (hash % 63) as u32, polarity, origin: Origin::Signal }
        };
        // With the first pixel of the second band: all in one, and in two.
        for (spread, second) in
            [1, 50, 1_000, 1_000_000].into_iter().flat_map(|s| [(s, 0), (s, 30)])
        {
            let requests: Vec<Request> = (0..500).map(|k| request(k, spread)).collect();
            let (front, back) =
                requests.iter().copied().partition::<Vec<_>, _>(|r| r.pixel < second);
            let bands = [front, back].map(|requests| {
                let mut band = StampedEvents::new();
                band.stamp(&requests, Micros(0), RowDivision::new(7));
                band
            });
            let mut delivery = Delivery::new(size);
            delivery.deliver(&bands, Micros(spread as i64)).unwrap();
            let mut expected = requests;
            expected.sort_by_key(|r| (stamp(r.t_s), r.pixel));
            let delivered: Vec<_> = delivery.events().iter().collect();
            assert_eq!(delivered.len(), expected.len());
            for (event, r) in delivered.iter().zip(&expected) {
                let pixel = u32::from(event.y) * 7 + u32::from(event.x);
                assert_eq!((event.t, pixel, event.polarity), (stamp(r.t_s), r.pixel, r.polarity));
            }
        }
    }
}
