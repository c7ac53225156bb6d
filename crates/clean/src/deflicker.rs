//! Flicker of lamps: milliseconds in which many pixels fire at once, and single pixels in them.
//!
//! # Model
//! A window is cut into bins of 1 ms. A bin flickers if it has more events of one polarity than the
//! one before it *or* the one after it (`rule = "or"`; `"and"`: than both). Of bins that flicker,
//! only events at pixels are kept that have company: at which the LNES of the window, opened with a
//! footprint of one by two pixels and opened with one of two by one, is above zero both times, each
//! polarity by itself. All other events are kept.
//!
//! An LNES is above zero where an event fell into any bin but the first, and an opening of size two
//! leaves what one of the two neighbours has as well. So no LNES has to be computed: a pixel has
//! neighbours if it fired, a horizontal neighbour did, and a vertical one did. Beyond the first
//! column and row the pixel itself counts as its neighbour, beyond the last ones nothing does;
//! SciPy's `grey_opening` with its reflected borders does the same.
//!
//! A bin at an end of the window lacks a neighbour, which it does not exceed.
//!
//! # Source
//! EventHands' reader of real recordings, with windows of 100 ms, rule "or" (its comment says
//! "and"), and counts of what it stores as polarity 0, which are ON events there. It slides the
//! window by 1 ms for every pose, so an event may be in one LNES and not in the next: that is
//! [`Deflicker::window`]. As a cleaner of recordings, windows follow one another from the first
//! event on.

use evpose_core::{
    Event, EventStream, Micros, NumberSpec, Parameter, Polarity, SensorSize, WordSpec,
};

use crate::{Cleaner, CleanerSpec, Note};

const WINDOW: Parameter = Parameter::Number(NumberSpec {
    name: "window_ms",
    range: (1.0, 60_000.0),
    default: Some(100.0),
    doc: "length of a window in whole milliseconds; EventHands'",
    ..NumberSpec::LINEAR
});
const RULE: Parameter = Parameter::Word(WordSpec {
    name: "rule",
    allowed: &["or", "and"],
    default: Some("or"),
    doc: "whether a millisecond flickers that exceeds one of its neighbours, or both",
});
const POLARITY: Parameter = Parameter::Word(WordSpec {
    name: "polarity",
    allowed: &["on", "off"],
    default: Some("on"),
    doc: "which events are counted",
});

pub(crate) static SPEC: CleanerSpec = CleanerSpec {
    name: "deflicker",
    summary: "removes lone pixels from milliseconds in which a lamp makes many fire",
    params: &[WINDOW, RULE, POLARITY],
    displaces: false,
    build: |settings, sensor| {
        let options = DeflickerOptions {
            bins: settings.number(&WINDOW).round() as u32,
            rule: if settings.word(&RULE) == Some("and") { Rule::And } else { Rule::Or },
            counted: Polarity::from_on(settings.word(&POLARITY) == Some("on")),
        };
        Ok(Box::new(Deflicker::new(sensor, options)))
    },
};

/// Neighbouring bins that a flickering bin exceeds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rule {
    /// One of them, as the published program has it.
    Or,
    /// Both, as its comment has it.
    And,
}

/// When a millisecond flickers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeflickerOptions {
    /// Milliseconds of a window; none counts as one.
    pub bins: u32,
    /// Neighbours that it exceeds.
    pub rule: Rule,
    /// Polarity of the counted events.
    pub counted: Polarity,
}

impl Default for DeflickerOptions {
    fn default() -> Self {
        Self { bins: 100, rule: Rule::Or, counted: Polarity::On }
    }
}

const BIN_US: u64 = 1_000;

/// The filter of flickering pixels, with the counts of each.
#[derive(Debug, Clone)]
pub struct Deflicker {
    options: DeflickerOptions,
    sensor: SensorSize,
    /// The first event of the recording.
    start: Option<Micros>,
    /// The number of the window that the events buffered back are from.
    number: u64,
    buffered: EventStream,
    out: EventStream,
    /// Whether the LNES is above zero, per pixel and polarity.
    shown: Vec<bool>,
    counts: Vec<u32>,
    flickering: u64,
}

impl Deflicker {
    /// A filter that has seen nothing.
    pub fn new(sensor: SensorSize, options: DeflickerOptions) -> Self {
        let bins = options.bins.max(1);
        Self {
            options: DeflickerOptions { bins, ..options },
            sensor,
            start: None,
            number: 0,
            buffered: EventStream::empty(sensor),
            out: EventStream::empty(sensor),
            shown: vec![false; 2 * sensor.pixels()],
            counts: vec![0; bins as usize],
            flickering: 0,
        }
    }

