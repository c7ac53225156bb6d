//! The conversion of the whole set.

use std::collections::HashSet;
use std::io;
use std::path::Path;

use evpose_core::{Plane, atomic_write, seed_for};
use evpose_pose::body::{BODY_JOINTS, JOINT_NAMES};
use evpose_repr::ErosLikeWork;
use rayon::prelude::*;
use serde::Serialize;
use sha2::{Digest, Sha256};

use super::image_file::{read_grey, size, write};
use super::label::label;
use super::person::{Person, Photograph};
use super::window::Window;
use super::{Converted, CropFormat, SkipReason, Skipped, StillOptions, StillStyle};
use crate::{Annotation, DatasetError, write_annotations};

/// Images of persons.
const IMAGES: &str = "images";
/// Their labels, which are written last: where they are, all is there.
const LABELS: &str = "poses.json";
/// Name of the report of converted and skipped persons.
const REPORT: &str = "conversion.json";
/// With what it was converted.
const SETTINGS: &str = "settings.json";

/// Annotated photographs of a set.
#[derive(Debug)]
pub(crate) struct StillSet {
    /// Name of the set, which noise is drawn by.
    pub(crate) name: &'static str,
    /// Photographs for training.
    pub(crate) photographs: Vec<Photograph>,
    /// How many others there are: their joints are not published.
    pub(crate) not_for_training: usize,
}

