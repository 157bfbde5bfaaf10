//! Contribution of external forces and frame actuators to the Jacobians of a step.
//!
//! Each force depends on the pose and the velocity of its body and on one input: one evaluation on dual numbers in these directions tells all, and
//! the joints that carry the body do the rest.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::chain::Chain;
use super::contact_kinematics::moved;
use crate::autodiff::Dual;
use crate::dynamics::Blocks;
use crate::dynamics::{Kinematics, forward_kinematics_into};
use crate::model::{BodyId, Model};
use crate::sim::{FrameTerm, Simulator, State};
use crate::spatial::{Force, Motion, SPATIAL, Transform};

/// The direction after those of the pose of the body (a motion of the body, in the body) and of its velocity (in the body).
const INPUT: usize = 2 * SPATIAL;

/// A number with its derivatives in these directions.
type Local = Dual<f64, { INPUT + 1 }>;

/// Working memory for forces on frames.
#[derive(Clone, Debug)]
pub(super) struct ForceColumns {
    kinematics: Kinematics<f64>,
    chain: Chain,
    /// Whose chain it is.
    body: Option<BodyId>,
    /// Derivative of the velocity of the body in the position of each coordinate.
    turns: Vec<Motion<f64>>,
}

impl ForceColumns {
    pub(super) fn new(model: &Model) -> Self {
        Self {
            kinematics: Kinematics::new(model),
            chain: Chain::new(model),
            body: None,
            turns: Vec::with_capacity(model.n_bodies().max(model.nv())),
        }
    }

    /// Adds −∂Jᵀ F to the columns, and the forces to those on the bodies (each in its body).
    ///
    /// That J follows the pose is the part of inverse dynamics, which takes the forces as fixed to their bodies.
    pub(super) fn add(
        &mut self,
        simulator: &Simulator,
        (state, u): (&State, &[f64]),
        columns: &mut Blocks,
        external: &mut [Force<f64>],
    ) {
        let (model, terms) = (simulator.model(), simulator.frame_terms());
        if terms.is_empty() {
            return;
        }
        let (q, v) = (state.q.as_slice(), state.v.as_slice());
        forward_kinematics_into(model, q, v, &mut self.kinematics);
        self.body = None;
        let first = simulator.n_tangent() + simulator.actuated().len();
        let u = simulator.frame_inputs(u);
        for term in terms.iter() {
            let Some(mount) = term.mount(model) else {
                continue;
            };
            let F = self.force(&term, &mount.X_BA, mount.body, u);
            external[mount.body.0] += part(&F, |x| x.re);
            self.follow(model, mount.body, v);
            if !term.is_fixed_to_body() {
                self.add_motion(&F, columns);
            }
            if let Some(input) = term.input() {
                self.subtract(&part(&F, |x| x.eps[INPUT]), first + input, columns);
            }
        }
    }

    /// A force on its body, in the body.
    fn force(
        &self,
        term: &FrameTerm<'_, f64>,
        X_BA: &Transform<f64>,
        body: BodyId,
        u: &[f64],
    ) -> Force<Local> {
        let X_WB = moved(&self.kinematics.pose(Some(body)));
        let mut V_B: Motion<Local> = self.kinematics.velocity(Some(body)).lift();
        for k in 0..SPATIAL {
            V_B.coordinate_mut(k).eps[SPATIAL + k] = 1.0;
        }
        let own = term.input().map(|input| Dual::variable(u[input], INPUT));
        term.body_force(X_BA, &X_WB, &V_B, own.unwrap_or(Dual::from(0.0)))
    }

    fn follow(&mut self, model: &Model, body: BodyId, v: &[f64]) {
        if self.body.replace(body) != Some(body) {
            self.chain.follow(model, &self.kinematics, body);
            self.chain.turns(v, &mut self.turns);
        }
    }

    /// The force follows pose and velocity of the body.
    fn add_motion(&self, F: &Force<Local>, columns: &mut Blocks) {
        let by_pose = |V: &Motion<f64>| part(F, |x| along(&x.eps[..SPATIAL], V));
        let by_velocity = |V: &Motion<f64>| part(F, |x| along(&x.eps[SPATIAL..INPUT], V));
        // A velocity for each coordinate, after as many positions.
        let nv = columns.rows();
        for (&(l, S), turn) in self.chain.coordinates.iter().zip(&self.turns) {
            self.subtract(&(by_pose(&S) + by_velocity(turn)), l, columns);
            self.subtract(&by_velocity(&S), nv + l, columns);
        }
    }

    /// A column loses Jᵀ δF, with a change of the force on the body, in the body.
    fn subtract(&self, change: &Force<f64>, column: usize, columns: &mut Blocks) {
        for (k, S) in &self.chain.coordinates {
            *columns.at(*k, column) -= S.power(change);
        }
    }
}

fn part(F: &Force<Local>, of: impl Fn(&Local) -> f64) -> Force<f64> {
    Force::from_array(F.to_array().map(|x| of(&x)))
}

fn along(slopes: &[f64], V: &Motion<f64>) -> f64 {
    let V = V.to_array();
    slopes.iter().zip(V).map(|(slope, x)| slope * x).sum()
}

#[cfg(test)]
mod tests {
    use nalgebra::Vector3;

    use super::super::tests::{EULER, difference, inputs, laws, lower, simulator};
    use super::*;
    use crate::constraint::{Anchor, Constraint};
    use crate::contact::Terrain;
    use crate::model::samples;
    use crate::scalar::Scalar;
    use crate::sim::{ExternalForce, ForceFunction, FrameActuator};
    use crate::spatial::Representation;
    use crate::spatial::linear::{cross, scale};
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    /// A damped spring to a point, stiffer the farther it is, that also turns its place: all that a force can follow.
    struct Tether;

