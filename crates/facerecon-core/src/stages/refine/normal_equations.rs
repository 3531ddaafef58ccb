//! The normal equations of a spline's control values: photometric terms, bending energy, and their
//! solution by conjugate gradients.

use rayon::prelude::*;

use super::bending::Bending;
use super::spline::{Spline, weights};
use crate::data::{Gray, Raster};

/// Couplings of one control value with itself and those after it in row-major order within three
/// rows and columns: 4 in its own row, 7 in each of the next three.
const HALF: usize = 25;
/// All couplings of one control value.
const FULL: usize = 49;
/// A control value with a smaller diagonal entry has neither pixels nor bending; its step is 0.
const MIN_DIAGONAL: f64 = 1e-12;
/// Rows of control values that one thread multiplies at least; fewer cost more than they save.
const MIN_ROWS_PER_THREAD: usize = 24;

/// `A step = right_side`, A symmetric positive definite.
pub(super) struct NormalEquations {
    columns: usize,
    rows: usize,
    /// Upper half of A, by control value.
    half: Vec<[f64; HALF]>,
    right_side: Vec<f64>,
}

/// Index of the coupling `(dx, dy)` in the half stencil; `dy > 0`, or `dy == 0` and `dx >= 0`.
#[inline]
fn slot(dx: isize, dy: isize) -> usize {
    if dy == 0 { dx as usize } else { (4 + (dy - 1) * 7 + dx + 3) as usize }
}

impl NormalEquations {
    /// The equations that minimise the sum of `information * (B step)^2 - 2 gradient * (B step)`
    /// over all pixels of the domain, where B are the spline's weights at the pixel.
    pub(super) fn photometric(
        spline: &Spline,
        domain: &Raster<bool>,
        information: &Gray,
        gradient: &Gray,
    ) -> Self {
        let (columns, rows) = (spline.columns, spline.rows);
        let mut bands = vec![Vec::new(); rows - 3];
        for y in (0..domain.height()).filter(|&y| domain.row(y).contains(&true)) {
            bands[spline.cell_row(y as f64).0].push(y);
        }
        let table: Vec<(usize, [f64; 4])> = (0..domain.width())
            .map(|x| spline.cell_column(x as f64))
            .map(|(i, s)| (i, weights(s)))
            .collect();
        let band =
            |lines: &Vec<usize>| band_sums(spline, &table, lines, domain, information, gradient);
        let sums: Vec<_> = bands.par_iter().map(band).collect();
        let mut equations = Self {
            columns,
            rows,
            half: vec![[0.0; HALF]; columns * rows],
            right_side: vec![0.0; columns * rows],
        };
        // in order, so that the sums do not depend on the number of threads
        for (j, (half, right_side)) in sums.iter().enumerate() {
            for (k, (h, r)) in half.iter().zip(right_side).enumerate() {
                let target = j * columns + k;
                equations.half[target].iter_mut().zip(h).for_each(|(a, b)| *a += b);
                equations.right_side[target] += r;
            }
        }
        equations
    }

    /// Adds the bending energy of `spline + step`, with one weight per cell.
    pub(super) fn add_bending(&mut self, spline: &Spline, bending: &Bending, weight: &[f64]) {
        let cells = self.columns - 3;
        for j in 0..self.rows - 3 {
            for i in 0..cells {
                let w = weight[j * cells + i];
                let at = |a: usize| (j + a / 4) * self.columns + i + a % 4;
                for a in 0..16 {
                    let row = &bending.energy[a];
                    let mut product = 0.0;
                    for b in 0..16 {
                        product += row[b] * spline.control[at(b)];
                        if b >= a {
                            let (dx, dy) = (b % 4, b / 4 - a / 4);
                            let dx = dx as isize - (a % 4) as isize;
                            self.half[at(a)][slot(dx, dy as isize)] += w * row[b];
                        }
                    }
                    self.right_side[at(a)] -= w * product;
                }
            }
        }
    }

