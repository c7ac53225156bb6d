//! Cleaners one after the other.

use evpose_core::{EventStream, Micros, SensorSize};

use crate::{CleanError, CleanRequest, Cleaner, Mask, Note};

/// Cleaners in the order in which they were asked for, and what each has removed.
///
/// Those that have to know the whole recording first, as hot pixels by their counts, make a survey:
/// the recording is read [`Self::surveys`] times through [`Self::survey`], each time followed by
/// [`Self::end_survey`], and then once through [`Self::clean`], followed by [`Self::finish`]. A
/// survey sees the events that the cleaners before it leave.
#[derive(Debug)]
pub struct CleanerChain {
    sensor: SensorSize,
    links: Vec<Link>,
    /// Links whose survey is over.
    surveyed: usize,
    last: Option<Micros>,
    /// Events of a survey that pass through the cleaners before it.
    passing: EventStream,
}

#[derive(Debug)]
struct Link {
    name: &'static str,
    cleaner: Box<dyn Cleaner>,
    entered: u64,
    left: u64,
}

/// Statistics of one cleaner of a chain.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CleanReport {
    /// Its name in the registry.
    pub cleaner: &'static str,
    /// Events that came to it.
    pub entered: u64,
    /// Events that it left.
    pub left: u64,
    /// Further counts.
    pub notes: Vec<Note>,
}

impl CleanReport {
    /// Events that it removed, once the recording is finished.
    pub fn removed(&self) -> u64 {
        self.entered - self.left
    }
}

impl CleanerChain {
    /// The cleaners that are asked for, in this order, for events of `sensor`.
    ///
    /// # Errors
    /// Values that a cleaner cannot take, files that cannot be read or are of another sensor.
    pub fn new(sensor: SensorSize, requests: &[CleanRequest]) -> Result<Self, CleanError> {
        let link = |request: &CleanRequest| {
            let cleaner = request.build(sensor)?;
            Ok(Link { name: request.name(), cleaner, entered: 0, left: 0 })
        };
        let links: Result<Vec<Link>, CleanError> = requests.iter().map(link).collect();
        let passing = EventStream::empty(sensor);
        Ok(Self { sensor, links: links?, surveyed: 0, last: None, passing })
    }

    /// How often the recording must still be read before it can be cleaned.
    pub fn surveys(&self) -> usize {
        self.links[self.surveyed..].iter().filter(|link| link.cleaner.surveys()).count()
    }

    /// Looks at a batch, if any survey is due.
    ///
    /// # Errors
    /// Events of another sensor, or from before the last batch.
    pub fn survey(&mut self, events: &EventStream) -> Result<(), CleanError> {
        self.check(events)?;
        if let Some(at) = self.next_survey() {
            // Earlier cleaners work on a copy, since they change events in place.
            self.passing.clear();
            self.passing
                .extend_columns(events.t(), events.x(), events.y(), events.polarity())
                .map_err(|_| self.of_other_sensor(events))?;
            for link in &mut self.links[..at] {
                link.cleaner.clean(&mut self.passing);
            }
            self.links[at].cleaner.survey(&self.passing);
        }
        Ok(())
    }

    /// The whole recording has been looked at.
    ///
    /// # Errors
    /// If the survey has found nothing that could be used.
    pub fn end_survey(&mut self) -> Result<(), CleanError> {
        let Some(at) = self.next_survey() else { return Ok(()) };
        self.passing.clear();
        // Events that earlier cleaners still buffer belong to the survey as well.
        for link in &mut self.links[..at] {
            link.cleaner.clean(&mut self.passing);
            link.cleaner.finish(&mut self.passing);
        }
        self.links[at].cleaner.survey(&self.passing);
        self.links[at].cleaner.settle()?;
        // The recording is read again from its beginning, also by the cleaners before.
        self.links[..=at].iter_mut().for_each(|link| link.cleaner.reset());
        self.surveyed = at + 1;
        self.last = None;
        Ok(())
    }

    /// Cleans a batch in place: what is left of it, and of earlier ones that were held back.
    ///
    /// # Errors
    /// Events of another sensor, or from before the last batch, and a survey that is still due; the
    /// batch is then unchanged.
    pub fn clean(&mut self, events: &mut EventStream) -> Result<(), CleanError> {
        self.check_surveyed()?;
        self.check(events)?;
        for link in &mut self.links {
            link.entered += events.len() as u64;
            link.cleaner.clean(events);
            link.left += events.len() as u64;
        }
        Ok(())
    }

    /// Returns the events still buffered at the end of the recording.
    ///
    /// # Errors
    /// A survey that is still due.
    pub fn finish(&mut self) -> Result<EventStream, CleanError> {
        self.check_surveyed()?;
        let mut events = EventStream::empty(self.sensor);
        for link in &mut self.links {
            link.entered += events.len() as u64;
            // Events that one cleaner releases at the end must still pass through the later ones.
            link.cleaner.clean(&mut events);
            link.cleaner.finish(&mut events);
            link.left += events.len() as u64;
        }
        Ok(events)
    }

    /// Statistics of every cleaner, in order.
    pub fn report(&self) -> Vec<CleanReport> {
        let report = |link: &Link| CleanReport {
            cleaner: link.name,
            entered: link.entered,
            left: link.left,
            notes: link.cleaner.notes(),
        };
        self.links.iter().map(report).collect()
    }

    /// The masks that cleaners apply or have found, to be written to files.
    pub fn masks(&self) -> impl Iterator<Item = (&'static str, &Mask)> {
        self.links.iter().filter_map(|link| Some((link.name, link.cleaner.mask()?)))
    }

    fn next_survey(&self) -> Option<usize> {
        (self.surveyed..self.links.len()).find(|&at| self.links[at].cleaner.surveys())
    }

    fn check_surveyed(&self) -> Result<(), CleanError> {
        match self.next_survey() {
            Some(at) => Err(CleanError::NotSurveyed { cleaner: self.links[at].name }),
            None => Ok(()),
        }
    }

    fn check(&mut self, events: &EventStream) -> Result<(), CleanError> {
        if events.sensor() != self.sensor {
            return Err(self.of_other_sensor(events));
        }
        let (Some(&first), Some(&last)) = (events.t().first(), events.t().last()) else {
            return Ok(());
        };
        if let Some(previous) = self.last.filter(|&previous| first < previous) {
            return Err(CleanError::OutOfOrder { t: first, previous });
        }
        self.last = Some(last);
        Ok(())
    }

    fn of_other_sensor(&self, events: &EventStream) -> CleanError {
        CleanError::EventsOfOtherSensor { actual: events.sensor(), sensor: self.sensor }
    }
}
