//! Inception v3, layout and weights as torchvision's, without the auxiliary classifier.
//!
//! Branches of convolutions of different sizes beside each other, whose channels are joined; large
//! kernels are factorised into rows and columns. torchvision's dropout of 0.5 before the last layer is
//! left out, for the reasons given in [`mobilenet_v2`](super::mobilenet_v2), and its input is not
//! transformed.
//!
//! # Source
//! Szegedy et al.: *Rethinking the Inception Architecture for Computer Vision*, CVPR 2016; layers and
//! names after torchvision.

use burn::module::Module;
use burn::nn::Linear;
use burn::nn::pool::{AdaptiveAvgPool2d, AdaptiveAvgPool2dConfig, MaxPool2d, MaxPool2dConfig};
use burn::tensor::Device;

use super::IMAGE_CHANNELS;
use super::spec::{BackboneNet, BackboneSpec};
use crate::channels::scaled;
use crate::conv_norm::{ConvNorm, ConvNormConfig};
use crate::initializer::Initializer;
use crate::linear::linear;
use crate::net_ops::{NetOps, VectorOps};
use crate::parameters::Slot;

pub(super) const INCEPTION_V3: BackboneSpec<InceptionV3> = BackboneSpec {
    name: "inception_v3",
    about: "Inception v3 (Szegedy et al. 2016): branches of rows and columns, twice the parameters",
    smallest_px: 75,
    narrowest: 1.0 / 64.0,
    build: InceptionV3::new,
};

/// Epsilon of all normalisations.
const EPSILON: f64 = 1e-3;
/// Names of the stem's convolutions in torchvision.
const STEM: [&str; 5] =
    ["Conv2d_1a_3x3", "Conv2d_2a_3x3", "Conv2d_2b_3x3", "Conv2d_3b_1x1", "Conv2d_4a_3x3"];
/// Convolutions of the stem before its first max-pool; the second is behind all.
const STEM_BEFORE_POOL: usize = 3;

/// The network: a stem, then blocks.
#[derive(Module, Debug)]
pub(crate) struct InceptionV3 {
    stem: Vec<ConvNorm>,
    /// Of the stem and of blocks that halve the image.
    pool: MaxPool2d,
    blocks: Vec<Block>,
    mean: AdaptiveAvgPool2d,
    head: Linear,
}

/// Branches beside each other, whose channels are joined.
#[derive(Module, Debug)]
struct Block {
    branches: Vec<Branch>,
    /// The convolution behind the local mean; a block without one halves the image, and this branch
    /// is a max-pool.
    pooled: Option<ConvNorm>,
}

/// Convolutions one after the other, then none or two beside each other.
#[derive(Module, Debug)]
struct Branch {
    convs: Vec<ConvNorm>,
    fork: Vec<ConvNorm>,
}

/// Shape of a block.
struct BlockPlan {
    name: &'static str,
    branches: Vec<BranchPlan>,
    /// Channels of the pooled branch; none where the block halves the image.
    pooled: Option<usize>,
}

/// Shape of a branch.
struct BranchPlan {
    name: &'static str,
    /// Kernel and channels of each convolution.
    convs: Vec<(Window, usize)>,
    /// Channels of the two convolutions at the end, of a row and of a column of three pixels.
    fork: Option<usize>,
}

/// Kernel of a convolution.
#[derive(Clone, Copy, PartialEq)]
enum Window {
    /// That keeps the size of the image: rows and columns.
    Same(usize, usize),
    /// 3x3 of stride 2, whole windows only.
    Halving,
    /// 3x3, whole windows only.
    Whole,
}

use Window::{Halving, Same, Whole};

const ONE: Window = Same(1, 1);
const ROW: Window = Same(1, 7);
const COLUMN: Window = Same(7, 1);

fn branch(name: &'static str, convs: &[(Window, usize)]) -> BranchPlan {
    BranchPlan { name, convs: convs.to_vec(), fork: None }
}

