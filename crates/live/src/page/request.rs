//! HTTP requests, and the responses other than a WebSocket.

use std::io::{self, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

use tungstenite::handshake::machine::TryParse;
use tungstenite::handshake::server::Request;

/// Upper bound of the head of a request.
const MAX_HEAD_BYTES: usize = 16 * 1024;

/// Timeout of the head of a request.
const READ_TIMEOUT: Duration = Duration::from_secs(2);

/// The page, with its style and scripts inline: nothing is fetched from other hosts.
const PAGE: &str = concat!(
    include_str!("web/head.html"),
    "<style>\n",
    include_str!("web/page.css"),
    "</style>\n",
    include_str!("web/body.html"),
    "<script>\n'use strict';\n",
    include_str!("web/scene.js"),
    include_str!("web/plot.js"),
    include_str!("web/figures.js"),
    include_str!("web/connection.js"),
    "</script>\n",
);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Status {
    Page,
    BadRequest,
    Forbidden,
    NotFound,
    NotAllowed,
    Busy,
}

/// Reads the head of a request. The error is the status to respond with, or none if the client has
/// left.
pub(super) fn read(stream: &mut TcpStream) -> Result<Request, Option<Status>> {
    let end = Instant::now() + READ_TIMEOUT;
    let (mut head, mut chunk) = (Vec::new(), [0; 1024]);
    loop {
        // A client that sends byte by byte has no more time than others.
        let left = end.saturating_duration_since(Instant::now());
        if left.is_zero() || stream.set_read_timeout(Some(left)).is_err() {
            return Err(None);
        }
        match stream.read(&mut chunk) {
            Ok(0) => return Err(None),
            Ok(read) => head.extend_from_slice(&chunk[..read]),
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(_) => return Err(None),
        }
        match Request::try_parse(&head) {
            // Nothing may follow the head: a WebSocket client sends only after our response.
            Ok(Some((size, request))) if size == head.len() => return Ok(request),
            // The head goes on in the next part.
            Ok(None) if head.len() < MAX_HEAD_BYTES => {}
            Ok(_) => return Err(Some(Status::BadRequest)),
            Err(tungstenite::Error::Protocol(
                tungstenite::error::ProtocolError::WrongHttpMethod,
            )) => return Err(Some(Status::NotAllowed)),
            Err(_) => return Err(Some(Status::BadRequest)),
        }
    }
}

/// A header, if it is text.
pub(super) fn field<'a>(request: &'a Request, name: &str) -> Option<&'a str> {
    request.headers().get(name).and_then(|value| value.to_str().ok())
}

/// Sends a response and closes the connection.
pub(super) fn answer(stream: &mut TcpStream, status: Status) -> io::Result<()> {
    let (line, body) = match status {
        Status::Page => ("200 OK", PAGE),
        Status::BadRequest => ("400 Bad Request", "This is no request for a page.\n"),
        Status::Forbidden => (
            "403 Forbidden",
            "Pages of other sites, and names that `--host` does not state, are not answered.\n",
        ),
        Status::NotFound => ("404 Not Found", "There is only /.\n"),
        Status::NotAllowed => ("405 Method Not Allowed", "There is only GET.\n"),
        Status::Busy => ("503 Service Unavailable", "Too many are watching.\n"),
    };
    let kind = if status == Status::Page { "html" } else { "plain" };
    // The content security policy lets the browser enforce that nothing is fetched from other
    // hosts.
    let head = format!(
        "HTTP/1.1 {line}\r\nContent-Type: text/{kind}; charset=utf-8\r\nContent-Length: {}\r\n\
         Connection: close\r\nCache-Control: no-store\r\nX-Content-Type-Options: nosniff\r\n\
         Content-Security-Policy: default-src 'none'; style-src 'unsafe-inline'; \
         script-src 'unsafe-inline'; img-src data:; connect-src 'self'; base-uri 'none'; \
         form-action 'none'; frame-ancestors 'none'\r\n\r\n",
        body.len()
    );
    stream.write_all(head.as_bytes())?;
    stream.write_all(body.as_bytes())?;
    stream.shutdown(Shutdown::Write)
}
