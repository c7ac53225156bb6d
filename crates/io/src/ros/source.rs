//! The events of one topic, as a source.

use std::path::Path;

use evpose_core::Micros;

use super::fields::Reason;
use super::file::{Fault, NamedFile, Topic, add_topic};
use super::message::{EventType, MessageDecoder};
use crate::{Columns, EventSource, Header, IoError, OpenOptions};

/// Events from which on a unit is read in parts, so that memory does not depend on it.
const EVENTS: usize = 1 << 24;
/// Bytes between two places from which reading can start again.
const BETWEEN_MARKS: u64 = 1 << 22;
/// Times from here on are of the calendar, the end of 2001 in microseconds.
pub(super) const CALENDAR_US: i64 = 1_000_000_000_000_000;

/// A place in files that follow each other, and the topic that is read of them.
pub(super) struct Place {
    files: Vec<NamedFile>,
    /// Topics of each file, and identifiers of the one that is read.
    topics: Vec<Vec<Topic>>,
    ids: Vec<Vec<u32>>,
    /// The present file, and the unit in it.
    file: usize,
    at: u64,
    /// Messages of the unit that were handed over.
    taken: usize,
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

/// The topic of events that is wanted, or the only one.
fn choose<'a>(topics: &'a [Topic], wanted: Option<&str>) -> Result<(&'a Topic, EventType), String> {
    let of_events: Vec<(&Topic, EventType)> =
        topics.iter().filter_map(|topic| Some((topic, EventType::by_name(&topic.kind)?))).collect();
    let events = || listed(of_events.iter().map(|(topic, _)| *topic));
    match (wanted, &of_events[..]) {
        (_, []) => Err(format!("no topic of events that are known; there are: {}", listed(topics))),
        (None, [one]) => Ok(*one),
        (None, several) => {
            let count = several.len();
            Err(format!("{count} topics of events, choose one with --topic: {}", events()))
        }
        (Some(wanted), several) => {
            let found = several.iter().find(|(topic, _)| topic.name == wanted);
            let none = || format!("no topic {wanted} of events; there are: {}", events());
            found.copied().ok_or_else(none)
        }
    }
}

/// Topics with their types and counts of messages.
pub(super) fn listed<'a>(topics: impl IntoIterator<Item = &'a Topic>) -> String {
    let described = topics
        .into_iter()
        .map(|Topic { name, kind, messages, .. }| format!("{name} ({kind}, {messages} messages)"));
    described.collect::<Vec<_>>().join(", ")
}

/// A place to start again.
#[derive(Clone)]
struct Mark {
    file: usize,
    at: u64,
    taken: usize,
    events: u64,
    /// The latest time before.
    latest: Micros,
    decoder: MessageDecoder,
}

/// Events of a topic.
pub(super) struct RosSource {
    place: Place,
    header: Header,
    pub(super) topic: String,
    /// Time of ROS at which times of events are 0, microseconds since 1970.
    pub(super) zero_us: i64,
    /// Time of the sensor that counts as 0.
    origin: Micros,
    events: u64,
    latest: Micros,
    decoder: MessageDecoder,
    /// Ascending; the first is the beginning.
    marks: Vec<Mark>,
    is_at_end: bool,
}

impl RosSource {
    /// Opens the topic of events of files that follow each other.
    ///
    /// # Errors
    /// If there is none, or are several and none is chosen.
    pub(super) fn open(
        files: Vec<NamedFile>,
        path: &Path,
        options: &OpenOptions,
    ) -> Result<Self, IoError> {
        let (mut place, topics, fault) = Place::new(files);
        let (topic, kind) = match (choose(&topics, options.topic.as_deref()), fault) {
            (Ok(chosen), _) => chosen,
            // What lies behind damage may hold the topic.
            (Err(_), Some(fault)) => return Err(fault),
            (Err(reason), None) => return Err(IoError::Stream { path: path.to_owned(), reason }),
        };
        place.choose(topic);
        let mut source = Self {
            place,
            header: Header::default(),
            topic: topic.name.clone(),
            zero_us: 0,
            origin: Micros(0),
            events: 0,
            latest: Micros(i64::MIN),
            decoder: MessageDecoder::new(kind, topic.serialisation),
            marks: Vec::new(),
            is_at_end: false,
        };
        let start = source.mark();
        source.marks.push(start.clone());
        source.begin(topic);
        source.go_to(start);
        Ok(source)
    }

    /// Learns from the first events what messages do not repeat.
    fn begin(&mut self, topic: &Topic) {
        let mut first = Columns::new();
        // A fault before the first event is met again when it is read.
        while first.is_empty() && !self.is_at_end && self.unit(&mut first).is_ok() {}
        self.header.sensor = self.decoder.sensor;
        self.header.facts.push(("topic", format!("{} ({})", topic.name, topic.kind)));
        if let Some(encoding) = self.decoder.encoding {
            self.header.facts.push(("encoding", encoding.to_owned()));
        }
        let Some(first) = first.t.first() else { return };
        if first.0 >= CALENDAR_US {
            self.origin = *first;
            let since = first.as_seconds();
            self.header.facts.push(("time 0", format!("{since:.6} s after 1970 began")));
        }
        // Packets of libcaer have times of ROS, and headers of their arrival; so have lists.
        self.zero_us = match (self.decoder.encoding, self.decoder.header_us) {
            (Some("evt3" | "mono"), Some(header_us)) => {
                header_us.saturating_sub(first.0.saturating_sub(self.origin.0))
            }
            _ => self.origin.0,
        };
    }

