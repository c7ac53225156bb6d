//! `evpose prepare mpii`, `lsp` and `coco`: sets of photographs.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use evpose_datasets::stills::{Converted, CropFormat, StillOptions, StillStyle};
use evpose_datasets::{DatasetError, coco, lsp, mpii};

use super::args::{CocoArgs, LspArgs, MpiiArgs, StillArgs};
use super::{list, say_next};
use crate::progress::{bar, say};
use crate::run_info;
use crate::threads::use_threads;

/// Folder of photographs, and places of annotations, in a set's folder.
const IMAGES: &str = "images";
const MPII: [&str; 2] =
    ["mpii_human_pose_v1_u12_1.mat", "mpii_human_pose_v1_u12_2/mpii_human_pose_v1_u12_1.mat"];
const LSP: [&str; 1] = ["joints.mat"];

/// The conversion of a set: options and progress in, counts out.
type Convert = fn(&StillOptions, &(dyn Fn(u64, u64) + Sync)) -> Result<Converted, DatasetError>;

pub(super) fn mpii(args: &MpiiArgs) -> Result<()> {
    let options =
        StillOptions { parity: args.parity, ..options(&args.data, &MPII, IMAGES, &args.stills)? };
    run(&options, args.stills.threads, mpii::convert)
}

pub(super) fn lsp(args: &LspArgs) -> Result<()> {
    run(&options(&args.data, &LSP, IMAGES, &args.stills)?, args.stills.threads, lsp::convert)
}

pub(super) fn coco(args: &CocoArgs) -> Result<()> {
    let annotations = format!("annotations/person_keypoints_{}.json", args.split);
    let options = options(&args.data, &[&annotations], &args.split, &args.stills)?;
    run(&options, args.stills.threads, coco::convert)
}

fn options(data: &Path, places: &[&str], images: &str, args: &StillArgs) -> Result<StillOptions> {
    let annotations = match &args.annotations {
        Some(path) => path.clone(),
        None => annotations(data, places)?,
    };
    let images = args.images.clone().unwrap_or_else(|| data.join(images));
    let mut options = StillOptions::new(annotations, images, &args.out);
    if args.grey {
        options.style = StillStyle::Grey;
    }
    if let Some(quality) = args.jpeg {
        options.format = CropFormat::Jpeg { quality };
    }
    options.seed = args.seed;
    Ok(options)
}

fn annotations(data: &Path, places: &[&str]) -> Result<PathBuf> {
    let mut paths = places.iter().map(|place| data.join(place));
    paths.find(|path| path.is_file()).with_context(|| {
        format!(
            "{}: no {} is there: --annotations says where it is, and datasets/README.md where it is \
             to be had",
            data.display(),
            places.join(" nor ")
        )
    })
}

fn run(options: &StillOptions, threads: Option<usize>, convert: Convert) -> Result<()> {
    use_threads(threads)?;
    let progress = bar("converting", 0, "photographs");
    let converted = convert(options, &|done, of| {
        // The count is known only when the annotations are read.
        progress.set_length(of);
        progress.inc(done);
    })?;
    progress.finish_and_clear();
    run_info::write(&options.output, options.seed, None)?;
    print(&converted);
    say(format!("written to {}", options.output.display()));
    say_next("pretrain", &options.output);
    Ok(())
}

fn print(converted: &Converted) {
    let Converted { images, persons, not_for_training, labelled, skipped } = converted;
    say(format!("{persons} persons of {images} photographs"));
    if *not_for_training > 0 {
        say(format!(
            "{not_for_training} photographs are not for training: their joints are not published"
        ));
    }
    let missing =
        labelled.iter().map(|(joint, labelled)| format!("{joint} {}", persons - labelled));
    say(format!("joints that are not labelled: {}", missing.collect::<Vec<_>>().join(", ")));
    let reasons = converted.skipped_by_reason();
    if !reasons.is_empty() {
        say(format!("left out: {}", skipped.len()));
        for (reason, count) in reasons {
            say(format!("  {count:6} {reason}"));
        }
    }
    let detailed = skipped
        .iter()
        .filter_map(|skipped| Some(format!("{}: {}", skipped.image, skipped.detail.as_ref()?)));
    list("in detail", &detailed.collect::<Vec<_>>());
}
