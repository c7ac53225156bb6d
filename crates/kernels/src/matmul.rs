//! A safe face for the `gemm` crate: the only unsafe code of the workspace.

#![allow(unsafe_code, reason = "gemm takes raw pointers; their bounds are checked here")]

use gemm::Parallelism;

/// A matrix inside a slice: element `(i, j)` is `data[i * row_stride + j * column_stride]`.
#[derive(Debug, Clone, Copy)]
pub struct Matrix<'a> {
    data: &'a [f32],
    rows: usize,
    columns: usize,
    row_stride: usize,
    column_stride: usize,
}

impl<'a> Matrix<'a> {
    /// `[rows, columns]`, row after row.
    ///
    /// # Panics
    /// If `data` has another length than `rows * columns`.
    pub fn new(data: &'a [f32], rows: usize, columns: usize) -> Self {
        assert_eq!(data.len(), rows * columns, "a {rows}x{columns} matrix");
        Self { data, rows, columns, row_stride: columns, column_stride: 1 }
    }

    /// The same numbers as `[columns, rows]`.
    #[must_use]
    pub fn transposed(self) -> Self {
        Self {
            rows: self.columns,
            columns: self.rows,
            row_stride: self.column_stride,
            column_stride: self.row_stride,
            ..self
        }
    }
}

/// `out = a b`, or `out += a b` where `add` is set; on the calling thread.
///
/// # Shapes
/// - `a`: `[m, k]`, `b`: `[k, n]`
/// - `out`: `[m, n]`, row after row
///
/// # Panics
/// If the shapes do not fit each other.
pub fn matmul(out: &mut [f32], a: Matrix<'_>, b: Matrix<'_>, add: bool) {
    let (m, k, n) = (a.rows, a.columns, b.columns);
    assert_eq!(k, b.rows, "inner sizes");
    assert_eq!(out.len(), m * n, "a {m}x{n} product");
    if m == 0 || n == 0 {
        return;
    }
    if k == 0 {
        if !add {
            out.fill(0.0);
        }
        return;
    }
    let stride = |stride: usize| stride as isize;
    // SAFETY: gemm reads `a[i, l]` and `b[l, j]` and writes `out[i, j]` for `i < m`, `j < n`,
    // `l < k`. A `Matrix` spans exactly its slice: both constructors keep
    // `(rows - 1) * row_stride + (columns - 1) * column_stride == data.len() - 1`, and so does
    // `out` with strides `n` and 1, by the second assertion. `out` is borrowed mutably, hence
    // disjoint from both; its elements do not overlap, and all of it is initialised. Slices
    // are no longer than `isize::MAX` bytes, so that no offset overflows.
    unsafe {
        gemm::gemm(
            m,
            n,
            k,
            out.as_mut_ptr(),
            1,
            stride(n),
            add,
            a.data.as_ptr(),
            stride(a.column_stride),
            stride(a.row_stride),
            b.data.as_ptr(),
            stride(b.column_stride),
            stride(b.row_stride),
            1.0,
            1.0,
            false,
            false,
            false,
            Parallelism::None,
        );
    }
}
