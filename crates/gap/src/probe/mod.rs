//! What is measured of events, in the same way whoever made them.
//!
//! # A new probe
//! is one file with its entries and its formula, and one line in [`PROBES`].

mod crossing;
mod fourier;
mod geometry;
mod image;
mod interval;
mod load;
mod quantile;
mod readout;
mod reference;
mod scan;
mod spatial;
mod spectrum;
mod swing;
#[cfg(test)]
mod testing;
mod timing;

use crate::{Block, Cell, Entry, Kind, View};

/// A pure function of events and scene to numbers.
pub trait Probe: Sync {
    /// What the numbers are, always the same for all views.
    fn entries(&self) -> Vec<Entry>;

    /// Adds the numbers of a view, as many as there are entries. A number that cannot be had is
    /// NaN, at a price.
    fn measure(&self, view: &View<'_>, out: &mut Vec<f64>);
}

/// Every probe there is.
pub static PROBES: &[&dyn Probe] = &[
    &crossing::Crossing,
    &interval::Interval,
    &timing::Timing,
    &swing::Swing,
    &spatial::Spatial,
    &spectrum::Spectrum,
    &readout::Readout,
    &load::Load,
    &geometry::Geometry,
];

impl Entry {
    fn count(block: Block, name: impl Into<String>) -> Self {
        Self { block, name: name.into(), kind: Kind::Count }
    }

    fn number(block: Block, name: impl Into<String>, tolerance: f64) -> Self {
        Self { block, name: name.into(), kind: Kind::Number(tolerance) }
    }
}

/// Dark, middle and bright: two, one and two of the five classes.
fn brightness_third(cell: Cell) -> usize {
    [0, 0, 1, 2, 2][cell.brightness()]
}

/// Whether light changes, or did less than 5 ms ago.
fn is_moving(cell: Cell) -> bool {
    cell.age() <= 1
}

#[cfg(test)]
mod tests {
    use evpose_core::{EventStream, Micros, TimeWindow};

    use super::*;
    use crate::Layout;
    use crate::probe::testing;

    fn summary(events: &EventStream, window: TimeWindow) -> Vec<f64> {
        Layout::of_all_probes().summarise(&View::new(testing::stage(), events, window))
    }

    #[test]
    fn every_recording_has_a_number_for_every_entry() {
        let entries = Layout::of_all_probes().entries.len();
        let all = testing::events();
        let nothing = EventStream::empty(all.sensor());
        let one = EventStream::from_events(all.sensor(), all.iter().take(1)).unwrap();
        for events in [&nothing, &one, all] {
            for (start, end) in [(0, 600_000), (100_000, 400_000), (200_000, 200_000)] {
                let window = TimeWindow { start: Micros(start), end: Micros(end) };
                assert_eq!(summary(events, window).len(), entries);
            }
        }
    }

    #[test]
    fn an_ordinary_recording_has_no_number_that_cannot_be_had() {
        let layout = Layout::of_all_probes();
        let numbers = summary(testing::events(), testing::whole());
        for (entry, number) in layout.entries.iter().zip(numbers) {
            assert!(number.is_finite(), "{:?} {}: {number}", entry.block, entry.name);
        }
    }

    #[test]
    fn the_same_events_have_the_same_numbers_to_the_bit() {
        let bits = || -> Vec<u64> {
            summary(testing::events(), testing::whole()).iter().map(|n| n.to_bits()).collect()
        };
        assert_eq!(bits(), bits());
    }

    #[test]
    fn entries_have_names_of_their_own() {
        let layout = Layout::of_all_probes();
        let mut names: Vec<_> = layout.entries.iter().map(|e| (e.block, &e.name)).collect();
        names.sort();
        names.dedup();
        assert_eq!(names.len(), layout.entries.len());
    }
}

#[cfg(test)]
mod speed {
    use super::*;
    use crate::view::Expected;
    use crate::*;
    use evpose_core::*;
    use evpose_sensor::{SensorConfig, SensorModel};

    #[test]
    fn tmp_speed() {
        for (w, h, secs, n) in
            [(240usize, 180usize, 1.0, 0), (240, 180, 2.0, 1), (1280, 720, 0.3, 2)]
        {
            let fps = 1000.0;
            let planes: Vec<_> = (0..=(secs * fps) as usize)
                .map(|k| {
                    let t = k as f32 / fps as f32;
                    let scale = if n == 0 { 0.3 } else { 0.4 };
                    Plane::from_vec(
                        w,
                        h,
                        (0..w * h)
                            .map(|p| {
                                let x =
                                    (p % w) as f32 - if p % w < 2 * w / 3 { 20.0 * t } else { 0.0 };
                                let y = (p / w) as f32;
                                (-1.5
                                    + scale * (0.35 * x + 0.1 * y).sin()
                                    + 0.2 * (0.15 * x - 0.3 * y).cos())
                                .exp()
                            })
                            .collect(),
                    )
                    .unwrap()
                })
                .collect();
            let scene = Scene::new(fps, planes).unwrap();
            let model = SensorModel::from_config(&SensorConfig::default()).unwrap();
            let mut run = model.start(scene.size(), 1);
            let mut all = Vec::new();
            for (k, plane) in scene.planes().iter().enumerate() {
                all.extend(run.expose(plane, scene.time(k)).unwrap().iter());
            }
            let ev = EventStream::from_events(scene.size(), all.iter().copied()).unwrap();
            let mut rng = CounterRng::new(1, "n", 0);
            for _ in 0..20000 {
                all.push(Event {
                    t: Micros(rng.below((secs * 1e6) as usize) as i64),
                    x: rng.below(w) as u16,
                    y: rng.below(h) as u16,
                    polarity: Polarity::On,
                });
            }
            all.sort_by_key(|e| e.t);
            let measured = EventStream::from_events(scene.size(), all).unwrap();
            let stage = Stage { classes: Classes::of(&scene), expected: Expected::of(&ev), scene };
            let win = TimeWindow { start: Micros(0), end: Micros((secs * 1e6) as i64) };
            let t0 = std::time::Instant::now();
            let view = View::new(&stage, &measured, win);
            println!("{w}x{h} events {} view {:?}", measured.len(), t0.elapsed());
            let t0 = std::time::Instant::now();
            for probe in PROBES {
                let mut best = 1e9f64;
                let mut len = 0;
                for _ in 0..5 {
                    let mut out = Vec::new();
                    let t = std::time::Instant::now();
                    probe.measure(&view, &mut out);
                    best = best.min(t.elapsed().as_secs_f64());
                    len = out.len();
                }
                println!("  {:<12} {len} {:.2} ms", probe.entries()[0].name, best * 1e3);
            }
            println!(" total/5 {:?}", t0.elapsed() / 5);
        }
    }
}
