//! Events in time order, column by column, checked once.

use crate::{CoreError, Event, Micros, Polarity, SensorSize, TimeWindow};

/// Events in time order with the size of the sensor they came from.
///
/// Columns rather than a `Vec<Event>`: a search in time touches 8 bytes an event instead of 16, and
/// every representation reads columns. Order and bounds hold by construction.
#[derive(Debug, Clone, PartialEq)]
pub struct EventStream {
    sensor: SensorSize,
    t: Vec<Micros>,
    x: Vec<u16>,
    y: Vec<u16>,
    polarity: Vec<Polarity>,
}

impl EventStream {
    /// A stream without events.
    pub fn empty(sensor: SensorSize) -> Self {
        Self { sensor, t: Vec::new(), x: Vec::new(), y: Vec::new(), polarity: Vec::new() }
    }

    /// A stream of `events`, checked.
    ///
    /// # Errors
    /// The first event that lies outside `sensor` or is earlier than the one before it.
    pub fn from_events(
        sensor: SensorSize,
        events: impl IntoIterator<Item = Event>,
    ) -> Result<Self, CoreError> {
        let mut stream = Self::empty(sensor);
        for event in events {
            stream.push(event)?;
        }
        Ok(stream)
    }

    /// Takes columns as they are, or gives them back: if they differ in length, an event lies
    /// outside `sensor`, or one is earlier than the one before it.
    #[expect(clippy::type_complexity, reason = "the columns that were given")]
    pub fn from_columns(
        sensor: SensorSize,
        t: Vec<Micros>,
        x: Vec<u16>,
        y: Vec<u16>,
        polarity: Vec<Polarity>,
    ) -> Result<Self, (Vec<Micros>, Vec<u16>, Vec<u16>, Vec<Polarity>)> {
        let is_even = [x.len(), y.len(), polarity.len()] == [t.len(); 3];
        if is_even && t.is_sorted() && lie_below(&x, sensor.width) && lie_below(&y, sensor.height) {
            return Ok(Self { sensor, t, x, y, polarity });
        }
        Err((t, x, y, polarity))
    }

    /// Appends one event.
    ///
    /// # Errors
    /// If it lies outside the sensor or is earlier than the last one; the stream is then unchanged.
    pub fn push(&mut self, event: Event) -> Result<(), CoreError> {
        let Event { t, x, y, polarity } = event;
        let index = self.t.len();
        // All checks come before the first column grows, so that a refused event leaves no trace.
        if !self.sensor.contains(x, y) {
            return Err(CoreError::OutsideSensor { index, x, y, sensor: self.sensor });
        }
        if let Some(&previous) = self.t.last()
            && t < previous
        {
            return Err(CoreError::OutOfOrder { index, t, previous });
        }
        self.t.push(t);
        self.x.push(x);
        self.y.push(y);
        self.polarity.push(polarity);
        Ok(())
    }

    /// Appends many events at once, given column by column.
    ///
    /// # Errors
    /// The first event that lies outside the sensor or is earlier than the one before it, or
    /// columns of different lengths; the stream is then unchanged.
    pub fn extend_columns(
        &mut self,
        t: &[Micros],
        x: &[u16],
        y: &[u16],
        polarity: &[Polarity],
    ) -> Result<(), CoreError> {
        let lengths = [t.len(), x.len(), y.len(), polarity.len()];
        if lengths != [t.len(); 4] {
            return Err(CoreError::ColumnLengths { lengths });
        }
        // Whole columns; only one that is faulty is looked at event by event.
        let in_order = t.is_sorted()
            && self.t.last().zip(t.first()).is_none_or(|(previous, first)| first >= previous);
        let is_sound =
            in_order && lie_below(x, self.sensor.width) && lie_below(y, self.sensor.height);
        if !is_sound && let Some(fault) = self.first_fault(t, x, y) {
            return Err(fault);
        }
        self.t.extend_from_slice(t);
        self.x.extend_from_slice(x);
        self.y.extend_from_slice(y);
        self.polarity.extend_from_slice(polarity);
        Ok(())
    }

    /// The error of the first event that cannot be appended.
    fn first_fault(&self, t: &[Micros], x: &[u16], y: &[u16]) -> Option<CoreError> {
        let mut previous = self.t.last().copied();
        for (k, ((&t, &x), &y)) in t.iter().zip(x).zip(y).enumerate() {
            // Counted from the first event of the stream, as users count.
            let index = self.len() + k;
            if !self.sensor.contains(x, y) {
                return Some(CoreError::OutsideSensor { index, x, y, sensor: self.sensor });
            }
            match previous {
                Some(previous) if t < previous => {
                    return Some(CoreError::OutOfOrder { index, t, previous });
                }
                _ => previous = Some(t),
            }
        }
        None
    }

