//! The readings of all sensors, from motions and forces of the step just taken.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::DVector;

use super::catalogue::Sensors;
use super::exterior::{each_exterior_force, has_exterior_forces};
use super::moment::Moment;
use super::needs::Needs;
use crate::dynamics::{
    Calls, Kinematics, Motions, RneaScratch, accelerations_of_some, motions_of_some,
    transmitted_forces,
};
use crate::scalar::{Opaque, Over, Scalar, compiled_over_f64};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::integrator::Integrator;
use crate::sim::integrators::{AccelerationScratch, FoundMotions};
use crate::sim::signals::Signals;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::sim::step::StepScratch;
use crate::spatial::Force;

/// Working memory of [`Sensors::read_into`] and [`Sensors::read_step_into`]. It belongs to the model that it was made for and to clones of it; after a
/// change of masses, placements or armature a new one is needed.
#[derive(Clone, Debug)]
pub struct SensorScratch<T: Scalar> {
    /// Acceleration and forces, where no step has found them.
    found: Option<Opaque<AccelerationScratch<T>>>,
    signals: Signals<T>,
    /// Motions of bodies that the step has not left.
    rnea: RneaScratch<T>,
    kinematics: Kinematics<T>,
    /// On each body, in it, but for the forces of joints.
    exterior: Vec<Force<T>>,
    /// Of joints, on their bodies.
    forces: Vec<Force<T>>,
}

impl<T: Scalar> SensorScratch<T> {
    /// Memory for a simulator.
    pub fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let model = simulator.model();
        Self {
            found: None,
            signals: Signals::default(),
            rnea: RneaScratch::new(model),
            kinematics: Kinematics::new(model),
            exterior: vec![Force::zero(); model.n_bodies()],
            forces: vec![Force::zero(); model.n_bodies()],
        }
    }
}

impl Sensors {
    /// Computes the readings of a step from `state` under the input `u` (length `nu`; N·m or N); the step is evaluated, not taken. Allocates.
    ///
    /// Differentiable in state and input, and over a simulator [cast](Simulator::cast) to dual numbers in its parameters.
    ///
    /// # Panics
    /// If state or input have the wrong length, or if the simulator is of another robot.
    pub fn read<P: Scalar, T: Over<P>>(
        &self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
    ) -> DVector<T> {
        let mut out = DVector::zeros(self.len());
        let mut scratch = SensorScratch::new(simulator);
        self.read_into(simulator, state, u, &mut scratch, out.as_mut_slice());
        out
    }

    /// [`read`](Self::read) without allocation after the first call.
    ///
    /// * `out` – output, length [`len`](Self::len)
    ///
    /// # Panics
    /// As there, or if the output has the wrong length.
    pub fn read_into<P: Scalar, T: Over<P>>(
        &self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        scratch: &mut SensorScratch<T>,
        out: &mut [T],
    ) {
        let sensors = self;
        compiled_over_f64!(
            [P, T] Sensors::evaluate, sensors: &Sensors, simulator: &Simulator, state: &State, u: &[f64], scratch: &mut SensorScratch<f64>, out: &mut [f64]
        );
    }

    fn evaluate<P: Scalar, T: Over<P>>(
        &self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        scratch: &mut SensorScratch<T>,
        out: &mut [T],
    ) {
        simulator.check_input(u);
        simulator.check(state);
        // Not bound to the numbers of one model: variants use it in turn.
        let new = || Opaque::new(AccelerationScratch::new(simulator, Calls::One));
        let mut found = scratch.found.take().unwrap_or_else(new);
        let mut signals = std::mem::take(&mut scratch.signals);
        let signal = signals.find(simulator, state, u);
        let at = EvaluationPoint::of_step(simulator, state, signal);
        simulator.accelerate(&at, found.get_mut());
        self.read_found(&at, found.get(), scratch, out);
        scratch.signals = signals;
        scratch.found = Some(found);
    }

