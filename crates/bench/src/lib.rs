//! Benchmarks of evpose, and of peer programs interleaved with it.
//!
//! * [`BenchCommand`]: `evpose bench`: inference, training, sensor, simulation, files,
//!   representations, the online pipeline, accuracy on named sets and before other cameras.
//! * [`peer_bench`]: peer programs on the same input, interleaved in the same run.
//!
//! Benchmarks are subcommands, run in-process:
//!
//! ```
//! use clap::{FromArgMatches as _, Subcommand as _};
//! use evpose_bench::BenchCommand;
//!
//! # fn main() -> anyhow::Result<()> {
//! let folder = tempfile::tempdir()?;
//! let json = folder.path().join("sensor.json");
//! let bench = BenchCommand::augment_subcommands(clap::Command::new("bench"));
//! let json_argument = json.display().to_string();
//! let args = ["bench", "sensor", "--seconds", "0.01", "--json", &json_argument];
//! let command = BenchCommand::from_arg_matches(&bench.try_get_matches_from(args)?)?;
//! evpose_bench::run(&command)?;
//! assert!(std::fs::read_to_string(json)?.contains("settings"));
//! # Ok(())
//! # }
//! ```

mod accuracy;
mod all;
mod cameras;
mod gpu;
mod infer;
mod io;
mod live;
pub mod peer_bench;
mod repr;
mod sensor;
mod sim;
mod train;

use anyhow::Result;
use clap::Subcommand;

/// Declares the benchmarks: help text, name, arguments and the function that runs them.
macro_rules! benchmarks {
    ($($(#[$meta:meta])* $name:ident($args:ty) => $run:path,)*) => {
        /// The benchmarks.
        #[derive(Debug, Subcommand)]
        #[command(after_help = "Start with:\n  evpose bench infer --layers\n  evpose bench train\n  \
            evpose bench live --checkpoint body")]
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
    /// Latency of networks at batch size 1, per layer, compared with other runtimes
    Infer(infer::BenchInferArgs) => infer::run,
    /// Time and memory of a training step of a network
    Train(train::BenchTrainArgs) => train::run,
    /// A GPU beside the CPU: agreement, inference, training, kernel by kernel, in a few minutes
    Gpu(gpu::BenchGpuArgs) => gpu::run,
    /// Cost of the simulated sensor per pixel and step, on one core and on several
    Sensor(sensor::BenchSensorArgs) => sensor::run,
    /// Simulation steps per second of labelled hands, and the share of each stage
    Sim(sim::BenchSimArgs) => sim::run,
    /// Events and labels per second read from files in the page cache, on one core
    Io(io::BenchIoArgs) => io::run,
    /// Events per second into representations, and the time to render an input
    Repr(repr::BenchReprArgs) => repr::run,
    /// Throughput and latency of the online pipeline at the event rates of busy cameras
    Live(live::BenchLiveArgs) => live::run,
    /// All speeds beside peers and the limits of the machine, as a page
    All(all::BenchAllArgs) => all::run,
    /// Accuracy of networks on named sets, stored with all that it was measured with
    Accuracy(accuracy::BenchAccuracyArgs) => accuracy::run,
    /// Accuracy of a network on the same scenes before seven sensors
    Cameras(cameras::BenchCamerasArgs) => cameras::run,
}
