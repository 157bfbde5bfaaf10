//! The problem as residuals: measured states less simulated ones, and distances from the nominal robot.

use nalgebra::DMatrix;

use super::derivatives::{Rows, Run};
use super::problem::Shooting;
use crate::least_squares::Residuals;
use crate::parallel::{available_threads, for_each_part};
use crate::sim::StepScratch;
use crate::stop::is_stopped;

impl Shooting<'_> {
    /// Columns of the numbers, then of the own start of a shot where it is a variable.
    fn block_columns(&self) -> usize {
        let of_start = match self.has_first() {
            true => 2 * self.simulator.model().nv(),
            false => 0,
        };
        self.variables.len() + of_start
    }

    /// −1 / deviation of each row of a sample.
    fn scales(&self) -> Vec<f64> {
        let nv = self.simulator.model().nv();
        let of = |deviation: f64| std::iter::repeat_n(-deviation.recip(), nv);
        of(self.options.position_deviation)
            .chain(of(self.options.velocity_deviation))
            .collect()
    }

    /// Puts the rows of each shot where they belong. Returns the row after them.
    fn place(&self, blocks: &[DMatrix<f64>], out: &mut DMatrix<f64>) -> usize {
        let (p, mut row, mut column) = (self.variables.len(), 0, self.variables.len());
        for block in blocks {
            let (rows, of_start) = (block.nrows(), block.ncols() - p);
            let mut numbers = out.view_mut((row, 0), (rows, p));
            numbers.copy_from(&block.columns(0, p));
            let mut start = out.view_mut((row, column), (rows, of_start));
            start.copy_from(&block.columns(p, of_start));
            (row, column) = (row + rows, column + of_start);
        }
        row
    }
}

impl Residuals for Shooting<'_> {
    fn n_residuals(&self) -> usize {
        self.shots
            .iter()
            .map(|shot| self.rows_of(shot))
            .sum::<usize>()
            + self.variables.n_distances()
    }

    fn residuals(&mut self, x: &[f64], out: &mut [f64]) {
        let Some(simulator) = self.simulator_with(&x[..self.variables.len()]) else {
            out.fill(f64::NAN);
            return;
        };
        let mut scratch = StepScratch::awake(&simulator);
        let width = 2 * simulator.model().nv();
        let (mut u, mut rows) = (
            vec![0.0; simulator.nu()],
            out.chunks_exact_mut(width.max(1)),
        );
        let mut carried = vec![0.0; simulator.n_contact() + simulator.n_activation()];
        for (k, shot) in self.shots.iter().enumerate() {
            let mut state = self.start_of(&simulator, k, x);
            if self.continues(k) {
                let own = state.beside_q_mut().skip(width / 2).zip(&carried);
                own.for_each(|(own, &given)| *own = given);
            }
            let mut next = state.clone();
            for sample in 0..=shot.samples {
                if is_stopped() {
                    return out.fill(f64::NAN);
                }
                if sample > 0 {
                    self.input(shot, sample - 1, &mut u);
                    for _ in 0..self.steps {
                        simulator.step_into(&state, &u, &mut scratch, &mut next);
                        std::mem::swap(&mut state, &mut next);
                    }
                }
                if (sample > 0 || self.has_first())
                    && let Some(row) = rows.next()
                {
                    self.compare(shot, sample, &state, row);
                }
            }
            let numbers = carried.iter_mut().zip(state.beside_q().skip(width / 2));
            numbers.for_each(|(out, x)| *out = *x);
        }
        let root = self.options.regularization.sqrt();
        let first = out.len() - self.variables.n_distances();
        let distances = self.variables.distances(x);
        (out[first..].iter_mut().zip(distances)).for_each(|(out, x)| *out = root * x);
    }

    fn jacobian(&mut self, x: &[f64], out: &mut DMatrix<f64>) {
        out.fill(0.0);
        let Some(simulator) = self.simulator_with(&x[..self.variables.len()]) else {
            out.fill(f64::NAN);
            return;
        };
        let mut blocks: Vec<_> = (self.shots.iter())
            .map(|shot| DMatrix::zeros(self.rows_of(shot), self.block_columns()))
            .collect();
        // Bristles and activations go on from shot to shot.
        let workers = match simulator.n_contact() + simulator.n_activation() {
            0 => available_threads().min(blocks.len()),
            _ => 1,
        };
        let new = || Run::new(&simulator, &self.variables.targets);
        let mut workers: Vec<_> = std::iter::repeat_with(new).take(workers).collect();
        let (problem, scales) = (&*self, self.scales());
        let slopes = self.variables.slopes(&x[..self.variables.len()]);
        for_each_part(&mut workers, &mut blocks, |run, shot, block| {
            let state = problem.start_of(&simulator, shot, x);
            let mut rows = Rows {
                block,
                next: 0,
                slopes: &slopes,
                scales: &scales,
                has_start: problem.has_first(),
            };
            problem.differentiate(run, shot, state, &mut rows);
        });
        let next = self.place(&blocks, out);
        let root = self.options.regularization.sqrt();
        self.variables.distance_slopes(x, root, next, out);
    }

    fn n_directions(&self, _: &[f64]) -> usize {
        let starts = if self.has_first() {
            self.shots.len()
        } else {
            0
        };
        self.variables.len() + starts * 2 * self.simulator.model().nv()
    }

    fn retract(&self, x: &[f64], d: &[f64], out: &mut [f64]) {
        let (p, model) = (self.variables.len(), self.simulator.model());
        let (nq, nv) = (model.nq(), model.nv());
        self.variables.retract(&x[..p], &d[..p], &mut out[..p]);
        let starts = x[p..]
            .chunks_exact((nq + nv).max(1))
            .zip(d[p..].chunks_exact((2 * nv).max(1)));
        for ((x, d), out) in starts.zip(out[p..].chunks_exact_mut((nq + nv).max(1))) {
            model.integrate_into(&x[..nq], &d[..nv], &mut out[..nq]);
            for k in 0..nv {
                out[nq + k] = x[nq + k] + d[nv + k];
            }
        }
    }
}
