//! Recordings with tables of poses, as images.

use std::collections::VecDeque;
use std::path::{Path, PathBuf};

use evpose_core::{CounterRng, EventStream, Micros, PlacedCamera};
use evpose_pose::body::{BODY_JOINTS, BodyPoints};
use evpose_sim::person::{People, PoseRow, PoseTable, RecordingPlace};
use glam::{Vec2, Vec3};
use rayon::prelude::*;

use super::frames::{BodyFrame, BodyFrames, CameraJoints, label_of, size_of};
use crate::TrainError;
use crate::listing::{events_of, file_names};
use evpose_task::Experiment as _;
use evpose_task::body::RepresentationReader;
use evpose_task::body::{BodyConfig, LabelTime, NoiseHistory};

/// Ending of the tables.
const POSES: &str = ".poses.csv";

/// A directory of recordings, each `0007.raw`, or of any other format, with `0007.poses.csv` beside
/// it.
#[derive(Debug, Clone)]
pub struct BodyRecordings {
    /// Events and poses of each, by name.
    pub files: Vec<(PathBuf, PathBuf)>,
}

impl BodyRecordings {
    /// The recordings of a directory.
    ///
    /// # Errors
    /// If it cannot be read, or holds none.
    pub fn open(directory: &Path) -> Result<Self, TrainError> {
        let names = file_names(directory)?;
        let mut files = Vec::new();
        for stem in names.iter().filter_map(|name| name.strip_suffix(POSES)) {
            if let Some(events) = events_of(&names, stem) {
                files.push((directory.join(events), directory.join(format!("{stem}{POSES}"))));
            }
        }
        if files.is_empty() {
            return Err(TrainError::Config {
                path: directory.to_owned(),
                message: format!(
                    "no recording with a table of poses (0000.raw and 0000{POSES}): make some with \
                     `evpose simulate configs/body/finetune.toml --out DIR`"
                ),
            });
        }
        Ok(Self { files })
    }

    /// Images of all recordings at even times, with the poses of those times.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn frames(
        &self,
        config: &BodyConfig,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<BodyFrames, TrainError> {
        self.collected(progress, |sequence, files| frames_of(config, files, sequence))
    }

    /// The images that `frames_of` makes of each recording, by its number and its files.
    fn collected(
        &self,
        progress: &(dyn Fn(u64) + Sync),
        frames_of: impl Fn(u64, &(PathBuf, PathBuf)) -> Result<Vec<BodyFrame>, TrainError> + Sync,
    ) -> Result<BodyFrames, TrainError> {
        let of = |(sequence, files): (usize, &(PathBuf, PathBuf))| {
            frames_of(sequence as u64, files).inspect(|_| progress(1))
        };
        // In the order of names, whichever thread ends first: a training depends on the order.
        let frames: Vec<Vec<BodyFrame>> =
            self.files.par_iter().enumerate().map(of).collect::<Result<_, TrainError>>()?;
        Ok(BodyFrames { frames: frames.concat() })
    }

    /// Photographs at the sample times of [`Self::frames`], simulated again: the directory must be
    /// one of `evpose simulate`, with its config.
    ///
    /// # Errors
    /// If a file cannot be read.
    pub fn photographs(
        &self,
        config: &BodyConfig,
        directory: &Path,
        progress: &(dyn Fn(u64) + Sync),
    ) -> Result<BodyFrames, TrainError> {
        let made_with = BodyConfig::read(&directory.join("config.toml"))?;
        let people = People::new(&made_with.simulation, made_with.seed)?;
        self.collected(progress, |sequence, (_, poses)| {
            let track = PoseTrack(PoseTable::read(poses)?);
            let (first, step) = sample_times(config);
            let times: Vec<Micros> = (0..)
                .map(|k| first + Micros(k * step.0))
                .take_while(|t| *t <= track.end())
                .collect();
            let images = people.photographs(sequence, &times)?;
            let frames = times.into_iter().zip(images).filter_map(|(t, image)| {
                let label = label_of(&track.at(t)?, size_of(&image));
                Some(BodyFrame { image, label, sequence, t, camera: None })
            });
            Ok(frames.collect())
        })
    }
}

/// The time of the first sample of a recording, and the interval between samples.
fn sample_times(config: &BodyConfig) -> (Micros, Micros) {
    let micros = |ms: u32| Micros(1_000 * i64::from(ms));
    (micros(config.data.first_ms), micros(config.data.every_ms))
}

