//! The way to the viewer: a file of its own, or a connection.

use std::path::Path;
use std::time::Duration;

use evpose_core::Micros;
use re_sdk::blueprint::Blueprint;
use re_sdk::sink::SinkFlushError;
use re_sdk::{RecordingStream, RecordingStreamBuilder, TimeCell};

use crate::RerunError;
use crate::layout::TIMELINE;
use crate::rrd_file::RrdFile;

/// The name under which the viewer keeps how its windows are arranged.
const APPLICATION: &str = "evpose";
/// How long a viewer may take to answer at first.
const ANSWER: Duration = Duration::from_secs(10);

/// What is sent, and where it goes.
pub(crate) struct Outlet {
    pub(crate) stream: RecordingStream,
    to: Destination,
}

enum Destination {
    File(RrdFile),
    Viewer(String),
}

impl Outlet {
    /// Begins the file `path`, which appears with [`Self::finish`].
    pub(crate) fn create(path: &Path, name: &str, views: Blueprint) -> Result<Self, RerunError> {
        let stream = builder(name, views).buffered()?;
        let file = RrdFile::create(path)?;
        stream.set_sink(Box::new(file.clone()));
        Ok(Self::new(stream, Destination::File(file)))
    }

    /// Connects to the viewer at `address`, and waits for its answer.
    pub(crate) fn connect(
        address: Option<&str>,
        name: &str,
        views: Blueprint,
    ) -> Result<Self, RerunError> {
        let address = match address {
            None => re_sdk::DEFAULT_CONNECT_URL.to_owned(),
            Some(url) if url.contains("://") => url.to_owned(),
            Some(host_and_port) => format!("rerun+http://{host_and_port}/proxy"),
        };
        let stream = match builder(name, views).connect_grpc_opts(address.as_str()) {
            Ok(stream) => stream,
            Err(source) => return Err(RerunError::Address { address, source }),
        };
        let outlet = Self::new(stream, Destination::Viewer(address));
        // Before a long recording is read for nobody.
        outlet.flush(ANSWER)?;
        Ok(outlet)
    }

    fn new(stream: RecordingStream, to: Destination) -> Self {
        // When an event was sent to the viewer says nothing about it.
        stream.set_log_time_enabled(false);
        Self { stream, to }
    }

    /// The time of what is sent from now on.
    pub(crate) fn set_time(&self, t: Micros) {
        let ns = t.0.saturating_mul(1_000);
        self.stream.set_time(TIMELINE, TimeCell::from_duration_nanos(ns));
    }

    /// Waits until everything has arrived; a file gets its name.
    pub(crate) fn finish(&self) -> Result<(), RerunError> {
        self.flush(Duration::MAX)?;
        match &self.to {
            Destination::File(file) => file.commit(),
            Destination::Viewer(_) => Ok(()),
        }
    }

    fn flush(&self, timeout: Duration) -> Result<(), RerunError> {
        self.stream.flush_with_timeout(timeout).map_err(|source| self.failed(source))
    }

    fn failed(&self, source: SinkFlushError) -> RerunError {
        match &self.to {
            Destination::File(file) => file.failed(&source),
            Destination::Viewer(address) => RerunError::Viewer { address: address.clone(), source },
        }
    }
}

fn builder(name: &str, views: Blueprint) -> RecordingStreamBuilder {
    RecordingStreamBuilder::new(APPLICATION)
        .recording_name(name)
        // Whoever asks for a file gets one, whatever the environment says.
        .enabled(true)
        .with_blueprint(views)
}
