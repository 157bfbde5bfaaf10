//! Derivatives of the states of a shot in the numbers and in its start, which go along with the simulation.

use nalgebra::{DMatrix, DVector};

use super::problem::{Shooting, Target};
use crate::linearize::{StepGradient, VjpScratch};
use crate::sim::{Simulator, State, StepScratch};

impl Shooting<'_> {
    /// Simulates a shot with the derivatives of its states in numbers and start, and fills its rows of the Jacobian.
    pub(super) fn differentiate(
        &self,
        run: &mut Run<'_>,
        shot: usize,
        state: State,
        rows: &mut Rows<'_>,
    ) {
        let (own, nv) = (&self.shots[shot], self.simulator.model().nv());
        let n = run.simulator.n_tangent();
        let mut by_number = DMatrix::zeros(n, self.targets.len());
        let mut state = state;
        if self.continues(shot) {
            state.contact.copy_from(&run.bristles);
            by_number
                .rows_mut(2 * nv, n - 2 * nv)
                .copy_from(&run.bristles_by_number);
        }
        let mut by_start = DMatrix::zeros(n, 2 * nv);
        by_start.fill_with_identity();
        let mut u = vec![0.0; run.simulator.nu()];
        let mut next = state.clone();
        for sample in 0..=own.samples {
            if sample > 0 || self.has_first() {
                rows.push(&by_number, &by_start);
            }
            if sample == own.samples {
                break;
            }
            self.input(own, sample, &mut u);
            for _ in 0..self.steps {
                run.linearize(&state, &u, &self.targets);
                by_number = &run.by_state * by_number + &run.by_number;
                by_start = &run.by_state * by_start;
                run.simulator
                    .step_into(&state, &u, &mut run.step, &mut next);
                std::mem::swap(&mut state, &mut next);
            }
        }
        run.bristles.copy_from(&state.contact);
        run.bristles_by_number
            .copy_from(&by_number.rows(2 * nv, n - 2 * nv));
    }
}

/// Working memory of derivatives of steps.
pub(super) struct Run<'a> {
    pub(super) simulator: &'a Simulator,
    pub(super) step: StepScratch<f64>,
    pub(super) vjp: VjpScratch,
    pub(super) gradient: StepGradient,
    pub(super) adjoint: Vec<f64>,
    pub(super) by_state: DMatrix<f64>,
    pub(super) by_number: DMatrix<f64>,
    /// State of contact at the end of the shot before, and its derivatives in numbers.
    pub(super) bristles: DVector<f64>,
    pub(super) bristles_by_number: DMatrix<f64>,
}

impl<'a> Run<'a> {
    pub(super) fn new(simulator: &'a Simulator, numbers: usize) -> Self {
        let n = simulator.n_tangent();
        Self {
            step: StepScratch::new(simulator),
            vjp: VjpScratch::new(simulator),
            gradient: StepGradient::zeros(simulator),
            adjoint: vec![0.0; n],
            by_state: DMatrix::zeros(n, n),
            by_number: DMatrix::zeros(n, numbers),
            bristles: DVector::zeros(simulator.n_contact()),
            bristles_by_number: DMatrix::zeros(simulator.n_contact(), numbers),
            simulator,
        }
    }

    /// Derivatives of the next state in this one and in numbers, row by row.
    pub(super) fn linearize(&mut self, state: &State, u: &[f64], targets: &[Target]) {
        for row in 0..self.adjoint.len() {
            self.adjoint[row] = 1.0;
            self.simulator
                .vjp_into(state, u, &self.adjoint, &mut self.vjp, &mut self.gradient);
            self.adjoint[row] = 0.0;
            self.by_state
                .row_mut(row)
                .copy_from(&self.gradient.state.transpose());
            for (k, target) in targets.iter().enumerate() {
                let slopes = target.iter().map(|&index| self.gradient.parameters[index]);
                self.by_number[(row, k)] = slopes.sum();
            }
        }
    }
}

/// Rows of the Jacobian that are filled one sample after another.
pub(super) struct Rows<'a> {
    pub(super) jacobian: &'a mut DMatrix<f64>,
    pub(super) next: usize,
    /// Slopes of numbers in the variables.
    pub(super) slopes: &'a DMatrix<f64>,
    /// −1 / deviation of each row of a sample.
    pub(super) scales: &'a [f64],
    /// First column of the start, where it is a variable.
    pub(super) start: Option<usize>,
}

impl Rows<'_> {
    pub(super) fn push(&mut self, by_number: &DMatrix<f64>, by_start: &DMatrix<f64>) {
        let by_variable = by_number.rows(0, self.scales.len()) * self.slopes;
        for (i, scale) in self.scales.iter().enumerate() {
            let row = self.next + i;
            for k in 0..by_variable.ncols() {
                self.jacobian[(row, k)] = scale * by_variable[(i, k)];
            }
            if let Some(first) = self.start {
                for k in 0..by_start.ncols() {
                    self.jacobian[(row, first + k)] = scale * by_start[(i, k)];
                }
            }
        }
        self.next += self.scales.len();
    }
}
