//! Frames, events and rates for the Rerun viewer, where the build has its feature.

use std::path::Path;

use anyhow::Result;

use super::ViewArgs;

/// Extension of the viewer's files.
pub(super) const ENDING: &str = "rrd";

#[cfg(feature = "rerun")]
pub(super) use sdk::{send, write};

#[cfg(feature = "rerun")]
mod sdk {
    use evpose_core::SensorSize;
    use evpose_live::rerun::{FrameContents, RerunError, RerunRecording};
    use evpose_report::png::png;

    use super::super::frames::FrameReader;
    use super::super::report;
    use super::{Path, Result, ViewArgs};
    use crate::progress::say;

    /// Default number of frames: they are small, and the viewer scrubs through them smoothly.
    const FRAMES: u32 = 300;

    pub(in super::super) fn write(args: &ViewArgs, out: &Path) -> Result<()> {
        let place = out.display().to_string();
        show(args, &place, |name, sensor| RerunRecording::create(out, name, sensor))
    }

    /// Sends the recording to the viewer at the given address.
    pub(in super::super) fn send(args: &ViewArgs) -> Result<()> {
        let address = args.rerun.as_ref().and_then(Option::as_deref);
        show(args, "the Rerun viewer", |name, sensor| {
            RerunRecording::connect(address, name, sensor)
        })
    }

    fn show(
        args: &ViewArgs,
        place: &str,
        begin: impl FnOnce(&str, SensorSize) -> Result<RerunRecording, RerunError>,
    ) -> Result<()> {
        let mut reader = FrameReader::open(args, args.frames.unwrap_or(FRAMES))?;
        let mut recording = begin(&reader.name, reader.sensor)?;
        // Unscaled: the viewer draws events as points over these pixels.
        let (palette, length) = (reader.palette.unscaled(), reader.every);
        reader.play(|data| {
            let frame = png(&palette.draw(data.planes))?;
            let (t, events) = (data.t, data.events);
            Ok(recording.send(&FrameContents { t, length, events, event_image: &frame })?)
        })?;
        let sent = recording.finish()?;
        if sent.points < sent.events {
            say(format!(
                "note      {} of {} events are drawn as points; rates and frames count all",
                sent.points, sent.events
            ));
        }
        report(&reader, place);
        Ok(())
    }
}

#[cfg(not(feature = "rerun"))]
pub(super) fn write(_args: &ViewArgs, out: &Path) -> Result<()> {
    anyhow::bail!("{}: {MISSING}", out.display())
}

#[cfg(not(feature = "rerun"))]
pub(super) fn send(_args: &ViewArgs) -> Result<()> {
    anyhow::bail!("--rerun: {MISSING}")
}

#[cfg(not(feature = "rerun"))]
const MISSING: &str =
    "this build has no support for the Rerun viewer: build it with `--features rerun`";
