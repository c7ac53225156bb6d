//! Consistency checks of a recording's axes, polarities and time stamps.
//!
//! It is little, and no more is claimed: which columns and rows never fire, how many events are ON, how many share their time
//! stamp, what time stamps are multiples of. Whether an image is mirrored, or ON and OFF are
//! exchanged, cannot be decided without a reference of the same scene: see
//! [`symmetry`](crate::symmetry).

use evpose_core::{EventStream, Micros, Polarity, SensorSize};

/// Of fewer events, shares mean nothing.
const MIN_EVENTS: u64 = 1_000;
/// Shares of ON events that no scene with motion has. Real ones have 0.3 to 0.8.
const ODD_ON_SHARE: (f64, f64) = (0.03, 0.97);
/// Part of the image that may be dark.
const MAX_SILENT: f64 = 0.1;

/// Looks at a recording, batch by batch.
#[derive(Debug, Clone)]
pub struct Checkup {
    sensor: SensorSize,
    /// Events of each column and each row, as far as there are any.
    columns: Vec<u64>,
    rows: Vec<u64>,
    events: u64,
    on: u64,
    same_time: u64,
    repeats: u64,
    backwards: u64,
    /// Greatest common divisor of the differences of times.
    step_us: u64,
    previous: Option<(Micros, u16, u16, Polarity)>,
}

/// Results of the checks.
#[derive(Debug, Clone, PartialEq)]
pub struct Findings {
    /// How many events there are.
    pub events: u64,
    /// Share of ON events, if there are any events.
    pub on_share: Option<f64>,
    /// First and last column that fires.
    pub columns: Option<(u16, u16)>,
    /// First and last row that fires.
    pub rows: Option<(u16, u16)>,
    /// Columns of the sensor that never fire.
    pub silent_columns: usize,
    /// Rows of the sensor that never fire.
    pub silent_rows: usize,
    /// Events with the time stamp of the one before.
    pub same_time: u64,
    /// Events that are the one before once more.
    pub repeats: u64,
    /// Events earlier than the one before.
    pub backwards: u64,
    /// Greatest common divisor of all differences of time stamps, in microseconds; none if all are
    /// equal.
    pub step_us: Option<u64>,
    /// Anomalies, in sentences.
    pub remarks: Vec<String>,
}

impl Checkup {
    /// A check-up of a recording of `sensor`, before its first events.
    pub fn new(sensor: SensorSize) -> Self {
        Self {
            sensor,
            columns: Vec::new(),
            rows: Vec::new(),
            events: 0,
            on: 0,
            same_time: 0,
            repeats: 0,
            backwards: 0,
            step_us: 0,
            previous: None,
        }
    }

    /// Looks at a batch, whatever sensor it says it is of.
    pub fn push(&mut self, events: &EventStream) {
        self.push_columns(events.t(), events.x(), events.y(), events.polarity());
    }

    /// Looks at a batch as its file has it, unchecked; of columns of different lengths, at as many
    /// events as all have.
    pub fn push_columns(&mut self, t: &[Micros], x: &[u16], y: &[u16], polarity: &[Polarity]) {
        for (((&t, &x), &y), &polarity) in t.iter().zip(x).zip(y).zip(polarity) {
            self.events += 1;
            self.on += u64::from(polarity.is_on());
            count(&mut self.columns, x);
            count(&mut self.rows, y);
            if let Some(previous) = self.previous {
                self.same_time += u64::from(t == previous.0);
                self.repeats += u64::from((t, x, y, polarity) == previous);
                self.backwards += u64::from(t < previous.0);
                // 1 divides everything, so that there is nothing left to find.
                if self.step_us != 1 {
                    self.step_us = common_divisor(self.step_us, t.0.abs_diff(previous.0.0));
                }
            }
            self.previous = Some((t, x, y, polarity));
        }
    }

