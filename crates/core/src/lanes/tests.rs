//! Every operation, on the processor at hand and on any.

use super::portable::Portable;
use super::{LANES, LaneWork, Lanes, in_lanes};
use crate::CounterRng;

/// The bits of what every operation makes of two vectors.
struct All {
    a: [f32; LANES],
    b: [f32; LANES],
}

impl LaneWork for All {
    type Output = Vec<[i32; LANES]>;

    #[inline(always)]
    fn run<L: Lanes>(self, l: L) -> Self::Output {
        let (a, b) = (l.load(self.a), l.load(self.b));
        let numbers = [
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
        let rows = numbers[..LANES].try_into().unwrap_or([a; LANES]);
        let mut out = vec![
            l.less(a, b),
            l.add_i(i, j),
            l.sub_i(i, j),
            l.mul_i(i, j),
            l.max_i(i, j),
            l.min_i(i, j),
            l.greater_i(i, j),
            l.and(i, j),
            l.or(i, j),
            l.and_not(i, j),
            l.negative(i),
            l.shift_right::<8>(i),
            l.shift_right_signed::<8>(i),
            l.splat_i(l.mask_bits(l.greater_i(i, j)) as i32),
            l.select(l.less(a, b), i, j),
            l.splat_i(self.b[5] as i32),
            l.load_i(l.store_i(j)),
            l.bits(l.numbers(i)),
            l.bits(l.to_f(j)),
        ];
        out.extend(numbers.map(|number| l.bits(number)));
        out.extend(l.transpose(rows).map(|row| l.bits(row)));
        let first = l.store_i(i);
        let rows = first.map(|first| [first, first + 1, first + 2, first + 3]);
        out.extend(l.columns(rows.each_ref()));
        let mut rows = [[0; 4]; LANES];
        l.rows([i, j, l.max_i(i, j), l.min_i(i, j)], &mut rows);
        out.extend(l.columns(rows.each_ref()));
        out.into_iter().map(|vector| l.store_i(vector)).collect()
    }
}

#[test]
fn vectors_of_this_processor_and_arrays_give_the_same_bits() {
    let mut rng = CounterRng::new(3, "lanes", 0);
    for _ in 0..1_000 {
        let mut draw = || std::array::from_fn(|_| rng.uniform(-1e6, 1e6).round() / 8.0);
        let (a, b) = (draw(), draw());
        assert_eq!(in_lanes(All { a, b }), All { a, b }.run(Portable), "{a:?} {b:?}");
    }
}

#[test]
fn columns_have_a_number_of_every_row() {
    let rows = std::array::from_fn(|k| std::array::from_fn(|i| (10 * k + i) as i32));
    let columns = Portable.columns(rows.each_ref());
    let mut again = [[0; 4]; LANES];
    Portable.rows(columns, &mut again);
    assert!((0..4).all(|i| (0..LANES).all(|k| columns[i][k] == (10 * k + i) as i32)));
    assert_eq!(again, rows);
    assert_eq!(Portable.mask_bits([0, -1, 0, 0, -1, 0, 0, -1]), 0b1001_0010);
}

#[test]
fn a_transposed_square_has_rows_for_columns() {
    let rows = std::array::from_fn(|i| std::array::from_fn(|k| (10 * i + k) as f32));
    let columns = Portable.transpose(rows);
    assert!((0..LANES).all(|i| (0..LANES).all(|k| columns[i][k] == (10 * k + i) as f32)));
}
