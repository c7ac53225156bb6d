//! A representation of one's own: the sign of the latest event of each pixel, +1 for ON and -1 for
//! OFF.
//!
//! ```console
//! $ cargo run --release --example custom_representation
//! ```
//! A representation of evpose is such a file, plus a line in the registry; see `CONTRIBUTING.md`.

#![allow(clippy::print_stdout, reason = "a program")]

use anyhow::Result;
use evpose_core::{Event, EventStream, Micros, Polarity, SensorSize};
use evpose_repr::{
    ChannelOrder, Grey, Memory, PolarityUse, REPRESENTATIONS, Representation, RepresentationSpec,
    StreamWindow, representation_by_name_in,
};

static SPEC: RepresentationSpec = RepresentationSpec {
    name: "latest-sign",
    summary: "sign of a pixel's latest event in the window",
    parameters: &[],
    memory: Memory::Window,
    polarity: PolarityUse::Sign,
    // Of two events at once, the later in the stream counts.
    any_order_at_once: false,
    channels: |_| 1,
    start: |window, _| Box::new(LatestSign::new(window)),
    fill: None,
};

#[derive(Debug)]
struct LatestSign {
    window: StreamWindow,
    /// Time stamp and sign of each pixel's latest event, row by row.
    latest: Vec<Option<(Micros, f32)>>,
    last_event: Option<Micros>,
    now: Micros,
}

impl LatestSign {
    fn new(window: StreamWindow) -> Self {
        let latest = vec![None; window.sensor().pixels()];
        Self { window, latest, last_event: None, now: Micros(i64::MIN) }
    }
}

impl Representation for LatestSign {
    fn channels(&self) -> usize {
        1
    }

    fn push(&mut self, events: &EventStream) {
        assert_eq!(events.sensor(), self.window.sensor(), "events of another sensor");
        let [Some(&first), Some(&last)] = [events.t().first(), events.t().last()] else { return };
        // A recording that starts again is a new stream.
        if self.last_event.is_some_and(|before| first < before) {
            self.reset();
        }
        for event in events.iter() {
            let width = usize::from(self.window.sensor().width);
            let sign = if event.polarity == Polarity::On { 1.0 } else { -1.0 };
            self.latest[usize::from(event.y) * width + usize::from(event.x)] =
                Some((event.t, sign));
        }
        self.last_event = Some(last);
        self.advance(last);
    }

    fn advance(&mut self, t: Micros) {
        self.now = self.now.max(t);
    }

    fn render(&self, out: &mut [f32]) {
        assert_eq!(out.len(), self.latest.len(), "a plane of another size");
        let start = self.now.0.saturating_sub(self.window.length().0);
        for (value, latest) in out.iter_mut().zip(&self.latest) {
            *value = latest.filter(|(t, _)| t.0 > start).map_or(0.0, |(_, sign)| sign);
        }
    }

    fn grey(&self) -> Grey {
        Grey::Signed
    }

    fn reset(&mut self) {
        *self = Self::new(self.window);
    }
}

fn main() -> Result<()> {
    let registry: Vec<&RepresentationSpec> =
        REPRESENTATIONS.iter().copied().chain([&SPEC]).collect();
    let sensor = SensorSize { width: 8, height: 1 };
    let window = StreamWindow::new(sensor, Micros(4_000), ChannelOrder::OffFirst)?;
    let mut representation = representation_by_name_in(&registry, "latest-sign")?.start(window);
    // A bright bar two pixels wide moves by a pixel a millisecond: ON at its front, OFF behind it.
    for step in 0..6u16 {
        let t = Micros(1_000 * i64::from(step));
        let on = Event { t, x: step + 2, y: 0, polarity: Polarity::On };
        let off = Event { t, x: step, y: 0, polarity: Polarity::Off };
        representation.push(&EventStream::from_events(sensor, [on, off])?);
        let mut plane = vec![0.0; representation.channels() * sensor.pixels()];
        representation.render(&mut plane);
        let row: Vec<String> = plane.iter().map(|value| format!("{value:>2}")).collect();
        println!("{:>4} us  {}", t.0, row.join(" "));
    }
    Ok(())
}
