//! `evpose prepare eh36m` and `evpose prepare h36m`.

use std::num::NonZeroUsize;
use std::path::Path;

use crate::threads::sensor_threads;
use anyhow::{Context, Result, bail, ensure};
use evpose_core::seed_for;
use evpose_datasets::LabelledRecording;
use evpose_datasets::h36m::{
    ClipName, Crop, CropRule, FPS, SENSOR, Synthesis, bodies_of_poses, events_of_frames,
    original_clips, published_clips, read_poses, read_published, write_published,
};
use evpose_io::{Encoding, FrameSource};
use glam::IVec2;

use super::args::{Eh36mArgs, FrameSetArgs, H36mArgs};
use super::frames::{Job, Reading, prepare};

/// Folder of clips in the published layout.
const YARP: &str = "yarp";

pub(super) fn published(args: &Eh36mArgs) -> Result<()> {
    let clips = wanted(published_clips(&args.data)?, &args.frames);
    if clips.is_empty() {
        bail!(
            "{}: no clip is there: folders such as cam2_S9_Walking_1, with ch0dvs and \
             ch2GT50Hzskeleton in them, are expected",
            args.data.display()
        );
    }
    prepare(&args.frames, &job(&clips, &args.frames, 0), |name| {
        Ok(match read_published(&args.data, name, args.tick_us) {
            Ok(clip) => Reading::Seen { recordings: vec![clip.recording], remarks: clip.remarks },
            Err(error) => Reading::LeftOut(error.to_string()),
        })
    })
}

pub(super) fn original(args: &H36mArgs) -> Result<()> {
    let clips = wanted(original_clips(&args.data)?, &args.frames);
    if clips.is_empty() {
        bail!(
            "{}: no clip of a front camera is there: files such as \
             `S9/Poses_D2_Positions/Walking 1.55011271.cdf` are expected",
            args.data.display()
        );
    }
    let yarp = args.yarp.then(|| args.frames.out.join(YARP));
    prepare(&args.frames, &job(&clips, &args.frames, args.seed), |name| {
        let (recording, remarks) = match synthesize(args, name) {
            Ok(clip) => clip,
            Err(reason) => return Ok(Reading::LeftOut(reason.to_string())),
        };
        // The events of a clip are dropped once its frames are drawn, so that this cannot wait.
        if let Some(folder) = &yarp {
            write_published(folder, name, &recording)?;
        }
        Ok(Reading::Seen { recordings: vec![recording], remarks })
    })
}

fn wanted(clips: Vec<ClipName>, args: &FrameSetArgs) -> Vec<ClipName> {
    clips.into_iter().filter(|clip| args.takes(clip.subject())).collect()
}

fn job<'a>(clips: &'a [ClipName], args: &FrameSetArgs, seed: u64) -> Job<'a, ClipName> {
    let options = args.options(NonZeroUsize::MIN);
    Job { unit: "clips", recordings: clips, is_test: ClipName::is_test, options, seed }
}

/// Events and joints of a clip with remarks, or the reason why it is skipped.
fn synthesize(args: &H36mArgs, name: &ClipName) -> Result<(LabelledRecording, Vec<String>)> {
    let mut poses = read_poses(&name.poses(&args.data))?;
    let folder = name.frames(args.videos.as_deref().unwrap_or(&args.data));
    let mut source = open(&folder)?;
    let mut remarks = Vec::new();
    let frames = usize::try_from(source.frames()).unwrap_or(usize::MAX);
    if frames != poses.len() {
        remarks.push(format!("{frames} frames, but {} poses: the rest is not used", poses.len()));
        poses.truncate(frames);
    }
    let rule = if args.frames.parity { CropRule::Published } else { CropRule::Paper };
    let frame_px = IVec2::new(source.size().width.into(), source.size().height.into());
    let crop = Crop::around(poses.iter().flatten().copied(), frame_px, rule)
        .context("there is no pose, or a joint of one is no number")?;
    // The noise of a clip must not depend on which others are converted.
    let seed = seed_for(args.seed, &name.to_string(), 0);
    // Clips come one by one.
    let how = Synthesis { threads: sensor_threads(SENSOR), ..Synthesis::published(seed)? };
    let events = events_of_frames(&mut source, &crop, &how)?;
    let bodies = bodies_of_poses(&poses, &crop, frame_px, rule, FPS);
    Ok((LabelledRecording { name: name.to_string(), events, bodies }, remarks))
}

/// Opens the frames of a video. The sensor treats code values as light, as published.
fn open(folder: &Path) -> Result<FrameSource> {
    ensure!(folder.is_dir(), "{}: there is no such folder of frames", folder.display());
    Ok(FrameSource::open(folder, Encoding::Linear, None)?)
}
