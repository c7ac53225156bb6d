//! Benchmarks of evpose, and of other programs interleaved with it.
//!
//! * [`BenchCommand`]: `evpose bench`: inference, training, sensor, simulation, files, representations, the
//!   online pipeline.
//! * [`peer_bench`]: other programs on the same input, interleaved in the same run.
//! * [`gap`]: the blind benchmark of the gap workflow.

pub mod gap;
mod infer;
mod io;
mod live;
pub mod peer_bench;
mod repr;
pub mod sensor;
mod sim;
mod train;

use anyhow::Result;
use clap::Subcommand;

/// Declares the benchmarks: help text, name, arguments and the function that runs them.
macro_rules! benchmarks {
    ($($(#[$meta:meta])* $name:ident($args:ty) => $run:path,)*) => {
        /// The benchmarks.
        #[derive(Debug, Subcommand)]
        pub enum BenchCommand {
            $($(#[$meta])* $name($args),)*
        }

        /// Runs a benchmark.
        ///
        /// # Errors
        /// If its input cannot be read, or a result cannot be written.
        pub fn run(command: &BenchCommand) -> Result<()> {
            match command {
                $(BenchCommand::$name(args) => $run(args),)*
            }
        }
    };
}

benchmarks! {
    /// Latency of networks on one window at a time, layer by layer, beside other runtimes
    Infer(infer::BenchInferArgs) => infer::run,
    /// Time and memory of a training step of a network
    Train(train::BenchTrainArgs) => train::run,
    /// Cost of the event camera per pixel and step, on one core
    Sensor(sensor::BenchSensorArgs) => sensor::run,
    /// Steps a second of the labelled hand simulation, and the share of each part
    Sim(sim::BenchSimArgs) => sim::run,
    /// Events and labels a second from files in the page cache, on one core
    Io(io::BenchIoArgs) => io::run,
    /// Events a second into representations, and the time of an image
    Repr(repr::BenchReprArgs) => repr::run,
    /// Throughput and latency of the online pipeline at the event rates of busy cameras
    Live(live::BenchLiveArgs) => live::run,
}