    /// Reads a unit of the present file.
    fn unit(&mut self, columns: &mut Columns) -> Result<(), Fault> {
        let before = columns.len();
        let decoder = &mut self.decoder;
        let read = self.place.unit(&mut |message| {
            decoder.decode(message, columns)?;
            Ok(columns.len() - before >= EVENTS)
        });
        for t in &mut columns.t[before..] {
            *t = Micros(t.0.saturating_sub(self.origin.0));
        }
        self.latest = columns.t[before..].iter().copied().fold(self.latest, Micros::max);
        self.events += (columns.len() - before) as u64;
        self.is_at_end = read?;
        Ok(())
    }

    fn mark(&self) -> Mark {
        let Place { file, at, taken, .. } = self.place;
        let decoder = self.decoder.clone();
        Mark { file, at, taken, events: self.events, latest: self.latest, decoder }
    }

    fn go_to(&mut self, mark: Mark) {
        (self.place.file, self.place.at, self.place.taken) = (mark.file, mark.at, mark.taken);
        (self.events, self.latest, self.decoder) = (mark.events, mark.latest, mark.decoder);
        self.is_at_end = false;
    }
}

impl EventSource for RosSource {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, columns: &mut Columns) -> Result<(), IoError> {
        let before = columns.len();
        while columns.len() == before && !self.is_at_end {
            let read = self.unit(columns);
            read.map_err(|fault| self.place.error(fault, self.events))?;
            let here = (self.place.file, self.place.at);
            let is_far = |last: &Mark| here >= (last.file, last.at.saturating_add(BETWEEN_MARKS));
            if self.marks.last().is_none_or(is_far) {
                self.marks.push(self.mark());
            }
        }
        Ok(())
    }

    fn seek(&mut self, t: Micros) -> Result<(), IoError> {
        let known = self.marks.partition_point(|mark| mark.latest < t);
        let mark = self.marks[known.saturating_sub(1)].clone();
        self.go_to(mark);
        // The index ends here: read and discard up to the unit that reaches `t`.
        let (mut discarded, mut before) = (Columns::new(), self.mark());
        while self.latest < t {
            before = self.mark();
            discarded.clear();
            self.next(&mut discarded)?;
            if discarded.is_empty() {
                return Ok(());
            }
        }
        self.go_to(before);
        Ok(())
    }

    fn remarks(&self) -> Vec<String> {
        self.decoder.remarks().collect()
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, reason = "tests")]
    use super::super::fields::Serialisation;
    use super::super::file::{MessageFile, MessageVisitor};
    use super::*;

    fn topic(name: &str, kind: &str) -> Topic {
        let serialisation = Serialisation::Cdr;
        Topic { name: name.into(), kind: kind.into(), serialisation, ids: vec![1], messages: 3 }
    }

    /// A file of one unit, which ends with a fault behind its messages.
    struct OneUnit;

    impl MessageFile for OneUnit {
        fn kind(&self) -> &'static str {
            "unit"
        }

        fn topics(&mut self) -> (Vec<Topic>, Option<Fault>) {
            (vec![topic("/events", "dvs_msgs/EventArray")], None)
        }

        fn begin(&self) -> u64 {
            7
        }

        fn unit(
            &mut self,
            at: u64,
            _ids: &[u32],
            take: &mut MessageVisitor<'_>,
        ) -> Result<Option<u64>, Fault> {
            let damage = |reason| Fault::damage(at, reason);
            (1..=3).try_for_each(|message| take(&[message])).map_err(damage)?;
            Err(damage("the end".into()))
        }
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

    #[test]
    fn one_topic_of_events_is_read_and_of_several_the_one_that_is_wanted() {
        let image = topic("/image", "sensor_msgs/msg/Image");
        let left = topic("/left", "event_camera_msgs/msg/EventPacket");
        let right = topic("/right", "dvs_msgs/EventArray");
        let one = [image.clone(), left.clone()];
        assert_eq!(choose(&one, None).unwrap(), (&left, EventType::Packet));
        let both = [image.clone(), left, right.clone()];
        let error = choose(&both, None).unwrap_err();
        assert!(error.contains("--topic") && error.contains("/right (dvs_msgs/EventArray, 3"));
        assert_eq!(choose(&both, Some("/right")).unwrap(), (&right, EventType::List));
        let error = choose(&both, Some("/image")).unwrap_err();
        assert!(error.contains("/left") && !error.contains("/image ("), "{error}");
        assert!(choose(&[image], None).unwrap_err().contains("sensor_msgs"));
    }
}
