//! The problem as residuals: measured states less simulated ones, and distances from the nominal robot.

use nalgebra::{DMatrix, DVector};

use super::derivatives::{Rows, Run};
use super::problem::Shooting;
use crate::least_squares::Residuals;
use crate::sim::StepScratch;

impl Residuals for Shooting<'_> {
    fn n_residuals(&self) -> usize {
        self.shots
            .iter()
            .map(|shot| self.rows_of(shot))
            .sum::<usize>()
            + self.variables.penalized().count()
    }

    fn residuals(&mut self, x: &[f64], out: &mut [f64]) {
        let Some(simulator) = self.simulator_with(&self.variables.numbers(x).values) else {
            out.fill(f64::NAN);
            return;
        };
        let mut scratch = StepScratch::new(&simulator);
        let width = 2 * simulator.model().nv();
        let (mut u, mut rows) = (
            vec![0.0; simulator.nu()],
            out.chunks_exact_mut(width.max(1)),
        );
        let mut bristles = DVector::zeros(simulator.n_contact());
        for (k, shot) in self.shots.iter().enumerate() {
            let mut state = self.start_of(&simulator, k, x);
            if self.continues(k) {
                state.contact.copy_from(&bristles);
            }
            let mut next = state.clone();
            for sample in 0..=shot.samples {
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
            bristles.copy_from(&state.contact);
        }
        let root = self.options.regularization.sqrt();
        let first = out.len() - self.variables.penalized().count();
        for (out, k) in out[first..].iter_mut().zip(self.variables.penalized()) {
            *out = root * (x[k] - self.variables.nominal[k]);
        }
    }

    fn jacobian(&mut self, x: &[f64], out: &mut DMatrix<f64>) {
        out.fill(0.0);
        let numbers = self.variables.numbers(x);
        let Some(simulator) = self.simulator_with(&numbers.values) else {
            out.fill(f64::NAN);
            return;
        };
        let nv = simulator.model().nv();
        let deviation = |k: usize| match k < nv {
            true => self.options.position_deviation,
            false => self.options.velocity_deviation,
        };
        let scales: Vec<f64> = (0..2 * nv).map(|k| -deviation(k).recip()).collect();
        let mut run = Run::new(&simulator, &self.variables.targets);
        let mut next = 0;
        for shot in 0..self.shots.len() {
            let start = self
                .has_first()
                .then_some(self.variables.len() + shot * 2 * nv);
            let mut rows = Rows {
                jacobian: out,
                next,
                slopes: &numbers.slopes,
                scales: &scales,
                start,
            };
            let state = self.start_of(&simulator, shot, x);
            self.differentiate(&mut run, shot, state, &mut rows);
            next = rows.next;
        }
        let root = self.options.regularization.sqrt();
        for (row, k) in (next..).zip(self.variables.penalized()) {
            out[(row, k)] = root;
        }
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
        for k in 0..p {
            out[k] = x[k] + d[k];
        }
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
