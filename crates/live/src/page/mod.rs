//! A web page that shows events, poses and measurements while they arrive.
//!
//! ```text
//!  front end ─► PageEvents ┐
//!  sink ─────► PageSink    ├─► painter, 30 frames/s ─► mailbox of each client ─► its thread, WebSocket
//!  all ──────► Meter       ┘                           (the newest frame wins)
//! ```
//!
//! * `GET /` is the page: one document without external resources.
//! * `GET /ws` becomes a WebSocket. A first text message describes the stream; then every frame is
//!   a binary message, the event image, and a text message, the poses and measurements.
//!
//! No client blocks the pipeline: frames that it does not read in time are replaced by newer ones,
//! and a client that reads nothing for three seconds is disconnected. Without clients, events cost
//! nothing.
//!
//! Requests from pages of other sites are refused: the `Origin` header must equal the `Host`
//! header. As a defence against DNS rebinding, a page answers only to loopback names, to the names in
//! [`PageInfo::hosts`], and, served to other machines, to addresses, since whoever owns a name can point it anywhere.

mod client;
mod event_counts;
mod event_image;
mod message;
mod origin;
mod painter;
mod poses;
mod rates;
mod request;

use std::net::{SocketAddr, TcpListener};
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;

use evpose_core::SensorSize;
use evpose_pose::{HandParams, PoseLayout};
use glam::Vec3;

pub use event_counts::PageEvents;
pub use poses::PageSink;

use crate::{LiveError, Meter};
use event_counts::EventCounts;
use painter::Painter;
use poses::NewestPoses;
use rates::Point;

/// Upper bound of simultaneous watchers: each costs a thread and the bandwidth of its frames.
const MAX_WATCHERS: usize = 8;

/// Skeleton of the poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Skeleton {
    /// A person: 13 joints.
    Body,
    /// A hand: 21 joints.
    Hand,
    /// The points of another task's poses, without bones.
    Points(&'static PoseLayout),
}

/// Description of the stream that a page shows.
pub struct PageInfo {
    /// Title of the page.
    pub title: String,
    /// Name of the source.
    pub source: String,
    /// Size of the sensor.
    pub sensor: SensorSize,
    /// Skeleton of the poses.
    pub skeleton: Skeleton,
    /// Names of this machine under which the page is served, beside addresses and loopback names.
    pub hosts: Vec<String>,
    /// Mesh of a hand; without it hands are drawn from their joints.
    pub hand_mesh: Option<HandMesh>,
}

/// Projection of a hand's vertices: pixels to the right, down, and away from the camera, the last
/// in pixels at the depth of the wrist. None behind the camera; else the same count for every hand.
pub type HandVertices = Box<dyn FnMut(&HandParams) -> Option<Vec<Vec3>> + Send>;

/// Mesh of a hand.
pub struct HandMesh {
    /// Triangles, as indices of vertices.
    pub faces: Vec<[u32; 3]>,
    /// Vertices of a pose.
    pub vertices: HandVertices,
}

/// A page, served until this is dropped.
pub struct Page {
    shared: Arc<Shared>,
    address: SocketAddr,
    painter: Option<JoinHandle<()>>,
}

struct Shared {
    /// First message to every client, without the history.
    about: message::About,
    /// Whether the address is a loopback address.
    is_local: bool,
    /// [`PageInfo::hosts`].
    hosts: Vec<String>,
    event_counts: Mutex<EventCounts>,
    newest: Mutex<NewestPoses>,
    /// Measurements of the last seconds, for clients that connect later.
    history: Mutex<Vec<Point>>,
    watchers: AtomicUsize,
    is_over: AtomicBool,
}

impl Page {
    /// Serves a page at `address`, port 0 for any free one, with the measurements of `meter`.
    ///
    /// # Errors
    /// If the address cannot be bound.
    pub fn serve(
        address: SocketAddr,
        info: PageInfo,
        meter: Arc<Meter>,
    ) -> Result<Self, LiveError> {
        let failed =
            |source| LiveError::Connection { endpoint: format!("http://{address}"), source };
        let listener = TcpListener::bind(address).map_err(failed)?;
        // The painter asks for new clients between frames and must not wait for one.
        listener.set_nonblocking(true).map_err(failed)?;
        // Port 0 has become a real one, which callers ask for.
        let address = listener.local_addr().map_err(failed)?;
        let shared = Arc::new(Shared {
            about: message::About::new(&info),
            is_local: address.ip().is_loopback(),
            hosts: info.hosts,
            event_counts: Mutex::new(EventCounts::new(info.sensor)),
            newest: Mutex::new(NewestPoses::new()),
            history: Mutex::default(),
            watchers: AtomicUsize::new(0),
            is_over: AtomicBool::new(false),
        });
        let painter = Painter::new(shared.clone(), listener, meter, info.hand_mesh);
        // A thread of its own: the pipeline must not wait for browsers.
        let thread = std::thread::Builder::new().name("page".to_owned());
        let thread = thread.spawn(move || painter.work()).map_err(failed)?;
        Ok(Self { shared, address, painter: Some(thread) })
    }

    /// Address of the page.
    pub fn local_addr(&self) -> SocketAddr {
        self.address
    }

    /// Input of the events.
    pub fn view(&self) -> PageEvents {
        PageEvents::new(self.shared.clone())
    }

    /// Sink of the poses.
    pub fn sink(&self) -> PageSink {
        PageSink::new(self.shared.clone(), self.address)
    }

    /// Number of watching clients.
    pub fn watchers(&self) -> usize {
        self.shared.watchers.load(Ordering::Relaxed)
    }
}

impl Drop for Page {
    fn drop(&mut self) {
        self.shared.is_over.store(true, Ordering::Relaxed);
        if let Some(painter) = self.painter.take() {
            // The panic hook has reported a panic; there is nothing to save.
            let _ = painter.join();
        }
    }
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;
