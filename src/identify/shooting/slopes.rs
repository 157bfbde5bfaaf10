//! Derivatives of a step in its state and in some parameters of the robot.

use std::ops::Range;

use nalgebra::DMatrix;

use super::variables::Target;
use crate::autodiff::CHUNK;
use crate::linearize::{Linearization, LinearizeScratch, StepGradient, VjpScratch};
use crate::scalar::{Cast, Dual};
use crate::sim::{Integrator, Simulator, State, StepPoint, StepScratch};

/// Parameters for each vector-Jacobian product above which these are cheaper.
const FORWARD_NUMBERS: usize = 2;

type Local = Dual<f64, CHUNK>;

/// Derivatives of the next state in the state and in numbers, with memory for them.
pub(super) struct Derivatives {
    pub(super) by_state: DMatrix<f64>,
    pub(super) by_number: DMatrix<f64>,
    mode: Mode,
}

enum Mode {
    /// The step linearised, and taken over dual numbers.
    Forward(Box<Forward>),
    /// A vector-Jacobian product for each entry of the next state.
    Adjoint(Box<Adjoint>),
}

impl Derivatives {
    /// Takes the cheaper mode. Forward costs a linearisation, of 3 to 12 steps, and 3 to 9 steps for every four numbers; a vector-Jacobian product costs 4
    /// to 7 (arm, quadruped, humanoid).
    pub(super) fn new(simulator: &Simulator, targets: &[Target]) -> Self {
        let n = simulator.n_tangent();
        let products = n - slid(simulator).count();
        let mode = match targets.len() <= FORWARD_NUMBERS * products {
            true => Mode::Forward(Box::new(Forward::new(simulator, targets))),
            false => Mode::Adjoint(Box::new(Adjoint::new(simulator, targets))),
        };
        Self {
            by_state: DMatrix::zeros(n, n),
            by_number: DMatrix::zeros(n, targets.len()),
            mode,
        }
    }

    /// Finds the derivatives of a step to `next`.
    pub(super) fn update(&mut self, simulator: &Simulator, at: &StepPoint<'_>, next: &State) {
        match &mut self.mode {
            Mode::Forward(own) => {
                let StepPoint { state, u, .. } = *at;
                simulator.linearize_into(state, u, &mut own.scratch, &mut own.step);
                self.by_state.copy_from(&own.step.a);
                for part in &mut own.parts {
                    part.update(simulator, state, u, next, &mut self.by_number);
                }
            }
            Mode::Adjoint(own) => {
                let (by_state, by_number) = (&mut self.by_state, &mut self.by_number);
                for &row in &own.rows {
                    own.product.update(simulator, at, row);
                    let gradient = &own.product.gradient;
                    by_state.row_mut(row).copy_from(&gradient.state.transpose());
                    for (k, target) in own.targets.iter().enumerate() {
                        let slopes = target
                            .iter()
                            .map(|&(index, factor)| factor * gradient.parameters[index]);
                        by_number[(row, k)] = slopes.sum();
                    }
                }
                let (nv, dt) = (simulator.model().nv(), simulator.time_step());
                for k in slid(simulator) {
                    for slopes in [&mut *by_state, &mut *by_number] {
                        let row = slopes.row(nv + k) * dt;
                        slopes.row_mut(k).copy_from(&row);
                    }
                    by_state[(k, k)] += 1.0;
                }
            }
        }
    }
}

/// Coordinates that a step moves by Δt v⁺: their derivatives follow from those of the velocity.
fn slid(simulator: &Simulator) -> impl Iterator<Item = usize> + '_ {
    let is_euler = simulator.integrator() != Integrator::RungeKutta4;
    let bodies = simulator.model().independent();
    let own = bodies.filter(move |body| is_euler && body.joint.nv() == 1);
    own.map(|body| body.v)
}

struct Forward {
    scratch: LinearizeScratch,
    step: Linearization,
    parts: Vec<Part>,
}

impl Forward {
    fn new(simulator: &Simulator, targets: &[Target]) -> Self {
        let firsts = (0..targets.len()).step_by(CHUNK);
        let part = |first| Part::new(simulator, targets, first..targets.len().min(first + CHUNK));
        Self {
            scratch: LinearizeScratch::new(simulator),
            step: Linearization::zeros(simulator),
            parts: firsts.map(part).collect(),
        }
    }
}

/// The simulator over dual numbers that are seeded in some of the numbers.
struct Part {
    numbers: Range<usize>,
    simulator: Simulator<Local>,
    scratch: StepScratch<Local>,
    next: State<Local>,
}

impl Part {
    fn new(simulator: &Simulator, targets: &[Target], numbers: Range<usize>) -> Self {
        let mut seeded: Vec<Local> = simulator.parameters().iter().map(|&x| x.into()).collect();
        for (k, target) in targets[numbers.clone()].iter().enumerate() {
            target
                .iter()
                .for_each(|&(index, factor)| seeded[index].eps[k] = factor);
        }
        let simulator = simulator.with_parameters(&seeded);
        Self {
            numbers,
            scratch: StepScratch::awake(&simulator),
            next: simulator.neutral_state(),
            simulator,
        }
    }

    fn update(
        &mut self,
        simulator: &Simulator,
        state: &State,
        u: &[f64],
        next: &State,
        out: &mut DMatrix<f64>,
    ) {
        let u: Vec<Local> = u.iter().map(|&u| u.into()).collect();
        self.simulator
            .step_into(&state.cast(), &u, &mut self.scratch, &mut self.next);
        let change = self.next.deviation(simulator.model(), &next.cast());
        for (row, x) in change.iter().enumerate() {
            for (k, slope) in self.numbers.clone().zip(x.eps) {
                out[(row, k)] = slope;
            }
        }
    }
}

struct Adjoint {
    targets: Vec<Target>,
    /// Numbers of the next state that need a product.
    rows: Vec<usize>,
    product: Product,
}

impl Adjoint {
    fn new(simulator: &Simulator, targets: &[Target]) -> Self {
        let mut needed = vec![true; simulator.n_tangent()];
        slid(simulator).for_each(|k| needed[k] = false);
        Self {
            targets: targets.to_vec(),
            rows: (0..needed.len()).filter(|&k| needed[k]).collect(),
            product: Product {
                scratch: VjpScratch::new(simulator),
                gradient: StepGradient::zeros(simulator),
                weights: vec![0.0; simulator.n_tangent()],
            },
        }
    }
}

/// Working memory of vector-Jacobian products.
struct Product {
    scratch: VjpScratch,
    gradient: StepGradient,
    weights: Vec<f64>,
}

impl Product {
    /// Finds the gradient of one entry of the next state.
    fn update(&mut self, simulator: &Simulator, at: &StepPoint<'_>, row: usize) {
        self.weights[row] = 1.0;
        let (scratch, out) = (&mut self.scratch, &mut self.gradient);
        out.parameters.fill(0.0);
        simulator.add_vjp(at, &self.weights, scratch, out);
        self.weights[row] = 0.0;
    }
}
