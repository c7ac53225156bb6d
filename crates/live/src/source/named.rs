//! Sources by the names that users give.

use std::io::{Cursor, Read};
use std::path::Path;
use std::time::Duration;

use evpose_io::aedat4::{SNIFF_BYTES, is_stream};
use evpose_io::framed::MAGIC;

use super::connection::Connection;
use super::{Replay, ReplayOptions, Source, StreamSource};
use crate::LiveError;

/// Options of a source.
#[derive(Debug, Clone, PartialEq)]
pub struct SourceOptions {
    /// Options of a recording. Of these, streams use the sensor and the camera, and standard input
    /// whether it is in real time.
    pub replay: ReplayOptions,
    /// Timeout of the connection, and then of the header of its stream.
    pub timeout: Duration,
}

impl Default for SourceOptions {
    fn default() -> Self {
        Self { replay: ReplayOptions::default(), timeout: Duration::from_secs(5) }
    }
}

/// Valid names of sources.
const RULE: &str = "FILE, tcp://HOST:PORT, - for standard input, camera or camera:TYPE";

/// Opens a source by its name:
///
/// | name | source |
/// |---|---|
/// | `FILE` | [`Replay`] of a recording of any format |
/// | `tcp://HOST:PORT` | a connection; framed or of DV, by its first bytes ([`StreamSource`]) |
/// | `-` | standard input, likewise; it waits for the pipeline unless in real time |
/// | `camera` | the first camera found; needs the Cargo feature |
/// | `camera:TYPE` | a camera by type, such as `davis346`, or by serial number |
///
/// # Errors
/// If the name is invalid, or the source cannot be opened.
pub fn open(text: &str, options: &SourceOptions) -> Result<Box<dyn Source>, LiveError> {
    if text == "-" {
        return stream(Connection::standard_input(), options);
    }
    match text.split_once(':') {
        None if text == "camera" => camera(None),
        Some(("camera", which)) => camera(Some(which)),
        Some(("tcp", rest)) if rest.starts_with("//") => {
            stream(Connection::connect(&rest[2..], options.timeout)?, options)
        }
        // Without this, a misspelt protocol would be reported as a missing file.
        Some((_, rest)) if rest.starts_with("//") => {
            Err(LiveError::Setting { setting: "the source", value: text.to_owned(), rule: RULE })
        }
        _ => Ok(Box::new(Replay::open(Path::new(text), options.replay.clone())?)),
    }
}

/// Opens a stream in the format that its first bytes identify.
fn stream(connection: Connection, options: &SourceOptions) -> Result<Box<dyn Source>, LiveError> {
    let Connection { name, mut bytes, shutdown } = connection;
    // Of a socket, the other end cannot wait.
    let is_lossless = !shutdown.is_of_socket() && !options.replay.is_real_time;
    let mut head = Vec::with_capacity(SNIFF_BYTES);
    (&mut bytes)
        .take(SNIFF_BYTES as u64)
        .read_to_end(&mut head)
        .map_err(|source| LiveError::Connection { endpoint: name.clone(), source })?;
    // Bytes that were read to find the format belong to the stream.
    let bytes = Cursor::new(head.clone()).chain(bytes);
    let open = &options.replay.open;
    let stream = match &head[..] {
        head if head.starts_with(MAGIC) => Some(StreamSource::framed(&name, bytes, open.sensor)?),
        head if is_stream(head) => Some(StreamSource::dv(&name, bytes, open)?),
        _ => None,
    };
    if let Some(stream) = stream {
        // The timeout was for the first bytes: a camera may be still for long.
        shutdown.clear_read_timeout(&name)?;
        return Ok(Box::new(stream.with(shutdown, is_lossless)));
    }
    let reason = match head.len() {
        0 => "ended before anything came".to_owned(),
        _ => format!(
            "begins with `{}`, neither as a framed stream (`EVPOSE1`) nor as one of DV (AEDAT 4.0)",
            head.escape_ascii()
        ),
    };
    Err(LiveError::Source { name, reason })
}

#[cfg(feature = "cameras")]
fn camera(which: Option<&str>) -> Result<Box<dyn Source>, LiveError> {
    Ok(Box::new(super::CameraSource::open(which)?))
}

#[cfg(not(feature = "cameras"))]
fn camera(_: Option<&str>) -> Result<Box<dyn Source>, LiveError> {
    Err(LiveError::Source {
        name: "camera".to_owned(),
        reason: "cameras are not in this build: build it with `--features live`".to_owned(),
    })
}
