//! Fused layers: consecutive layers computed band by band, so that activations between them stay in
//! the L2 cache.
//!
//! Activations of the first layers of a network are larger than the caches, and writing and reading
//! them takes as long as computing them. A chain computes a few rows of its last layer and, before
//! them, the rows of the earlier layers that these depend on; rows that the next few depend on too
//! are kept. Stems with their pooling, inverted residuals and heads are chains.
//!
//! # Source
//! Alwani, Chen, Ferdman, Milder: *Fused-Layer CNN Accelerators*, MICRO 2016.

mod execution;

use std::ops::Range;

use super::ThreadPool;
use super::conv::Conv;
use super::depthwise::Depthwise;
use super::image::{Image, Line, OVERREAD};
use super::nchw::NchwImage;
use super::nchw_conv::NchwConv;
use super::pool::MaxPool;
use super::tile::Activation;
use super::winograd::Scratch;
use crate::cache::l2_share_bytes;
use crate::simd::{LANES, Level};
use execution::{BandMemory, ChainExec};

/// Share of an L2 cache for all bands of a thread: they stay there beside the weights.
const L2_BAND_SHARE: f64 = 0.39;
/// Largest number of rows of the last layer that are computed at once.
const MAX_ROWS: usize = 8;

/// A layer of a chain.
#[derive(Debug, Clone)]
pub enum Link {
    /// A convolution of an image in nchw; only the first.
    Nchw(NchwConv, Activation),
    /// A direct convolution.
    Conv(Conv, Activation),
    /// A depthwise convolution.
    Depthwise(Depthwise, Activation),
    /// Max-pooling.
    MaxPool(MaxPool),
}