    /// Keeps the events for which `keep` says so, asked in order.
    pub fn retain(&mut self, mut keep: impl FnMut(Event) -> bool) {
        let length = self.len();
        // Every event is copied to where it would stay, without a branch that cannot be foreseen.
        let (t, x) = (&mut self.t[..length], &mut self.x[..length]);
        let (y, polarity) = (&mut self.y[..length], &mut self.polarity[..length]);
        let mut kept = 0;
        for i in 0..length {
            let event = Event { t: t[i], x: x[i], y: y[i], polarity: polarity[i] };
            (t[kept], x[kept]) = (event.t, event.x);
            (y[kept], polarity[kept]) = (event.y, event.polarity);
            kept += usize::from(keep(event));
        }
        self.t.truncate(kept);
        self.x.truncate(kept);
        self.y.truncate(kept);
        self.polarity.truncate(kept);
    }

    /// Gives the columns up: times, columns, rows, polarities. See [`Self::from_columns`].
    pub fn into_columns(self) -> (Vec<Micros>, Vec<u16>, Vec<u16>, Vec<Polarity>) {
        (self.t, self.x, self.y, self.polarity)
    }

    /// Makes room for `events` further events.
    pub fn reserve(&mut self, events: usize) {
        self.t.reserve(events);
        self.x.reserve(events);
        self.y.reserve(events);
        self.polarity.reserve(events);
    }

    /// Removes all events and keeps the capacity.
    pub fn clear(&mut self) {
        self.t.clear();
        self.x.clear();
        self.y.clear();
        self.polarity.clear();
    }

    /// The sensor the events came from.
    pub fn sensor(&self) -> SensorSize {
        self.sensor
    }

    /// Number of events.
    pub fn len(&self) -> usize {
        self.t.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.t.is_empty()
    }

    /// Times, ascending.
    pub fn t(&self) -> &[Micros] {
        &self.t
    }

    /// Column of each event, from 0 at the left.
    pub fn x(&self) -> &[u16] {
        &self.x
    }

    /// Row of each event, from 0 at the top.
    pub fn y(&self) -> &[u16] {
        &self.y
    }

    /// Polarities.
    pub fn polarity(&self) -> &[Polarity] {
        &self.polarity
    }

    /// Event number `index`, if there is one.
    pub fn get(&self, index: usize) -> Option<Event> {
        Some(Event {
            t: *self.t.get(index)?,
            x: self.x[index],
            y: self.y[index],
            polarity: self.polarity[index],
        })
    }

    /// All events in order.
    pub fn iter(&self) -> impl ExactSizeIterator<Item = Event> + '_ {
        (0..self.len()).map(|i| Event {
            t: self.t[i],
            x: self.x[i],
            y: self.y[i],
            polarity: self.polarity[i],
        })
    }

    /// The events inside `window` as a stream of their own.
    pub fn slice(&self, window: TimeWindow) -> Self {
        let range = self.range(window);
        Self {
            sensor: self.sensor,
            t: self.t[range.clone()].to_vec(),
            x: self.x[range.clone()].to_vec(),
            y: self.y[range.clone()].to_vec(),
            polarity: self.polarity[range].to_vec(),
        }
    }

    /// Indices of the events inside `window`.
    pub fn range(&self, window: TimeWindow) -> std::ops::Range<usize> {
        let start = self.t.partition_point(|&t| t < window.start);
        // A window that ends before its start is empty in this way, and no panic.
        let end = start + self.t[start..].partition_point(|&t| t < window.end);
        start..end
    }
}

/// Whether all values are below a limit, without a branch for each.
fn lie_below(column: &[u16], limit: u16) -> bool {
    column.iter().fold(true, |all, &value| all & (value < limit))
}

/// Builds a stream from possibly faulty data, counting rejected events.
#[derive(Debug)]
pub struct EventStreamBuilder {
    stream: EventStream,
    rejected: Rejected,
}

/// Counts of the events that a builder rejected, by reason.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Rejected {
    /// Outside the sensor.
    pub outside_sensor: usize,
    /// Earlier than the event before.
    pub out_of_order: usize,
}

impl Rejected {
    /// Events rejected for any reason.
    pub fn total(self) -> usize {
        self.outside_sensor + self.out_of_order
    }
}

