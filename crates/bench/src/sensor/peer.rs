//! Other simulators, timed on the same frames.

use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};

/// A program that times itself.
#[derive(Debug, Clone)]
pub(crate) struct Peer {
    pub(crate) name: String,
    /// Program and arguments, with placeholders.
    words: Vec<String>,
}

impl Peer {
    /// Reads `NAME=COMMAND`.
    pub(crate) fn parse(text: &str) -> Result<Self> {
        let (name, command) = text
            .split_once('=')
            .with_context(|| format!("--peer {text}: expected NAME=COMMAND"))?;
        let words: Vec<String> = command.split_whitespace().map(str::to_owned).collect();
        ensure!(!words.is_empty(), "--peer {text}: no command");
        Ok(Self { name: name.to_owned(), words })
    }

    /// Runs the program; it prints nanoseconds per pixel and step as its last line.
    pub(crate) fn measure(
        &self,
        frames: &Path,
        fps: u32,
        setting: &str,
        seconds: f64,
    ) -> Result<f64> {
        let (frames, fps) = (frames.to_string_lossy(), fps.to_string());
        let seconds = seconds.to_string();
        let filled = |word: &String| {
            word.replace("{frames}", &frames)
                .replace("{fps}", &fps)
                .replace("{setting}", setting)
                .replace("{seconds}", &seconds)
        };
        let mut words = self.words.iter().map(filled);
        let program = words.next().context("no command")?;
        let output = Command::new(&program)
            .args(words)
            .stdin(Stdio::null())
            .stderr(Stdio::inherit())
            .output()
            .with_context(|| format!("peer {}: {program} cannot be run", self.name))?;
        ensure!(output.status.success(), "peer {}: {}", self.name, output.status);
        let text = String::from_utf8_lossy(&output.stdout);
        // The last line with something in it: programs print what they like before.
        let last = text.lines().rfind(|line| !line.trim().is_empty()).unwrap_or_default();
        let ns: f64 = last.trim().parse().with_context(|| {
            format!("peer {}: its last line should be nanoseconds, it is {last:?}", self.name)
        })?;
        // Zero and infinity would decide every comparison.
        ensure!(ns > 0.0 && ns.is_finite(), "peer {}: {ns} nanoseconds", self.name);
        Ok(ns)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_peer_is_a_name_and_a_command() -> Result<()> {
        let peer = Peer::parse("other=run --file={frames} x=1")?;
        assert_eq!((peer.name.as_str(), peer.words.len()), ("other", 3));
        assert!(Peer::parse("run").is_err() && Peer::parse("other=").is_err());
        Ok(())
    }

    #[cfg(unix)]
    #[test]
    fn the_last_line_of_a_peer_is_its_time() -> Result<()> {
        let measure = |command: &str| {
            Peer::parse(&format!("other={command}"))?.measure(Path::new("f"), 1000, "all", 1.0)
        };
        assert_eq!(measure("printf {setting}\\n{fps}\\n")?, 1000.0);
        assert!(measure("printf {setting}").is_err());
        assert!(measure("false").is_err());
        assert!(measure("no-program-of-this-name").is_err());
        Ok(())
    }
}
