//! Small dense symmetric matrices: solve, invert, eigenvalues.

/// A symmetric matrix of a few dozen rows at most, stored whole.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Symmetric {
    size: usize,
    cells: Vec<f64>,
}

impl Symmetric {
    /// The matrix of that many rows whose entry in row `i`, column `j` is `entry(i, j)`; asked for `j <= i` only.
    pub fn of(size: usize, mut entry: impl FnMut(usize, usize) -> f64) -> Self {
        let mut matrix = Self { size, cells: vec![0.0; size * size] };
        for i in 0..size {
            for j in 0..=i {
                matrix.set(i, j, entry(i, j));
            }
        }
        matrix
    }

    /// The diagonal matrix of these entries.
    pub fn diagonal(entries: &[f64]) -> Self {
        Self::of(entries.len(), |i, j| if i == j { entries[i] } else { 0.0 })
    }

    /// Number of rows.
    pub fn size(&self) -> usize {
        self.size
    }

    /// Whether it has that many rows, all of finite numbers.
    pub fn is_finite_of(&self, size: usize) -> bool {
        self.size == size && self.cells.len() == size * size && self.cells.iter().all(|x| x.is_finite())
    }

    /// Entry in row `i`, column `j`.
    pub fn at(&self, i: usize, j: usize) -> f64 {
        self.cells[i * self.size + j]
    }

    /// Sets the entry and its mirror image.
    pub fn set(&mut self, i: usize, j: usize, value: f64) {
        self.cells[i * self.size + j] = value;
        self.cells[j * self.size + i] = value;
    }

    /// Of a covariance: that of the values times these factors.
    pub fn scaled(&self, factors: &[f64]) -> Self {
        Self::of(self.size, |i, j| self.at(i, j) * factors[i] * factors[j])
    }

    /// Of a covariance: the standard deviations.
    pub fn deviations(&self) -> Vec<f64> {
        (0..self.size).map(|i| self.at(i, i).max(0.0).sqrt()).collect()
    }

    /// Of a covariance: the correlation of each pair; not a number where a variance is 0 or infinite.
    pub fn correlations(&self) -> Self {
        Self::of(self.size, |i, j| if i == j { 1.0 } else { self.at(i, j) / (self.at(i, i) * self.at(j, j)).sqrt() })
    }

