//! Edges out of thinned gradients: pixels above the high threshold, and all that touch them, also
//! across corners, by way of pixels above the low one.
//!
//! Pixels are bits, 64 of a row in a word. Within a word, all that a seed reaches is found at once;
//! what it touches in the eight words around it are seeds there. One way down and one way up the
//! image reach nearly everything; where an edge winds, words wait on a stack.

const WORD: usize = 64;

/// Bit maps of candidate and confirmed edge pixels.
#[derive(Debug, Clone, Default)]
pub(super) struct EdgeMap {
    /// Words of a row of the image; one word of no pixels separates rows, and rows of such lie
    /// above and below.
    words: usize,
    candidates: Vec<u64>,
    edges: Vec<u64>,
    waiting: Vec<u32>,
}

impl EdgeMap {
    /// Makes room for an image without candidates.
    pub(super) fn start(&mut self, width: usize, height: usize) {
        self.words = width.div_ceil(WORD);
        // One more for the last word's neighbour to the lower right.
        let total = self.stride() * (height + 2) + 1;
        self.candidates.clear();
        self.candidates.resize(total, 0);
        self.edges.clear();
        self.edges.resize(total, 0);
        self.waiting.clear();
    }

    fn stride(&self) -> usize {
        self.words + 1
    }

    /// Index of the first word of row `y`.
    fn start_of(&self, y: usize) -> usize {
        (y + 1) * self.stride() + 1
    }

    /// The words of row `y`: candidates, and edges, which are a part of them.
    pub(super) fn row_mut(&mut self, y: usize) -> (&mut [u64], &mut [u64]) {
        let (start, words) = (self.start_of(y), self.words);
        (&mut self.candidates[start..][..words], &mut self.edges[start..][..words])
    }

    /// Lets edges go on through candidates.
    pub(super) fn grow(&mut self, height: usize) {
        let (first, end) = (self.start_of(0), self.start_of(height));
        for word in first..end {
            self.reach(word, |_| false);
        }
        // Two sweeps reach nearly all pixels; only what bends back again needs the stack.
        for word in (first..end).rev() {
            self.reach(word, |neighbour| neighbour > word);
        }
        while let Some(word) = self.waiting.pop() {
            self.reach(word as usize, |_| true);
        }
    }

    /// Grows the edges of a word through it and into the words around it; those of them that change
    /// and that `later` wants come onto the stack.
    #[inline(always)]
    fn reach(&mut self, word: usize, later: impl Fn(usize) -> bool) {
        let seeds = self.edges[word];
        if seeds == 0 {
            return;
        }
        let edges = flood(seeds, self.candidates[word]);
        self.edges[word] = edges;
        let stride = self.stride();
        // An edge reaches all eight neighbours: those above and below are these bits of other
        // words.
        let across = edges | (edges << 1) | (edges >> 1);
        let (to_left, to_right) = (edges << (WORD - 1), edges >> (WORD - 1));
        let (above, below) = (word - stride, word + stride);
        self.seed(above, across, &later);
        self.seed(below, across, &later);
        if to_left != 0 {
            for neighbour in [above - 1, word - 1, below - 1] {
                self.seed(neighbour, to_left, &later);
            }
        }
        if to_right != 0 {
            for neighbour in [above + 1, word + 1, below + 1] {
                self.seed(neighbour, to_right, &later);
            }
        }
    }

    #[inline(always)]
    fn seed(&mut self, word: usize, touched: u64, later: impl Fn(usize) -> bool) {
        let added = touched & self.candidates[word] & !self.edges[word];
        self.edges[word] |= added;
        if added != 0 && later(word) {
            // Images of more than 2³⁸ pixels are not made.
            self.waiting.push(word as u32);
        }
    }

