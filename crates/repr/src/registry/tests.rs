//! Laws that hold for every representation, or for those that say so.

use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use proptest::prelude::*;

use super::*;
use crate::{
    ChannelOrder, FrameEvent, FrameWindow, Memory, NumberKind, Parameter, PolarityUse,
    Representation, StreamWindow,
};

const SENSOR: SensorSize = SensorSize { width: 4, height: 3 };

/// Every representation as it comes, and some with parameters.
fn choices() -> impl Iterator<Item = RepresentationChoice> {
    let others = [
        "eros:kernel=3,decay=0.9",
        "eros-python:kernel=2",
        "eros-hpe-core:kernel=11,decay=0.01",
        "tos:kernel=3,line=8",
        "sits:kernel=3",
        "pim:rate=300",
        "fixed-count:n=9",
        "voxel-grid:bins=2",
        "time-surface:tau_ms=0.7",
    ];
    let others = others.into_iter().map(|name| representation_by_name(name).unwrap());
    REPRESENTATIONS.iter().map(|spec| spec.with_defaults()).chain(others)
}

fn order() -> impl Strategy<Value = ChannelOrder> {
    prop::sample::select(vec![ChannelOrder::OnFirst, ChannelOrder::OffFirst])
}

/// Events in time order, many of them at equal times.
fn events(max_us: i64) -> impl Strategy<Value = Vec<Event>> {
    let event = (0..max_us, 0..SENSOR.width, 0..SENSOR.height, any::<bool>());
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

fn frame_events(events: &[Event]) -> Vec<FrameEvent> {
    let frame =
        |&Event { t, x, y, polarity }: &Event| FrameEvent { frame: t.0 as u32, x, y, polarity };
    events.iter().map(frame).collect()
}

fn flipped(events: &[Event]) -> Vec<Event> {
    events.iter().map(|&e| Event { polarity: e.polarity.flipped(), ..e }).collect()
}

fn rendered(representation: &dyn Representation) -> Vec<f32> {
    let mut out = vec![f32::NAN; representation.channels() * SENSOR.pixels()];
    representation.render(&mut out);
    out
}

fn filled(choice: &RepresentationChoice, window: &FrameWindow, events: &[FrameEvent]) -> Vec<f32> {
    let mut out = vec![f32::NAN; choice.channels() * SENSOR.pixels()];
    choice.fill(window, events, &mut out);
    out
}

/// LNES of frames is that of a stream one frame after the last.
fn frames_late(choice: &RepresentationChoice) -> i64 {
    i64::from(choice.spec().name == "lnes")
}

#[test]
fn names_are_unique_and_found_and_others_are_refused_with_the_list() {
    for spec in &REPRESENTATIONS {
        let found = representation_by_name(spec.name).unwrap();
        assert_eq!((found.spec().name, found.spec().summary), (spec.name, spec.summary));
        let window = StreamWindow::new(SENSOR, Micros(1), ChannelOrder::OnFirst).unwrap();
        assert_eq!(found.start(window).channels(), found.channels());
        assert_eq!(
            spec.polarity == PolarityUse::Channels,
            found.channels() == 2 && { spec.name != "eci-s-parity" }
        );
    }
    let message = representation_by_name("erros").map_err(|e| e.to_string()).unwrap_err();
    let want = "no representation is called `erros`; \
                there are lnes, eoi, eci, eci-s, eci-parity, eci-s-parity, eros, ";
    assert!(message.starts_with(want), "{message}");
}

#[test]
fn every_parameter_takes_its_bounds_and_is_named_in_what_a_choice_displays() {
    for spec in &REPRESENTATIONS {
        let default = spec.with_defaults();
        let again = representation_by_name(&default.to_string()).unwrap();
        assert_eq!(again.to_string(), default.to_string());
        for parameter in spec.parameters.iter().filter_map(Parameter::as_number) {
            let (name, (min, max)) = (parameter.name, parameter.range);
            let preset = parameter.default.unwrap();
            assert_eq!(default.values().number(name), preset);
            // The nearest even number, where only those are taken.
            let inwards = f64::from(parameter.kind == NumberKind::Even);
            for value in [min + inwards, preset, max - inwards] {
                let choice = representation_by_name(&format!("{}:{name}={value}", spec.name));
                let choice = choice.unwrap();
                assert_eq!(choice.values().number(name), value);
                let window = StreamWindow::new(SENSOR, Micros(9), ChannelOrder::OnFirst).unwrap();
                let started = choice.start(window);
                assert!(rendered(started.as_ref()).iter().all(|&value| value == 0.0));
            }
            for value in [min - 2.0, max + 2.0] {
                let refused = representation_by_name(&format!("{}:{name}={value}", spec.name));
                assert!(refused.is_err(), "{} {name}={value}", spec.name);
            }
        }
    }
}

/// Planes by the definitions, of what depends on a pixel's own events alone; none of the others.
fn defined(
    choice: &RepresentationChoice,
    events: &[Event],
    (length_us, now): (i64, i64),
    order: ChannelOrder,
) -> Option<Vec<f64>> {
    let pixels = SENSOR.pixels();
    let at = |event: &Event| usize::from(event.y) * 4 + usize::from(event.x);
    let shown: Vec<&Event> = match choice.spec().memory {
        Memory::Window => events.iter().filter(|event| event.t.0 > now - length_us).collect(),
        Memory::Own => events.iter().collect(),
        Memory::Count => {
            let n = choice.values().whole("n") as usize;
            events[events.len().saturating_sub(n)..].iter().collect()
        }
    };
    let mut planes = vec![0.0; choice.channels() * pixels];
    let both = |event: &Event| order.channel(event.polarity) * pixels + at(event);
    let sign = |event: &Event| if event.polarity.is_on() { 1.0 } else { -1.0 };
    let fading = |rate: f64, event: &Event| (-rate * (now - event.t.0) as f64 * 1e-6).exp();
    // Later events come later.
    match choice.spec().name {
        "lnes" => shown.iter().for_each(|event| {
            planes[both(event)] = (event.t.0 - now + length_us) as f64 / length_us as f64;
        }),
        "eoi" => shown.iter().for_each(|event| planes[both(event)] = 1.0),
        "binary" => shown.iter().for_each(|event| planes[at(event)] = 255.0),
        "eci" => shown.iter().for_each(|event| planes[both(event)] += 1.0),
        "eci-s" => shown.iter().for_each(|event| planes[at(event)] += 1.0),
        "sae" => shown.iter().for_each(|event| {
            let first = shown.first().map_or(event.t, |first| first.t);
            planes[at(event)] = (event.t - first + Micros(1)).as_seconds();
        }),
        "pim" => shown.iter().for_each(|event| {
            planes[at(event)] += sign(event) * fading(choice.values().number("rate"), event);
        }),
        "time-surface" => shown.iter().for_each(|event| {
            planes[both(event)] = fading(1e3 / choice.values().number("tau_ms"), event);
        }),
        "voxel-grid" => {
            let bins = planes.len() / pixels;
            let (Some(first), Some(last)) = (shown.first(), shown.last()) else {
                return Some(planes);
            };
            let bins_per_us = (bins - 1) as f64 / (last.t.0 - first.t.0).max(1) as f64;
            for event in &shown {
                let place = (event.t.0 - first.t.0) as f64 * bins_per_us;
                for bin in 0..bins {
                    let share = (1.0 - (bin as f64 - place).abs()).max(0.0);
                    planes[bin * pixels + at(event)] += sign(event) * share;
                }
            }
        }
        name @ ("event-count" | "fixed-count") => {
            shown.iter().for_each(|event| planes[at(event)] += 1.0);
            let fired: Vec<f64> = planes.iter().copied().filter(|&count| count > 0.0).collect();
            let n = fired.len().max(1) as f64;
            let mean = fired.iter().sum::<f64>() / n;
            let variance = fired.iter().map(|count| (count - mean).powi(2)).sum::<f64>() / n;
            let scale = 255.0 / (3.0 * variance.sqrt().max(0.1 / 255.0));
            for count in &mut planes {
                let grey = (*count * scale).min(255.0);
                let is_whole = grey % 255.0 > 0.0 && (grey - grey.round()).abs() < 1e-9;
                *count = match name {
                    // But for rounding: it may become the integer below.
                    "event-count" if is_whole => f64::NAN,
                    "event-count" => grey.trunc(),
                    _ => grey,
                };
            }
        }
        _ => return None,
    }
    Some(planes)
}

proptest! {
    /// With an image in the midst, after which the stream goes on.
    #[test]
    fn planes_are_what_their_definitions_say(
        events in events(6_000), cut in 0usize..80, later in 0i64..500, length_us in 1i64..8_000,
        order in order(),
    ) {
        let window = StreamWindow::new(SENSOR, Micros(length_us), order)?;
        let mut compared = 0;
        for choice in choices() {
            let mut representation = choice.start(window);
            let cut = cut.min(events.len());
            representation.push(&stream(&events[..cut]));
            rendered(representation.as_ref());
            representation.push(&stream(&events[cut..]));
            let now = events.last().map_or(0, |event| event.t.0) + later;
            representation.advance(Micros(now));
            let Some(want) = defined(&choice, &events, (length_us, now), order) else { continue };
            compared += 1;
            let largest = want.iter().fold(1.0, |most: f64, value| value.abs().max(most));
            for (ours, want) in rendered(representation.as_ref()).into_iter().zip(want) {
                let apart = (f64::from(ours) - want).abs();
                prop_assert!(want.is_nan() || apart <= 1e-6 * largest, "{}: {} {}", choice, ours, want);
            }
        }
        prop_assert_eq!(compared, 15);
    }

    #[test]
    fn however_events_are_cut_into_pushes_the_planes_are_the_same(
        events in events(6_000), cuts in prop::collection::vec(0usize..80, 0..6),
        length_us in 1i64..8_000, order in order(),
    ) {
        let mut cuts: Vec<_> = cuts.into_iter().map(|cut| cut.min(events.len())).collect();
        cuts.extend([0, events.len()]);
        cuts.sort_unstable();
        let window = StreamWindow::new(SENSOR, Micros(length_us), order)?;
        for choice in choices() {
            let mut whole = choice.start(window);
            whole.push(&stream(&events));
            let mut pieces = choice.start(window);
            for pair in cuts.windows(2) {
                pieces.push(&stream(&events[pair[0]..pair[1]]));
                // Looking does not change what is seen, nor does the time that has passed anyway.
                rendered(pieces.as_ref());
                if let Some(last) = events[..pair[1]].last() {
                    pieces.advance(last.t);
                }
            }
            prop_assert_eq!(rendered(whole.as_ref()), rendered(pieces.as_ref()), "{}", choice);
        }
    }

    #[test]
    fn time_that_jumps_back_forgets_what_was_before(
        before in events(3_000), after in events(3_000), length_us in 1i64..8_000, order in order(),
    ) {
        let window = StreamWindow::new(SENSOR, Micros(length_us), order)?;
        // One more, so that it is later than all others.
        let mut before = before;
        before.push(Event { t: Micros(4_000), x: 1, y: 2, polarity: Polarity::On });
        for choice in choices() {
            let mut fresh = choice.start(window);
            fresh.push(&stream(&after));
            let mut used = choice.start(window);
            used.push(&stream(&before));
            if after.is_empty() {
                used.reset();
            }
            used.push(&stream(&after));
            prop_assert_eq!(rendered(fresh.as_ref()), rendered(used.as_ref()), "{}", choice);
        }
    }

    #[test]
    fn events_of_equal_time_may_come_in_any_order_where_a_representation_says_so(
        events in events(20), shuffle in any::<u64>(), order in order(),
    ) {
        let window = StreamWindow::new(SENSOR, Micros(15), order)?;
        let mut shuffled = events.clone();
        shuffled.sort_by_key(|e| {
            let pixel = u64::from(e.x) * 7 + u64::from(e.y) * 3 + e.polarity as u64;
            (e.t, pixel.wrapping_add(1).wrapping_mul(shuffle | 1))
        });
        for choice in choices().filter(|choice| choice.spec().any_order_at_once) {
            let render = |events: &[Event]| {
                let mut representation = choice.start(window);
                representation.push(&stream(events));
                rendered(representation.as_ref())
            };
            prop_assert_eq!(render(&events), render(&shuffled), "{}", choice);
        }
    }

    /// The window of the `frames` frames up to frame `n`, whose events are at whole milliseconds.
    /// What has a window forgets the events before by itself; the others are not shown them.
    #[test]
    fn a_stream_agrees_with_a_window_of_frames(
        events in events(30), frames in 1u32..25, n in 0i64..30, order in order(),
    ) {
        let start = n + 1 - i64::from(frames);
        let inside: Vec<_> = events
            .iter()
            .filter(|event| (start..=n).contains(&event.t.0))
            .map(|event| Event { t: Micros(event.t.0 - start), ..*event })
            .collect();
        let length = Micros(i64::from(frames) * 1000);
        for choice in choices() {
            let has_window = choice.spec().memory == Memory::Window;
            let shown: Vec<_> = events
                .iter()
                .filter(|event| event.t.0 <= n && (has_window || event.t.0 >= start))
                .map(|event| Event { t: Micros((event.t.0 - start) * 1000), ..*event })
                .collect();
            let mut streamed = choice.start(StreamWindow::new(SENSOR, length, order)?);
            streamed.push(&stream(&shown));
            streamed.advance(Micros(1000 * (n - start + frames_late(&choice))));
            let window = FrameWindow::new(SENSOR, frames, order);
            prop_assert_eq!(
                rendered(streamed.as_ref()),
                filled(&choice, &window, &frame_events(&inside)),
                "{}", choice
            );
        }
    }

    #[test]
    fn polarities_are_channels_or_signs_or_nothing(events in events(30), order in order()) {
        let window = FrameWindow::new(SENSOR, 30, order);
        for choice in choices() {
            let planes = filled(&choice, &window, &frame_events(&events));
            let mut other = filled(&choice, &window, &frame_events(&flipped(&events)));
            match choice.spec().polarity {
                PolarityUse::Channels => other.rotate_left(SENSOR.pixels()),
                PolarityUse::Sign => other.iter_mut().for_each(|value| *value = -*value),
                PolarityUse::Ignored => {}
            }
            prop_assert_eq!(planes, other, "{}", choice);
        }
    }

    #[test]
    fn the_other_channel_order_swaps_the_channels_and_nothing_else(events in events(30)) {
        let frames = frame_events(&events);
        for choice in choices() {
            let on_first =
                filled(&choice, &FrameWindow::new(SENSOR, 30, ChannelOrder::OnFirst), &frames);
            let mut off_first =
                filled(&choice, &FrameWindow::new(SENSOR, 30, ChannelOrder::OffFirst), &frames);
            if choice.spec().polarity == PolarityUse::Channels {
                off_first.rotate_left(SENSOR.pixels());
            }
            prop_assert_eq!(on_first, off_first, "{}", choice);
        }
    }

    #[test]
    fn hidden_frames_are_as_if_they_had_no_events(
        events in events(30), visible_from in 0u32..31,
    ) {
        let frames = frame_events(&events);
        let window = FrameWindow::new(SENSOR, 30, ChannelOrder::OffFirst);
        let hiding = FrameWindow { visible_from, ..window };
        let visible = frames.iter().copied().filter(|event| event.frame >= visible_from);
        let visible: Vec<FrameEvent> = visible.collect();
        for choice in choices() {
            prop_assert_eq!(
                filled(&choice, &hiding, &frames), filled(&choice, &window, &visible), "{}", choice
            );
        }
    }

    #[test]
    fn grey_planes_are_the_planes_in_grey(events in events(30), order in order()) {
        let window = StreamWindow::new(SENSOR, Micros(20), order)?;
        for choice in choices() {
            let mut representation = choice.start(window);
            representation.push(&stream(&events));
            let planes = rendered(representation.as_ref());
            let (mut grey, mut want) = (vec![9; planes.len()], vec![7; planes.len()]);
            representation.render_u8(&mut grey);
            representation.grey().write(&planes, &mut want);
            if choice.spec().name == "eros-hpe-core" {
                // Rounded from f64, where 76.500000001 is no half.
                let pairs = grey.iter().zip(&want);
                prop_assert!(pairs.clone().all(|(a, b)| a.abs_diff(*b) <= 1), "{}", choice);
            } else {
                prop_assert_eq!(grey, want, "{}", choice);
            }
        }
    }
}
