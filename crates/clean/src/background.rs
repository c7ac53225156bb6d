//! Background activity: events that no neighbour confirms.
//!
//! # Model
//! An event is kept if one, or as many as asked for, of the eight neighbours of its pixel fired at
//! most `tau` before it, at the same time included. Every event counts for its neighbours, kept or not. Beyond the sensor
//! nothing fires.
//!
//! # Source
//! Delbruck, *Frame-free dynamic digital vision*, 2008. The default of 30 ms is that of jAER's
//! `BackgroundActivityFilter`; others take 1 to 10 ms for scenes with more light.
//!
//! The preset `dhp19` is what the data set was made with: 70 ms, and pixels at the border of the
//! sensor confirm no others. (It ran over the images of four cameras side by side, so that inner
//! borders were none; here every camera has its own.) No pixel has fired before the recording.

use evpose_core::{Event, EventStream, Micros, NumberSpec, Parameter, SensorSize, WordSpec};

use crate::{Cleaner, CleanerSpec};

const PRESET: Parameter = Parameter::Word(WordSpec {
    name: "preset",
    allowed: &["dhp19"],
    default: None,
    doc: "dhp19: 70 ms, and pixels at the border confirm no others",
});
const TAU: Parameter = Parameter::Number(NumberSpec {
    name: "tau_ms",
    range: (0.001, 1e6),
    default: Some(30.0),
    doc: "how long an event confirms its neighbours, in milliseconds; jAER's default",
    ..NumberSpec::LINEAR
});
const OWN: Parameter = Parameter::Word(WordSpec {
    name: "own",
    allowed: &["no", "yes"],
    default: Some("no"),
    doc: "whether a pixel confirms itself",
});
const POLARITY: Parameter = Parameter::Word(WordSpec {
    name: "polarity",
    allowed: &["any", "same"],
    default: Some("any"),
    doc: "which events confirm one",
});

const NEIGHBOURS: Parameter = Parameter::Number(NumberSpec {
    name: "neighbours",
    range: (1.0, 8.0),
    default: Some(1.0),
    doc: "how many pixels must confirm an event: 2 for much noise",
    ..NumberSpec::LINEAR
});

pub(crate) static SPEC: CleanerSpec = CleanerSpec {
    name: "background",
    summary: "removes events that no neighbouring pixel confirms",
    params: &[PRESET, TAU, NEIGHBOURS, OWN, POLARITY],
    displaces: false,
    build: |settings, sensor| {
        let options = if settings.word(&PRESET).is_some() {
            SPEC.alone(settings, &PRESET)?;
            BackgroundOptions::DHP19
        } else {
            BackgroundOptions {
                tau: Micros::from_seconds(1e-3 * settings.number(&TAU)),
                neighbours: settings.number(&NEIGHBOURS) as u8,
                own_pixel: settings.word(&OWN) == Some("yes"),
                same_polarity: settings.word(&POLARITY) == Some("same"),
                border_confirms: true,
            }
        };
        Ok(Box::new(Background::new(sensor, options)))
    },
};

/// Rule by which neighbouring events confirm an event.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BackgroundOptions {
    /// For how long, at most [`Background::LONGEST`].
    pub tau: Micros,
    /// How many pixels must have fired.
    pub neighbours: u8,
    /// Whether the own pixel does as well.
    pub own_pixel: bool,
    /// Whether only events of the same polarity do.
    pub same_polarity: bool,
    /// Whether pixels in the first and last row and column do.
    pub border_confirms: bool,
}

impl BackgroundOptions {
    /// The rule of jAER.
    const JAER: Self = Self {
        tau: Micros(30_000),
        neighbours: 1,
        own_pixel: false,
        same_polarity: false,
        border_confirms: true,
    };
    /// The rule of the DHP19 data set.
    pub const DHP19: Self = Self { tau: Micros(70_000), border_confirms: false, ..Self::JAER };
}

impl Default for BackgroundOptions {
    fn default() -> Self {
        Self::JAER
    }
}

/// Further back than any time constant.
const NEVER: i32 = -(1 << 30);
/// The origin of times moves on before a difference from [`NEVER`] leaves 32 bits.
const FURTHEST_US: i64 = (1 << 30) - 1;

/// The background activity filter, with the latest event of each pixel.
#[derive(Debug, Clone)]
pub struct Background {
    sensor: SensorSize,
    options: BackgroundOptions,
    /// When each pixel last fired, in microseconds after the origin: a border of pixels that never
    /// do around the sensor, once or for each polarity, and a last place that nobody reads.
    last_us: Vec<i32>,
    origin: Option<Micros>,
}

impl Background {
    /// The longest time constant, almost 18 minutes.
    pub const LONGEST: Micros = Micros(1 << 30);

    /// A filter that has seen nothing. Longer time constants are [`Self::LONGEST`].
    pub fn new(sensor: SensorSize, options: BackgroundOptions) -> Self {
        let polarities = if options.same_polarity { 2 } else { 1 };
        let last_us = vec![NEVER; polarities * padded(sensor) + 1];
        Self { sensor, options, last_us, origin: None }
    }
}

