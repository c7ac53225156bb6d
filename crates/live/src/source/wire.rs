//! Where the bytes of a stream come from: a connection, or standard input.

use std::io::{self, ErrorKind, Read};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::time::Duration;

use crate::LiveError;

/// Bytes that come as somebody sends them.
pub(super) struct Wire {
    /// What it is, for messages.
    pub(super) name: String,
    pub(super) bytes: Box<dyn Read + Send>,
    pub(super) hook: Hook,
}

/// A hold on a connection whose bytes somebody waits for.
#[derive(Default)]
pub(super) struct Hook(Option<TcpStream>);

impl Wire {
    /// Standard input.
    pub(super) fn standard_input() -> Self {
        let bytes = Box::new(io::stdin());
        Self { name: "standard input".to_owned(), bytes, hook: Hook(None) }
    }

    /// Connects to `HOST:PORT`. Until [`Hook::be_patient`], bytes are waited for no longer than for the
    /// connection.
    pub(super) fn connect(address: &str, patience: Duration) -> Result<Self, LiveError> {
        let name = format!("tcp://{address}");
        let failed = |source| LiveError::Connection { what: name.clone(), source };
        let mut failure = io::Error::new(ErrorKind::NotFound, "the host has no address");
        for place in address.to_socket_addrs().map_err(failed)? {
            match TcpStream::connect_timeout(&place, patience) {
                Ok(socket) => {
                    let prepared = socket
                        .set_nodelay(true)
                        .and_then(|()| socket.set_read_timeout(Some(patience)))
                        .and_then(|()| socket.try_clone());
                    let hook = Hook(Some(prepared.map_err(failed)?));
                    return Ok(Self { name, bytes: Box::new(Socket { socket, patience }), hook });
                }
                Err(error) => failure = error,
            }
        }
        Err(failed(failure))
    }
}

impl Hook {
    /// From now on, bytes of `name` are waited for as long as it takes.
    pub(super) fn be_patient(&self, name: &str) -> Result<(), LiveError> {
        let set = self.0.as_ref().map_or(Ok(()), |socket| socket.set_read_timeout(None));
        set.map_err(|source| LiveError::Connection { what: name.to_owned(), source })
    }

    /// Has the connection end, and with it whoever waits for its bytes.
    pub(super) fn waker(&self) -> Option<Box<dyn Fn() + Send + Sync>> {
        let socket = self.0.as_ref()?.try_clone().ok()?;
        Some(Box::new(move || {
            // It may have ended already.
            let _ = socket.shutdown(Shutdown::Both);
        }))
    }
}

/// A connection whose silence is told as such.
struct Socket {
    socket: TcpStream,
    patience: Duration,
}

impl Read for Socket {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        self.socket.read(out).map_err(|error| match error.kind() {
            ErrorKind::WouldBlock | ErrorKind::TimedOut => {
                let silence = format!("nothing came for {:.1} s", self.patience.as_secs_f64());
                io::Error::new(ErrorKind::TimedOut, silence)
            }
            _ => error,
        })
    }
}
