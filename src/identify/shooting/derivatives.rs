//! Derivatives of the states of a shot in the numbers and in its start, which go along with the simulation.

use nalgebra::DMatrix;

use super::problem::Shooting;
use super::slopes::Derivatives;
use super::variables::Target;
use crate::sim::{Simulator, State, StepPoint, StepScratch};
use crate::stop::is_stopped;

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
        let mut by_number = DMatrix::zeros(n, self.variables.targets.len());
        let mut state = state;
        if self.continues(shot) {
            let own = state.beside_q_mut().skip(nv).zip(&run.carried);
            own.for_each(|(own, &given)| *own = given);
            by_number
                .rows_mut(2 * nv, n - 2 * nv)
                .copy_from(&run.carried_by_number);
        }
        let mut by_start = DMatrix::zeros(n, 2 * nv);
        by_start.fill_with_identity();
        let mut u = vec![0.0; run.simulator.nu()];
        for sample in 0..=own.samples {
            if sample > 0 || self.has_first() {
                rows.push(&by_number, &by_start);
            }
            if sample == own.samples || is_stopped() {
                break;
            }
            self.input(own, sample, &mut u);
            for _ in 0..self.steps {
                run.step(&mut state, &u);
                let Derivatives {
                    by_state,
                    by_number: own,
                    ..
                } = &mut run.slopes;
                own.gemm(1.0, by_state, &by_number, 1.0);
                std::mem::swap(own, &mut by_number);
                if self.has_first() {
                    by_start = &*by_state * by_start;
                }
            }
        }
        let numbers = run.carried.iter_mut().zip(state.beside_q().skip(nv));
        numbers.for_each(|(out, x)| *out = *x);
        run.carried_by_number
            .copy_from(&by_number.rows(2 * nv, n - 2 * nv));
    }
}

/// Working memory of derivatives of steps.
pub(super) struct Run<'a> {
    simulator: &'a Simulator,
    scratch: StepScratch<f64>,
    next: State,
    slopes: Derivatives,
    /// State of contact and activations at the end of the shot before, and their derivatives in numbers.
    carried: Vec<f64>,
    carried_by_number: DMatrix<f64>,
}

impl<'a> Run<'a> {
    pub(super) fn new(simulator: &'a Simulator, targets: &[Target]) -> Self {
        let carried = simulator.n_contact() + simulator.n_activation();
        Self {
            scratch: StepScratch::awake(simulator),
            next: simulator.neutral_state(),
            slopes: Derivatives::new(simulator, targets),
            carried: vec![0.0; carried],
            carried_by_number: DMatrix::zeros(carried, targets.len()),
            simulator,
        }
    }

    /// Takes a step, with its derivatives.
    fn step(&mut self, state: &mut State, u: &[f64]) {
        self.simulator
            .step_into(state, u, &mut self.scratch, &mut self.next);
        let at = StepPoint {
            state,
            u,
            acceleration: Some(&self.scratch.acceleration().a),
        };
        self.slopes.update(self.simulator, &at, &self.next);
        std::mem::swap(state, &mut self.next);
    }
}

/// Rows of a shot in the Jacobian, which are filled one sample after another.
pub(super) struct Rows<'a> {
    /// Columns of the parameters of the robot, then of the start where it is a variable.
    pub(super) block: &'a mut DMatrix<f64>,
    pub(super) next: usize,
    /// Derivatives of parameters in the directions.
    pub(super) slopes: &'a DMatrix<f64>,
    /// −1 / deviation of each row of a sample.
    pub(super) scales: &'a [f64],
    pub(super) has_start: bool,
}

impl Rows<'_> {
    fn push(&mut self, by_number: &DMatrix<f64>, by_start: &DMatrix<f64>) {
        let by_number = by_number.rows(0, self.scales.len()) * self.slopes;
        let p = by_number.ncols();
        for (i, scale) in self.scales.iter().enumerate() {
            let row = self.next + i;
            for k in 0..p {
                self.block[(row, k)] = scale * by_number[(i, k)];
            }
            if self.has_start {
                for k in 0..by_start.ncols() {
                    self.block[(row, p + k)] = scale * by_start[(i, k)];
                }
            }
        }
        self.next += self.scales.len();
    }
}
