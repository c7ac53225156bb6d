//! The program `evpose`.

use std::process::ExitCode;

fn main() -> ExitCode {
    evpose::main()
}
