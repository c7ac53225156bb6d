//! A case as the files of a measurement: recordings, frames and descriptions, no label.

use std::io::Write as _;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result};
use evpose_core::{AtomicFile, Event, EventStream, Micros, Polarity, SensorSize, atomic_write};
use evpose_io::format_for;
use gapbench_pixel::{Case, FPS, FRAMES, Which};

/// Folder of the files of cases, a folder a case.
pub(super) const FOLDER: &str = "cases";
/// The two recordings of a case, and their folders.
const PARTS: [(Which, &str); 2] = [(Which::Train, "train"), (Which::Validation, "validation")];

pub(super) fn part(folder: &Path, i: usize) -> (PathBuf, PathBuf) {
    let dir = folder.join(PARTS[i].1);
    (dir.join("measured.npz"), dir)
}

pub(super) fn write(folder: &Path, case: &Case) -> Result<()> {
    for (i, (which, _)) in PARTS.into_iter().enumerate() {
        let (measured, dir) = part(folder, i);
        std::fs::create_dir_all(&dir).with_context(|| format!("creating {}", dir.display()))?;
        let recording = case.record(which);
        let size = SensorSize { width: recording.width as u16, height: recording.height as u16 };
        let events = recording.events.iter().map(|event| Event {
            t: Micros(event.t_us as i64),
            x: event.x,
            y: event.y,
            polarity: Polarity::from_on(event.on),
        });
        let events = EventStream::from_events(size, events)?;
        format_for(&measured)?.write(&measured, &events)?;
        let json = dir.join("scene.json");
        atomic_write(&json, case.scene_json(which).as_bytes())
            .with_context(|| format!("writing {}", json.display()))?;
        let frames = dir.join("frames.npy");
        write_frames(&frames, case, which, size)
            .with_context(|| format!("writing {}", frames.display()))?;
    }
    Ok(())
}

/// An array (frames, height, width) of little-endian `f4`.
fn write_frames(path: &Path, case: &Case, which: Which, size: SensorSize) -> std::io::Result<()> {
    let shape = format!("({FRAMES}, {}, {})", size.height, size.width);
    let header = format!("{{'descr': '<f4', 'fortran_order': False, 'shape': {shape}, }}");
    let mut file = AtomicFile::create(path)?;
    // Version 1.0, then the size of the header, 118 bytes: 10 and 118 are 128, a multiple of 64.
    file.write_all(b"\x93NUMPY\x01\x00\x76\x00")?;
    // Filled up with spaces before the line break, as NumPy does.
    file.write_all(format!("{header:<117}\n").as_bytes())?;
    let scene = case.scene(which);
    let mut bytes = Vec::new();
    for k in 0..FRAMES {
        bytes.clear();
        bytes.extend(scene.frame(k, FPS).iter().flat_map(|light| light.to_le_bytes()));
        file.write_all(&bytes)?;
    }
    file.commit()
}