    /// Cleans one window by itself, as the published program does at every millisecond. Events
    /// outside of it are removed.
    ///
    /// # Panics
    /// If the events are of a sensor of another size.
    pub fn window(&mut self, events: &mut EventStream, start: Micros) {
        assert_eq!(events.sensor(), self.sensor, "events from a sensor of another size");
        let bins = self.counts.len();
        // What is before the start becomes a bin far behind the end.
        let bin_of = |t: Micros| since(start, t) / BIN_US;
        events.retain(|event| event.t >= start && bin_of(event.t) < bins as u64);
        self.counts.fill(0);
        self.shown.fill(false);
        for event in events.iter() {
            let bin = bin_of(event.t) as usize;
            self.counts[bin] += u32::from(event.polarity == self.options.counted);
            // An LNES is zero at the start of its window, so that the first bin shows nothing.
            if bin > 0 {
                let place = self.place(event);
                self.shown[place] = true;
            }
        }
        let flickers: Vec<bool> = (0..bins).map(|bin| self.flickers(bin)).collect();
        self.flickering += flickers.iter().filter(|flickers| **flickers).count() as u64;
        events.retain(|event| !flickers[bin_of(event.t) as usize] || self.has_company(event));
    }

    fn flickers(&self, bin: usize) -> bool {
        let exceeds = |other: Option<usize>| {
            other.and_then(|other| self.counts.get(other)).is_some_and(|n| self.counts[bin] > *n)
        };
        let (before, after) = (exceeds(bin.checked_sub(1)), exceeds(Some(bin + 1)));
        match self.options.rule {
            Rule::Or => before || after,
            Rule::And => before && after,
        }
    }

    fn place(&self, Event { x, y, polarity, .. }: Event) -> usize {
        let row = polarity as usize * usize::from(self.sensor.height) + usize::from(y);
        row * usize::from(self.sensor.width) + usize::from(x)
    }

    fn has_company(&self, event: Event) -> bool {
        let SensorSize { width, height } = self.sensor;
        let place = self.place(event);
        let beside =
            event.x == 0 || self.shown[place - 1] || (event.x + 1 < width && self.shown[place + 1]);
        let stride = usize::from(width);
        let above = event.y == 0
            || self.shown[place - stride]
            || (event.y + 1 < height && self.shown[place + stride]);
        self.shown[place] && beside && above
    }

    /// Cleans the window that is buffered back and lets it go.
    fn release(&mut self, start: Micros) {
        let mut buffered = std::mem::replace(&mut self.buffered, EventStream::empty(self.sensor));
        let from_us = (self.number * BIN_US * u64::from(self.options.bins)) as i64;
        // Sums wrap around as differences do: a recording may span all of 64 bits.
        self.window(&mut buffered, Micros(start.0.wrapping_add(from_us)));
        append(&mut self.out, &buffered, 0..buffered.len());
        buffered.clear();
        self.buffered = buffered;
    }
}

/// Microseconds from one time to a later one.
fn since(start: Micros, t: Micros) -> u64 {
    t.0.wrapping_sub(start.0) as u64
}

fn append(to: &mut EventStream, from: &EventStream, part: std::ops::Range<usize>) {
    let all = to.extend_columns(
        &from.t()[part.clone()],
        &from.x()[part.clone()],
        &from.y()[part.clone()],
        &from.polarity()[part],
    );
    assert_eq!(all, Ok(()), "batches in order and of one sensor");
}

impl Cleaner for Deflicker {
    fn clean(&mut self, events: &mut EventStream) {
        let Some(&first) = events.t().first() else { return };
        let start = *self.start.get_or_insert(first);
        let length_us = BIN_US * u64::from(self.options.bins);
        let mut at = 0;
        while at < events.len() {
            let number = since(start, events.t()[at]) / length_us;
            // The window before is complete: its events are decided together.
            if number != self.number {
                self.release(start);
                self.number = number;
            }
            let inside = |t: &Micros| since(start, *t) / length_us == number;
            let end = at + events.t()[at..].partition_point(inside);
            append(&mut self.buffered, events, at..end);
            at = end;
        }
        // Events leave later than they come.
        std::mem::swap(events, &mut self.out);
        self.out.clear();
    }

    fn finish(&mut self, events: &mut EventStream) {
        if let Some(start) = self.start {
            self.release(start);
            append(events, &self.out, 0..self.out.len());
            self.out.clear();
        }
    }

    fn reset(&mut self) {
        self.start = None;
        self.number = 0;
        self.buffered.clear();
        self.out.clear();
        self.flickering = 0;
    }

    fn notes(&self) -> Vec<Note> {
        vec![Note { what: "milliseconds that flicker", count: self.flickering }]
    }
}

#[cfg(test)]
mod tests;
