//! Networks, losses and weight files.
