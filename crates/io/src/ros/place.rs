//! A place in files that follow each other, from which the messages of a topic are read.

use std::path::Path;

use super::fields::Reason;
use super::file::{Fault, NamedFile, Topic, add_topic};
use crate::IoError;

/// A place in files that follow each other, and the topic that is read of them.
pub(super) struct Place {
    files: Vec<NamedFile>,
    /// Topics of each file, and identifiers of the one that is read.
    topics: Vec<Vec<Topic>>,
    ids: Vec<Vec<u32>>,
    /// The present file, and the unit in it.
    pub(super) file: usize,
    pub(super) at: u64,
    /// Messages of the unit that were handed over.
    pub(super) taken: usize,
}

impl Place {
    /// The begin of files, the topics of all of them, and the fault that ends them.
    pub(super) fn new(mut files: Vec<NamedFile>) -> (Self, Vec<Topic>, Option<IoError>) {
        let (mut all, mut topics, mut fault) = (Vec::new(), Vec::new(), None);
        for (path, file) in &mut files {
            let (of_file, ends) = file.topics();
            of_file.iter().for_each(|topic| add_topic(&mut all, topic.clone()));
            topics.push(of_file);
            let error = |ends: Fault| ends.of_file((path.as_path(), file.kind()), 0);
            fault = fault.or_else(|| ends.map(error));
        }
        let at = files.first().map_or(0, |(_, file)| file.begin());
        (Self { files, topics, ids: Vec::new(), file: 0, at, taken: 0 }, all, fault)
    }

    /// Reads a topic from here on.
    pub(super) fn choose(&mut self, topic: &Topic) {
        let same = |other: &&Topic| other.name == topic.name && other.kind == topic.kind;
        let of_file = |topics: &Vec<Topic>| {
            topics.iter().filter(same).flat_map(|topic| topic.ids.clone()).collect()
        };
        self.ids = self.topics.iter().map(of_file).collect();
    }

    /// The error of a fault of the present file.
    pub(super) fn error(&self, fault: Fault, events: u64) -> IoError {
        let file = self.files.get(self.file);
        let file = file.map_or((Path::new(""), ""), |(path, file)| (path.as_path(), file.kind()));
        fault.of_file(file, events)
    }

    /// Hands over the messages of a unit until `take` says that it has enough; the next call goes on
    /// behind them. Returns whether there is no unit.
    pub(super) fn unit(
        &mut self,
        take: &mut dyn FnMut(&[u8]) -> Result<bool, Reason>,
    ) -> Result<bool, Fault> {
        let Some((_, file)) = self.files.get_mut(self.file) else { return Ok(true) };
        let (mut met, mut has_enough) = (0, false);
        let read = file.unit(self.at, &self.ids[self.file], &mut |message| {
            // A unit cannot be left in the middle: messages behind the last are passed over.
            if has_enough {
                return Ok(());
            }
            met += 1;
            if met > self.taken {
                has_enough = take(message)?;
            }
            Ok(())
        });
        // What is behind is met again, a fault too.
        if has_enough {
            self.taken = met;
            return Ok(false);
        }
        match read? {
            Some(next) => self.at = next,
            None => {
                self.file += 1;
                self.at = self.files.get(self.file).map_or(0, |(_, file)| file.begin());
            }
        }
        self.taken = 0;
        Ok(false)
    }
}

#[cfg(test)]
mod tests {
    use super::super::fields::Serialisation;
    use super::super::file::{MessageFile, MessageVisitor, NextUnit};
    use super::*;

    /// A file of one unit, which ends with a fault behind its messages.
    struct OneUnit;

    impl MessageFile for OneUnit {
        fn kind(&self) -> &'static str {
            "unit"
        }

        fn topics(&mut self) -> (Vec<Topic>, Option<Fault>) {
            (vec![topic()], None)
        }

        fn begin(&self) -> u64 {
            7
        }

        fn unit(&mut self, at: u64, _ids: &[u32], take: &mut MessageVisitor<'_>) -> NextUnit {
            let damage = |reason| Fault::damage(at, reason);
            (1..=3).try_for_each(|message| take(&[message])).map_err(damage)?;
            Err(damage("the end".into()))
        }
    }

    fn topic() -> Topic {
        let (name, kind) = ("/events".to_owned(), "dvs_msgs/EventArray".to_owned());
        Topic { name, kind, serialisation: Serialisation::Cdr, ids: vec![1], messages: 3 }
    }

    #[test]
    fn a_unit_is_read_in_parts_of_so_many_messages_as_are_enough() {
        let (mut place, topics, _) = Place::new(vec![("one.bag".into(), Box::new(OneUnit))]);
        place.choose(&topics[0]);
        let mut parts = Vec::new();
        let fault = loop {
            let mut part = Vec::new();
            let read = place.unit(&mut |message| {
                part.push(message[0]);
                Ok(part.len() >= 2)
            });
            parts.push(part);
            if let Err(fault) = read {
                break fault;
            }
        };
        // A fault is met behind the messages before it.
        assert_eq!(parts, [vec![1, 2], vec![3]]);
        let error = place.error(fault, 5).to_string();
        assert_eq!(error, "one.bag: byte 7: unit: the end (5 events readable before it)");
    }
}
