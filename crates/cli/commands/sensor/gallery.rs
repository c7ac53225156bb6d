//! `evpose sensor gallery`: every preset and every effect in one page.

use anyhow::Result;
use evpose_app::threads::use_threads;
use evpose_report::gallery::{self, GalleryOptions};

use super::args::GalleryArgs;

pub(super) fn run(args: &GalleryArgs) -> Result<()> {
    use_threads(args.threads)?;
    let GalleryArgs { out, only, scale, seed, .. } = args;
    gallery::write(&GalleryOptions { out, only, scale: *scale, seed: *seed })
}
