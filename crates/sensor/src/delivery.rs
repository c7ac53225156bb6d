//! From served requests to a stream: stamps, order, and what waits for its turn.

use evpose_core::{EventStream, Micros, Polarity, SensorSize};

use crate::clock::stamp;
use crate::{Origin, Request, SensorError};

#[derive(Debug, Clone, Copy)]
struct Stamped {
    t: Micros,
    pixel: u32,
    polarity: Polarity,
    origin: Origin,
}

/// Events by column, as a stream takes them.
#[derive(Debug, Default)]
struct Columns {
    t: Vec<Micros>,
    x: Vec<u16>,
    y: Vec<u16>,
    polarity: Vec<Polarity>,
}

#[derive(Debug)]
pub(crate) struct Delivery {
    /// Events stamped later than the exposure that caused them, and room to sort in.
    pending: Vec<Stamped>,
    sorted: Vec<Stamped>,
    starts: Vec<u32>,
    columns: Columns,
    events: EventStream,
    origins: Option<Vec<Origin>>,
    width: u64,
    /// `2^40 / width`, rounded up: a division by the width for any pixel number of a sensor.
    reciprocal: u64,
}

/// Times are counted rather than compared where they span no more than this per event.
const SPAN_PER_EVENT: usize = 16;

/// Most events that wait for their stamps: one second of 32 million events per second, in 1.6 GB.
const MAX_PENDING: usize = 1 << 25;

/// Bits of the fraction of `reciprocal`.
const SHIFT: u32 = 40;

impl Delivery {
    pub(crate) fn new(size: SensorSize) -> Self {
        let width = u64::from(size.width).max(1);
        Self {
            pending: Vec::new(),
            sorted: Vec::new(),
            starts: Vec::new(),
            columns: Columns::default(),
            events: EventStream::empty(size),
            origins: None,
            width,
            reciprocal: (1u64 << SHIFT).div_ceil(width),
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

    /// Stamps `requests`, none before `earliest`, and hands out what is due by `now`: in order of
    /// time, and at equal times of pixels. Events of one pixel at one time keep their order.
    ///
    /// # Errors
    /// [`SensorError::Backlog`] if more than [`MAX_PENDING`] are left.
    pub(crate) fn deliver(
        &mut self,
        requests: &[Request],
        earliest: Micros,
        now: Micros,
    ) -> Result<(), SensorError> {
        // Requests mostly come pixel by pixel, and a stable sort by time then leaves nothing to do.
        let mut is_by_pixel = self.pending.is_empty();
        let mut previous = 0;
        self.pending.extend(requests.iter().map(|request| {
            is_by_pixel &= request.pixel >= previous;
            previous = request.pixel;
            Stamped {
                t: stamp(request.t_s).max(earliest),
                pixel: request.pixel,
                polarity: request.polarity,
                origin: request.origin,
            }
        }));
        self.sort();
        if !is_by_pixel {
            for same_time in self.pending.chunk_by_mut(|a, b| a.t == b.t) {
                if !same_time.is_sorted_by_key(|event| event.pixel) {
                    same_time.sort_by_key(|event| event.pixel);
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

    /// Appends the first `count` of what is pending to the events.
    fn write(&mut self, count: usize) -> Result<(), SensorError> {
        let Self { pending, columns, events, width, reciprocal, .. } = self;
        let due = &pending[..count];
        let Columns { t, x, y, polarity } = columns;
        t.clear();
        x.clear();
        y.clear();
        polarity.clear();
        t.extend(due.iter().map(|event| event.t));
        polarity.extend(due.iter().map(|event| event.polarity));
        // A division by the width takes some twenty cycles, once for every event.
        let row = |pixel: u32| (u64::from(pixel) * *reciprocal) >> SHIFT;
        y.extend(due.iter().map(|event| row(event.pixel) as u16));
        let column = |pixel: u32| u64::from(pixel) - row(pixel) * *width;
        x.extend(due.iter().map(|event| column(event.pixel) as u16));
        Ok(events.extend_columns(t, x, y, polarity)?)
    }

    /// Puts what is pending in order of time. Requests come pixel by pixel: events of a step lie
    /// in few microseconds, and counting how many lie in each is faster than comparing.
    fn sort(&mut self) {
        if self.pending.is_sorted_by_key(|event| event.t) {
            return;
        }
        let times = self.pending.iter().map(|event| event.t.0);
        let (low, high) = times.fold((i64::MAX, i64::MIN), |(l, h), t| (l.min(t), h.max(t)));
        let span = (high - low) as usize + 1;
        // A table much longer than the events costs more than comparing them.
        if span > SPAN_PER_EVENT * self.pending.len() {
            self.pending.sort_by_key(|event| event.t);
            return;
        }
        self.starts.clear();
        self.starts.resize(span + 1, 0);
        for event in &self.pending {
            self.starts[(event.t.0 - low) as usize + 1] += 1;
        }
        // Running sums turn counts into the place at which each microsecond begins.
        let mut sum = 0;
        for start in &mut self.starts {
            sum += *start;
            *start = sum;
        }
        // Every place is written to; what is there before does not matter.
        self.sorted.resize(self.pending.len(), self.pending[0]);
        for event in &self.pending {
            let place = &mut self.starts[(event.t.0 - low) as usize];
            self.sorted[*place as usize] = *event;
            *place += 1;
        }
        std::mem::swap(&mut self.pending, &mut self.sorted);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counting_and_comparing_give_the_same_order() {
        let size = SensorSize { width: 7, height: 9 };
        let request = |k: u64, spread: u64| {
            let hash = k.wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 20;
            let t_s = (hash % spread) as f64 * 1e-6;
            let polarity = Polarity::from_on(hash & 1 == 1);
            Request { t_s, pixel: (hash % 63) as u32, polarity, origin: Origin::Signal }
        };
        for spread in [1, 50, 1_000, 1_000_000] {
            let requests: Vec<Request> = (0..500).map(|k| request(k, spread)).collect();
            let mut delivery = Delivery::new(size);
            delivery.deliver(&requests, Micros(0), Micros(spread as i64)).unwrap();
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

    #[test]
    fn rows_and_columns_are_those_of_a_division() {
        for width in [1u16, 2, 3, 240, 346, 1280, 65_535] {
            let delivery = Delivery::new(SensorSize { width, height: 65_535 });
            let last = u64::from(width) * 65_535 - 1;
            for pixel in (0..=last).step_by(last as usize / 5_000 + 1).chain([last]) {
                let row = (pixel * delivery.reciprocal) >> SHIFT;
                assert!(row == pixel / u64::from(width) || pixel >= 1 << 24, "{pixel} / {width}");
            }
        }
    }
}
