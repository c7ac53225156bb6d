//! A connected client: a thread that answers its request, and streams frames to a WebSocket.

use std::io;
use std::net::{Shutdown, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use tungstenite::handshake::server::{Request, create_response, write_response};
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Bytes, Error, Message, Utf8Bytes, WebSocket};

use super::request::{Status, answer, field, read};
use super::{MAX_WATCHERS, Shared, lock, origin};

/// Write timeout, after which a client is disconnected.
const WRITE_TIMEOUT: Duration = Duration::from_secs(3);

/// Time that every client has for the head of its request; then it gives way to others that wait for a connection.
const HEAD_TIME: Duration = Duration::from_millis(500);

/// Bounds of incoming messages, in one poll and in bytes: the page itself sends none.
const MAX_MESSAGES: usize = 8;
const MAX_MESSAGE_BYTES: usize = 4_096;

/// A frame; its buffers are shared by all clients.
#[derive(Clone)]
pub(super) struct Frame {
    pub(super) event_image: Bytes,
    pub(super) text: Utf8Bytes,
}

/// The newest frame that its client has not read.
#[derive(Default)]
struct Mailbox {
    slot: Mutex<Slot>,
    changed: Condvar,
}

#[derive(Default)]
struct Slot {
    frame: Option<Frame>,
    is_over: bool,
}

impl Mailbox {
    fn replace(&self, frame: Frame) {
        lock(&self.slot).frame = Some(frame);
        self.changed.notify_one();
    }

    fn close(&self) {
        lock(&self.slot).is_over = true;
        self.changed.notify_one();
    }

    /// Waits for a frame. None after [`Self::close`].
    fn fetch(&self) -> Option<Frame> {
        let mut slot = self
            .changed
            .wait_while(lock(&self.slot), |slot| slot.frame.is_none() && !slot.is_over)
            .unwrap_or_else(PoisonError::into_inner);
        if slot.is_over { None } else { slot.frame.take() }
    }
}

/// A connection and its thread.
pub(super) struct Client {
    mailbox: Arc<Mailbox>,
    stream: TcpStream,
    thread: JoinHandle<()>,
    began: Instant,
    /// Whether the head of its request has come.
    has_asked: Arc<AtomicBool>,
}

impl Client {
    pub(super) fn start(stream: TcpStream, shared: Arc<Shared>) -> io::Result<Self> {
        // On some systems an accepted socket inherits the listener's mode, which is not to block.
        stream.set_nonblocking(false)?;
        // Nagle's algorithm would hold the tail of a frame until the client acknowledges the rest.
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(WRITE_TIMEOUT))?;
        let mailbox = Arc::new(Mailbox::default());
        let (own, theirs) = (stream.try_clone()?, mailbox.clone());
        let has_asked = Arc::new(AtomicBool::new(false));
        let asked = has_asked.clone();
        let thread = std::thread::Builder::new()
            .name("page client".to_owned())
            // Errors of a connection concern its client only.
            .spawn(move || drop(serve(own, &theirs, &shared, &asked)))?;
        Ok(Self { mailbox, stream, thread, began: Instant::now(), has_asked })
    }

    pub(super) fn send(&self, frame: Frame) {
        self.mailbox.replace(frame);
    }

    pub(super) fn is_finished(&self) -> bool {
        self.thread.is_finished()
    }

    /// Whether it has asked for nothing for so long that another may have its place.
    pub(super) fn gives_way(&self) -> bool {
        !self.has_asked.load(Ordering::Relaxed) && self.began.elapsed() > HEAD_TIME
    }

    /// Ends the thread, whatever it waits for.
    pub(super) fn end(self) {
        self.mailbox.close();
        let _ = self.stream.shutdown(Shutdown::Both);
        let _ = self.thread.join();
    }
}