    /// The product with a vector.
    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        self.cells.chunks_exact(self.size.max(1)).map(|row| row.iter().zip(x).map(|(a, b)| a * b).sum()).collect()
    }

    /// xᵀ A x.
    pub fn form(&self, x: &[f64]) -> f64 {
        self.times(x).iter().zip(x).map(|(a, b)| a * b).sum()
    }

    /// A B A.
    pub fn around(&self, inner: &Self) -> Self {
        let row = |i: usize| -> Vec<f64> { (0..self.size).map(|k| self.at(i, k)).collect() };
        Self::of(self.size, |i, j| inner.times(&row(j)).iter().zip(row(i)).map(|(a, b)| a * b).sum())
    }

    /// The lower triangular L with L Lᵀ = A, row by row; `None` when A is not positive definite.
    fn cholesky(&self) -> Option<Vec<f64>> {
        let n = self.size;
        let mut lower = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                let dot: f64 = (0..j).map(|k| lower[i * n + k] * lower[j * n + k]).sum();
                let rest = self.at(i, j) - dot;
                if i != j {
                    lower[i * n + j] = rest / lower[j * n + j];
                } else if rest > 0.0 && rest.is_finite() {
                    lower[i * n + i] = rest.sqrt();
                } else {
                    return None;
                }
            }
        }
        Some(lower)
    }

    /// The inverse; `None` when A is not positive definite.
    pub fn inverse(&self) -> Option<Self> {
        let n = self.size;
        let lower = self.cholesky()?;
        let mut columns = vec![vec![0.0; n]; n];
        for (c, x) in columns.iter_mut().enumerate() {
            x[c] = 1.0;
            for i in 0..n {
                let dot: f64 = (0..i).map(|k| lower[i * n + k] * x[k]).sum();
                x[i] = (x[i] - dot) / lower[i * n + i];
            }
            for i in (0..n).rev() {
                let dot: f64 = (i + 1..n).map(|k| lower[k * n + i] * x[k]).sum();
                x[i] = (x[i] - dot) / lower[i * n + i];
            }
        }
        Some(Self::of(n, |i, j| 0.5 * (columns[j][i] + columns[i][j])))
    }

    /// The matrix with every eigenvalue replaced by `change(eigenvalue)` (Jacobi 1846, cyclic rotations).
    pub fn with_eigenvalues(&self, mut change: impl FnMut(f64) -> f64) -> Self {
        let n = self.size;
        let mut a = self.clone();
        let mut vectors = vec![0.0; n * n];
        (0..n).for_each(|i| vectors[i * n + i] = 1.0);
        for _sweep in 0..60 {
            let off: f64 = (0..n).flat_map(|i| (0..i).map(move |j| (i, j))).map(|(i, j)| a.at(i, j).powi(2)).sum();
            let on: f64 = (0..n).map(|i| a.at(i, i).powi(2)).sum();
            if off <= 1e-30 * on {
                break;
            }
            for p in 0..n {
                for q in p + 1..n {
                    a.rotate(p, q, &mut vectors);
                }
            }
        }
        let values: Vec<f64> = (0..n).map(|i| change(a.at(i, i))).collect();
        Self::of(n, |i, j| (0..n).map(|k| values[k] * vectors[i * n + k] * vectors[j * n + k]).sum())
    }

    /// Rotates rows and columns `p` and `q` so that their common entry vanishes; `vectors` collects the rotations.
    fn rotate(&mut self, p: usize, q: usize, vectors: &mut [f64]) {
        let (n, apq) = (self.size, self.at(p, q));
        if apq == 0.0 {
            return;
        }
        let theta = (self.at(q, q) - self.at(p, p)) / (2.0 * apq);
        let t = theta.signum() / (theta.abs() + theta.hypot(1.0));
        let c = 1.0 / t.hypot(1.0);
        let s = t * c;
        let (app, aqq) = (self.at(p, p) - t * apq, self.at(q, q) + t * apq);
        for k in (0..n).filter(|&k| k != p && k != q) {
            let (akp, akq) = (self.at(k, p), self.at(k, q));
            self.set(k, p, c * akp - s * akq);
            self.set(k, q, s * akp + c * akq);
        }
        self.set(p, p, app);
        self.set(q, q, aqq);
        self.set(p, q, 0.0);
        for row in vectors.chunks_exact_mut(n) {
            (row[p], row[q]) = (c * row[p] - s * row[q], s * row[p] + c * row[q]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A positive definite matrix without structure.
    fn sample(n: usize) -> Symmetric {
        Symmetric::of(n, |i, j| if i == j { 3.0 + i as f64 } else { 0.9 * ((1 + i * 3 + j * 7) as f64).sin() })
    }

    #[test]
    fn the_inverse_times_the_matrix_is_the_identity() {
        let a = sample(6);
        let inverse = a.inverse().unwrap();
        for i in 0..6 {
            let unit: Vec<f64> = (0..6).map(|j| f64::from(i == j)).collect();
            for (got, want) in inverse.times(&a.times(&unit)).iter().zip(&unit) {
                assert!((got - want).abs() < 1e-12);
            }
        }
        assert!(Symmetric::diagonal(&[1.0, -1.0]).inverse().is_none());
    }

    #[test]
    fn eigenvalues_can_be_changed_in_place() {
        let a = sample(5);
        let same = a.with_eigenvalues(|v| v);
        let inverse = a.with_eigenvalues(|v| 1.0 / v);
        let expected = a.inverse().unwrap();
        for i in 0..5 {
            for j in 0..5 {
                assert!((same.at(i, j) - a.at(i, j)).abs() < 1e-12);
                assert!((inverse.at(i, j) - expected.at(i, j)).abs() < 1e-12);
            }
        }
        // Equal diagonal entries: the rotation is by 45 degrees, eigenvalues are 1 ± 0.5.
        let pair = Symmetric::of(2, |i, j| if i == j { 1.0 } else { 0.5 });
        let mut seen = vec![];
        pair.with_eigenvalues(|v| {
            seen.push(v);
            v
        });
        seen.sort_by(f64::total_cmp);
        assert!((seen[0] - 0.5).abs() < 1e-14 && (seen[1] - 1.5).abs() < 1e-14);
    }

    #[test]
    fn a_matrix_around_another() {
        let (a, b) = (Symmetric::of(2, |i, j| [[2.0, 1.0], [1.0, 3.0]][i][j]), Symmetric::diagonal(&[1.0, 2.0]));
        assert_eq!(a.around(&b), Symmetric::of(2, |i, j| [[6.0, 8.0], [8.0, 19.0]][i][j]));
    }
}
