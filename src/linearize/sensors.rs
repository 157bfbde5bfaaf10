//! C and D: Jacobians of sensor readings, with A and B of the same step.

use std::ops::Range;

use nalgebra::{DMatrix, DVector};

use super::Linearization;
use crate::autodiff::{CHUNK, Dual};
use crate::dynamics::Calls;
use crate::memory;
use crate::scalar::{Differentiable, Scalar};
use crate::sim::{
    AccelerationScratch, EvaluationPoint, KnownAcceleration, SensorScratch, Sensors, Signals,
    Simulator, State,
};

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
        let mut signals = Signals::default();
        let known = KnownAcceleration::new(simulator, state, signals.find(simulator, state, u));
        let mut memory = Memory::new(simulator);
        for first in (0..n + nu).step_by(CHUNK) {
            let directions = first..(first + CHUNK).min(n + nu);
            let point = Along {
                simulator,
                known: &known,
                directions: directions.clone(),
            };
            let y = point.read(self, state, u, &mut memory);
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
}

/// Working memory over dual numbers.
struct Memory<T: Differentiable> {
    found: AccelerationScratch<Dual<T, CHUNK>>,
    sensors: SensorScratch<Dual<T, CHUNK>>,
    signals: Signals<Dual<T, CHUNK>>,
}

impl<T: Differentiable> Memory<T> {
    fn new(simulator: &Simulator) -> Self {
        Self {
            found: AccelerationScratch::new(simulator, Calls::One),
            sensors: SensorScratch::new(simulator),
            signals: Signals::default(),
        }
    }
}

/// Some directions of (δx, δu) from a point whose acceleration is known.
struct Along<'a, T: Scalar> {
    simulator: &'a Simulator,
    known: &'a KnownAcceleration<T>,
    directions: Range<usize>,
}

impl<T: Differentiable> Along<'_, T> {
    /// The readings with their derivatives in these directions.
    fn read(
        &self,
        sensors: &Sensors,
        state: &State<T>,
        u: &[T],
        memory: &mut Memory<T>,
    ) -> DVector<Dual<T, CHUNK>> {
        let (simulator, n) = (self.simulator, self.simulator.n_tangent());
        let dx: Vec<_> = (0..n).map(|k| self.seeded(k, T::zero())).collect();
        let u: Vec<_> = (n..).zip(u).map(|(k, &u)| self.seeded(k, u)).collect();
        let lifted = |x: &DVector<T>| x.map(Dual::constant_of);
        let start = State {
            q: lifted(&state.q),
            v: lifted(&state.v),
            contact: lifted(&state.contact),
            activation: lifted(&state.activation),
            sleep: lifted(&state.sleep),
        };
        let moved = start.integrate(simulator.model(), &dx);
        let signal = memory.signals.find(simulator, &moved, &u);
        let at = EvaluationPoint::of_step(simulator, &moved, signal);
        let reads_forces = sensors.read_forces();
        (self.known).write(&at, &self.directions, reads_forces, &mut memory.found);
        let mut y = DVector::zeros(sensors.len());
        let (found, scratch) = (&memory.found, &mut memory.sensors);
        sensors.read_found(&at, found, scratch, y.as_mut_slice());
        y
    }

    /// A number, which is the variable of its direction if that is one of these.
    fn seeded(&self, k: usize, value: T) -> Dual<T, CHUNK> {
        match self.directions.contains(&k) {
            true => Dual::variable(value, k - self.directions.start),
            false => Dual::constant_of(value),
        }
    }
}