    impl ForceFunction for Tether {
        fn force<T: Scalar>(
            &self,
            pose: &Transform<T>,
            velocity: &Motion<T>,
            parameters: &[T],
        ) -> Force<T> {
            let p = &pose.translation;
            let stiffness = (p.x * p.x + p.y * p.y + p.z * p.z + 1.0).sqrt() * parameters[0];
            let pull = scale(p, -stiffness) - scale(&velocity.linear, parameters[1]);
            let axis = pose.rotation.column(2).into_owned();
            Force::new(pull, cross(&axis, &pull) - velocity.angular)
        }
    }

    /// Forces of all sorts on the last link and on the first.
    fn with_forces(simulator: Simulator) -> Simulator {
        let model = simulator.model();
        let links = model.link_names();
        let on = |name: &str| Anchor::frame(model, name).expect("a link of the robot");
        let (tip, base) = (on(links[links.len() - 1]), on(links[0]));
        // The first link may be the world.
        let base = if model.has_floating_base() { base } else { tip };
        let push = Force::from_array([1.0, -2.0, 3.0, 0.4, 0.5, -0.6]);
        let (mut forces, mut actuators) = (Vec::new(), Vec::new());
        for r in Representation::ALL {
            let place = tip.moved([0.1, 0.2, -0.3]);
            forces.push(ExternalForce::constant(place, push, r));
            forces.push(ExternalForce::function(base, Tether, &[5.0, 0.7], r));
            actuators.push(FrameActuator::new(format!("{r:?}"), place, push, r));
        }
        let direction = [0.1, 0.2, 0.9];
        let thruster = FrameActuator::thruster("thruster", base, direction, -0.1);
        actuators.push(thruster.with_limits(-10.0, 0.1));
        simulator
            .with_external_forces(forces)
            .with_frame_actuators(actuators)
    }

    #[test]
    fn jacobians_with_forces_on_frames_equal_those_of_the_dense_step() {
        for (seed, integrator) in (0..6).flat_map(|seed| EULER.map(|by| (seed, by))) {
            let simulator = Simulator::new(samples::random_tree(9, seed));
            let simulator = with_forces(simulator).with_integrator(integrator);
            let simulator = simulator.with_time_step(0.01);
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
            let state = State::random(simulator.model(), &mut rng, 2.0);
            let error = difference(&simulator, &state, &inputs(&simulator));
            assert!(error < 1e-12, "seed {seed} {integrator:?}: {error:e}");
        }
    }

    #[test]
    fn jacobians_with_forces_on_frames_contact_and_constraints_equal_those_of_the_dense_step() {
        let (mut touching, mut rng) = (0, Xoshiro256PlusPlus::seed_from_u64(5));
        for (law, integrator) in laws().iter().flat_map(|&law| EULER.map(|by| (law, by))) {
            let simulator = simulator("quadruped", &Terrain::incline(0.1), law);
            let mut state = simulator.neutral_state();
            let random = State::random(simulator.model(), &mut rng, 0.5);
            state.v.copy_from(&random.v);
            state.v[2] -= 1.0;
            lower(&simulator, &mut state);
            let foot = |name: &str| Anchor::frame(simulator.model(), name).unwrap();
            let tied = Constraint::distance([foot("FL_foot"), foot("RL_foot")], 0.35);
            let simulator = with_forces(simulator.with_constraints(vec![tied]));
            let simulator = simulator.with_integrator(integrator);
            let u = inputs(&simulator);
            let forces = simulator.contact_report(&state, &u).forces;
            touching += forces.iter().filter(|f| f.norm() > 0.0).count();
            let error = difference(&simulator, &state, &u);
            assert!(error < 1e-10, "{law:?} {integrator:?}: {error:e}");
        }
        assert!(touching > 3, "{touching}");
    }

    #[test]
    fn rate_with_a_thruster_equals_its_closed_form() {
        // A body of 2 kg and 0.1 kg·m² under a thrust of 3 N a quarter of a metre beside its centre of mass, which turns with it.
        let mut builder = crate::model::ModelBuilder::new("body");
        let link = crate::model::LinkSpec::new("body");
        builder.add_link(link.with_mass(2.0, [0.0; 3], [0.1; 3]));
        let model = builder.build().unwrap();
        let place = Anchor::frame(&model, "body").unwrap();
        let beside = place.moved([0.25, 0.0, 0.0]);
        let jet = FrameActuator::thruster("jet", beside, [0.0, 0.0, 2.0], 0.02);
        let simulator = Simulator::new(model).with_frame_actuators(vec![jet]);
        let rate = simulator.linearize_rate(&simulator.neutral_state(), &[3.0]);
        let expected = [0.0, 0.0, 0.5, 0.0, -2.5, 0.2];
        for (row, expected) in expected.into_iter().enumerate() {
            assert!((rate.b[(6 + row, 0)] - expected).abs() < 1e-14);
        }
        // Gravity turns with the body's axes, and the thrust does not: δv̇ = −δθ × g in the body.
        let g = Vector3::new(0.0, 0.0, -9.81);
        for k in 0..3 {
            let turned = -Vector3::ith(k, 1.0).cross(&g);
            for row in 0..3 {
                assert!((rate.a[(6 + row, 3 + k)] - turned[row]).abs() < 1e-13);
            }
        }
    }
}
