//! `evpose sensor gallery`: every preset and every effect in one page.

use crate::pages::gallery::{self, GalleryOptions};
use crate::threads::use_threads;
use anyhow::Result;

use super::args::GalleryArgs;

pub(super) fn run(args: &GalleryArgs) -> Result<()> {
    use_threads(args.threads)?;
    let GalleryArgs { out, only, scale, seed, .. } = args;
    gallery::write(&GalleryOptions { out, only, scale: *scale, seed: *seed })
}