    /// Solves by conjugate gradients with a Jacobi preconditioner, to a relative residual of
    /// `tolerance`, in at most `max_steps` steps. The step of undetermined control values is 0.
    pub(super) fn solve(&self, tolerance: f64, max_steps: usize) -> Vec<f64> {
        let matrix = self.full();
        let inverse: Vec<f32> = self
            .half
            .iter()
            .map(|a| if a[0] > MIN_DIAGONAL { (1.0 / a[0]) as f32 } else { 0.0 })
            .collect();
        let n = self.right_side.len();
        let mut x = vec![0.0f32; n];
        let mut r: Vec<f32> = self.right_side.iter().map(|&v| v as f32).collect();
        let mut z: Vec<f32> = r.iter().zip(&inverse).map(|(r, d)| r * d).collect();
        let mut padded = vec![0.0f32; (self.columns + 6) * (self.rows + 6)];
        let mut p = z.clone();
        let mut product = vec![0.0f32; n];
        let mut rz = dot(&r, &z);
        let target = rz * tolerance * tolerance;
        for _ in 0..max_steps {
            if !(rz > target) {
                break;
            }
            self.multiply(&matrix, &p, &mut padded, &mut product);
            let curvature = dot(&p, &product);
            if !(curvature > 0.0) {
                break;
            }
            let alpha = (rz / curvature) as f32;
            for i in 0..n {
                x[i] += alpha * p[i];
                r[i] -= alpha * product[i];
                z[i] = r[i] * inverse[i];
            }
            let next = dot(&r, &z);
            let beta = (next / rz) as f32;
            rz = next;
            for i in 0..n {
                p[i] = z[i] + beta * p[i];
            }
        }
        x.into_iter().map(f64::from).collect()
    }

    /// The matrix with both halves, one stencil for each control value.
    fn full(&self) -> Vec<[f32; FULL]> {
        let mut full = vec![[0.0f32; FULL]; self.half.len()];
        for j in 0..self.rows {
            for i in 0..self.columns {
                let k = j * self.columns + i;
                for dy in 0..4isize {
                    for dx in (if dy == 0 { 0 } else { -3 })..4isize {
                        let (u, v) = (i as isize + dx, j + dy as usize);
                        if u < 0 || u >= self.columns as isize || v >= self.rows {
                            continue;
                        }
                        let value = self.half[k][slot(dx, dy)] as f32;
                        full[k][((dy + 3) * 7 + dx + 3) as usize] = value;
                        full[v * self.columns + u as usize][((3 - dy) * 7 + 3 - dx) as usize] =
                            value;
                    }
                }
            }
        }
        full
    }

    /// Product of the matrix and `x`; `padded` is a buffer with a border of three zeros.
    fn multiply(&self, matrix: &[[f32; FULL]], x: &[f32], padded: &mut [f32], out: &mut [f32]) {
        let stride = self.columns + 6;
        for (j, row) in x.chunks(self.columns).enumerate() {
            padded[(j + 3) * stride + 3..][..self.columns].copy_from_slice(row);
        }
        let padded = &*padded;
        out.par_chunks_mut(self.columns).with_min_len(MIN_ROWS_PER_THREAD).enumerate().for_each(
            |(j, out)| {
                for (i, out) in out.iter_mut().enumerate() {
                    let a = &matrix[j * self.columns + i];
                    let mut lanes = [0.0f32; 7];
                    for e in 0..7 {
                        let x = &padded[(j + e) * stride + i..][..7];
                        for f in 0..7 {
                            lanes[f] += a[e * 7 + f] * x[f];
                        }
                    }
                    *out = lanes.iter().sum();
                }
            },
        );
    }
}

fn dot(a: &[f32], b: &[f32]) -> f64 {
    a.iter().zip(b).map(|(a, b)| f64::from(*a) * f64::from(*b)).sum()
}

