//! Slopes of a cost of a rollout in some chosen numbers, in either mode of differentiation.
//!
//! Forward mode takes the whole rollout over dual numbers, once for every [`CHUNK`] numbers, and needs none of the way back; weighted with the slopes of the
//! cost, the motion of the states is the slope. The adjoint mode has the slopes in all numbers from one sweep back. One rollout over dual numbers costs more than that
//! sweep on every robot that was measured, so that forward mode is for those who have no memory for a trajectory, or want a second opinion. It runs the
//! step over a robot of dual numbers, which nothing else in the library does, so its functions are generic in the width and compiled in the program that calls them.

use nalgebra::DVector;

use super::cost::{Costs, Stages};
use super::{CostSlopes, RolloutCost, RolloutGradientOptions, StagePoint, WantedParameters};
use crate::autodiff::CHUNK;
use crate::scalar::Dual;
use crate::sim::{Rollout, RolloutStatus, Simulator, State, StepScratch};

/// A number on which a rollout depends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RolloutNumber {
    /// The start along this direction of its tangent (δq, δv, and the state of contact where there is one).
    Start(usize),
    /// An entry of the input of a step.
    Input {
        /// Index of the step, from 0.
        step: usize,
        /// Index of the entry.
        index: usize,
    },
    /// A [parameter](Simulator::parameters) of the simulator.
    Parameter(usize),
}

/// Mode of differentiation of a rollout.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum RolloutMode {
    /// The rollout over dual numbers: once for every four numbers, without memory of its states' derivatives.
    Forward,
    /// The [gradient](Simulator::rollout_gradient), of which some numbers are wanted.
    Adjoint,
}

/// A cost of a rollout with its slopes in chosen numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct RolloutSlopes {
    /// The cost; infinite where the rollout did not come to its end.
    pub cost: f64,
    /// Slope in each number; zero unless the rollout is completed.
    pub slopes: DVector<f64>,
    /// The mode that found them.
    pub mode: RolloutMode,
    /// Status of the rollout.
    pub status: RolloutStatus,
}

impl Simulator<f64> {
    /// Computes a cost of the rollout from `start` under `inputs` and its slopes in some numbers only. Allocates.
    ///
    /// The same numbers as those of [`rollout_gradient`](Self::rollout_gradient). The adjoint mode is taken: it costs less from the first
    /// number on, where forward mode takes 6 to 8 rollouts for every four numbers (`benches/RESULTS.md`).
    ///
    /// * `start` – the first state
    /// * `inputs` – the input of each step, length `nu` (N·m or N)
    /// * `numbers` – those in which slopes are wanted
    ///
    /// # Panics
    /// If start or an input has the wrong length, or there is no such number.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Scalar, Simulator, State, linearize::{RolloutCost, RolloutNumber}, model::samples};
    /// use nalgebra::DVector;
    ///
    /// /// The angle at the end.
    /// struct Angle;
    /// impl RolloutCost for Angle {
    ///     fn end<T: Scalar>(&self, last: &State<T>) -> T {
    ///         last.q[0]
    ///     }
    /// }
    /// // Without gravity q = q₀ + v₀ t, here with t = 0.5 s.
    /// let model = samples::pendulum().with_gravity(nalgebra::Vector3::zeros());
    /// let simulator = Simulator::new(model).with_time_step(0.01);
    /// let inputs = vec![DVector::zeros(1); 50];
    /// let speed = [RolloutNumber::Start(1)];
    /// let swing = simulator.rollout_slopes(&State::new(&[0.1], &[2.0]), &inputs, &Angle, &speed);
    /// assert!((swing.cost - 1.1).abs() < 1e-12 && (swing.slopes[0] - 0.5).abs() < 1e-12);
    /// ```
    ///
    /// # References
    /// [Griewank, Walther 2008, chapter 3].
    pub fn rollout_slopes<C: RolloutCost>(
        &self,
        start: &State,
        inputs: &[DVector<f64>],
        cost: &C,
        numbers: &[RolloutNumber],
    ) -> RolloutSlopes {
        for number in numbers {
            number.check(self, inputs.len());
        }
        let options = RolloutGradientOptions {
            parameters: self.wanted_by(numbers),
            ..Default::default()
        };
        let all = self.rollout_gradient_with(start, inputs, cost, &options);
        let slope = |number: &RolloutNumber| match *number {
            RolloutNumber::Start(k) => all.start[k],
            RolloutNumber::Input { step, index } => all.inputs[step][index],
            RolloutNumber::Parameter(k) => all.parameters[k],
        };
        RolloutSlopes {
            cost: all.cost,
            slopes: DVector::from_iterator(numbers.len(), numbers.iter().map(slope)),
            mode: RolloutMode::Adjoint,
            status: all.status,
        }
    }