fn padded(sensor: SensorSize) -> usize {
    (usize::from(sensor.width) + 2) * (usize::from(sensor.height) + 2)
}

/// Three neighbours of a row.
fn three(last_us: &[i32], start: usize) -> [i32; 3] {
    let row = &last_us[start..start + 3];
    [row[0], row[1], row[2]]
}

/// Moves the origin of times on.
#[cold]
fn move_origin(last_us: &mut [i32], by_us: i64) {
    for last_us in last_us {
        // What falls behind `NEVER` confirms nothing.
        *last_us = i64::from(*last_us).saturating_sub(by_us).max(NEVER.into()) as i32;
    }
}

impl Cleaner for Background {
    fn clean(&mut self, events: &mut EventStream) {
        let Some(&first) = events.t().first() else { return };
        let SensorSize { width, height } = self.sensor;
        let stride = usize::from(width) + 2;
        // Zero is allowed: events of the same microsecond confirm each other.
        // At most so long that what never fired is out of it.
        let tau_us = self.options.tau.0.clamp(0, Self::LONGEST.0 - 1) as i32;
        let BackgroundOptions { neighbours, own_pixel, border_confirms, .. } = self.options;
        let apart = if self.options.same_polarity { padded(self.sensor) } else { 0 };
        let mut origin = self.origin.unwrap_or(first).0;
        let last_us = self.last_us.as_mut_slice();
        let nowhere = last_us.len() - 1;
        events.retain(|Event { t, x, y, polarity }| {
            let mut now_us = t.0.saturating_sub(origin);
            if now_us > FURTHEST_US {
                // Times are 32 bits from the origin, which moves before they overflow.
                move_origin(last_us, now_us);
                (origin, now_us) = (t.0, 0);
            }
            let now_us = now_us.max(0) as i32;
            // With one map for each polarity, only events of the same confirm.
            let map = apart * usize::from(polarity.is_on());
            let pixel = map + (usize::from(y) + 1) * stride + usize::from(x) + 1;
            // The border of silent pixels saves a test of the sides of the sensor.
            let [a, b, c] = three(last_us, pixel - stride - 1);
            let [d, own, e] = three(last_us, pixel - 1);
            let [f, g, h] = three(last_us, pixel + stride - 1);
            let own = if own_pixel { own } else { NEVER };
            let confirms = |at_us: i32| u8::from(now_us - at_us <= tau_us);
            let count = [a, b, c, d, e, f, g, h, own].map(confirms).into_iter().sum::<u8>();
            // Bitwise on purpose, for short circuits would be branches.
            let is_inside = (x > 0) & (y > 0) & (x + 1 < width) & (y + 1 < height);
            // Stored where nothing reads, so that the loop has no branch.
            let place = if border_confirms | is_inside { pixel } else { nowhere };
            last_us[place] = now_us;
            count >= neighbours
        });
        self.origin = Some(Micros(origin));
    }

