//! Byte streams: a TCP connection, or standard input.

use std::io::{self, ErrorKind, Read};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::time::Duration;

use crate::LiveError;

/// A byte stream.
pub(super) struct Connection {
    pub(super) name: String,
    pub(super) bytes: Box<dyn Read + Send>,
    pub(super) shutdown: ShutdownHandle,
}

#[derive(Default)]
pub(super) struct ShutdownHandle(Option<TcpStream>);

impl Connection {
    pub(super) fn standard_input() -> Self {
        let bytes = Box::new(io::stdin());
        Self { name: "standard input".to_owned(), bytes, shutdown: ShutdownHandle(None) }
    }

    /// Connects to `HOST:PORT`. Until [`ShutdownHandle::clear_read_timeout`], reads time out as the
    /// connection does.
    pub(super) fn connect(address: &str, timeout: Duration) -> Result<Self, LiveError> {
        let name = format!("tcp://{address}");
        let failed = |source| LiveError::Connection { endpoint: name.clone(), source };
        let mut failure = io::Error::new(ErrorKind::NotFound, "the host has no address");
        // A name may have several addresses, of which a host often serves only one: IPv6 before
        // IPv4.
        for place in address.to_socket_addrs().map_err(failed)? {
            match TcpStream::connect_timeout(&place, timeout) {
                Ok(socket) => {
                    let prepared = socket
                        .set_nodelay(true)
                        .and_then(|()| socket.set_read_timeout(Some(timeout)))
                        .and_then(|()| socket.try_clone());
                    let shutdown = ShutdownHandle(Some(prepared.map_err(failed)?));
                    return Ok(Self {
                        name,
                        bytes: Box::new(Socket { socket, timeout }),
                        shutdown,
                    });
                }
                Err(error) => failure = error,
            }
        }
        Err(failed(failure))
    }
}

impl ShutdownHandle {
    /// Whether the stream is a socket.
    pub(super) fn is_of_socket(&self) -> bool {
        self.0.is_some()
    }

    /// Lets reads block without a timeout; `name` identifies the stream in errors.
    pub(super) fn clear_read_timeout(&self, name: &str) -> Result<(), LiveError> {
        let set = self.0.as_ref().map_or(Ok(()), |socket| socket.set_read_timeout(None));
        set.map_err(|source| LiveError::Connection { endpoint: name.to_owned(), source })
    }

    /// A function that ends the connection, and with it a blocked read.
    pub(super) fn waker(&self) -> Option<Box<dyn Fn() + Send + Sync>> {
        let socket = self.0.as_ref()?.try_clone().ok()?;
        Some(Box::new(move || {
            // It may have ended already.
            let _ = socket.shutdown(Shutdown::Both);
        }))
    }
}

/// A connection whose timeouts have a clear message.
struct Socket {
    socket: TcpStream,
    timeout: Duration,
}

impl Read for Socket {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.socket.read(out).map_err(|error| match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                let silence = format!("nothing came for {:.1} s", self.timeout.as_secs_f64());
                io::Error::new(ErrorKind::TimedOut, silence)
            }
            _ => error,
        })
    }
}
