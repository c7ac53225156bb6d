//! The command line of evpose with one task more: the centre and the size of a disc that moves.
//!
//! ```console
//! $ alias blob="cargo run --release -p evpose-blob --"
//! $ blob simulate examples/task/blob.toml --out data/train
//! $ blob simulate examples/task/blob.toml --out data/test --held-out --sequences 4
//! $ blob train examples/task/blob.toml --data data/train --out runs/blob
//! $ blob eval --checkpoint runs/blob --data data/test
//! $ blob infer --checkpoint runs/blob --events data/test/0000.raw --out poses.csv
//! $ blob live --checkpoint runs/blob --source data/test/0000.raw --serve
//! ```

mod config;
mod network;
mod simulation;
mod stream;
mod task;

use std::process::ExitCode;

use evpose_cli::tasks::TASKS;
use evpose_pose::POSE_LAYOUTS;

fn main() -> ExitCode {
    let registered =
        POSE_LAYOUTS.register(&[&stream::LAYOUT]).and_then(|()| TASKS.register(&[&task::BlobTask]));
    match registered {
        Ok(()) => evpose::main(),
        Err(error) => evpose::report_error(&error.into()),
    }
}