impl EventStreamBuilder {
    /// Starts an empty stream.
    pub fn new(sensor: SensorSize) -> Self {
        Self { stream: EventStream::empty(sensor), rejected: Rejected::default() }
    }

    /// Takes an event, or counts it as rejected.
    pub fn push(&mut self, event: Event) {
        match self.stream.push(event) {
            Ok(()) => {}
            Err(CoreError::OutOfOrder { .. }) => self.rejected.out_of_order += 1,
            Err(_) => self.rejected.outside_sensor += 1,
        }
    }

    /// The stream and the counts of rejected events.
    pub fn finish(self) -> (EventStream, Rejected) {
        (self.stream, self.rejected)
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const SENSOR: SensorSize = SensorSize { width: 4, height: 3 };

    fn event(t: i64, x: u16, y: u16) -> Event {
        Event { t: Micros(t), x, y, polarity: Polarity::On }
    }

    #[test]
    fn an_event_outside_the_sensor_is_refused() {
        let refused = EventStream::from_events(SENSOR, [event(0, 4, 0)]);
        assert_eq!(refused, Err(CoreError::OutsideSensor { index: 0, x: 4, y: 0, sensor: SENSOR }));
    }

    #[test]
    fn columns_are_refused_as_their_events_would_be_one_by_one() {
        let mut stream = EventStream::from_events(SENSOR, [event(3, 0, 0)]).unwrap();
        let kept = stream.clone();
        let on = [Polarity::On; 3];
        let times = |t: [i64; 3]| t.map(Micros);
        for (t, x, y) in [([3, 4, 5], [0, 4, 0], [0; 3]), ([3, 4, 5], [0; 3], [0, 0, 3])] {
            let fault = stream.extend_columns(&times(t), &x, &y, &on).unwrap_err();
            assert!(matches!(fault, CoreError::OutsideSensor { .. }), "{fault}");
        }
        for (t, index) in [([2, 4, 5], 1), ([3, 5, 4], 3)] {
            let fault = stream.extend_columns(&times(t), &[0; 3], &[0; 3], &on).unwrap_err();
            assert!(matches!(fault, CoreError::OutOfOrder { index: at, .. } if at == index));
        }
        let fault = stream.extend_columns(&times([3, 4, 5]), &[0; 2], &[0; 3], &on).unwrap_err();
        assert_eq!(fault, CoreError::ColumnLengths { lengths: [3, 2, 3, 3] });
        assert_eq!(stream, kept);
        stream.extend_columns(&times([3, 4, 5]), &[1, 2, 3], &[0, 1, 2], &on).unwrap();
        assert_eq!(stream.get(3), Some(event(5, 3, 2)));
    }

    #[test]
    fn an_earlier_event_is_refused() {
        let refused = EventStream::from_events(SENSOR, [event(5, 0, 0), event(4, 0, 0)]);
        assert_eq!(
            refused,
            Err(CoreError::OutOfOrder { index: 1, t: Micros(4), previous: Micros(5) })
        );
    }

    #[test]
    fn rejected_events_are_counted_by_their_fault() {
        let mut builder = EventStreamBuilder::new(SENSOR);
        for event in
            [event(5, 0, 0), event(4, 0, 0), event(4, 9, 0), event(6, 0, 9), event(5, 3, 2)]
        {
            builder.push(event);
        }
        let (stream, rejected) = builder.finish();
        assert_eq!(
            stream,
            EventStream::from_events(SENSOR, [event(5, 0, 0), event(5, 3, 2)]).unwrap()
        );
        assert_eq!(rejected, Rejected { outside_sensor: 2, out_of_order: 1 });
        assert_eq!(rejected.total(), 3);
    }

    #[test]
    fn a_cleared_stream_is_empty_and_keeps_its_room() {
        let mut stream = EventStream::from_events(SENSOR, [event(5, 0, 0)]).unwrap();
        stream.reserve(100);
        let room = |stream: &EventStream| {
            let EventStream { t, x, y, polarity, .. } = stream;
            t.capacity().min(x.capacity()).min(y.capacity()).min(polarity.capacity())
        };
        assert!(room(&stream) > 100);
        stream.clear();
        assert!(stream.is_empty() && stream == EventStream::empty(SENSOR));
        assert!(room(&stream) > 100);
        stream.push(event(0, 1, 1)).unwrap();
    }

    proptest! {
        #[test]
        fn events_one_by_one_are_those_of_the_columns(
            raw in prop::collection::vec((0i64..9, 0u16..4, 0u16..3, any::<bool>()), 0..60),
            start in 0i64..9,
        ) {
            let mut events: Vec<Event> = raw
                .iter()
                .map(|&(t, x, y, on)| Event { t: Micros(t), x, y, polarity: Polarity::from_on(on) })
                .collect();
            events.sort_by_key(|event| event.t);
            let stream = EventStream::from_events(SENSOR, events.iter().copied())?;
            prop_assert_eq!(stream.iter().collect::<Vec<_>>(), events.clone());
            let got: Vec<_> = (0..=events.len()).map_while(|i| stream.get(i)).collect();
            prop_assert_eq!(&got, &events);
            prop_assert_eq!((stream.len(), stream.is_empty()), (events.len(), events.is_empty()));
            for (i, event) in events.iter().enumerate() {
                let columns = (stream.t()[i], stream.x()[i], stream.y()[i], stream.polarity()[i]);
                prop_assert_eq!(columns, (event.t, event.x, event.y, event.polarity));
                prop_assert_eq!(event.polarity.flipped().is_on(), !event.polarity.is_on());
            }
            let window = TimeWindow { start: Micros(start), end: Micros(start + 3) };
            let inside: Vec<_> = events.into_iter().filter(|event| window.contains(event.t)).collect();
            prop_assert_eq!(stream.slice(window).iter().collect::<Vec<_>>(), inside);
        }

        #[test]
        fn columns_are_taken_if_their_events_would_be(
            t in prop::collection::vec(0i64..4, 2), x in prop::collection::vec(0u16..6, 2),
            y in prop::collection::vec(0u16..5, 2), missing in 0usize..8,
        ) {
            let times: Vec<Micros> = t.iter().copied().map(Micros).collect();
            let (x_all, y_all) = (x.clone(), y.clone());
            let mut columns = (times, x, y, vec![Polarity::On; 2]);
            match missing {
                0 => drop(columns.1.pop()),
                1 => drop(columns.2.pop()),
                2 => drop(columns.3.pop()),
                _ => {}
            }
            let one_by_one = EventStream::from_events(
                SENSOR,
                (0..2).map(|i| event(t[i], x_all[i], y_all[i])),
            );
            let (t, x, y, polarity) = columns.clone();
            let taken = EventStream::from_columns(SENSOR, t, x, y, polarity);
            match one_by_one {
                Ok(stream) if missing > 2 => prop_assert_eq!(taken, Ok(stream)),
                _ => prop_assert_eq!(taken, Err(columns)),
            }
        }

        #[test]
        fn a_window_holds_exactly_the_events_inside(
            mut times in prop::collection::vec(0i64..50, 0..60), start in 0i64..50, length in 0i64..50,
        ) {
            times.sort_unstable();
            let stream = EventStream::from_events(SENSOR, times.iter().map(|&t| event(t, 1, 1)))?;
            let window = TimeWindow { start: Micros(start), end: Micros(start + length) };
            let inside = times.iter().filter(|&&t| window.contains(Micros(t))).count();
            let range = stream.range(window);
            prop_assert_eq!(range.len(), inside);
            prop_assert!(stream.t()[range].iter().all(|&t| window.contains(t)));
            prop_assert_eq!(stream.slice(window).len(), inside);
        }

        #[test]
        fn retaining_is_filtering_in_order(raw in prop::collection::vec((0u16..4, 0u16..3), 0..60)) {
            let events: Vec<Event> =
                raw.iter().enumerate().map(|(t, &(x, y))| event(t as i64, x, y)).collect();
            let mut stream = EventStream::from_events(SENSOR, events.iter().copied())?;
            let mut asked = Vec::new();
            stream.retain(|event| {
                asked.push(event);
                event.x != event.y
            });
            prop_assert_eq!(&asked, &events);
            let kept = events.into_iter().filter(|event| event.x != event.y);
            prop_assert_eq!(&stream, &EventStream::from_events(SENSOR, kept)?);
            let (t, x, y, polarity) = stream.clone().into_columns();
            prop_assert_eq!(EventStream::from_columns(SENSOR, t, x, y, polarity), Ok(stream));
        }

        #[test]
        fn a_builder_loses_count_of_nothing(
            raw in prop::collection::vec((0i64..20, 0u16..6, 0u16..6), 0..60),
        ) {
            let mut builder = EventStreamBuilder::new(SENSOR);
            for &(t, x, y) in &raw {
                builder.push(event(t, x, y));
            }
            let (stream, rejected) = builder.finish();
            prop_assert_eq!(stream.len() + rejected.total(), raw.len());
            prop_assert!(stream.t().is_sorted());
        }
    }
}
