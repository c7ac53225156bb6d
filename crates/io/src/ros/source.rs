//! The events of one topic, as a source.

use std::path::Path;

use evpose_core::Micros;

use super::file::{Fault, NamedFile, Topic};
use super::message::{EventType, MessageDecoder};
use super::place::Place;
use crate::{Columns, EventSource, Header, IoError, OpenOptions};

/// Events from which on a unit is read in parts, so that memory does not depend on it.
const EVENTS: usize = 1 << 24;
/// Bytes between two places from which reading can start again.
const BETWEEN_MARKS: u64 = 1 << 22;
/// Topics that are described beside the one that is read: robots have hundreds.
const MAX_LISTED: usize = 8;
/// Times from here on are of the calendar, the end of 2001 in microseconds.
pub(super) const CALENDAR_US: i64 = 1_000_000_000_000_000;

/// The topic of events that is wanted, or the only one.
fn choose<'a>(
    path: &Path,
    topics: &'a [Topic],
    wanted: Option<&str>,
) -> Result<(&'a Topic, EventType), IoError> {
    let refused = |reason: String| IoError::Stream { path: path.to_owned(), reason };
    let of_events: Vec<(&Topic, EventType)> =
        topics.iter().filter_map(|topic| Some((topic, EventType::by_name(&topic.kind)?))).collect();
    let events = || listed(of_events.iter().map(|(topic, _)| *topic));
    match (wanted, &of_events[..]) {
        (_, []) => {
            let known = listed(topics);
            Err(refused(format!("no topic of events that are known; there are: {known}")))
        }
        (None, [one]) => Ok(*one),
        (None, several) => {
            let count = several.len();
            let reason = format!("{count} topics of events, choose one with --topic: {}", events());
            Err(refused(reason))
        }
        (Some(wanted), several) => {
            let found = several.iter().find(|(topic, _)| topic.name == wanted);
            let none = || refused(format!("no topic {wanted} of events; there are: {}", events()));
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
        let (topic, kind) = match (choose(path, &topics, options.topic.as_deref()), fault) {
            (Ok(chosen), _) => chosen,
            // What lies behind damage may hold the topic.
            (Err(_), Some(fault)) => return Err(fault),
            (Err(error), None) => return Err(error),
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
        source.begin(topic, &topics);
        source.go_to(start);
        Ok(source)
    }

    /// Learns from the first events what messages do not repeat.
    fn begin(&mut self, topic: &Topic, topics: &[Topic]) {
        let mut first = Columns::new();
        // A fault before the first event is met again when it is read.
        while first.is_empty() && !self.is_at_end && self.unit(&mut first).is_ok() {}
        self.header.sensor = self.decoder.sensor;
        self.header.facts.push(("topic", format!("{} ({})", topic.name, topic.kind)));
        let others: Vec<&Topic> = topics.iter().filter(|other| other.name != topic.name).collect();
        if !others.is_empty() {
            let shown = listed(others.iter().copied().take(MAX_LISTED));
            let more = others.len().saturating_sub(MAX_LISTED);
            let more = if more > 0 { format!(", and {more} more") } else { String::new() };
            self.header.facts.push(("topics", format!("also {shown}{more}")));
        }
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
        // Events before a fault count: they are moved as well.
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
    use super::super::fields::Serialisation;
    use super::*;

    fn topic(name: &str, kind: &str) -> Topic {
        let serialisation = Serialisation::Cdr;
        Topic { name: name.into(), kind: kind.into(), serialisation, ids: vec![1], messages: 3 }
    }

    #[test]
    fn one_topic_of_events_is_read_and_of_several_the_one_that_is_wanted() {
        let image = topic("/image", "sensor_msgs/msg/Image");
        let left = topic("/left", "event_camera_msgs/msg/EventPacket");
        let right = topic("/right", "dvs_msgs/EventArray");
        let one = [image.clone(), left.clone()];
        let choose = |topics, wanted| choose(Path::new("robot.bag"), topics, wanted);
        let refusal = |topics, wanted| choose(topics, wanted).unwrap_err().to_string();
        assert_eq!(choose(&one, None).unwrap(), (&left, EventType::Packet));
        let both = [image.clone(), left, right.clone()];
        let error = refusal(&both, None);
        assert!(error.contains("--topic") && error.contains("/right (dvs_msgs/EventArray, 3"));
        assert_eq!(choose(&both, Some("/right")).unwrap(), (&right, EventType::List));
        let error = refusal(&both, Some("/image"));
        assert!(error.contains("/left") && !error.contains("/image ("), "{error}");
        assert!(refusal(&[image], None).contains("sensor_msgs"));
    }
}
