//! `evpose represent`: windows of a recording as dense planes, for other programs.
//!
//! The recording is read window by window, and windows are written as they come: memory depends on
//! the size of a window, not on the length of the recording.

mod args;
mod inputs;
mod outputs;
mod windows;

use anyhow::Result;

pub use args::RepresentArgs;
use outputs::Output;
use windows::WindowReader;

use crate::progress::say;

/// Runs `evpose represent`.
pub fn run(args: &RepresentArgs) -> Result<()> {
    // Before the recording is read, which may take minutes.
    outputs::check(args)?;
    if let Some(checkpoint) = &args.checkpoint {
        return inputs::write(args, checkpoint);
    }
    let mut reader = WindowReader::open(args)?;
    let mut output = Output::create(args, &reader)?;
    reader.play(|k, end, planes| output.write(k, end, planes))?;
    output.finish()?;
    reader.account().print();
    let schedule = reader.schedule;
    say(format!(
        "{}: {} windows of {}, {} channels of {} rows and {} columns, {} ms every {} ms",
        args.out.display(),
        schedule.count,
        reader.choice.spec().name,
        reader.choice.channels(),
        reader.size.height,
        reader.size.width,
        schedule.length.0 as f64 * 1e-3,
        schedule.every.0 as f64 * 1e-3,
    ));
    Ok(())
}
