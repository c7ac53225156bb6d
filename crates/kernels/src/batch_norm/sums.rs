//! Sums over planes of few pixels.

/// Sums held at a time in an inner loop, so that it runs on vectors.
const LANES: usize = 16;
/// Numbers after which lanes are added to what is held in double precision.
const HELD: usize = 1024;

/// Two sums over many short runs, in an order that depends on their lengths alone.
#[derive(Default)]
pub(super) struct Sums {
    lanes: [[f32; LANES]; 2],
    /// Numbers in the lanes.
    held: usize,
    totals: (f64, f64),
}

impl Sums {
    /// Adds both results of `term` over pairs.
    #[inline(always)]
    pub(super) fn add(&mut self, xs: &[f32], ys: &[f32], term: impl Fn(f32, f32) -> (f32, f32)) {
        let [first, second] = &mut self.lanes;
        let (x_blocks, x_rest) = xs.as_chunks::<LANES>();
        let (y_blocks, y_rest) = ys.as_chunks::<LANES>();
        for (xs, ys) in x_blocks.iter().zip(y_blocks) {
            for lane in 0..LANES {
                let (a, b) = term(xs[lane], ys[lane]);
                first[lane] += a;
                second[lane] += b;
            }
        }
        for (lane, (x, y)) in x_rest.iter().zip(y_rest).enumerate() {
            let (a, b) = term(*x, *y);
            first[lane] += a;
            second[lane] += b;
        }
        self.held += xs.len();
        if self.held >= HELD {
            self.flush();
        }
    }

    /// Lanes are summed rarely: planes of deep layers have a few pixels only.
    fn flush(&mut self) {
        let [first, second] = self.lanes.map(|lanes| lanes.iter().map(|&v| f64::from(v)).sum());
        let sums: (f64, f64) = (first, second);
        self.totals = (self.totals.0 + sums.0, self.totals.1 + sums.1);
        (self.lanes, self.held) = ([[0.0; LANES]; 2], 0);
    }

    pub(super) fn totals(mut self) -> (f64, f64) {
        self.flush();
        self.totals
    }
}