/// All blocks as published, and by their names in torchvision.
fn plans() -> Vec<BlockPlan> {
    // The three kinds of blocks at 35, 17 and 8 pixels of side, at the published input of 299.
    let first = |name, pooled| BlockPlan {
        name,
        branches: vec![
            branch("branch1x1", &[(ONE, 64)]),
            branch("branch5x5", &[(ONE, 48), (Same(5, 5), 64)]),
            branch("branch3x3dbl", &[(ONE, 64), (Same(3, 3), 96), (Same(3, 3), 96)]),
        ],
        pooled: Some(pooled),
    };
    let second = |name, inner| {
        // A 7x7 window as a row and a column takes 14 weights for each pair of channels, not 49.
        let long = [(ONE, inner), (COLUMN, inner), (ROW, inner), (COLUMN, inner), (ROW, 192)];
        BlockPlan {
            name,
            branches: vec![
                branch("branch1x1", &[(ONE, 192)]),
                branch("branch7x7", &[(ONE, inner), (ROW, inner), (COLUMN, 192)]),
                branch("branch7x7dbl", &long),
            ],
            pooled: Some(192),
        }
    };
    let third = |name| {
        // On the coarsest grid the published blocks grow wider, by 1x3 and 3x1 side by side.
        let forked = |name, convs| BranchPlan { fork: Some(384), ..branch(name, convs) };
        BlockPlan {
            name,
            branches: vec![
                branch("branch1x1", &[(ONE, 320)]),
                forked("branch3x3", &[(ONE, 384)]),
                forked("branch3x3dbl", &[(ONE, 448), (Same(3, 3), 384)]),
            ],
            pooled: Some(192),
        }
    };
    let halving = |name, branches| BlockPlan { name, branches, pooled: None };
    vec![
        first("Mixed_5b", 32),
        first("Mixed_5c", 64),
        first("Mixed_5d", 64),
        halving(
            "Mixed_6a",
            vec![
                branch("branch3x3", &[(Halving, 384)]),
                branch("branch3x3dbl", &[(ONE, 64), (Same(3, 3), 96), (Halving, 96)]),
            ],
        ),
        second("Mixed_6b", 128),
        second("Mixed_6c", 160),
        second("Mixed_6d", 160),
        second("Mixed_6e", 192),
        halving(
            "Mixed_7a",
            vec![
                branch("branch3x3", &[(ONE, 192), (Halving, 320)]),
                branch("branch7x7x3", &[(ONE, 192), (ROW, 192), (COLUMN, 192), (Halving, 192)]),
            ],
        ),
        third("Mixed_7b"),
        third("Mixed_7c"),
    ]
}

impl InceptionV3 {
    /// The network with all weights zero.
    fn new(width: f32, outputs: usize, device: &Device) -> Self {
        let conv = |channels: &mut usize, window: Window, published: usize| {
            let to = scaled(published, width);
            let from = std::mem::replace(channels, to);
            window.config(from, to).with_epsilon(EPSILON).init(device)
        };
        let mut channels = IMAGE_CHANNELS;
        let stem = [(Halving, 32), (Whole, 32), (Same(3, 3), 64), (ONE, 80), (Whole, 192)];
        let stem = stem.map(|(window, to)| conv(&mut channels, window, to)).into();
        let mut blocks = Vec::new();
        for plan in plans() {
            let mut joined = 0;
            let mut branches = Vec::new();
            for BranchPlan { convs, fork, .. } in plan.branches {
                // All branches begin at the input of the block; `channels` itself moves on at its
                // end.
                let mut at = channels;
                let convs = convs.iter().map(|(window, to)| conv(&mut at, *window, *to)).collect();
                let forked = |window| fork.map(|to| conv(&mut at.clone(), window, to));
                let fork: Vec<ConvNorm> =
                    [Same(1, 3), Same(3, 1)].into_iter().filter_map(forked).collect();
                let ends = fork.iter().map(|conv| conv.conv.weight.dims()[0]).sum();
                joined += if fork.is_empty() { at } else { ends };
                branches.push(Branch { convs, fork });
            }
            let pooled = plan.pooled.map(|to| conv(&mut channels.clone(), ONE, to));
            // A halving block appends its pooled input as it is.
            let last = pooled.as_ref().map_or(channels, |conv| conv.conv.weight.dims()[0]);
            channels = joined + last;
            blocks.push(Block { branches, pooled });
        }
        Self {
            stem,
            pool: MaxPool2dConfig::new([3, 3]).with_strides([2, 2]).init(),
            blocks,
            mean: AdaptiveAvgPool2dConfig::new([1, 1]).init(),
            head: linear(channels, outputs, device),
        }
    }
}

