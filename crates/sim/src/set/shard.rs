//! Shards of a data set, which machines record independently.

use std::fmt;
use std::str::FromStr;

use crate::SimError;

/// Shard `I` of `N` of the sequences of a run, written `I/N` and counted from 1: the sequences with
/// `index mod N = I - 1`, so that the shards differ by at most one sequence.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// Index of the shard, from 0.
    index: u64,
    count: u64,
}

impl Shard {
    /// All sequences.
    pub const WHOLE: Self = Self { index: 0, count: 1 };

    /// Whether a sequence belongs to this shard.
    pub fn owns(self, sequence: u64) -> bool {
        sequence % self.count == self.index
    }

    /// Indices of this shard's sequences, of `sequences` in all.
    pub fn sequences_of(self, sequences: u64) -> impl Iterator<Item = u64> {
        (0..sequences).filter(move |&sequence| self.owns(sequence))
    }

    /// Whether the shard is the complete run.
    pub fn is_whole(self) -> bool {
        self.count == 1
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.index + 1, self.count)
    }
}

impl FromStr for Shard {
    type Err = SimError;

    fn from_str(text: &str) -> Result<Self, SimError> {
        let parts = text.split_once('/').and_then(|(part, parts)| {
            let (part, count): (u64, u64) = (part.parse().ok()?, parts.parse().ok()?);
            (1..=count).contains(&part).then(|| Self { index: part - 1, count })
        });
        parts.ok_or_else(|| SimError::Shard { text: text.to_owned() })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_the_sequences_out_and_leave_none() {
        for (sequences, count) in [(7, 1), (7, 3), (2, 5), (268, 67)] {
            let mut owners = vec![0; sequences as usize];
            let mut sizes = Vec::new();
            for part in 1..=count {
                let shard: Shard = format!("{part}/{count}").parse().unwrap();
                sizes.push(shard.sequences_of(sequences).count());
                shard.sequences_of(sequences).for_each(|sequence| owners[sequence as usize] += 1);
            }
            assert!(owners.iter().all(|&owners| owners == 1), "{sequences} by {count}");
            assert!(sizes.iter().max().unwrap() - sizes.iter().min().unwrap() <= 1);
        }
    }

    #[test]
    fn a_shard_is_read_as_it_is_written() {
        assert_eq!("2/4".parse::<Shard>().unwrap().to_string(), "2/4");
        assert_eq!("1/1".parse::<Shard>().unwrap(), Shard::WHOLE);
        for text in ["0/4", "5/4", "1", "a/b", "1/0", "-1/4", "1/4/2", ""] {
            let message = text.parse::<Shard>().unwrap_err().to_string();
            assert!(message.starts_with(&format!("`{text}`")), "{message}");
        }
    }
}
