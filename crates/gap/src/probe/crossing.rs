//! Event counts by the classes of the scene: events per change of luminance, and events without
//! one.

use crate::probe::interface::StatisticProbe;
use crate::{Cell, Entry, StatisticBlock, StatisticKind, View};

/// Counts by brightness, speed or age, contrast, fineness and polarity.
pub(super) static PROBE: StatisticProbe = StatisticProbe { name: "crossing", entries, measure };

const POLARITIES: usize = 2;
/// Halves of the brightness range.
const HALVES: usize = 2;
/// Senses of an event relative to the last change of luminance: with it or against it.
const SENSES: usize = 2;

/// Entries of the histogram over brightness and speed, which counts every event once.
pub(super) const BY_SPEED: usize = Cell::BRIGHTNESSES * Cell::SPEEDS * POLARITIES;
const BY_CONTRAST: usize = Cell::CONTRASTS * (Cell::SPEEDS - 1) * POLARITIES;
const BY_AGE: usize = HALVES * (Cell::AGES - 1) * SENSES;
const BY_FINENESS: usize = 2 * (Cell::SPEEDS - 1) * POLARITIES;

fn sign(is_on: usize) -> &'static str {
    ["OFF", "ON"][is_on]
}

fn entries() -> Vec<Entry> {
    let mut entries = Vec::new();
    let mut add = |block, name: String| {
        entries.push(Entry { block, name, kind: StatisticKind::Count(0.0) });
    };
    for i in 0..BY_SPEED {
        let (is_on, speed, bright) = (i % 2, i / 2 % Cell::SPEEDS, i / 2 / Cell::SPEEDS);
        let block = if speed == 0 { StatisticBlock::Quiet } else { StatisticBlock::Crossing };
        add(block, format!("{} events, brightness {bright}, speed {speed}", sign(is_on)));
    }
    for i in 0..BY_CONTRAST {
        let (is_on, speed, contrast) = (i % 2, 1 + i / 2 % 3, i / 6);
        add(
            StatisticBlock::Crossing,
            format!("{} events, contrast {contrast}, speed {speed}", sign(is_on)),
        );
    }
    for i in 0..BY_AGE {
        let (sense, age, half) = (i % 2, 1 + i / 2 % (Cell::AGES - 1), i / 2 / (Cell::AGES - 1));
        let sense = ["against", "with"][sense];
        let half = ["dark", "bright"][half];
        add(StatisticBlock::Tail, format!("events {sense} the edge before, {half}, age {age}"));
    }
    for i in 0..BY_FINENESS {
        let (is_on, speed, fine) = (i % 2, 1 + i / 2 % 3, i / 6);
        let fine = ["even", "fine"][fine];
        add(
            StatisticBlock::Crossing,
            format!("{} events, {fine} light, speed {speed}", sign(is_on)),
        );
    }
    entries
}

fn measure(view: &View<'_>, out: &mut Vec<f64>) {
    let mut by_speed = [0.0; BY_SPEED];
    let mut by_contrast = [0.0; BY_CONTRAST];
    let mut by_age = [0.0; BY_AGE];
    let mut by_fineness = [0.0; BY_FINENESS];
    for event in view.events() {
        let (cell, is_on) = (event.cell, usize::from(event.is_on));
        // Indices as in `entries`: statistics differ by their positions in the summary alone.
        by_speed[(cell.brightness() * Cell::SPEEDS + cell.speed()) * 2 + is_on] += 1.0;
        if cell.speed() > 0 {
            by_contrast[(cell.contrast() * 3 + cell.speed() - 1) * 2 + is_on] += 1.0;
            by_fineness[(usize::from(cell.is_fine()) * 3 + cell.speed() - 1) * 2 + is_on] += 1.0;
        } else {
            let half = usize::from(cell.brightness() >= 3);
            let sense = usize::from(cell.rises() == event.is_on);
            by_age[(half * (Cell::AGES - 1) + cell.age() - 1) * 2 + sense] += 1.0;
        }
    }
    out.extend(by_speed.iter().chain(&by_contrast).chain(&by_age).chain(&by_fineness));
}
