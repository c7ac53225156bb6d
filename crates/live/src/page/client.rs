//! One who connects: a thread that answers, and if it is asked to, tells every frame.

use std::io;
use std::net::{Shutdown, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::Duration;

use tungstenite::handshake::server::{Request, create_response, write_response};
use tungstenite::protocol::{Role, WebSocketConfig};
use tungstenite::{Bytes, Error, Message, Utf8Bytes, WebSocket};

use super::request::{Status, answer, field, read};
use super::{MOST_WATCHERS, Shared, lock, origin};

/// A client that fetches nothing for so long is left.
const PATIENCE: Duration = Duration::from_secs(3);

/// The page has nothing to say; what others may send, at once and in one message.
const MOST_MESSAGES: usize = 8;
const MOST_BYTES: usize = 4_096;

/// What is shown at a moment; all clients are given the same memory.
#[derive(Clone)]
pub(super) struct Frame {
    pub(super) picture: Bytes,
    pub(super) words: Utf8Bytes,
}

/// Where a frame waits for its client.
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
    /// Replaces what was not fetched.
    fn put(&self, frame: Frame) {
        lock(&self.slot).frame = Some(frame);
        self.changed.notify_one();
    }

    fn close(&self) {
        lock(&self.slot).is_over = true;
        self.changed.notify_one();
    }

    /// Waits for a frame; none when there will be no more.
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
}

impl Client {
    pub(super) fn start(stream: TcpStream, shared: Arc<Shared>) -> io::Result<Self> {
        stream.set_nonblocking(false)?;
        stream.set_nodelay(true)?;
        stream.set_write_timeout(Some(PATIENCE))?;
        let mailbox = Arc::new(Mailbox::default());
        let (own, theirs) = (stream.try_clone()?, mailbox.clone());
        let thread = std::thread::Builder::new()
            .name("page client".to_owned())
            // How it ends concerns nobody else.
            .spawn(move || drop(serve(own, &theirs, &shared)))?;
        Ok(Self { mailbox, stream, thread })
    }

    pub(super) fn give(&self, frame: Frame) {
        self.mailbox.put(frame);
    }

    pub(super) fn is_gone(&self) -> bool {
        self.thread.is_finished()
    }

    /// Ends it, whatever it waits for.
    pub(super) fn end(self) {
        self.mailbox.close();
        let _ = self.stream.shutdown(Shutdown::Both);
        let _ = self.thread.join();
    }
}

fn serve(mut stream: TcpStream, mailbox: &Mailbox, shared: &Shared) -> Result<(), Error> {
    let request = match read(&mut stream) {
        Ok(request) => request,
        Err(status) => return Ok(status.map_or(Ok(()), |status| answer(&mut stream, status))?),
    };
    let status = match (judge(&request, shared.is_local), request.uri().path()) {
        (Some(status), _) => status,
        (None, "/") => Status::Page,
        (None, "/ws") => match (create_response(&request), Watcher::new(&shared.watchers)) {
            (Ok(response), Some(_watcher)) => {
                write_response(&mut stream, &response)?;
                return tell(stream, mailbox, shared);
            }
            (Err(_), _) => Status::BadRequest,
            (_, None) => Status::Busy,
        },
        (None, _) => Status::NotFound,
    };
    Ok(answer(&mut stream, status)?)
}

/// What is wrong with who asks.
fn judge(request: &Request, is_local: bool) -> Option<Status> {
    let Some(host) = field(request, "host") else { return Some(Status::BadRequest) };
    // An origin that is no text is not ours.
    let origin = request.headers().contains_key("origin");
    let origin = origin.then(|| field(request, "origin").unwrap_or_default());
    let is_welcome = origin::is_ours(host, origin) && (!is_local || origin::is_this_machine(host));
    (!is_welcome).then_some(Status::Forbidden)
}

/// Somebody who is counted as long as this lives.
struct Watcher<'a>(&'a AtomicUsize);

impl<'a> Watcher<'a> {
    /// None if there are enough.
    fn new(count: &'a AtomicUsize) -> Option<Self> {
        let more = |watchers| (watchers < MOST_WATCHERS).then_some(watchers + 1);
        let added = count.fetch_update(Ordering::Relaxed, Ordering::Relaxed, more);
        added.is_ok().then_some(Self(count))
    }
}

impl Drop for Watcher<'_> {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::Relaxed);
    }
}

fn tell(stream: TcpStream, mailbox: &Mailbox, shared: &Shared) -> Result<(), Error> {
    let config = WebSocketConfig::default()
        .read_buffer_size(MOST_BYTES)
        .max_message_size(Some(MOST_BYTES))
        .max_frame_size(Some(MOST_BYTES));
    let mut socket = WebSocket::from_raw_socket(stream, Role::Server, Some(config));
    let about = shared.about.with(&lock(&shared.history));
    socket.send(Message::text(about))?;
    while let Some(frame) = mailbox.fetch() {
        socket.write(Message::Binary(frame.picture))?;
        socket.send(Message::Text(frame.words))?;
        listen(&mut socket)?;
    }
    Ok(())
}

/// Takes what the client sent meanwhile: that it closes, or a question whether we live.
fn listen(socket: &mut WebSocket<TcpStream>) -> Result<(), Error> {
    socket.get_ref().set_nonblocking(true)?;
    let mut heard = Ok(());
    for _ in 0..MOST_MESSAGES {
        match socket.read() {
            Ok(Message::Close(_)) => heard = Err(Error::ConnectionClosed),
            Ok(_) => continue,
            Err(Error::Io(error)) if error.kind() == io::ErrorKind::WouldBlock => {}
            Err(error) => heard = Err(error),
        }
        break;
    }
    socket.get_ref().set_nonblocking(false)?;
    if heard.is_err() {
        // The answer to its farewell, if it waits for one.
        let _ = socket.flush();
    }
    heard
}

#[cfg(test)]
mod tests {
    use super::*;

    fn frame(number: u8) -> Frame {
        Frame { picture: vec![number].into(), words: Utf8Bytes::default() }
    }

    #[test]
    fn the_newest_frame_wins_and_none_is_given_twice() {
        let mailbox = Mailbox::default();
        (1..=3).for_each(|number| mailbox.put(frame(number)));
        assert_eq!(mailbox.fetch().map(|frame| frame.picture[0]), Some(3));
        assert!(lock(&mailbox.slot).frame.is_none());
        mailbox.put(frame(4));
        mailbox.close();
        assert!(mailbox.fetch().is_none(), "at the end nobody waits for the rest");
    }
}
