//! One stream of events of a file, as a source.

use evpose_core::Micros;
use evpose_cpu::vectorize;

use super::events;
use super::flat::identifier;
use super::header::{MAX_STREAMS, Stream, StreamKind};
use super::walk::{Body, HEAD, Head, Walk};
use crate::{Columns, EventSource, Header, Input, IoError, OpenOptions};

/// Bytes between two places from which reading can start again, where there is no data table.
const BETWEEN_MARKS: u64 = 1 << 20;

/// Opens a file, and chooses among its streams of events.
pub(super) fn open(input: Input, options: &OpenOptions) -> Result<Box<dyn EventSource>, IoError> {
    let path = input.path.clone();
    let walk = Walk::new(input)?;
    let streams = walk.header.streams.clone();
    let camera = usize::from(options.camera.unwrap_or(0));
    let cameras: Vec<&Stream> = streams.iter().filter(|s| s.kind == StreamKind::Events).collect();
    let chosen = cameras.get(camera).copied();
    // Only a camera that is asked for has to exist: otherwise no stream of events is no events.
    if chosen.is_none() && options.camera.is_some() && !streams.is_empty() {
        let reason = format!("no camera {camera}: the file has {} of them", cameras.len());
        return Err(IoError::Stream { path, reason });
    }
    let mut facts = Vec::new();
    if let Some(source) = chosen.map(|s| s.source.clone()).filter(|source| !source.is_empty()) {
        facts.push(("source", source));
    }
    facts.push(("packing", walk.header.compression.to_string()));
    facts.push(("streams", streams.iter().map(described).collect::<Vec<_>>().join(", ")));
    let header = Header { sensor: chosen.and_then(|s| s.size), facts, ..Header::default() };
    let chosen = chosen.map(|stream| stream.id);
    let start = Mark { at: walk.at, events: 0, latest: Micros(i64::MIN) };
    Ok(Box::new(Source {
        streams,
        camera,
        chosen,
        header,
        table: if walk.header.table.is_some() { Index::Unread } else { Index::Missing },
        listed: 0,
        lacks: false,
        walk,
        now: start,
        marks: vec![start],
        others: 0,
        seen_to: 0,
    }))
}

fn described(stream: &Stream) -> String {
    let Stream { id, kind, size, .. } = stream;
    let size = size.map_or_else(String::new, |size| format!(" {size}"));
    format!("{id} {kind}{size}")
}

/// A place to start again.
#[derive(Debug, Clone, Copy)]
struct Mark {
    at: u64,
    /// Events before it.
    events: u64,
    /// The latest time before it.
    latest: Micros,
}

/// State of the data table.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Index {
    /// There is none.
    Missing,
    /// Nobody needed it yet.
    Unread,
    /// The marks are its entries.
    Read,
    /// It cannot be read, or does not fit the packets.
    Wrong,
}

struct Source {
    walk: Walk,
    header: Header,
    /// Streams of the header, and behind them those that only packets reveal.
    streams: Vec<Stream>,
    camera: usize,
    /// Number of the stream of events that is read.
    chosen: Option<i32>,
    table: Index,
    /// Events that the data table lists, and whether as many were read at the end.
    listed: u64,
    lacks: bool,
    /// Offset of the next packet.
    now: Mark,
    /// Ascending; the first is the beginning.
    marks: Vec<Mark>,
    /// Packets of a kind that is not known.
    others: u64,
    /// They were counted up to here.
    seen_to: u64,
}

impl Source {
    fn kind(&self, stream: i32) -> Option<StreamKind> {
        self.streams.iter().find(|known| known.id == stream).map(|known| known.kind)
    }

    /// Reads a packet into `columns`; whether there was one.
    fn packet(&mut self, columns: &mut Columns) -> Result<bool, IoError> {
        let Some(head) = self.walk.head()? else {
            if self.table == Index::Unread && self.chosen.is_some() {
                self.read_table()?;
            }
            self.lacks = self.table == Index::Read && self.listed != self.now.events;
            return Ok(false);
        };
        // Packets are counted once, also where a search has gone back.
        let is_new = head.at >= self.seen_to;
        let kind = self.kind(head.stream);
        // A stream that no header named may be one of events: its first packet says.
        if self.chosen == Some(head.stream) || kind.is_none() {
            self.take(&head, kind.is_none(), columns)?;
            self.walk.pass(&head);
        } else {
            self.walk.skip(&head)?;
        }
        if is_new {
            self.seen_to = head.at + 1;
            self.others += u64::from(matches!(self.kind(head.stream), Some(StreamKind::Other(_))));
        }
        self.now.at = self.walk.at;
        let is_far = self.marks.last().is_none_or(|mark| mark.at + BETWEEN_MARKS <= self.now.at);
        // Without a data table the marks of reading make the index.
        if self.table != Index::Read && is_far {
            self.marks.push(self.now);
        }
        Ok(true)
    }

