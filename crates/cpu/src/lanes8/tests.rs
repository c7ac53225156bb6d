//! Every operation, at the best level of this processor and portable.

use super::portable::Portable;
use super::{Kernel8, LANES_8, Lanes8, dispatch};

/// The result bits of every operation on two vectors.
struct All {
    a: [f32; LANES_8],
    b: [f32; LANES_8],
}

impl Kernel8 for All {
    type Output = Vec<[i32; LANES_8]>;

    #[inline(always)]
    fn run<L: Lanes8>(self, l: L) -> Self::Output {
        let (a, b) = (l.load(self.a), l.load(self.b));
        let floats = [
            l.add(a, b),
            l.sub(a, b),
            l.mul(a, b),
            l.div(a, b),
            l.sqrt(l.mul(a, a)),
            l.min(a, b),
            l.max(a, b),
            l.floor(a),
            l.splat(self.b[3]),
            l.load(l.store(a)),
        ];
        let (i, j) = (l.to_i(a), l.to_i(b));
        let rows = floats[..LANES_8].try_into().unwrap_or([a; LANES_8]);
        let mut out = vec![
            l.lt(a, b),
            l.le(a, b),
            l.le(a, a),
            l.add_i(i, j),
            l.sub_i(i, j),
            l.mul_i(i, j),
            l.max_i(i, j),
            l.min_i(i, j),
            l.gt_i(i, j),
            l.and(i, j),
            l.or(i, j),
            l.and_not(i, j),
            l.sign_mask(i),
            l.shift_right::<8>(i),
            l.shift_right_signed::<8>(i),
            l.splat_i(l.to_bitmask(l.gt_i(i, j)) as i32),
            l.select(l.lt(a, b), i, j),
            l.splat_i(self.b[5] as i32),
            l.load_i(l.store_i(j)),
            l.to_bits(l.from_bits(i)),
            l.to_bits(l.to_f(j)),
        ];
        out.extend(floats.map(|value| l.to_bits(value)));
        out.extend(l.transpose(rows).map(|row| l.to_bits(row)));
        let first = l.store_i(i);
        let rows = first.map(|first| [first, first + 1, first + 2, first + 3]);
        out.extend(l.gather_columns(rows.each_ref()));
        let mut rows = [[0; 4]; LANES_8];
        l.scatter_columns([i, j, l.max_i(i, j), l.min_i(i, j)], &mut rows);
        out.extend(l.gather_columns(rows.each_ref()));
        out.into_iter().map(|vector| l.store_i(vector)).collect()
    }
}

#[test]
fn the_best_level_and_the_portable_one_give_the_same_bits() {
    const MULTIPLIER: u64 = 6_364_136_223_846_793_005;
    const INCREMENT: u64 = 1_442_695_040_888_963_407;
    let mut state = 3_u64;
    for _ in 0..1_000 {
        let mut draw = || {
            std::array::from_fn(|_| {
                // Knuth's MMIX generator; the upper bits are the random ones.
                state = state.wrapping_mul(MULTIPLIER).wrapping_add(INCREMENT);
                ((state >> 43) as f32 - (1 << 20) as f32) / 8.0
            })
        };
        let (a, b) = (draw(), draw());
        assert_eq!(dispatch(All { a, b }), All { a, b }.run(Portable), "{a:?} {b:?}");
    }
}

#[test]
fn gathered_columns_scatter_back_into_rows() {
    let rows = std::array::from_fn(|k| std::array::from_fn(|i| (10 * k + i) as i32));
    let columns = Portable.gather_columns(rows.each_ref());
    let mut again = [[0; 4]; LANES_8];
    Portable.scatter_columns(columns, &mut again);
    assert!((0..4).all(|i| (0..LANES_8).all(|k| columns[i][k] == (10 * k + i) as i32)));
    assert_eq!(again, rows);
    assert_eq!(Portable.to_bitmask([0, -1, 0, 0, -1, 0, 0, -1]), 0b1001_0010);
}

#[test]
fn transposing_makes_rows_of_columns() {
    let rows = std::array::from_fn(|i| std::array::from_fn(|k| (10 * i + k) as f32));
    let columns = Portable.transpose(rows);
    assert!((0..LANES_8).all(|i| (0..LANES_8).all(|k| columns[i][k] == (10 * k + i) as f32)));
}