fn serve(
    mut stream: TcpStream,
    mailbox: &Mailbox,
    shared: &Shared,
    has_asked: &AtomicBool,
) -> Result<(), Error> {
    let request = match read(&mut stream) {
        Ok(request) => request,
        Err(status) => return Ok(status.map_or(Ok(()), |status| answer(&mut stream, status))?),
    };
    // The painter evicts clients that have not asked yet, and this one has.
    has_asked.store(true, Ordering::Relaxed);
    // Foreign pages are refused before anything else, whatever they ask for.
    let status = match (refusal(&request, shared), request.uri().path()) {
        (Some(status), _) => status,
        (None, "/") => Status::Page,
        (None, "/ws") => match (create_response(&request), Watcher::new(&shared.watchers)) {
            // Counted as a watcher until the connection ends, however it does.
            (Ok(response), Some(_watcher)) => {
                write_response(&mut stream, &response)?;
                return send_frames(stream, mailbox, shared);
            }
            (Err(_), _) => Status::BadRequest,
            (_, None) => Status::Busy,
        },
        (None, _) => Status::NotFound,
    };
    Ok(answer(&mut stream, status)?)
}

/// The status that refuses a request, if it is not allowed.
fn refusal(request: &Request, shared: &Shared) -> Option<Status> {
    let Some(host) = field(request, "host") else { return Some(Status::BadRequest) };
    let is_single = request.headers().get_all("host").iter().count() == 1;
    let Some(name) = origin::name_of(host).filter(|_| is_single) else {
        return Some(Status::BadRequest);
    };
    // A header that is not text becomes an empty origin, which is refused.
    let origin = request.headers().contains_key("origin");
    let origin = origin.then(|| field(request, "origin").unwrap_or_default());
    let is_known = origin::is_known(&name, shared.is_local, &shared.hosts);
    let is_welcome = origin::is_ours(host, origin) && is_known;
    (!is_welcome).then_some(Status::Forbidden)
}

/// A counted watcher, until this is dropped.
struct Watcher<'a>(&'a AtomicUsize);

impl<'a> Watcher<'a> {
    /// Counts a watcher; none at [`MAX_WATCHERS`].
    fn new(count: &'a AtomicUsize) -> Option<Self> {
        let more = |watchers| (watchers < MAX_WATCHERS).then_some(watchers + 1);
        let added = count.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more);
        // Built only when it is granted: dropped, it would give back what nobody took.
        added.is_ok().then(|| Self(count))
    }
}

impl Drop for Watcher<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

fn send_frames(stream: TcpStream, mailbox: &Mailbox, shared: &Shared) -> Result<(), Error> {
    let config = WebSocketConfig::default()
        .read_buffer_size(MAX_MESSAGE_BYTES)
        .max_message_size(Some(MAX_MESSAGE_BYTES))
        .max_frame_size(Some(MAX_MESSAGE_BYTES));
    let mut socket = WebSocket::from_raw_socket(stream, Role::Server, Some(config));
    let about = shared.about.with(&lock(&shared.history));
    socket.send(Message::text(about))?;
    while let Some(frame) = mailbox.fetch() {
        // Only the second message flushes: both parts of a frame leave together.
        socket.write(Message::Binary(frame.event_image))?;
        socket.send(Message::Text(frame.text))?;
        // Browsers send pings and their wish to close: unread, they would fill the connection.
        read_incoming(&mut socket)?;
    }
    Ok(())
}

/// Handles messages from the client: close and ping.
fn read_incoming(socket: &mut WebSocket<TcpStream>) -> Result<(), Error> {
    socket.get_ref().set_nonblocking(true)?;
    let mut result = Ok(());
    // A client that sends without end must not keep its own frames from being sent.
    for _ in 0..MAX_MESSAGES {
        match socket.read() {
            Ok(Message::Close(_)) => result = Err(Error::ConnectionClosed),
            Ok(_) => continue,
            Err(Error::Io(error)) if error.kind() == io::ErrorKind::WouldBlock => {}
            Err(error) => result = Err(error),
        }
        break;
    }
    socket.get_ref().set_nonblocking(false)?;
    if result.is_err() {
        // Completes the closing handshake.
        let _ = socket.flush();
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(number: u8) -> Frame {
        Frame { event_image: vec![number].into(), text: Utf8Bytes::default() }
    }

    #[test]
    fn the_newest_frame_wins_and_none_is_given_twice() {
        let mailbox = Mailbox::default();
        (1..=3).for_each(|number| mailbox.replace(frame(number)));
        assert_eq!(mailbox.fetch().map(|frame| frame.event_image[0]), Some(3));
        assert!(lock(&mailbox.slot).frame.is_none());
        mailbox.replace(frame(4));
        mailbox.close();
        assert!(mailbox.fetch().is_none(), "a closed mailbox drops its frame");
    }
}
