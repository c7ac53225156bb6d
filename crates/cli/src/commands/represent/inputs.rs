//! The inputs of a network, for its exported file.

use std::path::Path;

use anyhow::{Result, ensure};
use evpose_io::tensors::TensorWriter;
use evpose_nn::DeviceKind;

use super::RepresentArgs;
use crate::args::DeviceArgs;
use crate::progress::say;
use crate::tasks::open;

/// Writes the network's input for each pose of `evpose infer`, with its time stamp in archives.
pub(super) fn write(args: &RepresentArgs, checkpoint: &Path) -> Result<()> {
    let model = open(checkpoint, &DeviceArgs { device: DeviceKind::Flex, threads: None })?;
    let network = model.network()?;
    let recording = &args.recording.input;
    let opening = args.recording.opening.options_with_sensor(recording)?;
    let every_ms = args.every_ms.map(|ms| ms.round().max(1.0) as u32);
    // The header of an array comes first and has their count.
    let mut count = 0;
    network.for_each_input(recording, every_ms, &opening, &mut |_, _| {
        count += 1;
        Ok(())
    })?;
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
