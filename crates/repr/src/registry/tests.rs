//! Laws that hold for every representation.

#![allow(clippy::unwrap_used, reason = "tests")]

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use proptest::prelude::*;

use super::*;
use crate::{ChannelOrder, Transitions};

const SENSOR: SensorSize = SensorSize { width: 4, height: 3 };

fn order() -> impl Strategy<Value = ChannelOrder> {
    prop::sample::select(vec![ChannelOrder::OnFirst, ChannelOrder::OffFirst])
}

/// Events in time order, many of them at equal times.
fn events(most_us: i64) -> impl Strategy<Value = Vec<Event>> {
    let event = (0..most_us, 0..SENSOR.width, 0..SENSOR.height, any::<bool>());
    prop::collection::vec(event, 0..80).prop_map(|mut events| {
        events.sort_by_key(|&(t, ..)| t);
        let event = |(t, x, y, on)| Event { t: Micros(t), x, y, polarity: Polarity::from_on(on) };
        events.into_iter().map(event).collect()
    })
}

fn stream(events: &[Event]) -> EventStream {
    let mut stream = EventStream::empty(SENSOR);
    for &event in events {
        assert_eq!(stream.push(event), Ok(()));
    }
    stream
}

fn rendered(representation: &dyn Representation) -> Vec<f32> {
    let mut out = vec![f32::NAN; representation.channels() * SENSOR.pixels()];
    representation.render(&mut out);
    out
}

fn filled(spec: &RepresentationSpec, window: &FrameWindow, events: &[FrameEvent]) -> Vec<f32> {
    let mut out = vec![f32::NAN; spec.channels * SENSOR.pixels()];
    (spec.fill)(window, events, &mut out);
    out
}

#[test]
fn names_are_unique_and_found_and_others_are_refused_with_the_list() {
    for spec in REPRESENTATIONS {
        assert_eq!(representation_called(spec.name).map(|s| s.summary), Ok(spec.summary));
        let window = StreamWindow::new(SENSOR, Micros(1), ChannelOrder::OnFirst).unwrap();
        assert_eq!((spec.start)(window).channels(), spec.channels);
    }
    let message = representation_called("eros").map_err(|e| e.to_string()).err();
    let want = "no representation is called `eros`; \
                there are lnes, eoi, eci, eci-s, eci-parity, eci-s-parity";
    assert_eq!(message.as_deref(), Some(want));
}

proptest! {
    #[test]
    fn however_events_are_cut_into_pushes_the_planes_are_the_same(
        events in events(6_000), cuts in prop::collection::vec(0usize..80, 0..6),
        length_us in 1i64..8_000, order in order(),
    ) {
        let mut cuts: Vec<_> = cuts.into_iter().map(|cut| cut.min(events.len())).collect();
        cuts.extend([0, events.len()]);
        cuts.sort_unstable();
        let window = StreamWindow::new(SENSOR, Micros(length_us), order)?;
        for spec in REPRESENTATIONS {
            let mut whole = (spec.start)(window);
            whole.push(&stream(&events));
            let mut pieces = (spec.start)(window);
            for pair in cuts.windows(2) {
                pieces.push(&stream(&events[pair[0]..pair[1]]));
                // Looking does not change what is seen, nor does the time that has passed anyway.
                rendered(pieces.as_ref());
                if let Some(last) = events[..pair[1]].last() {
                    pieces.advance(last.t);
                }
            }
            prop_assert_eq!(rendered(whole.as_ref()), rendered(pieces.as_ref()), "{}", spec.name);
        }
    }

    #[test]
    fn events_of_equal_time_may_come_in_any_order(
        events in events(20), shuffle in any::<u64>(), order in order(),
    ) {
        let window = StreamWindow::new(SENSOR, Micros(15), order)?;
        let mut shuffled = events.clone();
        shuffled.sort_by_key(|e| {
            let pixel = u64::from(e.x) * 7 + u64::from(e.y) * 3 + e.polarity as u64;
            (e.t, pixel.wrapping_add(1).wrapping_mul(shuffle | 1))
        });
        for spec in REPRESENTATIONS {
            let render = |events: &[Event]| {
                let mut representation = (spec.start)(window);
                representation.push(&stream(events));
                rendered(representation.as_ref())
            };
            prop_assert_eq!(render(&events), render(&shuffled), "{}", spec.name);
        }
    }

    /// The window of the `frames` frames up to frame `n`, whose events are at whole milliseconds:
    /// counts and occurrences agree at `n` ms, LNES one frame later.
    #[test]
    fn a_stream_agrees_with_a_window_of_frames(
        events in events(30), frames in 1u32..25, n in 0i64..30, order in order(),
    ) {
        let upto: Vec<_> = events
            .iter()
            .filter(|event| event.t.0 <= n)
            .map(|event| Event { t: Micros(event.t.0 * 1000), ..*event })
            .collect();
        let start = n + 1 - i64::from(frames);
        let inside: Vec<_> = events
            .iter()
            .filter(|event| (start..=n).contains(&event.t.0))
            .map(|&Event { t, x, y, polarity }| {
                FrameEvent { frame: (t.0 - start) as u32, x, y, polarity }
            })
            .collect();
        let length = Micros(i64::from(frames) * 1000);
        for spec in REPRESENTATIONS {
            let mut streamed = (spec.start)(StreamWindow::new(SENSOR, length, order)?);
            streamed.push(&stream(&upto));
            streamed.advance(Micros(1000 * if spec.name == "lnes" { n + 1 } else { n }));
            let window = FrameWindow::new(SENSOR, frames, order);
            prop_assert_eq!(
                rendered(streamed.as_ref()), filled(spec, &window, &inside), "{}", spec.name
            );
        }
    }

    #[test]
    fn the_other_channel_order_is_the_channels_swapped(events in events(30)) {
        let frames: Vec<_> = events
            .iter()
            .map(|&Event { t, x, y, polarity }| FrameEvent { frame: t.0 as u32, x, y, polarity })
            .collect();
        for spec in REPRESENTATIONS.iter().filter(|spec| spec.channels == 2) {
            let on_first =
                filled(spec, &FrameWindow::new(SENSOR, 30, ChannelOrder::OnFirst), &frames);
            let mut off_first =
                filled(spec, &FrameWindow::new(SENSOR, 30, ChannelOrder::OffFirst), &frames);
            off_first.rotate_left(SENSOR.pixels());
            prop_assert_eq!(on_first, off_first, "{}", spec.name);
        }
    }

    /// The published rule: draw frame by frame and clear everything after a transition frame.
    #[test]
    fn hiding_is_clearing_after_each_transition(
        events in events(30), start in 0u64..40, period_frames in 1u64..40,
    ) {
        let frames: Vec<_> = events
            .iter()
            .map(|&Event { t, x, y, polarity }| FrameEvent { frame: t.0 as u32, x, y, polarity })
            .collect();
        let window = FrameWindow::new(SENSOR, 30, ChannelOrder::OffFirst);
        let mut remaining: Vec<FrameEvent> = Vec::new();
        for frame in 0..30 {
            remaining.extend(frames.iter().filter(|event| event.frame == frame));
            if (start + u64::from(frame)).is_multiple_of(period_frames) {
                remaining.clear();
            }
        }
        let hiding = window.hiding(&Transitions::Every { period_frames }, start);
        for spec in REPRESENTATIONS {
            prop_assert_eq!(
                filled(spec, &hiding, &frames), filled(spec, &window, &remaining), "{}", spec.name
            );
        }
    }
}
