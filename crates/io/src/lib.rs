//! Event and label files, opened by content.
