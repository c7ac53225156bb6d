//! Label files, and their labels as tracks.

use std::ffi::OsStr;
use std::io::Read as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use evpose_core::SensorSize;
use evpose_datasets::check::{LabelTrack, TrackFrame, tracks_of};
use evpose_datasets::h36m::{self, ClipName};
use evpose_datasets::read_annotations;
use evpose_io::poses::{PoseKind, PoseSequence, read_poses};
use evpose_io::yarp::{YarpSkeleton, read_skeletons};
use evpose_pose::body::BodyPoints;
use evpose_sim::person::PersonInfo;
use glam::Vec2;

use super::images::ImageSizes;

/// Name of the log in a YARP folder.
const LOG: &str = "data.log";
/// Suffix of the name of a table of poses.
const TABLE: &str = ".poses.csv";

/// A file or a folder of labels.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Source {
    /// An annotation file.
    Annotations(PathBuf),
    /// Poses of a person.
    Table(PathBuf),
    /// A folder with a log of skeletons, or the log.
    Skeletons(PathBuf),
}

/// Label files at `path` or below it, sorted by name.
pub(super) fn find(path: &Path) -> Result<Vec<Source>> {
    if !path.is_dir() {
        // A file given by name is read by its extension, even if its content differs.
        let source = if is_poses(path) {
            Source::Table(path.to_owned())
        } else if path.extension() == Some(OsStr::new("log")) {
            Source::Skeletons(path.to_owned())
        } else {
            Source::Annotations(path.to_owned())
        };
        return Ok(vec![source]);
    }
    if path.join(LOG).is_file() {
        return Ok(vec![Source::Skeletons(path.to_owned())]);
    }
    let mut sources = Vec::new();
    below(path, &mut sources)
        .with_context(|| format!("looking for labels in {}", path.display()))?;
    sources.sort();
    Ok(sources)
}

fn below(directory: &Path, sources: &mut Vec<Source>) -> std::io::Result<()> {
    for entry in std::fs::read_dir(directory)? {
        let entry = entry?;
        let path = entry.path();
        // Symbolic links are not followed: they may form cycles.
        if entry.file_type()?.is_dir() {
            if is_skeletons(&path) {
                sources.push(Source::Skeletons(path));
            } else {
                below(&path, sources)?;
            }
        } else if is_table(&path) {
            sources.push(Source::Table(path));
        } else if path.extension() == Some(OsStr::new("json")) && is_array(&path)? {
            sources.push(Source::Annotations(path));
        }
    }
    Ok(())
}

fn is_table(path: &Path) -> bool {
    path.file_name().is_some_and(|name| name.to_string_lossy().ends_with(TABLE))
}

/// Whether a file that is given by name is one of poses, in any format.
fn is_poses(path: &Path) -> bool {
    is_table(path) || path.extension().is_some_and(|ending| ending == "csv" || ending == "jsonl")
}

/// Whether a folder has the published name of skeleton logs.
fn is_skeletons(path: &Path) -> bool {
    let name = path.file_name().map(|name| name.to_string_lossy().to_lowercase());
    name.is_some_and(|name| name.contains("skeleton")) && path.join(LOG).is_file()
}

/// Whether a JSON file is an array, as annotations are; settings and reports are objects.
fn is_array(path: &Path) -> std::io::Result<bool> {
    for byte in std::io::BufReader::new(std::fs::File::open(path)?).bytes() {
        match byte? {
            byte if byte.is_ascii_whitespace() => {}
            byte => return Ok(byte == b'['),
        }
    }
    Ok(false)
}

impl Source {
    /// Reads the labels, on images of `image_size` if given.
    pub(super) fn tracks(
        &self,
        image_size: Option<SensorSize>,
        transposed: bool,
    ) -> Result<Vec<LabelTrack>> {
        match self {
            Self::Annotations(path) => annotated(path, image_size),
            Self::Table(path) => Ok(vec![simulated(path, image_size)?]),
            Self::Skeletons(path) => Ok(vec![logged(path, image_size, transposed)?]),
        }
    }
}

/// Tracks of annotations: images with a time stamp are frames of a clip, others are single
/// photographs.
fn annotated(path: &Path, image_size: Option<SensorSize>) -> Result<Vec<LabelTrack>> {
    let annotations = read_annotations(path)?;
    let mut tracks = tracks_of(&annotations, Vec2::ONE, |annotation| {
        // Photographs have no order in time: each is a track, or motion would be checked.
        if annotation.t_s.is_some() { annotation.sequence() } else { &annotation.image }
    });
    let sizes = ImageSizes::beside(path, image_size);
    for track in &mut tracks {
        let size = sizes.image_size(track)?;
        track.image_size = Some(size);
        for frame in &mut track.frames {
            // Labels are shares of the image; the check is in pixels, since images are not square.
            frame.joints = frame.joints.map(|joint| joint.map(|at| at * size));
        }
    }
    Ok(tracks)
}

fn simulated(path: &Path, image_size: Option<SensorSize>) -> Result<LabelTrack> {
    let PoseSequence { kind, poses, .. } = read_poses(path)?;
    ensure!(kind == PoseKind::Body, "{}: not poses of a person", path.display());
    let name = path.to_string_lossy();
    let name = name.strip_suffix(TABLE).unwrap_or(&name).to_owned();
    let size = match image_size {
        Some(size) => size,
        None => sensor_of(Path::new(&format!("{name}.toml")))?,
    };
    // The first line is a header, and lines count from 1.
    let frames = poses.iter().zip(2..).map(|(pose, line): (_, u64)| {
        frame(format!("line {line}"), pose.t.as_seconds(), pose.body_px())
    });
    Ok(LabelTrack { name, frames: frames.collect(), image_size: Some(pixels(size)) })
}

/// Sensor of a simulated person.
fn sensor_of(path: &Path) -> Result<SensorSize> {
    let text = std::fs::read_to_string(path).with_context(|| {
        format!(
            "reading {}, which holds the size of the image; or give --image-size",
            path.display()
        )
    })?;
    let info: PersonInfo =
        toml::from_str(&text).with_context(|| format!("reading {}", path.display()))?;
    Ok(info.sensor)
}

fn logged(path: &Path, image_size: Option<SensorSize>, transposed: bool) -> Result<LabelTrack> {
    let skeletons = read_skeletons(path)?;
    let frames = skeletons.into_iter().zip(1..).map(|(skeleton, line): (YarpSkeleton, u64)| {
        let skeleton = if transposed { skeleton.transposed() } else { skeleton };
        frame(format!("line {line}"), skeleton.t.as_seconds(), skeleton.points_px())
    });
    // The published logs do not state the size of their images.
    let image_size = image_size.or_else(|| is_clip(path).then_some(h36m::SENSOR)).map(pixels);
    Ok(LabelTrack { name: path.display().to_string(), frames: frames.collect(), image_size })
}

/// Whether a parent folder has the name of an eH3.6M clip.
fn is_clip(path: &Path) -> bool {
    let above = path.ancestors().filter_map(|folder| folder.file_name()?.to_str());
    // Names further up than the folder of the clip are those of the user.
    above.take(3).any(|name| name.parse::<ClipName>().is_ok())
}

fn frame(name: String, t_s: f64, joints: BodyPoints) -> TrackFrame {
    TrackFrame { name, t_s: Some(t_s), joints }
}

fn pixels(size: SensorSize) -> Vec2 {
    Vec2::new(size.width.into(), size.height.into())
}
