//! `evpose info`.

use anyhow::{Result, bail};
use evpose_body::files::ModelFile;

use super::{checkpoint_info, data_set};
use crate::args::InfoArgs;
use crate::progress::say;

pub(crate) fn run(args: &InfoArgs) -> Result<()> {
    for (i, file) in args.files.iter().enumerate() {
        if i > 0 {
            say("");
        }
        if file.is_dir() {
            data_set::describe(file)?;
            if args.verify {
                data_set::verify(file)?;
            }
        } else if args.verify {
            bail!("{}: --verify is for directories of sequences", file.display());
        } else if checkpoint_info::is_likely(file) {
            say(checkpoint_info::describe(file)?);
        } else if ModelFile::is_likely(file) {
            let model = ModelFile::read(file)?;
            say(format!("{}\n{model}", file.display()));
        } else {
            say(evpose_io::info(file, &args.opening.options(file))?);
        }
    }
    Ok(())
}
