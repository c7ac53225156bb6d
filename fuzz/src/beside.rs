//! Files beside recordings: labels, skeletons, frames, settings; and sequences by random access.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;
use std::{env, fs, process};

use evpose_camera::CameraFile;
use evpose_clean::Mask;
use evpose_core::{Plane, SensorSize};
use evpose_io::yarp::read_skeletons_from;
use evpose_io::{Encoding, EvcReader, EvcWindow, FrameSource, Input, IoError, MetaReader};

use crate::check;

/// An image of no more pixels than this is converted; larger ones are only opened.
const PIXELS: usize = 1 << 20;

/// Some readers open files themselves. This is one with `bytes` in it, the same in every execution,
/// in a folder of its own: keep `TMPDIR` in memory.
fn file(name: &str, bytes: &[u8]) -> PathBuf {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    let folder = FOLDER.get_or_init(|| {
        let folder = env::temp_dir().join(format!("evpose-fuzz-{}", process::id()));
        fs::create_dir_all(&folder).expect("a folder for temporary files");
        folder
    });
    let path = folder.join(name);
    fs::write(&path, bytes).expect("room for a temporary file");
    path
}

/// Reads a `.evc` file by random access, frame by frame and as a stream.
///
/// # Panics
/// If frames that were accepted cannot be read, or hold other events than were counted.
pub fn evc_frames(bytes: &[u8]) {
    let path = file("sequence.evc", bytes);
    let sensor = SensorSize { width: u16::MAX, height: 256 };
    let (reader, fault) = EvcReader::open_prefix(&path, sensor).expect("a file that is there");
    if let Some(fault) = &fault {
        check(fault, bytes.len());
        if let IoError::Evc { frames, events, .. } = fault {
            assert_eq!((*frames, *events), (reader.frames(), reader.events()), "{fault}");
        }
    }
    let stream = reader.read_stream(0..reader.frames()).expect("frames that were accepted");
    assert_eq!(stream.len() as u64, reader.events());
    let (mut window, mut events) = (EvcWindow::new(), 0);
    for frame in 0..reader.frames() {
        reader.read_frames(frame..frame + 1, &mut window).expect("a frame that was accepted");
        events += window.records().len() as u64 - 1;
    }
    assert_eq!(events, reader.events());
}

/// Reads labels.
///
/// # Panics
/// If a fault has no place in the file.
pub fn meta(bytes: &[u8]) {
    let path = file("sequence.meta", bytes);
    let reader = match MetaReader::open_prefix(&path) {
        Ok((reader, fault)) => {
            fault.iter().for_each(|fault| check(fault, bytes.len()));
            reader
        }
        Err(error) => return check(&error, bytes.len()),
    };
    let mut values = Vec::new();
    for record in 0..reader.records() {
        match reader.read_record(record, &mut values) {
            Ok(()) => assert_eq!(values.len(), reader.values()),
            Err(error) => check(&error, bytes.len()),
        }
        if let Err(error) = reader.read_hand(record) {
            check(&error, bytes.len());
        }
    }
    let _ = reader.read_hands(0..reader.records());
}

/// Reads the skeletons of a YARP log.
///
/// # Panics
/// If a fault has no place in the file.
pub fn skeletons(bytes: &[u8]) {
    match read_skeletons_from(Input::memory("data.log", bytes.to_vec())) {
        // The shortest of them has 26 values.
        Ok(skeletons) => assert!(skeletons.len() <= bytes.len() / 52),
        Err(error) => check(&error, bytes.len()),
    }
}

/// Reads an array of frames.
pub fn npy(bytes: &[u8]) {
    frames(&file("frames.npy", bytes));
}

/// Reads a folder of one image.
pub fn png(bytes: &[u8]) {
    let path = file("0.png", bytes);
    frames(path.parent().expect("the folder of a file"));
}

fn frames(path: &Path) {
    for encoding in [Encoding::Linear, Encoding::Srgb] {
        let Ok(mut source) = FrameSource::open(path, encoding, None) else { return };
        if source.size().pixels() > PIXELS {
            return;
        }
        let mut frame = Plane::for_sensor(source.size(), 0.0);
        let mut count = 0;
        while matches!(source.next_into(&mut frame), Ok(true)) {
            count += 1;
        }
        assert_eq!(count, source.frames(), "frames that were there");
    }
}

/// Reads the settings of a camera and a mask.
///
/// # Panics
/// If what was accepted cannot be used.
pub fn settings(bytes: &[u8]) {
    let path = file("settings.toml", bytes);
    if let Ok(camera) = CameraFile::load(&path) {
        camera.camera().expect("a camera that was accepted");
    }
    let sensor = SensorSize { width: 9, height: 7 };
    if let Ok(mask) = Mask::load(&path, sensor) {
        let flags = mask.flags();
        assert_eq!(flags.len(), sensor.pixels());
        assert!(mask.pixels.iter().all(|&(x, y)| flags[usize::from(y) * 9 + usize::from(x)]));
    }
}
