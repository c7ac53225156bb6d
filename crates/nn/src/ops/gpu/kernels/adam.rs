//! The kernel of a step of Adam.

use cubecl::prelude::*;

/// New values of a parameter and of its two moments. `correction_1` is one less the power of `beta_1`,
/// `correction_2` the root of one less that of `beta_2`.
#[cube(launch_unchecked, address_type = "dynamic")]
pub(crate) fn adam<E: Float>(
    parameter: &Tensor<E>,
    gradient: &Tensor<E>,
    first: &Tensor<E>,
    second: &Tensor<E>,
    next: &mut Tensor<E>,
    next_first: &mut Tensor<E>,
    next_second: &mut Tensor<E>,
    learning_rate: f32,
    weight_decay: f32,
    beta_1: f32,
    beta_2: f32,
    correction_1: f32,
    correction_2: f32,
    epsilon: f32,
    #[define(E)] _element: ElemType,
) {
    if ABSOLUTE_POS >= next.len() {
        terminate!();
    }
    let value = parameter[ABSOLUTE_POS];
    // The decay joins the gradient before the moments: Adam's L2 penalty, not AdamW's.
    let slope = gradient[ABSOLUTE_POS] + E::cast_from(weight_decay) * value;
    let (one, beta_1, beta_2) = (E::from_int(1), E::cast_from(beta_1), E::cast_from(beta_2));
    let mean = beta_1 * first[ABSOLUTE_POS] + (one - beta_1) * slope;
    let square = beta_2 * second[ABSOLUTE_POS] + (one - beta_2) * slope * slope;
    // The epsilon is added after the correction, as in Burn: a GPU trains as the CPU does.
    let root = E::sqrt(square) / E::cast_from(correction_2) + E::cast_from(epsilon);
    let step = E::cast_from(learning_rate) * (mean / E::cast_from(correction_1)) / root;
    next[ABSOLUTE_POS] = value - step;
    next_first[ABSOLUTE_POS] = mean;
    next_second[ABSOLUTE_POS] = square;
}
