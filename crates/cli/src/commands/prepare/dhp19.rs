//! `evpose prepare dhp19`.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use anyhow::{Result, bail};
use evpose_datasets::dhp19::{
    BackgroundFilter, CAMERAS, Dhp19Filters, Dhp19Name, Movement, NeighbourRule, PixelRule, Pose,
    Projection, SUBJECTS, SpanOrigin, cut_movement, read_extracted, read_movie, read_vicon,
};
use evpose_datasets::{DatasetError, LabelledRecording};

use super::args::Dhp19Args;
use super::frames::{Job, Reading, prepare};
use crate::progress::say;

/// Default stride of the poses at 100 Hz. The published exporter takes every eleventh.
const EVERY: NonZeroUsize = NonZeroUsize::new(10).unwrap();

pub(super) fn run(args: &Dhp19Args) -> Result<()> {
    let wanted: Vec<_> =
        Dhp19Name::all().filter(|name| args.frames.takes(name.subject())).collect();
    let Some(&first) = wanted.first() else {
        bail!("--subjects names none of the persons 1 to {SUBJECTS}");
    };
    // Those that are there, since the whole set is large and few need all of it.
    let is_there = |name: &&Dhp19Name| events(args, **name).is_file();
    let movements: Vec<_> = wanted.iter().filter(is_there).copied().collect();
    if movements.is_empty() {
        let path = events(args, first);
        bail!("no movement is there: files such as {} are expected", path.display());
    }
    if movements.len() < wanted.len() {
        say(format!("{} of {} movements are there", movements.len(), wanted.len()));
    }
    let projections = Projections::read(args)?;
    let job = Job {
        unit: "movements",
        recordings: &movements,
        is_test: |name: &Dhp19Name| name.is_test(),
        options: args.frames.options(EVERY),
        seed: 0,
    };
    prepare(&args.frames, &job, |name| Ok(read(args, &projections, *name)))
}

fn events(args: &Dhp19Args, name: Dhp19Name) -> PathBuf {
    match &args.extracted {
        Some(folder) => folder.join(format!("{name}.mat")),
        None => name.movie(&args.data),
    }
}

struct Projections([Option<Projection>; CAMERAS]);

impl Projections {
    fn read(args: &Dhp19Args) -> Result<Self> {
        let folder = args.projections.clone().unwrap_or_else(|| args.data.join("P_matrices"));
        let mut projections = [None; CAMERAS];
        // Files of cameras that are not chosen may be missing.
        for &camera in args.cameras.indices() {
            projections[camera] = Some(Projection::of_camera(camera, &folder)?);
        }
        Ok(Self(projections))
    }

    /// Labels of a movement, camera by camera.
    fn seen(
        &self,
        name: Dhp19Name,
        movement: &Movement,
        poses: &[Pose],
        rule: PixelRule,
    ) -> Vec<LabelledRecording> {
        let cameras = self.0.iter().enumerate();
        cameras
            .filter_map(|(camera, projection)| {
                Some(movement.seen_by(name, camera, projection.as_ref()?, poses, rule))
            })
            .collect()
    }
}

fn read(args: &Dhp19Args, projections: &Projections, name: Dhp19Name) -> Reading {
    // Faults of the published files are known, whatever reading them would say.
    if let Some(fault) = name.faults().find(|fault| fault.is_fatal) {
        return Reading::LeftOut(fault.what.to_owned());
    }
    // The published pipeline truncates coordinates, which parity repeats.
    let rule = if args.frames.parity { PixelRule::Truncated } else { PixelRule::Exact };
    let read = || -> Result<Reading, DatasetError> {
        let poses = read_vicon(&name.vicon(&args.data))?;
        let mut movement = movement(args, name, poses.len())?;
        let recordings = projections.seen(name, &movement, &poses, rule);
        let mut remarks = std::mem::take(&mut movement.remarks);
        if let Some(origin) = remark_on(movement.span.origin) {
            remarks.push(origin.to_owned());
        }
        let faults = name.faults().filter(|fault| fault.recording.is_some());
        remarks.extend(faults.map(|fault| fault.what.to_owned()));
        Ok(Reading::Seen { recordings, remarks })
    };
    read().unwrap_or_else(|error| Reading::LeftOut(error.to_string()))
}

fn movement(args: &Dhp19Args, name: Dhp19Name, poses: usize) -> Result<Movement, DatasetError> {
    let path = events(args, name);
    if args.extracted.is_some() {
        return read_extracted(&path);
    }
    let rule = if args.frames.parity { NeighbourRule::Published } else { NeighbourRule::PerCamera };
    let background = Some(BackgroundFilter { rule, ..BackgroundFilter::default() });
    let filters = Dhp19Filters { background, ..Dhp19Filters::default() };
    cut_movement(&path, &read_movie(&path, args.salvage)?, poses, &filters)
}

/// A remark for movements whose time is only approximate.
fn remark_on(origin: SpanOrigin) -> Option<&'static str> {
    match origin {
        SpanOrigin::Pulses | SpanOrigin::Stated => None,
        SpanOrigin::Beginning => {
            Some("its end is estimated from the count of poses: no pulse marks it")
        }
        SpanOrigin::End => {
            Some("its beginning is estimated from the count of poses: no pulse marks it")
        }
        SpanOrigin::Recording => Some("no pulse marks it: it is taken to be the whole recording"),
    }
}