    /// Computes the readings of the step that [`Simulator::step_into`] has just taken with `step`, from `state` under the input `u`. Does not
    /// allocate after the first call, except for force–torque sensors of robots with constraints.
    ///
    /// With an Euler step the acceleration and the forces are those that the step has left in its memory; with other integrators they are evaluated.
    ///
    /// * `state`, `u` – the state *before* the step, and its input
    /// * `out` – output, length [`len`](Self::len)
    ///
    /// # Panics
    /// If state, input or output have the wrong length, or if the simulator is of another robot.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, State, model::samples, sim::{Sensor, SensorScratch, Sensors, StepScratch}};
    ///
    /// let simulator = Simulator::new(samples::pendulum()).with_time_step(0.01);
    /// let pivot = simulator.model().find_joint("pivot")?;
    /// let sensors = Sensors::new(simulator.model(), [("torque", Sensor::JointForce(pivot))]);
    /// let (mut step, mut scratch) = (StepScratch::new(&simulator), SensorScratch::new(&simulator));
    /// let (state, mut next, mut y) = (State::new(&[0.4], &[0.0]), State::new(&[0.0], &[0.0]), [0.0]);
    /// simulator.step_into(&state, &[2.0], &mut step, &mut next);
    /// sensors.read_step_into(&simulator, &state, &[2.0], &step, &mut scratch, &mut y);
    /// assert!((y[0] - 2.0).abs() < 1e-12); // without friction and rotor the torque is that of the motor
    /// # Ok::<(), dualbody::UnknownName>(())
    /// ```
    pub fn read_step_into<P: Scalar, T: Over<P>>(
        &self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        step: &StepScratch<T>,
        scratch: &mut SensorScratch<T>,
        out: &mut [T],
    ) {
        if !has_one_acceleration(simulator.integrator()) || step.has_slept() {
            return self.read_into(simulator, state, u, scratch, out);
        }
        let sensors = self;
        compiled_over_f64!(
            [P, T] Sensors::take_from_step, sensors: &Sensors, simulator: &Simulator, state: &State, u: &[f64], step: &StepScratch<f64>,
            scratch: &mut SensorScratch<f64>, out: &mut [f64]
        );
    }

    fn take_from_step<P: Scalar, T: Over<P>>(
        &self,
        simulator: &Simulator<P>,
        state: &State<T>,
        u: &[T],
        step: &StepScratch<T>,
        scratch: &mut SensorScratch<T>,
        out: &mut [T],
    ) {
        simulator.check_input(u);
        simulator.check(state);
        let mut signals = std::mem::take(&mut scratch.signals);
        let signal = signals.find(simulator, state, u);
        let at = EvaluationPoint::after_step(simulator, state, signal);
        self.read_found(&at, step.acceleration(), scratch, out);
        scratch.signals = signals;
    }

    /// The bodies whose motion is taken.
    fn needs_in<P: Scalar>(&self, simulator: &Simulator<P>) -> &Needs {
        let has_no_forces =
            simulator.frame_terms().is_empty() && simulator.constraints().is_empty();
        match has_no_forces {
            true => &self.needs,
            false => &self.needs_with_forces,
        }
    }

    /// The readings where acceleration and forces have been found.
    pub(crate) fn read_found<P: Scalar, T: Over<P>>(
        &self,
        at: &EvaluationPoint<'_, P, T>,
        found: &AccelerationScratch<T>,
        scratch: &mut SensorScratch<T>,
        out: &mut [T],
    ) {
        self.check(at.simulator, out);
        let SensorScratch {
            rnea,
            kinematics,
            exterior,
            forces,
            ..
        } = scratch;
        let needs = self.needs_in(at.simulator);
        let motions = motions(at, found, needs, rnea);
        kinematics.place_some(at.model(), &needs.placed, (motions.X_PB, motions.V));
        if !needs.loaded.is_empty() {
            let mut acting = &[][..];
            if has_exterior_forces(at.simulator) {
                exterior.fill(Force::zero());
                each_exterior_force(at, found, kinematics, |_, body, F| {
                    if let Some(body) = body {
                        exterior[body.0] += F;
                    }
                });
                acting = exterior;
            }
            transmitted_forces(at.model(), &needs.loaded, motions, acting, forces);
        }
        let moment = Moment {
            at,
            found,
            kinematics,
            motions,
            forces,
        };
        for (encoders, coordinates) in self.encoders.iter().zip([at.q(), at.v()]) {
            for own in encoders {
                out[own.reading] = coordinates[own.coordinate];
            }
        }
        for placed in self.others.iter().map(|&k| &self.all[k]) {
            moment.read(self, placed, &mut out[placed.range.clone()]);
        }
    }
}

/// Motions of the bodies that sensors need: those that the step has left, and what it has not.
fn motions<'a, P: Scalar, T: Over<P>>(
    at: &EvaluationPoint<'_, P, T>,
    found: &'a AccelerationScratch<T>,
    needs: &Needs,
    rnea: &'a mut RneaScratch<T>,
) -> Motions<'a, T> {
    let (model, q, v, a) = (at.model(), at.q(), at.v(), &found.a);
    match found.motions(at) {
        FoundMotions::Accelerations(motions) => motions,
        FoundMotions::Velocities(motions) => {
            accelerations_of_some(model, &needs.accelerated, motions, [v, a], rnea)
        }
        FoundMotions::Packed(aba) => {
            aba.copy_packed_motions(&needs.read, rnea);
            rnea.accelerated()
        }
        FoundMotions::Nothing => {
            motions_of_some(model, &needs.moving, [q, v, a], rnea);
            rnea.accelerated()
        }
    }
}

/// Whether a step has one acceleration, which is left where it was found.
fn has_one_acceleration(integrator: Integrator) -> bool {
    match integrator {
        Integrator::SemiImplicitEuler | Integrator::ImplicitVelocity => true,
        Integrator::RungeKutta4 | Integrator::ImplicitMidpoint => false,
    }
}
