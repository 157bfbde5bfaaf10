//! Learned actuators: networks of position errors and velocities.

use nalgebra::DMatrix;

use super::function::{ActuatorFunction, ActuatorPoint, MAX_ACTUATOR_STATES};
use crate::scalar::Scalar;

/// The most outputs of a layer, and inputs of the first one.
const MAX_WIDTH: usize = 64;

/// A learned actuator: a multilayer perceptron from position errors u − q and velocities v, now and some steps ago, to a force.
///
/// The input of the first layer is x = (errors at all ages, then velocities at all ages). Each layer except the last maps x to s(W x + b) with the
/// softsign s(y) = y / (1 + |y|). The last layer has one row and maps x to W x + b, the force in N·m or N. Include scales of inputs and output in the
/// weights.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, model::samples, sim::{Activation, ActuatorNetwork}};
/// use nalgebra::dmatrix;
///
/// // One layer: a spring of 30 N·m/rad on the mean of the error now and that of the step before, and a damper.
/// let network = ActuatorNetwork::new(vec![(dmatrix![15.0, 15.0, -1.0, 0.0], vec![0.0])], &[0, 1]);
/// let motor = Simulator::new(samples::pendulum()).with_time_step(0.01);
/// let motor = motor.with_activation("pivot", Activation::function(network, &[]))?;
/// let next = motor.step(&motor.state(&[0.0], &[0.0]), &[0.4]);
/// assert!((next.v[0] - 0.03 * 15.0 * 0.4).abs() < 1e-14); // Δt τ / J with J = 1/3 kg·m²
/// # Ok::<(), dualbody::UnknownName>(())
/// ```
///
/// # References
/// [Hwangbo et al. 2019].
#[derive(Clone, Debug, PartialEq)]
pub struct ActuatorNetwork {
    layers: Vec<(DMatrix<f64>, Vec<f64>)>,
    /// Ages of errors and velocities, steps.
    ages: Vec<usize>,
}

impl ActuatorNetwork {
    /// Makes a network.
    ///
    /// * `layers` – W and b of each; the first W has twice as many columns as there are ages, the last W one row
    /// * `ages` – ages of the errors and velocities that are inputs, in steps; 0 is now
    ///
    /// # Panics
    /// If sizes do not fit together, a number is not finite, a layer is wider than 64, or an age is above 16 steps.
    pub fn new(layers: Vec<(DMatrix<f64>, Vec<f64>)>, ages: &[usize]) -> Self {
        assert!(
            ages.iter().all(|age| 2 * age <= MAX_ACTUATOR_STATES),
            "ages of {ages:?} steps: a network looks back at most {} steps",
            MAX_ACTUATOR_STATES / 2
        );
        let mut width = 2 * ages.len();
        for (k, (weights, bias)) in layers.iter().enumerate() {
            let (rows, columns) = weights.shape();
            assert!(
                columns == width && bias.len() == rows && rows.max(columns) <= MAX_WIDTH,
                "layer {k} of a network has {rows} × {columns} weights and {} offsets: expected {width} columns, as many offsets as rows, at most {MAX_WIDTH} of each",
                bias.len()
            );
            let mut numbers = weights.iter().chain(bias);
            assert!(
                numbers.all(|x| x.is_finite()),
                "layer {k} of a network has a number that is not finite"
            );
            width = rows;
        }
        assert!(
            width == 1 && !layers.is_empty(),
            "a network of {} layers ends with {width} numbers: expected 1, the force",
            layers.len()
        );
        Self {
            layers,
            ages: ages.to_vec(),
        }
    }

    /// Steps that it looks back.
    fn oldest(&self) -> usize {
        self.ages.iter().copied().max().unwrap_or(0)
    }
}

impl ActuatorFunction for ActuatorNetwork {
    /// Errors of the steps before, the newest first, then velocities.
    fn states(&self) -> usize {
        2 * self.oldest()
    }

    fn respond<T: Scalar>(&self, at: &ActuatorPoint<T>, state: &[T], _: &[T], next: &mut [T]) -> T {
        let n = self.oldest();
        let (errors, velocities) = state.split_at(n);
        let now = [at.u - at.q, at.v];
        let mut x = [T::zero(); MAX_WIDTH];
        for (part, (now, before)) in now.into_iter().zip([errors, velocities]).enumerate() {
            for (k, &age) in self.ages.iter().enumerate() {
                let own = if age == 0 { now } else { before[age - 1] };
                x[part * self.ages.len() + k] = own;
            }
            if let [first, rest @ ..] = &mut next[part * n..(part + 1) * n] {
                *first = now;
                rest.copy_from_slice(&before[..n - 1]);
            }
        }
        let last = self.layers.len() - 1;
        for (k, (weights, bias)) in self.layers.iter().enumerate() {
            let mut y = [T::zero(); MAX_WIDTH];
            for (i, (out, &bias)) in y.iter_mut().zip(bias).enumerate() {
                let row = weights.row(i);
                let products = row.iter().zip(&x).map(|(&w, &x)| x * w);
                let sum = products.fold(T::constant(bias), |sum, product| sum + product);
                *out = if k == last {
                    sum
                } else {
                    sum / (sum.abs() + 1.0)
                };
            }
            x = y;
        }
        x[0]
    }
}
