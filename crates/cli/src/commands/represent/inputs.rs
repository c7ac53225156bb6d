//! The inputs of a network, for its exported file.

use std::path::Path;

use anyhow::{Result, ensure};
use evpose_io::tensors::TensorWriter;
use evpose_nn::DeviceKind;

use super::RepresentArgs;
use crate::args::DeviceArgs;
use crate::progress::{note, say};
use crate::tasks::open;

/// Writes the network's input for each pose of `evpose infer`, with its time stamp in archives.
pub(super) fn write(args: &RepresentArgs, checkpoint: &Path) -> Result<()> {
    let model = open(checkpoint, &DeviceArgs { device: DeviceKind::Flex, threads: None })?;
    let network = model.network()?;
    let recording = &args.recording.input;
    let opening = args.recording.opening.options_with_sensor(recording)?;
    let every_ms = args.every_ms.map(whole_ms).transpose()?;
    // Before the recording is gone through, which may take minutes.
    let ending = args.out.extension().and_then(|ending| ending.to_str()).unwrap_or_default();
    ensure!(
        ["npy", "npz"].contains(&ending),
        "{}: inputs of a network are written to .npy or .npz",
        args.out.display()
    );
    // The header of an array comes first and has their count.
    let mut count = 0;
    let warnings = network.for_each_input(recording, every_ms, &opening, &mut |_, _| {
        count += 1;
        Ok(())
    })?;
    for warning in warnings {
        note(format!("warning: {}: {warning}", recording.display()));
    }
    ensure!(count > 0, "{}: too few events for an input", recording.display());
    let [channels, rows, columns] = network.input_shape().map(|side| side as u64);
    let mut writer = TensorWriter::create(&args.out, [count, channels, rows, columns])?;
    network.for_each_input(recording, every_ms, &opening, &mut |t, input| {
        Ok(writer.write(t, input)?)
    })?;
    writer.finish()?;
    say(format!(
        "{}: {count} inputs of {}, {channels} channels of {rows} rows and {columns} columns",
        args.out.display(),
        network.network_name(),
    ));
    Ok(())
}

/// Milliseconds between poses, which are whole.
fn whole_ms(ms: f64) -> Result<u32> {
    ensure!(
        (1.0..=1e6).contains(&ms) && ms.fract() == 0.0,
        "--every-ms {ms}: with --checkpoint a whole number of milliseconds, from 1 to 1000000"
    );
    Ok(ms as u32)
}