    /// Results so far.
    pub fn findings(&self) -> Findings {
        let SensorSize { width, height } = self.sensor;
        let (columns, rows) = (range(&self.columns), range(&self.rows));
        let mut findings = Findings {
            events: self.events,
            on_share: (self.events > 0).then(|| self.on as f64 / self.events as f64),
            columns,
            rows,
            silent_columns: silent(&self.columns, width),
            silent_rows: silent(&self.rows, height),
            same_time: self.same_time,
            repeats: self.repeats,
            backwards: self.backwards,
            step_us: (self.step_us > 0).then_some(self.step_us),
            remarks: Vec::new(),
        };
        // Remarks compare the finished values, and so come last.
        findings.remarks = self.remarks(&findings);
        findings
    }

    fn remarks(&self, findings: &Findings) -> Vec<String> {
        let (mut remarks, sensor) = (Vec::new(), self.sensor);
        if findings.backwards > 0 {
            remarks.push(format!("{} events are earlier than the one before", findings.backwards));
        }
        // A few events have odd shares, gaps and steps by chance.
        if findings.events < MIN_EVENTS {
            return remarks;
        }
        match findings.on_share {
            Some(0.0) => remarks.push("all events are OFF: polarities may be lost".to_owned()),
            Some(1.0) => remarks.push("all events are ON: polarities may be lost".to_owned()),
            Some(share) if share < ODD_ON_SHARE.0 || share > ODD_ON_SHARE.1 => remarks.push(
                format!("{:.1} % of events are ON: more even shares are usual", 100.0 * share),
            ),
            _ => {}
        }
        for (what, counts, silent, size) in [
            ("columns", &self.columns, findings.silent_columns, sensor.width),
            ("rows", &self.rows, findings.silent_rows, sensor.height),
        ] {
            // This comes first: half of the coordinates are silent then, and for this reason.
            if let Some(parity) = parity(counts) {
                remarks.push(format!("only {parity} {what} fire: coordinates may be shifted"));
            } else if silent as f64 > MAX_SILENT * f64::from(size) {
                remarks.push(format!(
                    "{silent} of {size} {what} never fire: the sensor may be smaller, or cropped"
                ));
            }
        }
        // A pixel cannot fire twice within a microsecond, so that many repeats are copies.
        if 10 * findings.repeats > findings.events {
            remarks.push(format!(
                "{} events are the one before once more, to the microsecond",
                findings.repeats
            ));
        }
        match findings.step_us {
            None => remarks.push("all events have the same time stamp".to_owned()),
            Some(1) => {}
            Some(step_us) => remarks.push(format!("time stamps are multiples of {step_us} µs")),
        }
        remarks
    }
}

fn count(counts: &mut Vec<u64>, at: u16) {
    let at = usize::from(at);
    if at >= counts.len() {
        counts.resize(at + 1, 0);
    }
    counts[at] += 1;
}

fn range(counts: &[u64]) -> Option<(u16, u16)> {
    let first = counts.iter().position(|count| *count > 0)?;
    Some((first as u16, (counts.len() - 1) as u16))
}

fn silent(counts: &[u64], size: u16) -> usize {
    let size = usize::from(size);
    size - counts.iter().take(size).filter(|count| **count > 0).count()
}

/// Parity of the coordinates that fire, if only even or only odd ones of enough do.
fn parity(counts: &[u64]) -> Option<&'static str> {
    let some = |odd: usize| counts.iter().skip(odd).step_by(2).filter(|n| **n > 0).count();
    // Fewer may be of one parity by chance; eight are so once in 128 times.
    match (some(0), some(1)) {
        (even, 0) if even >= 8 => Some("even"),
        (0, odd) if odd >= 8 => Some("odd"),
        _ => None,
    }
}

/// Euclid's.
fn common_divisor(mut a: u64, mut b: u64) -> u64 {
    while b > 0 {
        (a, b) = (b, a % b);
    }
    a
}

#[cfg(test)]
mod tests {
    use super::*;

    const SENSOR: SensorSize = SensorSize { width: 346, height: 260 };

