//! People drawn over a recording.

use anyhow::Result;
use evpose_core::Micros;
use evpose_io::predictions::{DelayUnit, read_predictions};
use evpose_pose::body::BodyPoints;
use evpose_sim::person::PoseTable;
use image::{Rgb, RgbImage};

use super::ViewArgs;
use crate::report::canvas::{Canvas, PREDICTION, TRUTH};

/// Joints over time, each in a colour.
#[derive(Default)]
pub(super) struct People {
    tracks: Vec<(Rgb<u8>, Track)>,
}

/// Joints in the order of time.
type Track = Vec<(Micros, BodyPoints)>;

impl People {
    /// Those of the files that were named.
    pub(super) fn open(args: &ViewArgs) -> Result<Self> {
        let mut tracks = Vec::new();
        if let Some(path) = &args.truth {
            let rows = PoseTable::read(path)?.rows.into_iter();
            tracks.push((TRUTH, rows.map(|row| (row.t, row.joints_px)).collect()));
        }
        if let Some(path) = &args.joints {
            let mut found: Track = read_predictions(path, DelayUnit::Seconds)?
                .into_iter()
                .map(|found| (Micros::from_seconds(found.t_s), found.joints_px))
                .collect();
            found.sort_by_key(|(t, _)| *t);
            tracks.push((PREDICTION, found));
        }
        Ok(Self { tracks })
    }

    /// Draws where they were last seen at `t`, as the file counts.
    pub(super) fn draw(&self, image: RgbImage, scale: u32, t: Micros) -> RgbImage {
        if self.tracks.is_empty() {
            return image;
        }
        let mut canvas = Canvas::over(image, scale);
        for (colour, track) in &self.tracks {
            let seen = track.partition_point(|(at, _)| *at <= t);
            if let Some((_, joints_px)) = seen.checked_sub(1).and_then(|last| track.get(last)) {
                canvas.body(joints_px, *colour);
            }
        }
        canvas.into_image()
    }
}