    /// Appends the events of a packet of the chosen stream, or of one that the header does not
    /// name.
    fn take(
        &mut self,
        head: &Head,
        is_unnamed: bool,
        columns: &mut Columns,
    ) -> Result<(), IoError> {
        let names_streams = !self.walk.header.streams.is_empty();
        let Body { bytes, fault } = self.walk.body(head)?;
        let kind = identifier(bytes).map(StreamKind::from_identifier);
        let id = head.stream;
        // A broken file has a new number in every packet; the list would grow with it.
        if is_unnamed && self.streams.len() >= MAX_STREAMS {
            let reason = "packets of more streams than any recording has";
            return Err(self.walk.broken(head, super::flat::Broken { at: 0, reason }));
        }
        let is_stray = is_unnamed && kind == Ok(StreamKind::Events);
        if is_stray && names_streams {
            let reason = "events of a stream that the header does not name";
            return Err(self.walk.broken(head, super::flat::Broken { at: 0, reason }));
        }
        if let (true, Ok(kind)) = (is_unnamed, kind) {
            let cameras = self.streams.iter().filter(|s| s.kind == StreamKind::Events).count();
            // Streams of events are the cameras, in the order in which they appear.
            if kind == StreamKind::Events && cameras == self.camera && self.chosen.is_none() {
                self.chosen = Some(id);
            }
            let (name, source) = (String::new(), String::new());
            self.streams.push(Stream { id, kind, name, source, size: None });
        }
        let missing = match kind {
            Ok(StreamKind::Events) if self.chosen == Some(id) => {
                let before = columns.len();
                let missing = events::decode(bytes, columns);
                let new = &columns.t[before..];
                self.now.events += new.len() as u64;
                let latest = self.now.latest;
                self.now.latest = vectorize(
                    #[inline(always)]
                    || new.iter().copied().fold(latest, Micros::max),
                );
                missing
            }
            Ok(_) if is_unnamed => Ok(0),
            Ok(_) => Err(super::flat::Broken { at: 8, reason: "a packet that holds no events" }),
            Err(broken) => Err(broken),
        };
        // After the events: those before a cut are handed out.
        if let Some(fault) = fault {
            return Err(fault);
        }
        match missing {
            Ok(0) => Ok(()),
            Ok(_) => {
                let reason = "events are missing at the end of a packet";
                Err(self.walk.broken(head, super::flat::Broken { at: 0, reason }))
            }
            Err(broken) => Err(self.walk.broken(head, broken)),
        }
    }

    fn go_to(&mut self, mark: Mark) {
        self.now = mark;
        self.walk.at = mark.at;
    }

    /// Takes the entries of the data table for marks.
    fn read_table(&mut self) -> Result<(), IoError> {
        // Until all of it is found to be in order.
        self.table = Index::Wrong;
        let Some(entries) = self.walk.table()? else {
            return Ok(());
        };
        let mut mark = self.marks[0];
        let mut marks = vec![mark];
        for entry in entries.iter().filter(|entry| Some(entry.stream) == self.chosen) {
            // Entries point at the body of a packet; the walk begins at its head.
            let at = u64::try_from(entry.body).ok().and_then(|body| body.checked_sub(HEAD));
            let Some(at) = at.filter(|&at| at >= mark.at) else {
                return Ok(());
            };
            mark.at = at;
            marks.push(mark);
            // A mark counts the events before it.
            mark.events = mark.events.saturating_add_signed(entry.elements);
            mark.latest = mark.latest.max(entry.last);
        }
        self.marks = marks;
        self.listed = mark.events;
        self.table = Index::Read;
        Ok(())
    }

    /// Whether a packet of the stream begins where the data table says.
    fn is_packet(&mut self, mark: Mark) -> bool {
        self.walk.at = mark.at;
        mark.at == self.marks[0].at
            || matches!(self.walk.head(), Ok(Some(head)) if Some(head.stream) == self.chosen)
    }
}

impl EventSource for Source {
    fn header(&self) -> &Header {
        &self.header
    }

    fn next(&mut self, columns: &mut Columns) -> Result<(), IoError> {
        let before = columns.len();
        while columns.len() == before {
            let (start, read) = (self.now, self.packet(columns));
            // What a fault left readable counts for the message, not for the place.
            let read = read.map_err(|error| {
                let events = self.now.events;
                self.now = start;
                error.behind(events)
            });
            if !read? {
                break;
            }
        }
        Ok(())
    }

    fn seek(&mut self, t: Micros) -> Result<(), IoError> {
        if self.table == Index::Unread && self.chosen.is_some() {
            self.read_table()?;
        }
        // Up to the last mark below `t` no event reaches it, and any behind that mark may.
        let known = self.marks.partition_point(|mark| mark.latest < t);
        let mut from = self.marks[known.saturating_sub(1)];
        if self.table == Index::Read {
            if self.is_packet(from) {
                self.go_to(from);
                return Ok(());
            }
            // A table that points beside a packet once is trusted nowhere else.
            self.table = Index::Wrong;
            self.marks.truncate(1);
            from = self.marks[0];
        } else if known == self.marks.len() && self.now.latest < t && self.now.at > from.at {
            // The index does not reach there yet, and reading has come further.
            from = self.now;
        }
        self.go_to(from);
        // The table ends here: read and discard packets up to the one that reaches `t`.
        let mut discarded = Columns::new();
        let mut before = from;
        while self.now.latest < t {
            before = self.now;
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
        let mut remarks = Vec::new();
        let cameras = self.streams.iter().filter(|stream| stream.kind == StreamKind::Events);
        for (camera, stream) in cameras.enumerate().filter(|(_, s)| Some(s.id) != self.chosen) {
            let Stream { id, name, source, .. } = stream;
            remarks.push(format!(
                "stream {id} (`{name}` of `{source}`) holds events, too, and is not read: it is \
                 camera {camera}"
            ));
        }
        if self.chosen.is_none() {
            remarks.push(format!("the file has no stream of events for camera {}", self.camera));
        }
        if self.others > 0 {
            remarks.push(format!("{} packets of other kinds are passed over", self.others));
        }
        if self.lacks {
            let (listed, events) = (self.listed, self.now.events);
            remarks
                .push(format!("the data table lists {listed} events, the packets hold {events}"));
        }
        match self.table {
            Index::Missing => remarks.push(
                "the file has no data table: its recorder may have been stopped in between".into(),
            ),
            Index::Wrong => remarks.push("the data table of the file is not usable".into()),
            Index::Unread | Index::Read => {}
        }
        remarks
    }
}