    /// Writes row `y`: 255 where there is an edge, else 0.
    pub(super) fn draw(&self, y: usize, out: &mut [u8]) {
        let edges = &self.edges[self.start_of(y)..][..self.words];
        for (word, out) in edges.iter().zip(out.chunks_mut(WORD)) {
            let (eights, rest) = out.as_chunks_mut::<8>();
            let bytes = word.to_le_bytes();
            rest.copy_from_slice(&SPREAD[usize::from(bytes[eights.len() % 8])][..rest.len()]);
            for (eight, byte) in eights.iter_mut().zip(bytes) {
                *eight = SPREAD[usize::from(byte)];
            }
        }
    }
}

/// The runs of `candidates` that hold a seed.
#[inline(always)]
fn flood(seeds: u64, candidates: u64) -> u64 {
    // Towards high bits: a carry runs from a seed to the end of its run and leaves zeros.
    let mut reached = (candidates & !candidates.wrapping_add(seeds)) | seeds;
    // Towards low bits: 1, 2, 4, … steps at once where all between are candidates.
    let mut open = candidates;
    for step in [1, 2, 4, 8, 16, 32] {
        reached |= open & (reached >> step);
        open &= open >> step;
    }
    reached
}

/// Eight bits as eight pixels.
static SPREAD: [[u8; 8]; 256] = {
    let mut spread = [[0; 8]; 256];
    let mut byte = 0;
    while byte < 256 {
        let mut bit = 0;
        while bit < 8 {
            if byte >> bit & 1 == 1 {
                spread[byte][bit] = 255;
            }
            bit += 1;
        }
        byte += 1;
    }
    spread
};

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_fills_whole_runs_and_no_others() {
        let mut rng = evpose_core::CounterRng::new(1, "flood", 0);
        for round in 0..20_000 {
            let mut candidates = rng.bits();
            for _ in 0..round % 4 {
                candidates |= rng.bits();
            }
            let seeds = rng.bits() & rng.bits() & rng.bits() & candidates;
            let mut expected = seeds;
            for _ in 0..WORD {
                expected |= candidates & ((expected << 1) | (expected >> 1));
            }
            assert_eq!(flood(seeds, candidates), expected, "{seeds:x} in {candidates:x}");
        }
    }

    /// Pixel by pixel: all that edges reach.
    fn defined(width: usize, height: usize, candidates: &[bool], edges: &mut [bool]) {
        let mut waiting: Vec<_> = (0..edges.len()).filter(|&i| edges[i]).collect();
        while let Some(i) = waiting.pop() {
            let (x, y) = (i % width, i / width);
            for y in y.saturating_sub(1)..(y + 2).min(height) {
                for x in x.saturating_sub(1)..(x + 2).min(width) {
                    let i = y * width + x;
                    if candidates[i] && !edges[i] {
                        edges[i] = true;
                        waiting.push(i);
                    }
                }
            }
        }
    }

    #[test]
    fn edges_reach_what_a_search_pixel_by_pixel_reaches() {
        let mut rng = evpose_core::CounterRng::new(2, "grow", 0);
        let mut map = EdgeMap::default();
        for round in 0..600 {
            let (width, height) = (1 + rng.below(200), 1 + rng.below(60));
            // Around the density at which paths through the whole image appear.
            let share = 0.2 + 0.05 * (round % 8) as f32;
            let candidates: Vec<_> = (0..width * height).map(|_| rng.chance(share)).collect();
            let mut edges: Vec<_> = candidates.iter().map(|&c| c && rng.chance(0.01)).collect();
            map.start(width, height);
            for i in 0..width * height {
                let (row, strong) = map.row_mut(i / width);
                let (word, bit) = (i % width / WORD, i % width % WORD);
                row[word] |= u64::from(candidates[i]) << bit;
                strong[word] |= u64::from(edges[i]) << bit;
            }
            map.grow(height);
            defined(width, height, &candidates, &mut edges);
            let mut drawn = vec![7; width];
            for (y, expected) in edges.chunks(width).enumerate() {
                map.draw(y, &mut drawn);
                let expected: Vec<_> = expected.iter().map(|&e| if e { 255 } else { 0 }).collect();
                assert_eq!(drawn, expected, "row {y} of {width}x{height}");
            }
        }
    }
}