/// Input of a chain, in the layout that its first layer takes.
#[derive(Debug, Clone, Copy)]
pub enum ChainInput<'a> {
    /// An image in nChw16c.
    Image(&'a Image),
    /// An image in nchw.
    Nchw(&'a NchwImage),
}

/// Fused layers.
#[derive(Debug, Clone)]
pub struct Chain {
    level: Level,
    links: Vec<Link>,
    /// Channels, height and width of the input, then of each layer's output.
    sizes: Vec<[usize; 3]>,
    /// For each max-pooling, the columns of its windows; empty for other layers.
    columns: Vec<Vec<Range<usize>>>,
    /// For each layer but the last, memory for some rows of its output.
    bands: Vec<Band>,
    /// Rows of the last layer that are computed at once.
    rows_at_once: usize,
}

/// Layout of a band: memory for some rows of all channels of an activation.
#[derive(Debug, Clone, Copy)]
struct Band {
    /// Zero pixels to the left and right.
    border: usize,
    /// Lines from a row to the next.
    row_pitch: usize,
    /// Lines from a channel block to the next; in nchw from a channel to the next.
    block_pitch: usize,
    /// Channel blocks; in nchw channels.
    blocks: usize,
    is_nchw: bool,
    /// Offset of the band in a thread's memory, in lines.
    first: usize,
}

impl Link {
    /// Window size, stride and padding.
    fn window(&self) -> [usize; 3] {
        let of = |kernel: usize, stride: usize| [kernel, stride, kernel / 2];
        match self {
            Self::Nchw(conv, _) => of(conv.shape().kernel[0], conv.shape().stride),
            Self::Conv(conv, _) => of(conv.shape().kernel[0], conv.shape().stride),
            Self::Depthwise(conv, _) => of(conv.shape().kernel, conv.shape().stride),
            Self::MaxPool(pool) => [pool.window, pool.stride, pool.padding],
        }
    }

    /// Zero border that the layer needs around its input.
    fn border(&self) -> usize {
        match self {
            // Its windows are cut at the edges.
            Self::MaxPool(_) => 0,
            _ => self.window()[2],
        }
    }

    /// Channels, height and width of the output for an input of such a size.
    fn output(&self, [channels, height, width]: [usize; 3]) -> [usize; 3] {
        match self {
            Self::Nchw(conv, _) => [conv.shape().channels_out, height, width],
            Self::Conv(conv, _) => {
                let [rows, columns] = conv.shape().output([height, width]);
                [conv.shape().channels_out, rows, columns]
            }
            Self::Depthwise(conv, _) => {
                let sides = [height, width].map(|side| side.div_ceil(conv.shape().stride));
                [channels, sides[0], sides[1]]
            }
            Self::MaxPool(pool) => [channels, pool.output(height), pool.output(width)],
        }
    }

    /// Input rows that output rows `rows` depend on, rows of the padding included.
    fn input_rows(&self, rows: &Range<isize>) -> Range<isize> {
        let [window, stride, padding] = self.window().map(|side| side as isize);
        rows.start * stride - padding..(rows.end - 1) * stride - padding + window
    }
}

impl Chain {
    /// Fuses layers, each of which takes the output of the one before it, for an input of `input`
    /// channels, height and width.
    ///
    /// # Panics
    /// If a layer cannot take the output of the one before it, or one that is not the first takes
    /// nchw.
    pub fn new(links: Vec<Link>, input: [usize; 3], level: Level) -> Self {
        assert!(!links.is_empty(), "layers");
        let mut sizes = vec![input];
        for (at, link) in links.iter().enumerate() {
            let channels = match link {
                Link::Nchw(conv, _) => conv.shape().channels_in,
                Link::Conv(conv, _) => conv.shape().channels_in,
                Link::Depthwise(conv, _) => conv.shape().channels,
                Link::MaxPool(_) => sizes[at][0],
            };
            // Sizes are checked here once, so that no kernel has to.
            assert_eq!(channels, sizes[at][0], "channels of layer {at}");
            let is_nchw = matches!(link, Link::Nchw(..));
            assert!(!is_nchw || at == 0, "only the first takes nchw");
            // It writes nchw here, which only a convolution reads.
            let next = links.get(at + 1);
            assert!(!is_nchw || matches!(next, Some(Link::Conv(..))), "a convolution of nchw");
            sizes.push(link.output(sizes[at]));
        }
        let columns = |(link, size): (&Link, &[usize; 3])| match link {
            Link::MaxPool(pool) => pool.windows([size[1], size[2]])[1].clone(),
            _ => Vec::new(),
        };
        let columns = links.iter().zip(&sizes).map(columns).collect();
        let rows_at_once = MAX_ROWS;
        let mut chain = Self { level, links, sizes, columns, bands: Vec::new(), rows_at_once };
        // The more rows at once, the fewer are moved in the bands: as many as fit in the cache.
        loop {
            chain.bands = chain.bands_for(chain.rows_at_once);
            if chain.rows_at_once == 1
                || chain.lines() * size_of::<Line>() <= l2_share_bytes(L2_BAND_SHARE)
            {
                return chain;
            }
            chain.rows_at_once -= 1;
        }
    }

    /// Channels, height and width of the output.
    pub fn output(&self) -> [usize; 3] {
        self.sizes[self.links.len()]
    }

    /// Zero border that the chain needs around its input.
    pub fn border(&self) -> usize {
        self.links[0].border()
    }

    /// Bands for `rows` rows of the last layer at once.
    fn bands_for(&self, rows: usize) -> Vec<Band> {
        let mut bands = Vec::new();
        // From the last layer back: each says how many rows it needs of the one before.
        let mut needed = 0..rows as isize;
        for (at, link) in self.links.iter().enumerate().skip(1).rev() {
            needed = link.input_rows(&needed);
            let [channels, _, width] = self.sizes[at];
            let border = link.border();
            let is_nchw = matches!(self.links[at - 1], Link::Nchw(..));
            let (row_pitch, blocks) = if is_nchw {
                // One vector more, since loads at the last pixels read past it.
                ((width + 2 * border + LANES).div_ceil(LANES), channels)
            } else {
                (width + 2 * border + OVERREAD, channels.div_ceil(LANES))
            };
            let block_pitch = needed.len() * row_pitch;
            bands.push(Band { border, row_pitch, block_pitch, blocks, is_nchw, first: 0 });
        }
        bands.reverse();
        // Bands lie one behind the other in one piece of memory.
        let mut first = 0;
        for band in &mut bands {
            band.first = first;
            first += band.lines();
        }
        bands
    }

    /// Lines of all bands of a thread.
    fn lines(&self) -> usize {
        self.bands.iter().map(Band::lines).sum()
    }

    /// Writes the output of the last layer to `output`. `residual` is added to the sums of the last
    /// layer, which must be a convolution then.
    ///
    /// # Panics
    /// If an image has another size, the border of the input is narrower than that of the first
    /// layer, there is a residual for a layer other than a convolution, or more than 16 channels in
    /// nchw.
    pub fn run(
        &self,
        thread_pool: &ThreadPool,
        input: ChainInput<'_>,
        residual: Option<&Image>,
        output: &mut Image,
        scratch: &mut Scratch,
    ) {
        let size = |image: &Image| [image.channels(), image.height(), image.width()];
        match (input, &self.links[0]) {
            (ChainInput::Image(image), Link::Conv(..) | Link::Depthwise(..) | Link::MaxPool(_)) => {
                assert_eq!(size(image), self.sizes[0], "size of the input");
                assert!(image.border() >= self.border(), "a border as wide as the padding");
            }
            (ChainInput::Nchw(image), Link::Nchw(..) | Link::Conv(..)) => {
                assert_eq!(image.size(), self.sizes[0], "size of the input");
                assert!(self.sizes[0][0] <= LANES, "at most sixteen channels in nchw");
                assert!(image.border() >= self.border(), "a border as wide as the padding");
            }
            _ => panic!("an input that the first layer takes"),
        }
        assert_eq!(size(output), self.output(), "size of the output");
        let takes_residual = matches!(self.links.last(), Some(Link::Conv(..)));
        assert!(residual.is_none_or(|image| takes_residual && size(image) == self.output()));
        let lines_per_thread = self.lines();
        let memory = BandMemory(scratch.lines(lines_per_thread * thread_pool.threads()));
        let rows = self.output()[1];
        let (residual, output) = (residual.map(Image::src), output.dst());
        thread_pool.run(&|part| {
            let memory = memory.from(part.index * lines_per_thread);
            let exec = ChainExec { chain: self, input, residual, output, memory };
            // SAFETY: sizes were compared, rows of the parts are disjoint, each has memory of its
            // own, and the level is one of this processor's.
            unsafe { exec.run(part.chunk(rows)) };
        });
    }
}

impl Band {
    fn lines(&self) -> usize {
        self.blocks * self.block_pitch
    }
}
