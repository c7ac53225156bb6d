//! Signals that end a live run.

use std::time::{Duration, Instant};

use anyhow::{Context, Result};
use evpose_live::Control;

/// Stops the pipeline on Ctrl-C, SIGTERM and SIGHUP, so that outputs and the report are written; another one a second
/// later or more exits at once. SIGHUP is left alone where it was ignored, as `nohup` does.
pub(crate) fn stop_on(control: &Control) -> Result<()> {
    let control = control.clone();
    let mut first: Option<Instant> = None;
    listen(move || {
        // A terminal that closes sends two at once: the shell's and its own.
        if first.get_or_insert_with(Instant::now).elapsed() > Duration::from_secs(1) {
            // 128 plus the number of SIGINT, as shells report it.
            std::process::exit(130);
        }
        control.stop();
    })
    .context("listening for signals")
}

#[cfg(unix)]
fn listen(mut stop: impl FnMut() + Send + 'static) -> Result<()> {
    use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};

    let mut listened = vec![SIGINT, SIGTERM];
    if !is_ignored(SIGHUP) {
        listened.push(SIGHUP);
    }
    let mut signals = signal_hook::iterator::Signals::new(listened)?;
    std::thread::spawn(move || signals.forever().for_each(|_| stop()));
    Ok(())
}

#[cfg(not(unix))]
fn listen(stop: impl FnMut() + Send + 'static) -> Result<()> {
    Ok(ctrlc::set_handler(stop)?)
}

/// Whether this process ignores a signal. Only Linux says so without calls that are unsafe.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let mask = status.lines().find_map(|line| line.strip_prefix("SigIgn:"));
    let mask = mask.and_then(|mask| u64::from_str_radix(mask.trim(), 16).ok());
    // Signals are counted from 1.
    mask.is_some_and(|mask| mask >> (signal - 1) & 1 == 1)
}
