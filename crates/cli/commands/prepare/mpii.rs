//! `evpose prepare mpii`.

use std::path::PathBuf;

use anyhow::{Result, bail};
use evpose_datasets::mpii::{Converted, CropFormat, MpiiOptions, MpiiStyle, convert};

use super::args::MpiiArgs;
use super::{list, say_next};
use evpose_app::progress::{bar, say};
use evpose_app::run_info;
use evpose_app::threads::use_threads;

/// File of the annotations, and the folder in their archive.
const ANNOTATIONS: &str = "mpii_human_pose_v1_u12_1.mat";
const ARCHIVE: &str = "mpii_human_pose_v1_u12_2";

pub(super) fn run(args: &MpiiArgs) -> Result<()> {
    use_threads(args.threads)?;
    let images = args.images.clone().unwrap_or_else(|| args.data.join("images"));
    let mut options = MpiiOptions::new(annotations(args)?, images, &args.out);
    if args.grey {
        options.style = MpiiStyle::Grey;
    }
    if let Some(quality) = args.jpeg {
        options.format = CropFormat::Jpeg { quality };
    }
    (options.seed, options.parity) = (args.seed, args.parity);
    let progress = bar("converting", 0, "photographs");
    let converted = convert(&options, &|done, of| {
        progress.set_length(of);
        progress.inc(done);
    })?;
    progress.finish_and_clear();
    run_info::write(&args.out, args.seed, None)?;
    print(&converted);
    say(format!("written to {}", args.out.display()));
    say_next("pretrain", &args.out);
    Ok(())
}

fn annotations(args: &MpiiArgs) -> Result<PathBuf> {
    if let Some(path) = &args.annotations {
        return Ok(path.clone());
    }
    let places = [args.data.join(ANNOTATIONS), args.data.join(ARCHIVE).join(ANNOTATIONS)];
    match places.into_iter().find(|path| path.is_file()) {
        Some(path) => Ok(path),
        None => bail!(
            "{}: neither {ANNOTATIONS} nor {ARCHIVE}/{ANNOTATIONS} is there: --annotations says where \
             it is, and datasets/README.md where it is to be had",
            args.data.display()
        ),
    }
}

fn print(converted: &Converted) {
    let Converted { images, persons, not_for_training, skipped } = converted;
    say(format!("{persons} persons of {images} photographs"));
    say(format!(
        "{not_for_training} photographs are not for training: their joints are not published"
    ));
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