    /// [`rollout_slopes`](Self::rollout_slopes) in a mode of one's own choice.
    ///
    /// # Panics
    /// If start or an input has the wrong length, or there is no such number.
    pub fn rollout_slopes_in<C: RolloutCost>(
        &self,
        mode: RolloutMode,
        start: &State,
        inputs: &[DVector<f64>],
        cost: &C,
        numbers: &[RolloutNumber],
    ) -> RolloutSlopes {
        match mode {
            RolloutMode::Forward => {
                for number in numbers {
                    number.check(self, inputs.len());
                }
                let mut costs = Stages::new(cost, self);
                forward::<CHUNK>(self, start, inputs, &mut costs, numbers)
            }
            RolloutMode::Adjoint => self.rollout_slopes(start, inputs, cost, numbers),
        }
    }

    /// The parameters that a gradient has to have.
    fn wanted_by(&self, numbers: &[RolloutNumber]) -> WantedParameters {
        let of_model = self.model().parameters().len();
        let parameters = numbers.iter().filter_map(|number| match *number {
            RolloutNumber::Parameter(k) => Some(k),
            _ => None,
        });
        match parameters.max() {
            None => WantedParameters::None,
            Some(last) if last < of_model => WantedParameters::Model,
            Some(_) => WantedParameters::All,
        }
    }

    /// The rollout under given inputs.
    pub(super) fn rollout_under(&self, start: &State, inputs: &[DVector<f64>]) -> Rollout {
        self.check(start);
        inputs.iter().for_each(|u| self.check_input(u.as_slice()));
        let mut given = inputs.iter();
        self.rollout(start, inputs.len(), |_, _, u| {
            if let Some(given) = given.next() {
                u.copy_from_slice(given.as_slice());
            }
        })
    }
}

impl RolloutNumber {
    /// # Panics
    /// If there is no such number.
    fn check(self, simulator: &Simulator, steps: usize) {
        let exists = match self {
            Self::Start(k) => k < simulator.n_tangent(),
            Self::Input { step, index } => step < steps && index < simulator.nu(),
            Self::Parameter(k) => k < simulator.parameters().len(),
        };
        let name = simulator.model().name();
        assert!(
            exists,
            "a rollout of {steps} steps of \"{name}\" has no {self:?}"
        );
    }
}

fn forward<const N: usize>(
    simulator: &Simulator,
    start: &State,
    inputs: &[DVector<f64>],
    costs: &mut dyn Costs,
    numbers: &[RolloutNumber],
) -> RolloutSlopes {
    let rollout = simulator.rollout_under(start, inputs);
    let mut out = RolloutSlopes {
        cost: f64::INFINITY,
        slopes: DVector::zeros(numbers.len()),
        mode: RolloutMode::Forward,
        status: rollout.status,
    };
    if rollout.status != RolloutStatus::Completed {
        return out;
    }
    let weights = Weights::new(simulator, &rollout, costs);
    out.cost = weights.cost;
    let own = out.slopes.as_mut_slice().chunks_mut(N);
    for (numbers, out) in numbers.chunks(N).zip(own) {
        let mut run = DualRollout::<N>::new(simulator, start, numbers);
        for (k, state) in rollout.states.iter().enumerate() {
            run.add_motion(simulator, state, &weights.states[k], out);
            if let Some(u) = rollout.inputs.get(k) {
                run.step(k, u, numbers, &weights.inputs[k], out);
            }
        }
    }
    out
}