/// The sums over the pixel lines of one cell row, for its four rows of control values.
fn band_sums(
    spline: &Spline,
    table: &[(usize, [f64; 4])],
    lines: &[usize],
    domain: &Raster<bool>,
    information: &Gray,
    gradient: &Gray,
) -> (Vec<[f64; HALF]>, Vec<f64>) {
    let columns = spline.columns;
    let mut half = vec![[0.0; HALF]; 4 * columns];
    let mut right_side = vec![0.0; 4 * columns];
    for &y in lines {
        let wy = weights(spline.cell_row(y as f64).1);
        let (mask, info, grad) = (domain.row(y), information.row(y), gradient.row(y));
        let mut x = 0;
        while x < mask.len() {
            // products of the horizontal weights, summed over the line's pixels in one cell
            let cell = table[x].0;
            let mut across = [[0.0f64; 4]; 4];
            let mut gradient_sum = [0.0f64; 4];
            let mut any = false;
            while x < mask.len() && table[x].0 == cell {
                if mask[x] {
                    let w = &table[x].1;
                    let (info, grad) = (f64::from(info[x]), f64::from(grad[x]));
                    for f in 0..4 {
                        gradient_sum[f] += grad * w[f];
                        let iw = info * w[f];
                        for g in f..4 {
                            across[f][g] += iw * w[g];
                        }
                    }
                    any = true;
                }
                x += 1;
            }
            if !any {
                continue;
            }
            for e in 0..4 {
                for f in 0..4 {
                    let k = e * columns + cell + f;
                    right_side[k] += wy[e] * gradient_sum[f];
                    let own = wy[e] * wy[e];
                    for g in f..4 {
                        half[k][g - f] += own * across[f][g];
                    }
                    for e2 in e + 1..4 {
                        let w = wy[e] * wy[e2];
                        for g in 0..4 {
                            let product = if g < f { across[g][f] } else { across[f][g] };
                            half[k][4 + (e2 - e - 1) * 7 + g + 3 - f] += w * product;
                        }
                    }
                }
            }
        }
    }
    (half, right_side)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn quadratic() -> (Spline, Raster<bool>) {
        let domain = Raster::filled(37, 29, true);
        let mut spline = Spline::over(&domain, 4.0).unwrap();
        for k in 0..spline.control.len() {
            let [x, y] = spline.node(k % spline.columns, k / spline.columns);
            spline.control[k] = 0.01 * x * x + 0.02 * x * y + 0.3 * y;
        }
        (spline, domain)
    }

    #[test]
    fn the_solution_satisfies_the_dense_equations() {
        let (spline, domain) = quadratic();
        let info = Gray::from_fn(37, 29, |x, y| 1.0 + ((x * 7 + y * 3) % 5) as f32);
        let slope = Gray::from_fn(37, 29, |x, y| ((x * 3 + y * 5) % 7) as f32 - 2.0);
        let mut equations = NormalEquations::photometric(&spline, &domain, &info, &slope);
        let bending = Bending::new(4.0);
        let weight = vec![30.0; (spline.columns - 3) * (spline.rows - 3)];
        equations.add_bending(&spline, &bending, &weight);
        let step = equations.solve(1e-6, 2000);
        // naive reference: the gradient of the energy at the solution, from its definition
        let n = spline.control.len();
        let mut gradient = vec![0.0; n];
        for y in 0..29 {
            for x in 0..37 {
                let ((i, s), (j, t)) = (spline.cell_column(x as f64), spline.cell_row(y as f64));
                let (wx, wy) = (weights(s), weights(t));
                let at = |a: usize| (j + a / 4) * spline.columns + i + a % 4;
                let moved: f64 = (0..16).map(|a| wy[a / 4] * wx[a % 4] * step[at(a)]).sum();
                let g = f64::from(info.at(x, y)) * moved - f64::from(slope.at(x, y));
                (0..16).for_each(|a| gradient[at(a)] += g * wy[a / 4] * wx[a % 4]);
            }
        }
        let cells = spline.columns - 3;
        for k in 0..weight.len() {
            let at = |a: usize| (k / cells + a / 4) * spline.columns + k % cells + a % 4;
            for a in 0..16 {
                for b in 0..16 {
                    let value = spline.control[at(b)] + step[at(b)];
                    gradient[at(a)] += weight[k] * bending.energy[a][b] * value;
                }
            }
        }
        let largest = gradient.iter().fold(0.0f64, |m, g| m.max(g.abs()));
        assert!(largest < 1e-2, "{largest}");
    }
}
