//! Small dense systems of linear equations, by Gaussian elimination with partial pivoting.

/// Pivots below this make a system of any size singular: there only exact zeros and denormals
/// count.
const MIN_PIVOT: f64 = 1e-300;

/// Solves `matrix x = right` by elimination and back substitution; none where the matrix is
/// singular.
///
/// ```
/// use evpose_core::stats::linear::solve;
///
/// // x + y = 3, x - y = 1.
/// let matrix = vec![vec![1.0, 1.0], vec![1.0, -1.0]];
/// assert_eq!(solve(matrix, vec![3.0, 1.0]), Some(vec![2.0, 1.0]));
/// ```
pub fn solve(mut matrix: Vec<Vec<f64>>, mut right: Vec<f64>) -> Option<Vec<f64>> {
    let n = right.len();
    for column in 0..n {
        // With the largest pivot no factor is above 1 in magnitude, and errors stay small.
        let pivot = (column..n)
            .max_by(|a, b| matrix[*a][column].abs().total_cmp(&matrix[*b][column].abs()))?;
        if matrix[pivot][column].abs() < MIN_PIVOT {
            return None;
        }
        matrix.swap(column, pivot);
        right.swap(column, pivot);
        for row in column + 1..n {
            let factor = matrix[row][column] / matrix[column][column];
            let (above, below) = matrix.split_at_mut(row);
            let pairs = below[0][column..].iter_mut().zip(&above[column][column..]);
            pairs.for_each(|(value, pivot)| *value -= factor * pivot);
            right[row] -= factor * right[column];
        }
    }
    let mut x = vec![0.0; n];
    for row in (0..n).rev() {
        let known: f64 = (row + 1..n).map(|k| matrix[row][k] * x[k]).sum();
        x[row] = (right[row] - known) / matrix[row][row];
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_regular_system_is_solved_and_a_singular_one_is_not() {
        let matrix = vec![vec![0.0, 2.0, 1.0], vec![1.0, 1.0, 0.0], vec![3.0, 0.0, 1.0]];
        let x = solve(matrix.clone(), vec![7.0, 3.0, 6.0]).expect("regular");
        for (row, value) in matrix.iter().zip([7.0, 3.0, 6.0]) {
            let sum: f64 = row.iter().zip(&x).map(|(a, b)| a * b).sum();
            assert!((sum - value).abs() < 1e-12);
        }
        assert!(solve(vec![vec![1.0, 2.0], vec![2.0, 4.0]], vec![1.0, 2.0]).is_none());
    }

    #[test]
    fn rows_are_exchanged_where_a_pivot_is_zero() {
        let matrix = [
            [0.0, 2.0, 0.0, 0.0, 1.0],
            [1.0, 0.0, 0.0, 0.0, 0.0],
            [0.0, 0.0, 3.0, 0.0, 0.0],
            [0.0, 0.0, 1.0, 1.0, 0.0],
            [1.0, 0.0, 0.0, 0.0, 1.0],
        ];
        let x = solve(matrix.map(Vec::from).to_vec(), vec![9.0, 1.0, 9.0, 7.0, 6.0]);
        assert_eq!(x, Some(vec![1.0, 2.0, 3.0, 4.0, 5.0]));
    }
}
