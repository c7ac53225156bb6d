//! Times that count from one that the header states, as faery writes them (`% T0 1700000000`).

use evpose_core::Micros;

use super::{DecodeResult, Decoder};
use crate::Columns;

/// A decoder whose times count from `t0`.
#[derive(Debug, Clone)]
pub(crate) struct Shifted<D> {
    decoder: D,
    t0: i64,
}

impl<D> Shifted<D> {
    pub(crate) fn new(decoder: D, t0: i64) -> Self {
        Self { decoder, t0 }
    }
}

impl<D: Decoder> Decoder for Shifted<D> {
    fn decode(&mut self, bytes: &[u8], is_last: bool, columns: &mut Columns) -> DecodeResult {
        let before = columns.len();
        let decoded = self.decoder.decode(bytes, is_last, columns);
        if self.t0 != 0 {
            let times = columns.t[before..].iter_mut();
            times.for_each(|t| *t = Micros(t.0.saturating_add(self.t0)));
        }
        decoded
    }

    fn missing(&self) -> Option<String> {
        self.decoder.missing()
    }

    fn duration(&self) -> Option<Micros> {
        self.decoder.duration()
    }

    fn remarks(&self) -> Vec<String> {
        self.decoder.remarks()
    }
}

#[cfg(test)]
mod tests {
    use crate::{Input, OpenOptions, read_as};

    #[test]
    fn times_of_raw_and_dat_files_count_from_what_the_header_states() {
        let raw = b"% evt 2.0\n% format EVT2;height=320;width=320\n% T0 1700000000\n% end\n\
                    \x00\x00\x00\x80\x05\x10\x40\x10";
        let dat = b"% Data file containing CD events.\n% Version 2\n% T0 1700000000\n% Height 9\n\
                    % Width 9\n\x0c\x08\x01\x00\x00\x00\x03\x00\x01\x00";
        for (name, bytes) in [("a.raw", &raw[..]), ("b.dat", &dat[..])] {
            let input = Input::memory(name, bytes.to_vec());
            let read = read_as(input, &OpenOptions::default()).unwrap();
            assert_eq!(read.stream.t()[0].0, 1_700_000_001, "{name}");
        }
    }
}
