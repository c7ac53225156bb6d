//! Images that are drawn from the state of each pixel, which all else goes to.

use std::fmt::Debug;

use evpose_core::{EventStream, Micros};

use crate::{Grey, Representation};

/// State of pixels that a stream of events changes.
pub(crate) trait PixelState: Debug + Send {
    fn push(&mut self, events: &EventStream);

    fn advance(&mut self, t: Micros);

    fn reset(&mut self);
}

/// A state, and what of it is shown.
#[derive(Debug)]
pub(crate) struct Drawn<S> {
    pub(crate) state: S,
    pub(crate) channels: usize,
    pub(crate) grey: Grey,
    pub(crate) draw: fn(&S, &mut [f32]),
}

impl<S: PixelState> Representation for Drawn<S> {
    fn channels(&self) -> usize {
        self.channels
    }

    fn push(&mut self, events: &EventStream) {
        self.state.push(events);
    }

    fn advance(&mut self, t: Micros) {
        self.state.advance(t);
    }

    fn render(&self, out: &mut [f32]) {
        (self.draw)(&self.state, out);
    }

    fn grey(&self) -> Grey {
        self.grey
    }

    fn reset(&mut self) {
        self.state.reset();
    }
}
