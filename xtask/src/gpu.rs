//! A program to carry to a machine with a GPU, where there is neither Cargo nor a network.

use std::fs::File;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

/// Folder of what is to be carried.
const FOLDER: &str = "target/gpu";
/// Kernels of Vulkan and, compiled there, of CUDA.
const FEATURES: &str = "vulkan,cuda-cpp";
/// `cubecl-cuda` names types of a crate that fetches LLVM when it is built; this one has them alone.
const WITHOUT_LLVM: &str = r#"patch.crates-io.cubecl-llvm.path="xtask/cubecl-llvm""#;
/// The version of CUDA's interface.
const CUDA: &str = "13000";

/// Builds the program with `args` of Cargo behind ours, strips it and packs it.
pub(crate) fn run(args: &[String], say: fn(&str)) -> Result<()> {
    let cargo = std::env::var("CARGO").unwrap_or_else(|_| "cargo".into());
    // The patch is of this build alone.
    let lock = std::fs::read("Cargo.lock")
        .context("reading Cargo.lock: run this in the project's folder")?;
    let mut build = Command::new(cargo);
    build.args(["build", "--release", "--bin=evpose", "--features", FEATURES]);
    build.args(["--config", WITHOUT_LLVM]).args(args).env("CUDARC_CUDA_VERSION", CUDA);
    let built = build.status();
    // The lock file is restored before the result is checked: a failed build changes none.
    std::fs::write("Cargo.lock", lock).context("putting Cargo.lock back")?;
    ensure!(built.context("starting cargo")?.success(), "the program was not built");
    std::fs::create_dir_all(FOLDER)?;
    let program = Path::new(FOLDER).join("evpose");
    succeeds(Command::new("strip").arg("-o").arg(&program).arg("target/release/evpose"))?;
    let packed = Path::new(FOLDER).join("evpose.gz");
    succeeds(Command::new("gzip").args(["-9", "-c"]).arg(&program).stdout(File::create(&packed)?))?;
    let mib = |path: &Path| {
        Ok::<_, std::io::Error>(std::fs::metadata(path)?.len() as f64 / 1024.0f64.powi(2))
    };
    say(&format!(
        "{} ({:.1} MiB, packed {:.1} MiB): there, `evpose bench gpu --minutes 9 --out gpu`",
        packed.display(),
        mib(&program)?,
        mib(&packed)?
    ));
    Ok(())
}

fn succeeds(command: &mut Command) -> Result<()> {
    // Nothing may wait for input here.
    let status = command.stdin(Stdio::null()).status();
    let status = status.with_context(|| format!("starting {command:?}"))?;
    ensure!(status.success(), "{command:?} ended with {status}");
    Ok(())
}
