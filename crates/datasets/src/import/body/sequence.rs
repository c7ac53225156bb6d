//! A recording of a person and its labels as sequences: `NAME.raw`, `NAME.toml` and
//! `NAME.poses.csv`, as `evpose simulate` writes them.

use std::path::{Path, PathBuf};

use evpose_core::{EventStream, Micros, SensorSize, TimeWindow, atomic_write};
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use evpose_sim::person::{PersonInfo, PoseRow, PoseTable};
use glam::Vec3;

use super::format::LabelledImage;
use super::poses::LabelledPoses;
use crate::import::ImportError;
use crate::import::clock::LabelClock;
use crate::import::stretch::WrittenSequence;
use crate::import::stretch::{MS, begin_of, cut, floor_ms, name_of, stretches, within};

/// Content of the field `activity` of imported sequences.
const ACTIVITY: &str = "imported";

/// Options of importing recordings of people.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct BodyOptions {
    /// Whether sequences that are there are written again, in place of an error.
    pub replace: bool,
    /// Times of the labels.
    pub clock: LabelClock,
    /// Longest time between labels over which they are interpolated.
    pub max_gap: Micros,
    /// Time before and after a label without neighbours for which it holds.
    pub hold: Micros,
    /// Longest recording before the first label of a sequence.
    pub lead: Micros,
}

impl Default for BodyOptions {
    fn default() -> Self {
        Self {
            replace: false,
            clock: LabelClock::default(),
            max_gap: Micros(100_000),
            hold: Micros(20_000),
            lead: Micros(1_000_000),
        }
    }
}

/// Result of importing a recording.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct BodyReport {
    /// The written sequences.
    pub sequences: Vec<WrittenSequence>,
    /// Count of labels that were used.
    pub labels: usize,
    /// Count of labels outside of the recording.
    pub outside_recording: usize,
    /// Count of images without annotations, which were skipped.
    pub without_person: usize,
    /// Count of images with several persons, of whom the largest was used.
    pub several_persons: usize,
    /// Count of labelled joints outside of the image.
    pub outside_image: usize,
    /// Size of the images that labels were scaled from.
    pub scaled_from: Option<[f32; 2]>,
    /// Count of labels of each joint, in the order of networks.
    pub joint_counts: [usize; BODY_JOINTS],
}

/// Writes a recording and its labels, which are of the file `labels`, as sequences into
/// `directory`, one for each stretch without a long gap between labels. Their time stamps count
/// from their own start.
///
/// # Errors
/// If labels and recording do not fit, a sequence of that name exists, or a file cannot be written.
pub fn import_body(
    events: &EventStream,
    images: &[LabelledImage],
    labels: &Path,
    options: &BodyOptions,
    directory: &Path,
    name: &str,
) -> Result<BodyReport, ImportError> {
    let sensor = events.sensor();
    let poses = LabelledPoses::new(images, &options.clock, sensor, labels)?;
    let range = within(&poses.times, events, labels)?;
    let (times, joints_px) = (&poses.times[range.clone()], &poses.joints_px[range]);
    let stretches = stretches(times, options.max_gap);
    let mut report = BodyReport {
        labels: times.len(),
        outside_recording: poses.times.len() - times.len(),
        without_person: poses.without_person,
        several_persons: poses.several_persons,
        outside_image: poses.outside,
        scaled_from: poses.scaled_from,
        joint_counts: LabelledPoses::counts(joints_px),
        ..BodyReport::default()
    };
    let path = |name: &str, ending: &str| -> PathBuf { directory.join(format!("{name}.{ending}")) };
    let names: Vec<String> =
        (0..stretches.len()).map(|index| name_of(name, index, stretches.len())).collect();
    // All names are checked before the first file is written.
    for name in names.iter().filter(|_| !options.replace) {
        if let Some(path) = ["raw", "poses.csv"].iter().map(|e| path(name, e)).find(|p| p.exists())
        {
            return Err(ImportError::Exists { path });
        }
    }
    for (stretch, name) in stretches.into_iter().zip(names) {
        let (times, joints_px) = (&times[stretch.clone()], &joints_px[stretch]);
        let [first, last] = [times[0], times[times.len() - 1]];
        // Labels may begin before the first event.
        let begin = begin_of(events).min(first);
        let window = TimeWindow {
            // With what came before the first label: representations have a history.
            start: floor_ms(first - options.lead).max(floor_ms(begin)),
            end: floor_ms(last + options.hold) + MS,
        };
        write_events(&cut(events, window), &path(&name, "raw"))?;
        write_info(sensor, &path(&name, "toml"))?;
        // Readers look for tables: where one is, the recording is there.
        table(times, joints_px, window.start, options.hold).write(&path(&name, "poses.csv"))?;
        report.sequences.push(WrittenSequence { name, start: window.start, labels: times.len() });
    }
    Ok(report)
}

