//! Registry entries of representations, and a chosen one with the values of its parameters.

use std::fmt;

use evpose_core::{Event, EventStream, Given, Micros, Parameter, Settings};

use crate::{FrameEvent, FrameWindow, ReprError, Representation, StreamWindow};

/// Registry entry of a representation: name, parameters, properties and constructors.
#[derive(Debug)]
pub struct RepresentationSpec {
    /// Name in configurations.
    pub name: &'static str,
    /// One line on its content.
    pub summary: &'static str,
    /// Parameters, in the order of tables.
    pub parameters: &'static [Parameter],
    /// Events that the planes show.
    pub memory: Memory,
    /// Use of polarities.
    pub polarity: PolarityUse,
    /// Whether events of equal time may come in any order.
    pub any_order_at_once: bool,
    /// Number of planes.
    pub channels: fn(&Settings) -> usize,
    /// Starts the representation on a stream.
    pub start: fn(StreamWindow, &Settings) -> Box<dyn Representation>,
    /// Faster equivalent of a stream for the events of a window of frames, ascending in frame; none
    /// if a stream is used there as well.
    pub fill: Option<Fill>,
}

/// Writes planes, `[channels][height][width]`, from the events of a window of frames.
pub type Fill = fn(&FrameWindow, &[FrameEvent], &mut [f32]);

/// The events that a representation shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Memory {
    /// The events of the window.
    Window,
    /// All, older ones faded or written over: the length of the window is ignored.
    Own,
    /// A fixed number of the latest events: the length of the window is ignored.
    Count,
}

/// Use of polarities by a representation.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PolarityUse {
    /// A channel each.
    Channels,
    /// ON is positive, OFF negative.
    Sign,
    /// No effect.
    Ignored,
}

impl RepresentationSpec {
    /// This representation with the defaults of its parameters.
    pub fn with_defaults(&'static self) -> RepresentationChoice {
        self.choose(&[]).expect("nothing is given")
    }

    /// This representation with `settings`: `name=value`, separated by commas.
    ///
    /// # Errors
    /// A parameter that it does not have, or a value out of its range.
    pub fn with(&'static self, settings: &str) -> Result<RepresentationChoice, ReprError> {
        let given =
            settings.split(',').map(|setting| setting.split_once('=').unwrap_or((setting, "")));
        let given: Vec<_> = given.map(|(name, text)| (name, Given::Text(text))).collect();
        self.choose(&given)
    }

    fn choose(
        &'static self,
        given: &[(&str, Given<'_>)],
    ) -> Result<RepresentationChoice, ReprError> {
        let values = Settings::resolve(self.parameters, given)
            .and_then(|values| values.complete(self.parameters));
        let refused = |error| ReprError::Parameter { representation: self.name, error };
        Ok(RepresentationChoice { spec: self, values: values.map_err(refused)? })
    }
}

/// A representation and the values of its parameters.
///
/// Displayed as what [`representation_by_name`](crate::representation_by_name) takes, with every parameter.
#[derive(Debug, Clone)]
pub struct RepresentationChoice {
    spec: &'static RepresentationSpec,
    values: Settings,
}

impl RepresentationChoice {
    /// Registry entry.
    pub fn spec(&self) -> &'static RepresentationSpec {
        self.spec
    }

    /// Parameter values.
    pub fn values(&self) -> &Settings {
        &self.values
    }

    /// Number of planes.
    pub fn channels(&self) -> usize {
        (self.spec.channels)(&self.values)
    }

    /// Starts it on a stream.
    pub fn start(&self, window: StreamWindow) -> Box<dyn Representation> {
        (self.spec.start)(window, &self.values)
    }

    /// Fills `out`, `[channels][height][width]`, from the events of a window, ascending in frame:
    /// what a stream of these events, frame `k` at `k` ms, shows when the last frame has passed.
    /// (LNES shows it one frame later.)
    ///
    /// # Panics
    /// If `out` has another length, an event lies outside the sensor, or one is earlier than the
    /// one before.
    pub fn fill(&self, window: &FrameWindow, events: &[FrameEvent], out: &mut [f32]) {
        match self.spec.fill {
            Some(fill) => fill(window, events, out),
            None => self.replay(window, events, out),
        }
    }

    fn replay(&self, window: &FrameWindow, events: &[FrameEvent], out: &mut [f32]) {
        let mut stream = EventStream::empty(window.sensor);
        stream.reserve(events.len());
        for &FrameEvent { frame, x, y, polarity } in events {
            if window.shows(frame) {
                // Frames are milliseconds: all events of one get the same time.
                let t = Micros(i64::from(frame) * Micros::MILLISECOND.0);
                let taken = stream.push(Event { t, x, y, polarity });
                assert!(taken.is_ok(), "an event outside the sensor or out of order: {taken:?}");
            }
        }
        let mut representation = self.start(StreamWindow::of_frames(window));
        representation.push(&stream);
        let last = i64::from(window.frames) - 1;
        representation.advance(Micros(last * Micros::MILLISECOND.0));
        representation.render(out);
    }
}

impl fmt::Display for RepresentationChoice {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.spec.name)?;
        for (i, (name, value)) in self.values.iter().enumerate() {
            let separator = if i == 0 { ':' } else { ',' };
            write!(f, "{separator}{name}={value}")?;
        }
        Ok(())
    }
}