impl Window {
    fn config(self, from: usize, to: usize) -> ConvNormConfig {
        match self {
            Self::Same(rows, columns) => ConvNormConfig::rectangular(from, to, [rows, columns]),
            Self::Halving => ConvNormConfig::new(from, to, 3).with_stride(2).without_padding(),
            Self::Whole => ConvNormConfig::new(from, to, 3).without_padding(),
        }
    }
}

impl Block {
    fn forward<N: NetOps>(&self, input: N, pool: &MaxPool2d) -> N {
        let mut parts: Vec<N> =
            self.branches.iter().map(|branch| branch.forward(input.clone())).collect();
        parts.push(match &self.pooled {
            Some(conv) => conv.forward_relu(input.local_mean()),
            None => input.max_pool(pool),
        });
        N::concat(parts)
    }
}

impl Branch {
    fn forward<N: NetOps>(&self, input: N) -> N {
        let x = self.convs.iter().fold(input, |x, conv| conv.forward_relu(x));
        match self.fork.as_slice() {
            [] => x,
            fork => N::concat(fork.iter().map(|conv| conv.forward_relu(x.clone())).collect()),
        }
    }
}

impl BackboneNet for InceptionV3 {
    fn forward<N: NetOps>(&self, images: N) -> N::Vector {
        let mut x = images;
        for (index, conv) in self.stem.iter().enumerate() {
            if index == STEM_BEFORE_POOL {
                x = x.max_pool(&self.pool);
            }
            x = conv.forward_relu(x);
        }
        x = x.max_pool(&self.pool);
        for block in &self.blocks {
            x = block.forward(x, &self.pool);
        }
        x.avg_pool(&self.mean).linear(&self.head)
    }

    /// As torchvision initialises: normals of deviation 0.1 for all weights.
    fn initializer(&self, slot: &Slot) -> Initializer {
        match slot.layer.as_str() {
            "BatchNorm" => Initializer::batch_norm(slot.name()),
            "Conv2d" => Initializer::Normal { deviation: 0.1 },
            _ if slot.is_linear_weight() => Initializer::Normal { deviation: 0.1 },
            _ => Initializer::torch_default(self.head.weight.dims()[0]),
        }
    }

    /// `blocks.3.branches.1.convs.0.conv.x` is `Mixed_6a.branch3x3dbl_1.conv.x`.
    fn torchvision_path(&self, path: &str) -> String {
        let parts: Vec<&str> = path.split('.').collect();
        let number = |text: &str| text.parse::<usize>().unwrap_or(0);
        let kind = |kind: &str| if kind == "norm" { "bn" } else { "conv" };
        match *parts.as_slice() {
            ["stem", index, layer, name] => {
                format!("{}.{}.{name}", STEM[number(index)], kind(layer))
            }
            ["blocks", block, "pooled", layer, name] => {
                let block = &plans()[number(block)];
                format!("{}.branch_pool.{}.{name}", block.name, kind(layer))
            }
            ["blocks", block, "branches", branch, part, index, layer, name] => {
                let block = &plans()[number(block)];
                let branch = &block.branches[number(branch)];
                // torchvision counts the convolutions of a branch from 1, unless it has only one.
                let (count, index) = (branch.convs.len(), number(index));
                let suffix = match part {
                    "fork" => format!("_{}{}", count + 1, ["a", "b"][index]),
                    _ if count == 1 && branch.fork.is_none() => String::new(),
                    _ => format!("_{}", index + 1),
                };
                format!("{}.{}{suffix}.{}.{name}", block.name, branch.name, kind(layer))
            }
            ["head", name] => format!("fc.{name}"),
            _ => path.to_owned(),
        }
    }
}
