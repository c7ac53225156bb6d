//! Errors of devices, configurations and weight files.

use std::path::PathBuf;

/// Errors of this crate.
#[derive(Debug, thiserror::Error)]
pub enum NnError {
    /// An unknown name of a device.
    #[error(
        "no device is called `{name}`: choose one of flex, ndarray, wgpu, cuda, or of several GPUs \
         wgpu:1; `evpose info --devices` lists them"
    )]
    UnknownDevice {
        /// The unknown name.
        name: String,
    },
    /// A device that this build leaves out.
    #[error("this build has no {device} device: rebuild with `--features {device}`")]
    DeviceNotBuilt {
        /// The device, which is also the name of its Cargo feature.
        device: &'static str,
    },
    /// A device that this machine does not have.
    #[error("no {device} device: {reason}; `evpose info --devices` lists what there is")]
    DeviceMissing {
        /// The kind of device.
        device: &'static str,
        /// The missing part, and the remedy.
        reason: String,
    },
    /// An index beyond the adapters of this machine.
    #[error(
        "no device {device}: there are {available}, counted from 0; `evpose info --devices` lists them"
    )]
    NoAdapter {
        /// The device with its index.
        device: String,
        /// Devices of this kind on this machine.
        available: usize,
    },
    /// The machine has fewer devices of a kind than were asked for.
    #[error(
        "{count} {device} devices were asked for, and there are {available}: lower training.devices"
    )]
    TooFewDevices {
        /// The kind of device.
        device: &'static str,
        /// Devices of this kind on this machine.
        available: usize,
        /// Devices that the configuration asks for.
        count: usize,
    },
    /// An unknown name of a backbone.
    #[error("no backbone is called `{name}`: choose one of {known}")]
    UnknownBackbone {
        /// The unknown name.
        name: String,
        /// The known names, separated by commas.
        known: String,
    },
    /// An unknown name of a network.
    #[error("no network is called `{name}`: choose one of {known}")]
    UnknownNetwork {
        /// The unknown name.
        name: String,
        /// The known names, separated by commas.
        known: String,
    },
    /// A relative width outside of the range of the network.
    #[error(
        "`width` must give every layer at least one channel, at most 8 times the published width; got {width}"
    )]
    Width {
        /// The width given, relative to the published network.
        width: f32,
    },
    /// A count in the shape of a network that is zero.
    #[error("`{field}` must be at least 1")]
    TooFew {
        /// The field of the configuration.
        field: &'static str,
    },
    /// A file that cannot be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// File that was refused.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A file is not a weight file of the expected kind, or is damaged.
    #[error("{}: not a readable {format} file: {reason}", path.display())]
    Unreadable {
        /// The weight file.
        path: PathBuf,
        /// The format that was expected.
        format: &'static str,
        /// The message of the reader.
        reason: String,
    },
    /// A checkpoint that is not as it was written.
    #[error("{}: damaged: {reason}", path.display())]
    Damaged {
        /// Path of the checkpoint.
        path: PathBuf,
        /// The sign of the damage, and the remedy.
        reason: String,
    },
    /// A weight file without a description of its network.
    #[error("{}: the weights carry no description of their network: {reason}", path.display())]
    Card {
        /// The weight file.
        path: PathBuf,
        /// The missing or malformed part.
        reason: String,
    },
    /// The parameters in a file are not those of the network.
    #[error("{}: these are not the weights of this network: {mismatch}", path.display())]
    Mismatch {
        /// The weight file.
        path: PathBuf,
        /// The parameters that differ.
        mismatch: Mismatch,
    },
}

/// How the parameters of a file differ from those of a network, each list sorted by name.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Mismatch {
    /// Parameters of the network that the file lacks.
    pub missing: Vec<String>,
    /// Parameters of the file that the network lacks.
    pub unexpected: Vec<String>,
    /// Parameters of another shape: name, shape in the network, shape in the file.
    pub reshaped: Vec<(String, Vec<usize>, Vec<usize>)>,
}

impl Mismatch {
    /// Whether nothing differs.
    pub fn is_empty(&self) -> bool {
        self.missing.is_empty() && self.unexpected.is_empty() && self.reshaped.is_empty()
    }
}

impl std::fmt::Display for Mismatch {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut parts = Vec::new();
        if !self.missing.is_empty() {
            parts.push(format!("missing {}", listed(&self.missing)));
        }
        if !self.unexpected.is_empty() {
            parts.push(format!("unexpected {}", listed(&self.unexpected)));
        }
        if !self.reshaped.is_empty() {
            let shapes = self.reshaped.iter();
            let shapes: Vec<_> =
                shapes.map(|(name, ours, file)| format!("{name} {file:?} for {ours:?}")).collect();
            parts.push(format!("of another shape {}", listed(&shapes)));
        }
        f.write_str(&parts.join("; "))
    }
}

/// The count and the first few names: a wrong network differs in all of its hundred.
fn listed(names: &[String]) -> String {
    const SHOWN: usize = 5;
    let rest = names.len().saturating_sub(SHOWN);
    let shown = names[..names.len() - rest].join(", ");
    let more = if rest > 0 { format!(" and {rest} more") } else { String::new() };
    format!("{} ({shown}{more})", names.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_mismatch_is_counted_and_cut() {
        let missing = (0..7).map(|i| format!("p{i}")).collect();
        let mismatch = Mismatch { missing, unexpected: vec!["q".into()], ..Mismatch::default() };
        assert_eq!(
            mismatch.to_string(),
            "missing 7 (p0, p1, p2, p3, p4 and 2 more); unexpected 1 (q)"
        );
    }
}
