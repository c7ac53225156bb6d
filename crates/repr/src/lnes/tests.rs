use evpose_core::{Event, Polarity, SensorSize};

use super::*;
use crate::{ChannelOrder, ReprError};

const SENSOR: SensorSize = SensorSize { width: 3, height: 2 };

fn event(t_us: i64, x: u16, y: u16, on: bool) -> Event {
    Event { t: Micros(t_us), x, y, polarity: Polarity::from_on(on) }
}

fn frame_event(frame: u32, x: u16, y: u16, on: bool) -> FrameEvent {
    FrameEvent { frame, x, y, polarity: Polarity::from_on(on) }
}

fn stream(events: &[Event]) -> EventStream {
    let mut stream = EventStream::empty(SENSOR);
    for &event in events {
        assert_eq!(stream.push(event), Ok(()));
    }
    stream
}

fn lnes(length_us: i64, order: ChannelOrder) -> Lnes {
    Lnes::new(StreamWindow::new(SENSOR, Micros(length_us), order).unwrap())
}

fn rendered(lnes: &Lnes) -> [f32; 12] {
    let mut out = [f32::NAN; 12];
    lnes.render(&mut out);
    out
}

/// By hand: a window of 100 µs that ends at 1000 µs.
#[test]
fn a_stream_gives_the_age_of_the_latest_event_as_a_share_of_the_window() {
    let mut lnes = lnes(100, ChannelOrder::OffFirst);
    assert_eq!(rendered(&lnes), [0.0; 12]);
    lnes.push(&stream(&[
        event(850, 0, 1, true),  // too old
        event(900, 1, 1, true),  // the oldest: 0
        event(925, 0, 0, false), // 0.25
        event(930, 2, 1, false), // overwritten
        event(975, 2, 1, false), // 0.75
        event(1000, 1, 0, true), // now: 1
    ]));
    #[rustfmt::skip]
    assert_eq!(rendered(&lnes), [
        0.25, 0.0, 0.0,   0.0, 0.0, 0.75, // OFF
        0.0, 1.0, 0.0,    0.0, 0.0, 0.0,  // ON
    ]);
    lnes.advance(Micros(1050));
    #[rustfmt::skip]
    assert_eq!(rendered(&lnes), [
        0.0, 0.0, 0.0,    0.0, 0.0, 0.25,
        0.0, 0.5, 0.0,    0.0, 0.0, 0.0,
    ]);
    lnes.advance(Micros(0));
    assert_eq!(rendered(&lnes)[7], 0.5);
    lnes.reset();
    assert_eq!(rendered(&lnes), [0.0; 12]);
}

/// By hand: a window of four frames.
#[test]
fn a_window_of_frames_gives_the_frame_number_over_their_count() {
    let events = [
        frame_event(0, 0, 0, true), // the oldest frame is invisible
        frame_event(1, 1, 0, true),
        frame_event(1, 2, 0, true),
        frame_event(2, 2, 0, false),
        frame_event(3, 2, 0, true), // the last event wins
        frame_event(3, 2, 1, true),
    ];
    let mut out = [f32::NAN; 12];
    fill_lnes(&FrameWindow::new(SENSOR, 4, ChannelOrder::OffFirst), events, &mut out);
    let off = [0.0, 0.0, 0.5, 0.0, 0.0, 0.0];
    let on = [0.0, 0.25, 0.75, 0.0, 0.0, 0.75];
    assert_eq!(out[..], [off, on].concat());
    fill_lnes(&FrameWindow::new(SENSOR, 4, ChannelOrder::OnFirst), events, &mut out);
    assert_eq!(out[..], [on, off].concat());
}

#[test]
fn what_happened_before_the_first_visible_frame_is_not_drawn_and_later_values_stay() {
    let events =
        [frame_event(1, 0, 0, true), frame_event(2, 1, 0, true), frame_event(3, 2, 0, true)];
    let mut out = [f32::NAN; 12];
    for (visible_from, want) in [(3, [0.0, 0.0, 0.75]), (4, [0.0; 3]), (1, [0.25, 0.5, 0.75])] {
        let window = FrameWindow::new(SENSOR, 4, ChannelOrder::OnFirst);
        fill_lnes(&FrameWindow { visible_from, ..window }, events, &mut out);
        assert_eq!(out[..3], want);
    }
}

#[test]
fn time_that_jumps_back_starts_anew() {
    let mut lnes = lnes(100, ChannelOrder::OffFirst);
    lnes.push(&stream(&[event(10_000, 0, 0, false)]));
    lnes.push(&stream(&[event(500, 1, 0, false)]));
    assert_eq!(rendered(&lnes)[..3], [0.0, 1.0, 0.0]);
}

#[test]
#[should_panic(expected = "events from a sensor of another size")]
fn events_of_another_sensor_are_a_bug() {
    lnes(100, ChannelOrder::OffFirst).push(&EventStream::empty(SensorSize::DAVIS240C));
}

/// The planes keep 32 bits of each time: at and around every move of their origin.
#[test]
fn days_of_events_give_the_same_ages_as_minutes() {
    let mut lnes = lnes(1000, ChannelOrder::OffFirst);
    let half = 1 << 29;
    for step in (0..200 * half).step_by(half as usize) {
        let t = 5 + step;
        lnes.push(&stream(&[event(t, 0, 0, false), event(t + 500, 1, 0, false)]));
        lnes.advance(Micros(t + 750));
        assert_eq!(rendered(&lnes)[..3], [0.25, 0.75, 0.0], "{t}");
    }
    lnes.advance(Micros(i64::MAX));
    assert_eq!(rendered(&lnes), [0.0; 12]);
}

#[test]
fn an_event_survives_the_longest_window_and_a_longer_one_is_refused() {
    let longest = StreamWindow::MAX_LENGTH;
    let mut lnes = lnes(longest.0, ChannelOrder::OffFirst);
    lnes.push(&stream(&[event(0, 0, 0, false), event(longest.0 / 2, 1, 0, false)]));
    lnes.advance(longest);
    assert_eq!(rendered(&lnes)[..3], [0.0, 0.5, 0.0]);
    for length in [0, -1, longest.0 + 1, i64::MAX] {
        let length = Micros(length);
        let refused = StreamWindow::new(SENSOR, length, ChannelOrder::OffFirst);
        assert_eq!(refused, Err(ReprError::WindowLength { length }));
    }
}

#[test]
fn times_at_the_ends_of_the_range_do_not_overflow() {
    let mut lnes = lnes(100, ChannelOrder::OffFirst);
    lnes.push(&stream(&[event(i64::MIN, 0, 0, false), event(i64::MAX, 1, 0, false)]));
    assert_eq!(rendered(&lnes)[..3], [0.0, 1.0, 0.0]);
}