/// Slopes of the cost in all states and inputs of a rollout.
struct Weights {
    cost: f64,
    states: Vec<DVector<f64>>,
    inputs: Vec<DVector<f64>>,
}

impl Weights {
    fn new(simulator: &Simulator, rollout: &Rollout, costs: &mut dyn Costs) -> Self {
        let (states, inputs) = (&rollout.states, &rollout.inputs);
        let mut out = Self {
            cost: 0.0,
            states: vec![DVector::zeros(simulator.n_tangent()); states.len()],
            inputs: vec![DVector::zeros(simulator.nu()); inputs.len()],
        };
        for (step, u) in inputs.iter().enumerate() {
            let at = StagePoint {
                simulator,
                step,
                state: &states[step],
                u: u.as_slice(),
            };
            let mut slopes = CostSlopes {
                state: out.states[step].as_mut_slice(),
                input: out.inputs[step].as_mut_slice(),
            };
            out.cost += costs.stage(&at, &mut slopes);
        }
        let last = inputs.len();
        let slopes = out.states[last].as_mut_slice();
        out.cost += costs.end(simulator, &states[last], slopes);
        out
    }
}

/// A rollout over dual numbers along some numbers.
struct DualRollout<const N: usize> {
    simulator: Simulator<Dual<f64, N>>,
    state: State<Dual<f64, N>>,
    next: State<Dual<f64, N>>,
    u: Vec<Dual<f64, N>>,
    scratch: StepScratch<Dual<f64, N>>,
}

impl<const N: usize> DualRollout<N> {
    fn new(simulator: &Simulator, start: &State, numbers: &[RolloutNumber]) -> Self {
        let mut parameters = simulator.parameters().map(Dual::<f64, N>::from);
        let mut tangent = DVector::from_element(simulator.n_tangent(), Dual::from(0.0));
        for (direction, number) in numbers.iter().enumerate() {
            match *number {
                RolloutNumber::Start(k) => tangent[k].eps[direction] = 1.0,
                RolloutNumber::Parameter(k) => parameters[k].eps[direction] = 1.0,
                RolloutNumber::Input { .. } => {}
            }
        }
        let over = simulator.with_parameters(parameters.as_slice());
        let start: State<Dual<f64, N>> = start.lift();
        Self {
            state: start.integrate(simulator.model(), tangent.as_slice()),
            next: over.neutral_state(),
            u: vec![Dual::from(0.0); simulator.nu()],
            scratch: StepScratch::new(&over),
            simulator: over,
        }
    }

    /// Adds the motion of the state along the numbers, weighted.
    fn add_motion(
        &self,
        simulator: &Simulator,
        state: &State,
        weights: &DVector<f64>,
        out: &mut [f64],
    ) {
        let motion = self.state.deviation(simulator.model(), &state.lift());
        for (x, weight) in motion.iter().zip(weights) {
            let slopes = out.iter_mut().zip(x.eps);
            slopes.for_each(|(out, slope)| *out += weight * slope);
        }
    }

    /// Takes a step, and adds the slopes in its input.
    fn step(
        &mut self,
        step: usize,
        u: &DVector<f64>,
        numbers: &[RolloutNumber],
        weights: &DVector<f64>,
        out: &mut [f64],
    ) {
        for (own, &u) in self.u.iter_mut().zip(u) {
            *own = u.into();
        }
        for (direction, number) in numbers.iter().enumerate() {
            match *number {
                RolloutNumber::Input { step: own, index } if own == step => {
                    self.u[index].eps[direction] = 1.0;
                    out[direction] += weights[index];
                }
                _ => {}
            }
        }
        let (state, scratch) = (&self.state, &mut self.scratch);
        (self.simulator).step_into(state, &self.u, scratch, &mut self.next);
        std::mem::swap(&mut self.state, &mut self.next);
    }
}
