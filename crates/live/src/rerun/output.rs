//! Destination of a recording: a file, or a running viewer.

use std::path::Path;
use std::time::Duration;

use evpose_core::Micros;
use re_sdk::blueprint::Blueprint;
use re_sdk::sink::SinkFlushError;
use re_sdk::{RecordingStream, RecordingStreamBuilder, TimeCell};

use crate::rerun::RerunError;
use crate::rerun::layout::TIMELINE;
use crate::rerun::rrd_file::RrdFile;

/// Application id, under which the viewer stores the arrangement of its views.
const APPLICATION: &str = "evpose";
/// Timeout of the first response of a viewer.
const CONNECT_TIMEOUT: Duration = Duration::from_secs(10);

/// A stream of messages and its destination.
pub(crate) struct Output {
    pub(crate) stream: RecordingStream,
    destination: Destination,
}

enum Destination {
    File(RrdFile),
    Viewer(String),
}

impl Output {
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
        let output = Self::new(stream, Destination::Viewer(address));
        // Fails now rather than after a long recording is read.
        output.flush(CONNECT_TIMEOUT)?;
        Ok(output)
    }

    fn new(stream: RecordingStream, destination: Destination) -> Self {
        // The host time of sending carries no information.
        stream.set_log_time_enabled(false);
        Self { stream, destination }
    }

    /// Sets the event time of the following messages.
    pub(crate) fn set_time(&self, t: Micros) {
        let ns = t.0.saturating_mul(1_000);
        self.stream.set_time(TIMELINE, TimeCell::from_duration_nanos(ns));
    }

    /// Waits until everything has arrived, and gives a file its final name.
    pub(crate) fn finish(&self) -> Result<(), RerunError> {
        self.flush(Duration::MAX)?;
        match &self.destination {
            Destination::File(file) => file.commit(),
            Destination::Viewer(_) => Ok(()),
        }
    }

    fn flush(&self, timeout: Duration) -> Result<(), RerunError> {
        self.stream.flush_with_timeout(timeout).map_err(|source| self.failed(source))
    }

    fn failed(&self, source: SinkFlushError) -> RerunError {
        match &self.destination {
            Destination::File(file) => file.failed(&source),
            Destination::Viewer(address) => RerunError::Viewer { address: address.clone(), source },
        }
    }
}

fn builder(name: &str, views: Blueprint) -> RecordingStreamBuilder {
    RecordingStreamBuilder::new(APPLICATION)
        .recording_name(name)
        // Overrides the SDK's environment variable RERUN.
        .enabled(true)
        .with_blueprint(views)
}
