//! `evpose info`.

use anyhow::Result;
use evpose_body::files::ModelFile;

use crate::args::InfoArgs;
use crate::progress::say;

pub(crate) fn run(args: &InfoArgs) -> Result<()> {
    for (i, file) in args.files.iter().enumerate() {
        if i > 0 {
            say("");
        }
        if ModelFile::is_likely(file) {
            let model = ModelFile::read(file)?;
            say(format!("{}\n{model}", file.display()));
        } else {
            say(evpose_io::info(file, None)?);
        }
    }
    Ok(())
}
