//! LNES in one channel: that of ON events less that of OFF events.

use evpose_core::{EventStream, Micros, Polarity};
use evpose_repr::{
    Grey, Lnes, Memory, PolarityUse, Representation, RepresentationSpec, StreamWindow,
};

pub(crate) static SIGNED_LNES: RepresentationSpec = RepresentationSpec {
    name: "signed-lnes",
    summary: "LNES of ON events less LNES of OFF events",
    parameters: &[],
    memory: Memory::Window,
    polarity: PolarityUse::Sign,
    any_order_at_once: true,
    channels: |_| 1,
    start: |window, _| Box::new(SignedLnes { window, lnes: Lnes::new(window) }),
    fill: None,
};

#[derive(Debug)]
struct SignedLnes {
    window: StreamWindow,
    lnes: Lnes,
}

impl Representation for SignedLnes {
    fn channels(&self) -> usize {
        1
    }

    fn push(&mut self, events: &EventStream) {
        self.lnes.push(events);
    }

    fn advance(&mut self, t: Micros) {
        self.lnes.advance(t);
    }

    fn render(&self, out: &mut [f32]) {
        let pixels = self.window.sensor().pixels();
        assert_eq!(out.len(), pixels, "a plane of another size");
        let mut planes = vec![0.0; 2 * pixels];
        self.lnes.render(&mut planes);
        let [on, off] = [Polarity::On, Polarity::Off]
            .map(|polarity| &planes[self.window.order().channel(polarity) * pixels..][..pixels]);
        for ((value, on), off) in out.iter_mut().zip(on).zip(off) {
            *value = on - off;
        }
    }

    fn grey(&self) -> Grey {
        Grey::Signed
    }

    fn reset(&mut self) {
        self.lnes.reset();
    }
}