    fn reset(&mut self) {
        self.last_us.fill(NEVER);
        self.origin = None;
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::Polarity;
    use proptest::prelude::*;
    use sha2::{Digest, Sha256};

    use super::*;
    use crate::laws::{events, stream};

    const SENSOR: SensorSize = SensorSize { width: 5, height: 4 };

    fn filtered(
        options: BackgroundOptions,
        events: &[(i64, u16, u16, bool)],
    ) -> Vec<(i64, u16, u16)> {
        let event = |&(t, x, y, on): &(i64, u16, u16, bool)| Event {
            t: Micros(t),
            x,
            y,
            polarity: Polarity::from_on(on),
        };
        let mut stream = EventStream::from_events(SENSOR, events.iter().map(event)).unwrap();
        Background::new(SENSOR, options).clean(&mut stream);
        stream.iter().map(|event| (event.t.0, event.x, event.y)).collect()
    }

    const TEN: BackgroundOptions = BackgroundOptions { tau: Micros(10), ..BackgroundOptions::JAER };

    #[test]
    fn a_neighbour_confirms_up_to_the_time_constant_and_not_after_it() {
        let events = [(0, 2, 2, true), (10, 3, 1, false), (21, 2, 2, true), (21, 1, 1, true)];
        assert_eq!(filtered(TEN, &events), [(10, 3, 1), (21, 1, 1)]);
    }

    #[test]
    fn the_own_pixel_and_those_two_away_do_not_confirm_unless_asked() {
        let events = [(0, 2, 2, true), (1, 2, 2, true), (2, 4, 2, true)];
        assert_eq!(filtered(TEN, &events), []);
        let own = BackgroundOptions { own_pixel: true, ..TEN };
        assert_eq!(filtered(own, &events), [(1, 2, 2)]);
    }

    #[test]
    fn polarities_are_kept_apart_if_asked() {
        let events = [(0, 2, 2, true), (1, 1, 2, false), (2, 2, 3, true), (3, 0, 2, false)];
        let same = BackgroundOptions { same_polarity: true, ..TEN };
        assert_eq!(filtered(TEN, &events), [(1, 1, 2), (2, 2, 3), (3, 0, 2)]);
        assert_eq!(filtered(same, &events), [(2, 2, 3), (3, 0, 2)]);
    }

    #[test]
    fn rows_do_not_run_into_each_other() {
        let events = [(0, 4, 1, true), (1, 0, 2, true), (2, 0, 3, true), (3, 4, 2, true)];
        assert_eq!(filtered(TEN, &events), [(2, 0, 3), (3, 4, 2)]);
    }

    #[test]
    fn at_the_border_events_are_kept_but_do_not_confirm_as_in_dhp19() {
        let events = [
            (0, 0, 0, true),
            (1, 1, 1, true),
            (70_001, 0, 1, true),
            (70_002, 2, 1, true),
            (70_002, 1, 2, true),
        ];
        assert_eq!(filtered(BackgroundOptions::DHP19, &events), [(70_001, 0, 1), (70_002, 1, 2)]);
    }

    #[test]
    fn hours_and_the_ends_of_time_are_no_obstacle() {
        let hour = 3_600_000_000;
        let mut events = vec![(i64::MIN, 2, 2, true)];
        for k in 0..5 {
            events.extend([(k * hour, 2, 2, true), (k * hour + 9, 1, 2, true)]);
        }
        events.extend([(i64::MAX - 10, 2, 2, true), (i64::MAX, 3, 2, true)]);
        let mut wanted: Vec<_> = (0..5).map(|k| (k * hour + 9, 1, 2)).collect();
        wanted.push((i64::MAX, 3, 2));
        assert_eq!(filtered(TEN, &events), wanted);
    }

    /// DHP19's program by its description: events write to their neighbours.
    fn by_writing_to_neighbours(events: &[Event]) -> Vec<Event> {
        let mut last: Vec<Option<i64>> = vec![None; SENSOR.pixels()];
        let (width, height) = (i32::from(SENSOR.width), i32::from(SENSOR.height));
        let mut kept = Vec::new();
        for event in events {
            let (x, y) = (i32::from(event.x), i32::from(event.y));
            let at = |x: i32, y: i32| (y * width + x) as usize;
            if last[at(x, y)].is_some_and(|last| event.t.0 - last <= 70_000) {
                kept.push(*event);
            }
            if x == 0 || y == 0 || x == width - 1 || y == height - 1 {
                continue;
            }
            for (dx, dy) in (-1..=1).flat_map(|dx| (-1..=1).map(move |dy| (dx, dy))) {
                if (dx, dy) != (0, 0) {
                    last[at(x + dx, y + dy)] = Some(event.t.0);
                }
            }
        }
        kept
    }

    /// SHA-256 of events: time as little-endian `i64`, column and row as `u16`, ON as a byte.
    fn digest(events: &EventStream) -> String {
        let mut hash = Sha256::new();
        for event in events.iter() {
            hash.update(event.t.0.to_le_bytes());
            hash.update([event.x.to_le_bytes(), event.y.to_le_bytes()].concat());
            hash.update([event.polarity as u8]);
        }
        hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
    }

    /// `BackgroundActivityNoiseFilter` of dv-processing 2.0.4, in Python, with a duration of 2 ms,
    /// which it takes as "less than", on the same events.
    #[test]
    fn the_same_events_are_kept_as_by_dv_processing() {
        let sensor = SensorSize { width: 40, height: 30 };
        let mut state = 12_345_u64;
        // A generator of two lines makes the same events in any language.
        let mut next = |below: u64| {
            state = state.wrapping_mul(6_364_136_223_846_793_005);
            state = state.wrapping_add(1_442_695_040_888_963_407);
            (state >> 33) % below
        };
        let mut events = EventStream::empty(sensor);
        let mut t = 10_000_000;
        for _ in 0..20_000 {
            t += next(60) as i64;
            let (x, y) = (next(40) as u16, next(30) as u16);
            let polarity = Polarity::from_on(next(2) == 1);
            events.push(Event { t: Micros(t), x, y, polarity }).unwrap();
        }
        let given = "0491b4e7f146eb510681ae65df3ed0fa3a4a5ac1ca14dec2c40d617437110572";
        assert_eq!(digest(&events), given);
        let tau = Micros(1_999);
        let options = BackgroundOptions { tau, ..BackgroundOptions::default() };
        Background::new(sensor, options).clean(&mut events);
        let wanted = "b523c2d294d9127f2a732e1ee9956249a7684b7063c726c3654beb22eb363aa5";
        assert_eq!((events.len(), digest(&events).as_str()), (7_025, wanted));
    }

    proptest! {
        #[test]
        fn reading_neighbours_is_what_dhp19_does_by_writing_to_them(
            events in events(SENSOR, 400_000),
        ) {
            let mut cleaned = stream(SENSOR, &events);
            Background::new(SENSOR, BackgroundOptions::DHP19).clean(&mut cleaned);
            prop_assert_eq!(cleaned.iter().collect::<Vec<_>>(), by_writing_to_neighbours(&events));
        }
    }
}
