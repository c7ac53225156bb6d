//! Events, poses and figures in a browser, live: a page that this machine serves.
//!
//! ```text
//!  eye's thread ─► PageEvents ┐
//!  sink's thread ─► PageSink  ├─► painter, 30 times a second ─► mailbox of each client ─► its thread, WebSocket
//!  everyone ─► Meter          ┘                                 (the newest frame wins)
//! ```
//!
//! * `GET /` is the page: one document, with nothing from elsewhere.
//! * `GET /ws` becomes a WebSocket. A first text says what is shown; then every frame is a binary message,
//!   the events, and a text, the poses and figures.
//!
//! What a client does holds up nobody: frames that it does not fetch in time are replaced by newer ones, and
//! one that fetches nothing for three seconds is forgotten. Without clients, events cost nothing.
//!
//! A page of another site is refused: the browser tells its origin, which must be the host that it asks. A
//! server of this machine alone answers only to names of this machine, so that no other name can be made to
//! lead here.

mod client;
mod message;
mod origin;
mod painter;
mod picture;
mod plane;
mod poses;
mod rates;
mod request;

use std::net::{SocketAddr, TcpListener};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use evpose_core::SensorSize;
use evpose_pose::HandParams;
use glam::Vec3;

pub use plane::PageEvents;
pub use poses::PageSink;

use crate::{LiveError, Meter};
use painter::Painter;
use plane::Plane;
use poses::Newest;
use rates::Point;

/// Clients that watch at the same time, at most.
const MOST_WATCHERS: usize = 8;

/// What poses are of.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Subject {
    /// A person: 13 joints.
    Body,
    /// A hand: 21 joints.
    Hand,
}

/// What a page shows.
pub struct PageInfo {
    /// Its title.
    pub title: String,
    /// Where events come from, as a person calls it.
    pub source: String,
    /// The sensor.
    pub sensor: SensorSize,
    /// What poses are of.
    pub subject: Subject,
    /// The surface of hands; without it they are drawn from their joints.
    pub hand_mesh: Option<HandMesh>,
}

/// Where the vertices of a hand are: pixels to the right, down, and away from the camera, the last by the
/// scale that the others have at the wrist. None where the hand lies behind the camera; else the same number
/// for every hand.
pub type HandVertices = Box<dyn FnMut(&HandParams) -> Option<Vec<Vec3>> + Send>;

/// The surface of a hand.
pub struct HandMesh {
    /// Triangles, as indices of vertices.
    pub faces: Vec<[u32; 3]>,
    /// Its vertices.
    pub vertices: HandVertices,
}

/// A page that is served, until this is dropped.
pub struct Page {
    shared: Arc<Shared>,
    address: SocketAddr,
    painter: Option<JoinHandle<()>>,
}

/// What the threads of a page share.
struct Shared {
    /// The first text of every client, without the history.
    about: message::About,
    /// Whether only this machine can connect.
    is_local: bool,
    plane: Mutex<Plane>,
    newest: Mutex<Newest>,
    /// Figures of the last seconds, for clients that come later.
    history: Mutex<Vec<Point>>,
    watchers: AtomicUsize,
    is_over: AtomicBool,
}

impl Page {
    /// Serves a page at `address`, port 0 for any that is free, with the figures of `meter`.
    ///
    /// # Errors
    /// If nobody can listen there.
    pub fn serve(
        address: SocketAddr,
        info: PageInfo,
        meter: Arc<Meter>,
    ) -> Result<Self, LiveError> {
        let failed = |source| LiveError::Connection { what: format!("http://{address}"), source };
        let listener = TcpListener::bind(address).map_err(failed)?;
        listener.set_nonblocking(true).map_err(failed)?;
        let address = listener.local_addr().map_err(failed)?;
        let shared = Arc::new(Shared {
            about: message::About::new(&info),
            is_local: address.ip().is_loopback(),
            plane: Mutex::new(Plane::new(info.sensor)),
            newest: Mutex::new(Newest::new()),
            history: Mutex::default(),
            watchers: AtomicUsize::new(0),
            is_over: AtomicBool::new(false),
        });
        let painter = Painter::new(shared.clone(), listener, meter, info.hand_mesh);
        let thread = std::thread::Builder::new().name("page".to_owned());
        let thread = thread.spawn(move || painter.work()).map_err(failed)?;
        Ok(Self { shared, address, painter: Some(thread) })
    }

    /// Where it is served.
    pub fn local_addr(&self) -> SocketAddr {
        self.address
    }

    /// Takes the events that are shown.
    pub fn view(&self) -> PageEvents {
        PageEvents::new(self.shared.clone())
    }

    /// Takes the poses that are shown.
    pub fn sink(&self) -> PageSink {
        PageSink::new(self.shared.clone(), self.address)
    }

    /// How many clients watch.
    pub fn watchers(&self) -> usize {
        self.shared.watchers.load(Ordering::Relaxed)
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.shared.is_over.store(true, Ordering::Relaxed);
        if let Some(painter) = self.painter.take() {
            // Its panic was told when it happened; there is nothing to save.
            let _ = painter.join();
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;