fn frames_of(
    config: &BodyConfig,
    (events, poses): &(PathBuf, PathBuf),
    sequence: u64,
) -> Result<Vec<BodyFrame>, TrainError> {
    let track = PoseTrack(PoseTable::read(poses)?);
    let mut reader = RepresentationReader::open(events, &config.image)?;
    if let Some(events_per_pixel) = noise_before(config, sequence) {
        let seed = evpose_core::seed_for(config.seed, "noise history", sequence);
        reader.add_noise_history(events_per_pixel, seed);
    }
    let placed = placed_camera(poses);
    let counted = match config.data.label_at {
        LabelTime::Now => 0,
        LabelTime::MeanOf(events) => events,
    };
    // No more times than are counted, however long the recording.
    let mut recent = RecentTimes { most: counted, times: VecDeque::new() };
    let mut frames = Vec::new();
    let (mut t, step) = sample_times(config);
    while t <= track.end() {
        let image = reader.at(t, |events| recent.push(events))?;
        // Images of a fixed count of events are labelled at the mean of their times.
        let labelled_at = recent.mean().unwrap_or(t);
        if let Some(joints_px) = track.at(labelled_at) {
            let label = label_of(&reader.image_points(&joints_px), reader.image_size());
            let camera = placed.zip(track.at_m(labelled_at)).map(|(camera, joints_m)| {
                let joints_m = joints_m.map(|at_m| in_camera(&camera, at_m));
                CameraJoints { joints_m, lens: camera.lens, sensor: reader.sensor() }
            });
            frames.push(BodyFrame { image, label, sequence, t, camera });
        }
        t = t + step;
    }
    Ok(frames)
}

/// The camera of the recording whose table of poses is `poses`; none where it moves, or the file
/// beside the table does not say.
fn placed_camera(poses: &Path) -> Option<PlacedCamera> {
    let stem = poses.to_str()?.strip_suffix(POSES)?;
    RecordingPlace::read(Path::new(&format!("{stem}.toml"))).ok()?.camera
}

/// A point of the world in camera space, both in metres.
fn in_camera(camera: &PlacedCamera, at_m: Vec3) -> Vec3 {
    camera.camera_from_world.transform_point3(at_m.as_dvec3()).as_vec3()
}

/// Draws how much noise there was before a recording.
fn noise_before(config: &BodyConfig, sequence: u64) -> Option<f32> {
    let NoiseHistory { probability, events_per_pixel: [low, high] } = config.data.noise_history?;
    let mut rng = CounterRng::new(config.seed, "noise before", sequence);
    rng.chance(probability).then(|| rng.uniform(low.ln(), high.ln()).exp())
}

/// A table of poses as a function of time.
#[derive(Debug, Clone)]
pub struct PoseTrack(pub PoseTable);

impl PoseTrack {
    /// The time of the last pose.
    pub fn end(&self) -> Micros {
        self.0.rows.last().map_or(Micros(-1), |row| row.t)
    }

    /// The joints at a time, linearly interpolated; a joint that either of the poses around it
    /// lacks is missing. None outside of the table.
    pub fn at(&self, t: Micros) -> Option<BodyPoints> {
        let (before, after, share) = self.around(t)?;
        Some(std::array::from_fn(|joint| {
            let (from, to): (Vec2, Vec2) = before.joints_px[joint].zip(after.joints_px[joint])?;
            Some(from.lerp(to, share))
        }))
    }

    /// The joints at a time in the world, in metres, likewise; not finite where one is not known.
    pub fn at_m(&self, t: Micros) -> Option<[Vec3; BODY_JOINTS]> {
        let (before, after, share) = self.around(t)?;
        Some(std::array::from_fn(|joint| before.joints_m[joint].lerp(after.joints_m[joint], share)))
    }

    /// The rows around a time and how far it is from the first to the second; twice the same row at
    /// the time of one.
    fn around(&self, t: Micros) -> Option<(&PoseRow, &PoseRow, f32)> {
        let rows = &self.0.rows;
        let next = rows.partition_point(|row| row.t < t);
        let after = rows.get(next)?;
        if after.t == t {
            return Some((after, after, 0.0));
        }
        let before = rows.get(next.checked_sub(1)?)?;
        Some((before, after, (t.0 - before.t.0) as f32 / (after.t.0 - before.t.0) as f32))
    }
}

