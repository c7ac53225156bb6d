//! `evpose info`.

use anyhow::Result;

use crate::args::InfoArgs;
use crate::progress::say;

pub(crate) fn run(args: &InfoArgs) -> Result<()> {
    for (i, file) in args.files.iter().enumerate() {
        if i > 0 {
            say("");
        }
        say(evpose_io::info(file, None)?);
    }
    Ok(())
}
