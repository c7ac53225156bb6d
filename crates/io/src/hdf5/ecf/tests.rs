use evpose_core::Event;
use proptest::prelude::*;

use super::*;

/// How pixels are packed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Coding {
    /// Rows, columns with their neighbours, polarities.
    Runs = 0,
    /// Rows, columns with polarities.
    Pairs = 1,
    /// Everything in 24 bits.
    Whole = 2,
}

const CODINGS: [Coding; 3] = [Coding::Runs, Coding::Pairs, Coding::Whole];

/// Lengths of the runs of equal values.
fn runs<T: Copy + PartialEq>(values: &[T]) -> impl Iterator<Item = (T, u16)> {
    values.chunk_by(|a, b| a == b).map(|run| (run[0], run.len() as u16))
}

/// Packs events whose times do not fall, as the module describes.
fn encode(events: &Columns, coding: Coding) -> Vec<u8> {
    let mut out = ((events.len() as u32) << 2 | coding as u32).to_le_bytes().to_vec();
    let first = events.t.first().map_or(0, |t| t.0);
    out.extend(first.to_le_bytes());
    let mut last = first;
    for (t, count) in runs(&events.t) {
        let mut step = t.0.wrapping_sub(last) as u64;
        last = t.0;
        // A long step has bytes of its own, and the byte of the count has a step of zero then.
        if step >= 15 {
            while step > 0 {
                out.push(0xf0 | (step & 15) as u8);
                step >>= 4;
            }
        }
        match u8::try_from(count).ok().filter(|count| *count < 15) {
            Some(count) => out.push((step as u8) << 4 | count),
            None => {
                out.push((step as u8) << 4 | 15);
                out.extend(count.to_le_bytes());
            }
        }
    }
    let bit = |k: usize| u32::from(events.polarity.get(k).is_some_and(|p| p.is_on()));
    let x = |k: usize| u32::from(events.x.get(k).copied().unwrap_or(2047));
    if coding == Coding::Whole {
        let value = |k: usize| {
            u32::from(events.y.get(k).copied().unwrap_or(2047)) << 12 | x(k) << 1 | bit(k)
        };
        for k in (0..events.len()).step_by(4) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|n| value(k + n));
            let words = [a << 8 | b & 0xff, b >> 8 << 16 | c & 0xffff, c >> 16 << 24 | d];
            out.extend(words.into_iter().flat_map(u32::to_le_bytes));
        }
        return out;
    }
    for (y, count) in runs(&events.y) {
        out.extend((y << 5 | count.min(31)).to_le_bytes());
        if count >= 31 {
            out.extend(count.to_le_bytes());
        }
    }
    if coding == Coding::Pairs {
        let value = |k: usize| (x(k) << 1 | bit(k)) as u16;
        for k in (0..events.len()).step_by(4) {
            let [a, b, c, d] = [0, 1, 2, 3].map(|n| value(k + n));
            let words = [a << 4 | b & 0xf, b >> 4 << 8 | c & 0xff, c >> 8 << 12 | d];
            out.extend(words.into_iter().flat_map(u16::to_le_bytes));
        }
        return out;
    }
    let mut k = 0;
    while k < events.len() {
        let (first, mut word) = (events.x[k], events.x[k] << 5);
        k += 1;
        for next in 1..6 {
            if events.x.get(k) == Some(&(first + next)) {
                word |= 1 << (5 - next);
                k += 1;
            }
        }
        // Published packers look at what is behind the last event.
        out.extend((if k == events.len() { word | 1 } else { word }).to_le_bytes());
    }
    for (polarity, count) in runs(&events.polarity) {
        let bit = u8::from(polarity.is_on()) << 7;
        out.push(bit | count.min(127) as u8);
        if count >= 127 {
            out.extend(count.to_le_bytes());
        }
    }
    out
}

/// Events with runs and neighbours of all lengths.
fn events() -> impl Strategy<Value = Columns> {
    let one = (
        prop_oneof![6 => Just(0_i64), 3 => 0_i64..40, 1 => 0_i64..1 << 40],
        prop_oneof![4 => Just(None), 1 => (0_u16..2048).prop_map(Some)],
        prop_oneof![3 => Just(None), 1 => (0_u16..2048).prop_map(Some)],
        prop_oneof![6 => Just(false), 1 => Just(true)],
        1_usize..200,
    );
    let start = prop_oneof![Just(0_i64), any::<i64>().prop_map(|t| t >> 2)];
    (start, prop::collection::vec(one, 0..60)).prop_map(|(start, parts)| {
        let mut last = Event { t: Micros(start), x: 0, y: 0, polarity: Polarity::Off };
        let mut columns = Columns::new();
        for (step, x, y, flips, count) in parts {
            last.t.0 += step;
            last.x = x.unwrap_or((last.x + 1) % 2048);
            last.y = y.unwrap_or(last.y);
            last.polarity = if flips { last.polarity.flipped() } else { last.polarity };
            let is_still = x.is_none();
            for k in 0..count as u16 {
                let x = if is_still { (last.x + k) % 2048 } else { last.x };
                columns.push(Event { x, ..last });
            }
        }
        columns
    })
}

proptest! {
    #[test]
    fn events_of_every_coding_come_back(
        events in events(),
        coding in prop::sample::select(CODINGS.to_vec()),
    ) {
        let packed = encode(&events, coding);
        let mut columns = events.clone();
        prop_assert_eq!(decode(&packed, &mut columns).unwrap(), events.len());
        columns = columns.iter().skip(events.len()).collect();
        prop_assert_eq!(columns, events);
    }

    #[test]
    fn a_chunk_cut_anywhere_is_an_error_and_leaves_nothing(
        events in events(),
        coding in prop::sample::select(CODINGS.to_vec()),
        at in 0.0..1.0,
    ) {
        let packed = encode(&events, coding);
        let cut = &packed[..(at * packed.len() as f64) as usize];
        let mut columns = Columns::new();
        let fault = decode(cut, &mut columns).unwrap_err();
        prop_assert!(fault.at <= cut.len());
        prop_assert!(columns.is_empty());
    }

    #[test]
    fn bytes_of_any_kind_never_panic(
        events in events(),
        coding in prop::sample::select(CODINGS.to_vec()),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..8),
    ) {
        let mut packed = encode(&events, coding);
        for (at, byte) in changes {
            let length = packed.len();
            packed[at.index(length)] = byte;
        }
        let mut columns = Columns::new();
        match decode(&packed, &mut columns) {
            Ok(events) => prop_assert_eq!(columns.len(), events),
            Err(fault) => prop_assert!(columns.is_empty() && fault.at <= packed.len()),
        }
    }
}

#[test]
fn a_chunk_as_long_as_can_be_comes_back() {
    let event = |k: i64| Event {
        t: Micros(k / 1000 * 17),
        x: (k * k % 1280) as u16,
        y: (k / 70 % 720) as u16,
        polarity: Polarity::from_on(k % 300 < 200),
    };
    let events: Columns = (0..MAX_EVENTS as i64).map(event).collect();
    for coding in CODINGS {
        let mut columns = Columns::new();
        assert_eq!(decode(&encode(&events, coding), &mut columns).unwrap(), MAX_EVENTS);
        assert!(columns == events, "{coding:?}");
    }
    let longer = (MAX_EVENTS as u32 + 1) << 2;
    assert!(decode(&longer.to_le_bytes(), &mut Columns::new()).is_err());
}