/// Times of the last so many events.
struct RecentTimes {
    most: usize,
    times: VecDeque<Micros>,
}

impl RecentTimes {
    fn push(&mut self, events: &EventStream) {
        if self.most == 0 {
            return;
        }
        let t = events.t();
        // Of more events than fit, only those that remain are copied.
        let newest = &t[t.len().saturating_sub(self.most)..];
        let over = (self.times.len() + newest.len()).saturating_sub(self.most);
        self.times.drain(..over);
        self.times.extend(newest);
    }

    /// Their mean; none if there are none to count.
    fn mean(&self) -> Option<Micros> {
        let first = *self.times.front()?;
        let sum: i64 = self.times.iter().map(|t| t.0 - first.0).sum();
        Some(Micros(first.0 + sum / self.times.len() as i64))
    }
}

#[cfg(test)]
mod tests {
    use evpose_core::{Event, Polarity, SensorSize};

    use super::*;

    fn row(t_ms: i64, x: Option<f32>) -> PoseRow {
        let mut joints_px = [Some(Vec2::ZERO); BODY_JOINTS];
        joints_px[4] = x.map(|x| Vec2::new(x, 2.0 * x));
        PoseRow { t: Micros(1_000 * t_ms), joints_px, joints_m: [Vec3::ZERO; BODY_JOINTS] }
    }

    #[test]
    fn poses_are_interpolated_where_both_rows_have_the_joint() {
        let rows = vec![row(10, Some(1.0)), row(20, Some(3.0)), row(30, None)];
        let track = PoseTrack(PoseTable { rows });
        let at = |t_us: i64| track.at(Micros(t_us)).map(|joints| joints[4]);
        assert_eq!(at(10_000), Some(Some(Vec2::new(1.0, 2.0))));
        assert_eq!(at(15_000), Some(Some(Vec2::new(2.0, 4.0))));
        assert_eq!(at(25_000), Some(None), "the later one does not know it");
        assert_eq!((at(9_999), at(30_001)), (None, None));
        assert_eq!(track.end(), Micros(30_000));
    }

    #[test]
    fn positions_in_the_world_are_interpolated_likewise() {
        let rows = [10, 20].map(|t_ms: i64| {
            let joints_m = [Vec3::new(t_ms as f32, 1.0, -2.0); BODY_JOINTS];
            PoseRow { joints_m, ..row(t_ms, None) }
        });
        let track = PoseTrack(PoseTable { rows: rows.into() });
        let at = |t_us: i64| track.at_m(Micros(t_us)).map(|joints| joints[7]);
        assert_eq!(at(12_500), Some(Vec3::new(12.5, 1.0, -2.0)));
        assert_eq!(at(20_000), Some(Vec3::new(20.0, 1.0, -2.0)));
        assert_eq!(at(20_001), None);
    }

    #[test]
    fn the_mean_time_is_that_of_the_last_events_however_they_come() {
        let sensor = SensorSize { width: 4, height: 4 };
        // Uneven times: the mean of the last seven is none of them.
        let events: Vec<Event> = (0..50)
            .map(|k| Event { t: Micros(1_000 + k * k), x: 1, y: 2, polarity: Polarity::On })
            .collect();
        let mean = |pieces: usize| {
            let mut recent = RecentTimes { most: 7, times: VecDeque::new() };
            for piece in events.chunks(pieces) {
                recent.push(&EventStream::from_events(sensor, piece.iter().copied()).unwrap());
            }
            recent.mean().unwrap()
        };
        let want: i64 = (43..50).map(|k| 1_000 + k * k).sum::<i64>() / 7;
        assert_eq!([mean(1), mean(3), mean(50)], [Micros(want); 3]);
    }

    #[test]
    fn a_directory_without_recordings_says_how_to_make_some() {
        let directory = tempfile::tempdir().unwrap();
        std::fs::write(directory.path().join("0000.poses.csv"), "t_us").unwrap();
        let message = BodyRecordings::open(directory.path()).unwrap_err().to_string();
        assert!(message.contains("evpose simulate"), "{message}");
        std::fs::write(directory.path().join("0000.raw"), "").unwrap();
        assert_eq!(BodyRecordings::open(directory.path()).unwrap().files.len(), 1);
    }
}
