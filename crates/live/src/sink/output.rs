//! Destinations of lines of poses.

use std::io::{self, BufWriter, Write};
use std::net::TcpStream;
use std::path::Path;

use evpose_core::AtomicFile;

use crate::LiveError;

/// A stream of lines, or a file that has its name when it ends.
pub(super) enum Output {
    Stream(Box<dyn Write + Send>),
    File(AtomicFile),
}

impl Output {
    /// Opens `-` for standard output, `tcp://HOST:PORT`, or a file.
    pub(super) fn open(place: &Path) -> Result<Self, LiveError> {
        let open = || match place.to_str() {
            Some("-") => Ok(Self::Stream(Box::new(BufWriter::new(io::stdout())))),
            Some(text) if text.starts_with("tcp://") => {
                let socket = TcpStream::connect(&text["tcp://".len()..])?;
                // A pose is of use at once or not at all.
                socket.set_nodelay(true)?;
                Ok(Self::Stream(Box::new(BufWriter::new(socket))))
            }
            _ => AtomicFile::create(place).map(Self::File),
        };
        open().map_err(|source| LiveError::Sink { sink: place.display().to_string(), source })
    }

    /// Writes what is buffered and gives a file its name.
    pub(super) fn end(&mut self) -> io::Result<()> {
        match std::mem::replace(self, Self::Stream(Box::new(io::sink()))) {
            Self::Stream(mut stream) => stream.flush(),
            Self::File(file) => file.commit(),
        }
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Stream(stream) => stream.write(bytes),
            Self::File(file) => file.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Stream(stream) => stream.flush(),
            Self::File(file) => file.flush(),
        }
    }
}
