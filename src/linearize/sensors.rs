//! C and D: Jacobians of sensor readings, with A and B of the same step.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::Linearization;
use crate::autodiff::{CHUNK, Dual};
use crate::memory;
use crate::scalar::{Differentiable, Scalar};
use crate::sim::{SensorScratch, Sensors, Simulator, State};

/// The Jacobians of a step and of its sensor readings: δx⁺ = A δx + B δu and δy = C δx + D δu.
#[derive(Clone, Debug, PartialEq)]
pub struct SensorLinearization<T: Scalar = f64> {
    /// A and B.
    pub step: Linearization<T>,
    /// C: a row for each number that is read, columns (δq, δv), then the contact state and activations where there are any.
    pub c: DMatrix<T>,
    /// D: one row per reading, `nu` columns.
    pub d: DMatrix<T>,
    /// The readings y.
    pub reading: DVector<T>,
}

impl Sensors {
    /// Computes A and B of the step from `state` with input `u`, and C and D of the readings of that step. Allocates.
    ///
    /// Exact to rounding, including the acceleration and the forces of contact and constraints: D of an accelerometer is not zero. A pose is
    /// differentiated component by component, so its quaternion has four rows.
    ///
    /// * `state`, `u` – as in [`Simulator::linearize`]
    ///
    /// # Panics
    /// As [`Simulator::linearize`], or if simulator and sensors belong to different robots.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, sim::{Sensor, Sensors}};
    ///
    /// // Without friction and rotor the torque at the pivot is the input
    /// let simulator = Simulator::new(samples::pendulum());
    /// let pivot = simulator.model().find_joint("pivot")?;
    /// let sensors = Sensors::new(simulator.model(), [("torque", Sensor::JointForce(pivot))]);
    /// let at = sensors.linearize(&simulator, &State::new(&[0.3], &[0.0]), &[0.5]);
    /// assert!((at.d[(0, 0)] - 1.0).abs() < 1e-12 && at.c[(0, 0)].abs() < 1e-12);
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    pub fn linearize<T: Differentiable>(
        &self,
        simulator: &Simulator,
        state: &State<T>,
        u: &[T],
    ) -> SensorLinearization<T> {
        let (n, nu) = (simulator.n_tangent(), simulator.nu());
        let what = format_args!("Jacobians of {} readings", self.len());
        let bytes = (n + nu).saturating_mul(self.len()) * size_of::<T>();
        memory::granted(memory::check(what, bytes));
        let mut out = SensorLinearization {
            step: simulator.linearize(state, u),
            c: DMatrix::zeros(self.len(), n),
            d: DMatrix::zeros(self.len(), nu),
            reading: self.read(simulator, state, u),
        };
        let mut scratch = SensorScratch::new(simulator);
        for first in (0..n + nu).step_by(CHUNK) {
            let directions = first..(first + CHUNK).min(n + nu);
            let y = self.read_along(simulator, state, u, &directions, &mut scratch);
            for (k, column) in directions.enumerate() {
                let mut column = match column.checked_sub(n) {
                    None => out.c.column_mut(column),
                    Some(input) => out.d.column_mut(input),
                };
                let slopes = column.iter_mut().zip(&y);
                slopes.for_each(|(out, y)| *out = y.eps[k]);
            }
        }
        out
    }

    /// The readings with their derivatives in some directions of (δx, δu).
    fn read_along<T: Differentiable>(
        &self,
        simulator: &Simulator,
        state: &State<T>,
        u: &[T],
        directions: &Range<usize>,
        scratch: &mut SensorScratch<Dual<T, CHUNK>>,
    ) -> DVector<Dual<T, CHUNK>> {
        let n = simulator.n_tangent();
        let seeded = |k: usize, value: T| match directions.contains(&k) {
            true => Dual::variable(value, k - directions.start),
            false => Dual::constant_of(value),
        };
        let dx: Vec<_> = (0..n).map(|k| seeded(k, T::zero())).collect();
        let u: Vec<_> = (n..).zip(u).map(|(k, &u)| seeded(k, u)).collect();
        let lifted = |x: &DVector<T>| x.map(Dual::constant_of);
        let start = State {
            q: lifted(&state.q),
            v: lifted(&state.v),
            contact: lifted(&state.contact),
            activation: lifted(&state.activation),
            sleep: lifted(&state.sleep),
        };
        let moved = start.integrate(simulator.model(), &dx);
        let mut y = DVector::zeros(self.len());
        self.read_into(simulator, &moved, &u, scratch, y.as_mut_slice());
        y
    }
}
