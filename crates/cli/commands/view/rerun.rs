//! Pictures, events and rates for the Rerun viewer, where the build has its feature.

use std::path::Path;

use anyhow::Result;

use super::ViewArgs;

/// What names of the viewer's files end in.
pub(super) const ENDING: &str = "rrd";

#[cfg(feature = "rerun")]
pub(super) use sdk::{send, write};

#[cfg(feature = "rerun")]
mod sdk {
    use evpose_core::SensorSize;
    use evpose_rerun::{Moment, Recording, RerunError};

    use super::super::files::png;
    use super::super::report;
    use super::super::shots::Reel;
    use super::{Path, Result, ViewArgs};
    use evpose_app::progress::say;

    /// Pictures, unless the user says: they are small, and the viewer moves through them smoothly.
    const PICTURES: u32 = 300;

    /// Writes the file `out`.
    pub(in super::super) fn write(args: &ViewArgs, out: &Path) -> Result<()> {
        let place = out.display().to_string();
        show(args, &place, |name, sensor| Recording::create(out, name, sensor))
    }

    /// Sends it to the viewer that the user says.
    pub(in super::super) fn send(args: &ViewArgs) -> Result<()> {
        let address = args.rerun.as_ref().and_then(Option::as_deref);
        show(args, "the Rerun viewer", |name, sensor| Recording::connect(address, name, sensor))
    }

    fn show(
        args: &ViewArgs,
        place: &str,
        begin: impl FnOnce(&str, SensorSize) -> Result<Recording, RerunError>,
    ) -> Result<()> {
        let mut reel = Reel::open(args, args.pictures.unwrap_or(PICTURES))?;
        let mut recording = begin(&reel.name, reel.sensor)?;
        let (palette, length) = (reel.palette.unscaled(), reel.every);
        reel.play(|moment| {
            let picture = png(&palette.draw(moment.planes))?;
            let (t, events) = (moment.t, moment.events);
            Ok(recording.send(&Moment { t, length, events, picture: &picture })?)
        })?;
        let sent = recording.finish()?;
        if sent.points < sent.events {
            say(format!(
                "note      {} of {} events are points; rates and pictures have all",
                sent.points, sent.events
            ));
        }
        report(&reel, place);
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
const MISSING: &str = "this build knows no Rerun viewer: build it with `--features rerun`";
