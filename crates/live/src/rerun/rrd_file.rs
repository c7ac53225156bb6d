//! A file of the viewer, created atomically.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use evpose_core::AtomicFile;
use re_sdk::external::re_log_encoding::{EncodeError, Encoder, EncodingOptions};
use re_sdk::log::{ChunkBatcherConfig, LogMsg};
use re_sdk::sink::{LogSink, SinkFlushError};

use crate::rerun::RerunError;

/// A file sink. The SDK's own sink writes under the final name, and only logs errors.
#[derive(Clone)]
pub(crate) struct RrdFile {
    path: PathBuf,
    state: Arc<Mutex<State>>,
}

enum State {
    Open(Box<Encoder<AtomicFile>>),
    /// The first error; nothing is written after it.
    Failed(EncodeError),
    Finished,
}

impl RrdFile {
    pub(crate) fn create(path: &Path) -> Result<Self, RerunError> {
        let file = AtomicFile::create(path)
            .map_err(|source| RerunError::File { path: path.to_owned(), source })?;
        let version = re_sdk::build_info().version;
        let encoder = Encoder::new_eager(version, EncodingOptions::PROTOBUF_COMPRESSED, file)
            .map_err(|source| RerunError::Encode { path: path.to_owned(), source })?;
        let state = Arc::new(Mutex::new(State::Open(Box::new(encoder))));
        Ok(Self { path: path.to_owned(), state })
    }

    /// Gives the file its final name. Later messages are dropped.
    pub(crate) fn commit(&self) -> Result<(), RerunError> {
        // The state is replaced first, so that no later message reaches a file that is closed.
        let state = std::mem::replace(&mut *self.state(), State::Finished);
        let finished = match state {
            State::Open(mut encoder) => encoder.finish().and_then(|()| encoder.into_inner()),
            State::Failed(error) => Err(error),
            State::Finished => Err(EncodeError::AlreadyFinished),
        };
        let path = || self.path.clone();
        let file = finished.map_err(|source| RerunError::Encode { path: path(), source })?;
        file.commit().map_err(|source| RerunError::File { path: path(), source })
    }

    pub(crate) fn failed(&self, error: &SinkFlushError) -> RerunError {
        RerunError::File { path: self.path.clone(), source: io::Error::other(error.to_string()) }
    }

    /// A panic of another writer does not invalidate the messages written so far.
    fn state(&self) -> MutexGuard<'_, State> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl LogSink for RrdFile {
    fn send(&self, message: LogMsg) {
        let mut state = self.state();
        if let State::Open(encoder) = &mut *state
            && let Err(error) = encoder.append(&message)
        {
            *state = State::Failed(error);
        }
    }

    /// Messages are encoded as they are sent: nothing is left to flush.
    fn flush_blocking(&self, _timeout: Duration) -> Result<(), SinkFlushError> {
        Ok(())
    }

    /// Nobody watches a file while it is written: chunks are cut by size, not by time.
    fn default_batcher_config(&self) -> ChunkBatcherConfig {
        ChunkBatcherConfig { flush_tick: Duration::MAX, ..ChunkBatcherConfig::DEFAULT }
    }
}