/// The table of a stretch, whose time stamps count from `start`.
fn table(times: &[Micros], joints_px: &[BodyPoints], start: Micros, hold: Micros) -> PoseTable {
    let row = |(t, joints_px): (Micros, &BodyPoints)| PoseRow {
        t: t - start,
        joints_px: *joints_px,
        joints_m: [Vec3::NAN; BODY_JOINTS],
    };
    let rows = match times {
        // A single label cannot be interpolated: it holds for a short time.
        [t] => [(*t - hold).max(start), *t, *t + hold]
            .into_iter()
            .map(|t| row((t, &joints_px[0])))
            .collect::<Vec<_>>(),
        _ => times.iter().copied().zip(joints_px).map(row).collect(),
    };
    let mut table = PoseTable { rows };
    table.rows.dedup_by_key(|row| row.t);
    table
}

fn write_events(events: &EventStream, path: &Path) -> Result<(), ImportError> {
    let mut sink = evpose_io::create(path, events.sensor())?;
    sink.write(events)?;
    Ok(sink.finish()?)
}

fn write_info(sensor: SensorSize, path: &Path) -> Result<(), ImportError> {
    let info = PersonInfo {
        sensor,
        activity: ACTIVITY.to_owned(),
        betas: Vec::new(),
        threshold_offset: 0.0,
        scene: None,
        camera: None,
    };
    let text = toml::to_string(&info)
        .map_err(|error| ImportError::malformed(path, "description", error.to_string()))?;
    atomic_write(path, text.as_bytes()).map_err(ImportError::io(path, "write"))
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Polarity};
    use glam::Vec2;

    use super::*;
    use crate::import::clock::ImageTime;

    /// An event every millisecond of a second that begins at `start`.
    fn events(start: i64) -> EventStream {
        let event =
            |k: i64| Event { t: Micros(start + 1_000 * k), x: 1, y: 2, polarity: Polarity::On };
        EventStream::from_events(SensorSize::DAVIS240C, (0..1_000).map(event)).unwrap()
    }

    fn images(times: &[i64]) -> Vec<LabelledImage> {
        let image = |t: &i64| LabelledImage {
            time: ImageTime::Stamp(Micros(*t)),
            size_px: None,
            persons: vec![[Some(Vec2::new(*t as f32 * 1e-5, 7.0)); BODY_JOINTS]],
        };
        times.iter().map(image).collect()
    }

    #[test]
    fn a_recording_becomes_a_sequence_for_each_stretch_of_labels() {
        let folder = tempfile::tempdir().unwrap();
        let import = |times: &[i64]| {
            let (events, images) = (events(7_000_300), images(times));
            let options = BodyOptions { lead: Micros(100_000), ..BodyOptions::default() };
            import_body(&events, &images, Path::new("l.csv"), &options, folder.path(), "walk")
        };
        let report = import(&[5_000_000, 7_200_000, 7_250_000, 7_700_000]).unwrap();
        let written: Vec<_> =
            report.sequences.iter().map(|s| (&*s.name, s.start.0, s.labels)).collect();
        assert_eq!(written, [("walk-000", 7_100_000, 2), ("walk-001", 7_600_000, 1)]);
        assert_eq!((report.labels, report.outside_recording), (3, 1));
        let read = |name: &str| PoseTable::read(&folder.path().join(name)).unwrap().rows;
        let times = |rows: &[PoseRow]| rows.iter().map(|row| row.t.0).collect::<Vec<_>>();
        let first = read("walk-000.poses.csv");
        assert_eq!(times(&first), [100_000, 150_000]);
        assert_eq!(first[1].joints_px[4], Some(Vec2::new(72.5, 7.0)));
        assert_eq!(times(&read("walk-001.poses.csv")), [80_000, 100_000, 120_000]);
        let raw = evpose_io::open(folder.path().join("walk-000.raw")).unwrap().stream;
        assert_eq!(raw.sensor(), SensorSize::DAVIS240C);
        assert_eq!(raw.t().first(), Some(&Micros(300)));
        assert_eq!(raw.t().last(), Some(&Micros(170_300)));
        let message = import(&[7_200_000, 7_700_000]).unwrap_err().to_string();
        assert!(message.contains("walk-000.raw: exists already"), "{message}");
    }

    #[test]
    fn labels_of_another_clock_leave_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let options = BodyOptions::default();
        let labels = Path::new("l.csv");
        let result =
            import_body(&events(0), &images(&[9_000_000]), labels, &options, folder.path(), "a");
        let message = result.unwrap_err().to_string();
        assert!(message.contains("l.csv: labels from 9 s") && message.contains("--start-us"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