/// Cuts every person of the photographs for training out into an image of its own,
/// `OUTPUT/images/NAME_PERSON.png`, with its label in `OUTPUT/poses.json`; `OUTPUT/conversion.json`
/// reports what was skipped and why.
///
/// A conversion that was interrupted is gone on with. What is written depends on the options alone,
/// not on the number of threads. `progress` is called with the count of photographs since its last
/// call, and how many there are.
///
/// # Source
/// `export_to_eros.py` and `export_to_movenet.py` of hpe-core, one behind the other: the look is
/// made of the whole photograph.
///
/// # Errors
/// If the annotations cannot be read, none of the photographs is there, the output folder is that
/// of other options, or a file cannot be written.
pub(crate) fn convert(
    options: &StillOptions,
    read: impl FnOnce(&Path, &[u8]) -> Result<StillSet, DatasetError>,
    progress: &(dyn Fn(u64, u64) + Sync),
) -> Result<Converted, DatasetError> {
    let path = &options.annotations;
    let bytes = std::fs::read(path).map_err(DatasetError::io(path, "read it"))?;
    let digest = Sha256::digest(&bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    let set = read(path, &bytes)?;
    // COCO's annotations take hundreds of megabytes.
    drop(bytes);
    start(options, digest)?;
    let unnamed = bad_names(&set.photographs);
    let photographs = set.photographs.len() as u64;
    // Outcomes are in the order of the set, whichever thread was first.
    let outcomes = set
        .photographs
        .par_iter()
        .map_init(ErosLikeWork::default, |work, photograph| {
            let outcome = if unnamed.contains(&photograph.index) {
                Ok(Outcome::skipped(photograph, SkipReason::BadName, None))
            } else {
                photograph_of(options, set.name, photograph, work)
            };
            progress(1, photographs);
            outcome
        })
        .collect::<Result<Vec<_>, _>>()?;
    finish(options, outcomes, set.not_for_training)
}

/// Result of a photograph.
#[derive(Default)]
struct Outcome {
    annotations: Vec<Annotation>,
    skipped: Vec<Skipped>,
}

impl Outcome {
    fn skipped(photograph: &Photograph, reason: SkipReason, detail: Option<String>) -> Self {
        let skipped = Skipped { image: photograph.name.clone(), person: None, reason, detail };
        Self { annotations: Vec::new(), skipped: vec![skipped] }
    }
}

/// Notes the settings, or checks that they are those with which the folder was begun.
fn start(options: &StillOptions, annotations_sha256: String) -> Result<(), DatasetError> {
    #[derive(Serialize)]
    struct Settings {
        annotations_sha256: String,
        #[serde(rename = "look")]
        style: StillStyle,
        format: CropFormat,
        seed: u64,
        parity: bool,
    }
    // What changes images is compared; threads and folders may differ.
    let StillOptions { style, format, seed, parity, .. } = *options;
    let bytes = json(&Settings { annotations_sha256, style, format, seed, parity })?;
    let path = options.output.join(SETTINGS);
    match std::fs::read(&path) {
        // Compared as bytes: any other setting is another conversion.
        Ok(found) if found == bytes => Ok(()),
        Ok(_) => {
            let reason = "this folder was converted with other ones: take another, or remove it";
            Err(DatasetError::malformed(path, "settings", reason))
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            atomic_write(&path, &bytes).map_err(DatasetError::io(&path, "write it"))
        }
        Err(source) => Err(DatasetError::io(path, "read it")(source)),
    }
}

/// Photographs whose name is no plain file name, or whose persons would be called as those of
/// another.
fn bad_names(photographs: &[Photograph]) -> HashSet<usize> {
    let mut stems = HashSet::new();
    let mut bad = HashSet::new();
    for photograph in photographs {
        let name = Path::new(&photograph.name);
        // A path in an annotation file must not lead out of the folder of images.
        let is_plain = name.file_name().is_some_and(|plain| plain == name.as_os_str())
            && !photograph.name.contains(['\\', '\0']);
        if !is_plain || !stems.insert(stem(&photograph.name)) {
            bad.insert(photograph.index);
        }
    }
    bad
}

fn stem(name: &str) -> &str {
    name.rsplit_once('.').map_or(name, |(stem, _)| stem)
}

/// Converts the persons of a photograph.
fn photograph_of(
    options: &StillOptions,
    set: &str,
    photograph: &Photograph,
    work: &mut ErosLikeWork,
) -> Result<Outcome, DatasetError> {
    let path = options.images.join(&photograph.name);
    if photograph.persons.is_empty() {
        return Ok(Outcome::skipped(photograph, SkipReason::NoPersons, None));
    }
    let unreadable = |error: image::ImageError| {
        let reason = match &error {
            image::ImageError::IoError(error) if error.kind() == io::ErrorKind::NotFound => {
                SkipReason::NoImage
            }
            _ => SkipReason::UnreadableImage,
        };
        Ok(Outcome::skipped(photograph, reason, Some(error.to_string())))
    };
    // The header alone: pixels are decoded only if an image is missing.
    let size = match size(&path) {
        Ok(size) => size,
        Err(error) => return unreadable(error),
    };
    let mut outcome = Outcome::default();
    let mut missing = Vec::new();
    for (index, person) in photograph.persons.iter().enumerate() {
        let (reason, detail) = match person {
            Ok(person) => match labelled(options, photograph, index, person, size) {
                Ok((window, annotation)) => {
                    let path = options.output.join(IMAGES).join(&annotation.image);
                    // It may be there from an interrupted run.
                    if !path.exists() {
                        missing.push((window, path));
                    }
                    outcome.annotations.push(annotation);
                    continue;
                }
                Err(reason) => (reason, None),
            },
            Err(fault) => (fault.reason, fault.detail.clone()),
        };
        let image = photograph.name.clone();
        outcome.skipped.push(Skipped { image, person: Some(index), reason, detail });
    }
    if missing.is_empty() {
        return Ok(outcome);
    }
    let grey = match read_grey(&path) {
        Ok(grey) => grey,
        Err(error) => return unreadable(error),
    };
    let image = match options.style {
        StillStyle::Grey => grey,
        StillStyle::ErosLike(look) => {
            // By number of the photograph: threads and restarts do not change it.
            let seed = seed_for(options.seed, set, photograph.index as u64);
            let mut out = Plane::filled(0, 0, 0);
            look.convert_into(&grey, seed, work, &mut out);
            out
        }
    };
    // Written at the end: a photograph is read once for all of its persons.
    for (window, path) in missing {
        write(&path, &window.cut(&image), options.format)?;
    }
    Ok(outcome)
}

fn labelled(
    options: &StillOptions,
    photograph: &Photograph,
    index: usize,
    person: &Person,
    size: [usize; 2],
) -> Result<(Window, Annotation), SkipReason> {
    let others = photograph.persons.iter().enumerate().filter(|&(other, _)| other != index);
    if options.parity && others.clone().any(|(_, other)| other.is_err()) {
        return Err(SkipReason::IncompleteCompanion);
    }
    // Whoever cannot be read is nobody's companion.
    let others: Vec<&Person> = others.filter_map(|(_, other)| other.as_ref().ok()).collect();
    let window = Window::around(person, size)?;
    let label = label(person, &others, &window, options.parity)?;
    let image = format!("{}_{index}.{}", stem(&photograph.name), options.format.ending());
    Ok((window, Annotation { image, t_s: None, label }))
}

fn finish(
    options: &StillOptions,
    outcomes: Vec<Outcome>,
    not_for_training: usize,
) -> Result<Converted, DatasetError> {
    let photographs = outcomes.len();
    // A photograph counts if somebody on it can be used.
    let images = outcomes.iter().filter(|outcome| !outcome.annotations.is_empty()).count();
    let mut annotations = Vec::new();
    let mut skipped = Vec::new();
    for outcome in outcomes {
        annotations.extend(outcome.annotations);
        skipped.extend(outcome.skipped);
    }
    let of = |joint: usize| {
        let keypoints = annotations.iter().map(|annotation| &annotation.label.keypoints[joint]);
        (JOINT_NAMES[joint], keypoints.filter(|keypoint| keypoint.is_labelled()).count())
    };
    let labelled = (0..BODY_JOINTS).map(of).collect();
    let persons = annotations.len();
    let converted = Converted { images, persons, not_for_training, labelled, skipped };
    let counts = converted.skipped_by_reason();
    let missing = counts.get(&SkipReason::NoImage).copied().unwrap_or(0);
    // A wrong folder of images must not end as an empty data set.
    if images == 0 && missing > 0 {
        let reason = format!("{missing} of {photographs} are missing and nobody is on the others");
        return Err(DatasetError::malformed(&options.images, "photographs", reason));
    }
    let path = options.output.join(REPORT);
    let bytes = json(&converted)?;
    atomic_write(&path, &bytes).map_err(DatasetError::io(&path, "write it"))?;
    // Last: a folder with labels is complete.
    write_annotations(&options.output.join(LABELS), &annotations)?;
    Ok(converted)
}

fn json(value: &impl Serialize) -> Result<Vec<u8>, DatasetError> {
    let mut bytes = serde_json::to_vec_pretty(value)
        .map_err(|error| DatasetError::malformed(SETTINGS, "settings", error.to_string()))?;
    bytes.push(b'\n');
    Ok(bytes)
}
