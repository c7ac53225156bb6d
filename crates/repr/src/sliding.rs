//! The events of a window that slides.

use std::collections::VecDeque;

use evpose_core::{EventStream, Micros};

use crate::StreamWindow;

/// When an event happened, and the index of its pixel.
pub(crate) type Placed = (Micros, u32);

/// Removes the events that are out of the window at `now`, and shows their indices to `gone`.
pub(crate) fn expire(
    events: &mut VecDeque<Placed>,
    window: &StreamWindow,
    now: Micros,
    gone: impl FnMut(u32),
) {
    let oldest = Micros(now.0.saturating_sub(window.length_us.into()));
    let out = events.partition_point(|&(t, _)| t <= oldest);
    events.drain(..out).map(|(_, index)| index).for_each(gone);
}

/// Number of the first event of a push that the window still shows once all of it has been pushed.
pub(crate) fn first_shown(window: &StreamWindow, events: &EventStream) -> usize {
    let Some(&last) = events.t().last() else { return 0 };
    let oldest = Micros(last.0.saturating_sub(window.length_us.into()));
    events.t().partition_point(|&t| t <= oldest)
}
