//! The command line of evpose with the plugin in it.
//!
//! ```console
//! $ cargo run --release -p evpose-plugin -- sensor show soft_saturation
//! ```

use std::process::ExitCode;

fn main() -> ExitCode {
    match evpose_plugin::register() {
        Ok(()) => evpose::main(),
        Err(error) => evpose::report_error(&error.into()),
    }
}
