//! Data sets, batches, training, evaluation and checkpoints.