    /// A recording in which every pixel of `x` by `y` fires now and then, one event every
    /// `step_us`.
    fn findings(
        (columns, rows): (u16, u16),
        step_us: i64,
        change: impl Fn(&mut (Micros, u16, u16, Polarity), i64),
    ) -> Findings {
        let mut checkup = Checkup::new(SENSOR);
        for i in 0..20_000_i64 {
            // A prime step reaches every column and row in no apparent order.
            let pixel = i.wrapping_mul(7_919);
            let (x, y) = (pixel % i64::from(columns), (pixel / 13) % i64::from(rows));
            let on = Polarity::from_on((i / 2) % 2 == 0);
            let mut event = (Micros(step_us * i), x as u16, y as u16, on);
            change(&mut event, i);
            checkup.push_columns(&[event.0], &[event.1], &[event.2], &[event.3]);
        }
        checkup.findings()
    }

    #[test]
    fn a_sound_recording_is_nothing_to_remark_on() {
        let found = findings((346, 260), 1, |_, _| {});
        assert_eq!(found.remarks, [] as [String; 0]);
        assert_eq!((found.columns, found.rows), (Some((0, 345)), Some((0, 259))));
        assert_eq!((found.silent_columns, found.silent_rows), (0, 0));
        assert_eq!((found.on_share, found.step_us), (Some(0.5), Some(1)));
        assert_eq!((found.same_time, found.repeats, found.backwards), (0, 0, 0));
    }

    #[test]
    fn eight_columns_of_one_parity_are_remarked_on_and_seven_are_not() {
        for (count, offset) in [(7, 0), (8, 0), (7, 1), (8, 1)] {
            let mut counts = vec![0; 17];
            (0..count).for_each(|k| counts[2 * k + offset] = 1);
            let wanted = (count == 8).then_some(["even", "odd"][offset]);
            assert_eq!(parity(&counts), wanted, "{count} from {offset}");
        }
    }

    #[test]
    fn an_empty_recording_has_no_share_of_on_events_and_no_remarks() {
        let found = Checkup::new(SENSOR).findings();
        let none = (None, None, None, None);
        assert_eq!((found.on_share, found.columns, found.rows, found.step_us), none);
        assert_eq!((found.events, found.silent_columns, found.silent_rows), (0, 346, 260));
        assert!(found.remarks.is_empty());
    }

    #[test]
    fn lost_polarities_and_one_sided_ones_are_remarked_on() {
        let off = findings((346, 260), 1, |event, _| event.3 = Polarity::Off);
        assert_eq!(off.remarks, ["all events are OFF: polarities may be lost"]);
        let few = findings((346, 260), 1, |event, i| event.3 = Polarity::from_on(i % 100 > 0));
        assert_eq!(few.remarks, ["99.0 % of events are ON: more even shares are usual"]);
    }

    #[test]
    fn shifted_and_cropped_coordinates_are_remarked_on() {
        let shifted = findings((173, 260), 1, |event, _| event.1 *= 2);
        assert_eq!(shifted.remarks, ["only even columns fire: coordinates may be shifted"]);
        let cropped = findings((346, 180), 1, |_, _| {});
        let wanted = "80 of 260 rows never fire: the sensor may be smaller, or cropped";
        assert_eq!(cropped.remarks, [wanted]);
    }

    #[test]
    fn time_stamps_are_looked_at() {
        let coarse = findings((346, 260), 1_000, |event, i| event.0 = Micros(1_000 * (i / 4)));
        assert_eq!(coarse.remarks, ["time stamps are multiples of 1000 µs"]);
        assert_eq!(coarse.same_time, 15_000);
        let back = findings((346, 260), 1, |event, i| event.0 = Micros(if i == 9 { 3 } else { i }));
        assert_eq!(back.remarks, ["1 events are earlier than the one before"]);
        let twice = findings((346, 260), 1, |event, i| {
            *event = (Micros(i / 2), (i / 2 % 346) as u16, (i / 7 % 260) as u16, Polarity::On);
            event.3 = Polarity::from_on(i % 4 < 2);
            event.2 = (i / 2 % 260) as u16;
        });
        assert_eq!(twice.repeats, 10_000);
        assert!(twice.remarks[0].starts_with("10000 events are the one before"));
    }
}
