//! Sources as users name them.

use std::io::{Cursor, Read};
use std::path::Path;
use std::time::Duration;

use evpose_io::aedat4::{TELLING, is_stream};
use evpose_io::framed::MAGIC;

use super::wire::Wire;
use super::{Dv, Framed, Replay, ReplayOptions, Source};
use crate::LiveError;

/// How a source is opened.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceOptions {
    /// How a recording is played. Streams heed its sensor and its camera.
    pub replay: ReplayOptions,
    /// How long a connection is waited for, and then the header of what it sends.
    pub patience: Duration,
}

impl Default for SourceOptions {
    fn default() -> Self {
        Self { replay: ReplayOptions::default(), patience: Duration::from_secs(5) }
    }
}

/// What names a source.
const RULE: &str = "FILE, tcp://HOST:PORT, - for standard input, camera or camera:TYPE";

/// Opens what `text` names:
///
/// | text | source |
/// |---|---|
/// | `FILE` | [`Replay`] of a recording of any format |
/// | `tcp://HOST:PORT` | connects; [`Framed`] or [`Dv`], by what comes first |
/// | `-` | standard input, likewise |
/// | `camera` | the first camera that is found; needs the Cargo feature |
/// | `camera:TYPE` | one of a type, such as `davis346`, or of a serial number |
///
/// # Errors
/// If the text names none, or the source cannot be opened.
pub fn open(text: &str, options: &SourceOptions) -> Result<Box<dyn Source>, LiveError> {
    if text == "-" {
        return stream(Wire::standard_input(), options);
    }
    match text.split_once(':') {
        None if text == "camera" => camera(None),
        Some(("camera", which)) => camera(Some(which)),
        Some(("tcp", rest)) if rest.starts_with("//") => {
            stream(Wire::connect(&rest[2..], options.patience)?, options)
        }
        Some((_, rest)) if rest.starts_with("//") => {
            Err(LiveError::Setting { what: "the source", value: text.to_owned(), rule: RULE })
        }
        _ => Ok(Box::new(Replay::open(Path::new(text), options.replay.clone())?)),
    }
}

/// A stream, by how it begins.
fn stream(wire: Wire, options: &SourceOptions) -> Result<Box<dyn Source>, LiveError> {
    let Wire { name, mut bytes, hook } = wire;
    let mut head = Vec::with_capacity(TELLING);
    (&mut bytes)
        .take(TELLING as u64)
        .read_to_end(&mut head)
        .map_err(|source| LiveError::Connection { what: name.clone(), source })?;
    let bytes = Cursor::new(head.clone()).chain(bytes);
    let open = &options.replay.open;
    if head.starts_with(MAGIC) {
        let stream = Framed::open(&name, bytes)?.of_sensor(open.sensor);
        hook.be_patient(&name)?;
        return Ok(Box::new(stream.hooked(hook)));
    }
    if is_stream(&head) {
        let stream = Dv::open(&name, bytes, open)?;
        hook.be_patient(&name)?;
        return Ok(Box::new(stream.hooked(hook)));
    }
    let reason = match head.len() {
        0 => "ended before anything came".to_owned(),
        _ => format!(
            "begins with `{}`, neither as a framed stream (`EVPOSE1`) nor as one of DV (AEDAT 4.0)",
            head.escape_ascii()
        ),
    };
    Err(LiveError::Source { what: name, reason })
}

#[cfg(feature = "cameras")]
fn camera(which: Option<&str>) -> Result<Box<dyn Source>, LiveError> {
    Ok(Box::new(super::Camera::open(which)?))
}

#[cfg(not(feature = "cameras"))]
fn camera(_: Option<&str>) -> Result<Box<dyn Source>, LiveError> {
    Err(LiveError::Source {
        what: "camera".to_owned(),
        reason: "cameras are not in this build: build it with `--features live`".to_owned(),
    })
}
