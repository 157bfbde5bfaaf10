//! Linearised contact kinematics: rows and forces of a point, on dual numbers in the few directions that it has.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::point_on_bodies::{PointOnBodies, SecondBody};
use crate::constraint::CarrierMotion;
use crate::contact::{
    BodyMotion, BristleLoad, ContactLaw, Contacts, PairPoint, PairState, PointKinematics, ROWS,
    Turning, TurningFriction,
};
use crate::scalar::{Dual, MapEach, Over, Scalar, vectorized};
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::state::State;
use crate::sim::terms::delassus::DELASSUS;
use crate::sim::terms::jacobian::BRISTLE;
use crate::sim::terms::local::{
    OfBody, constant_motion, constant_pose, in_directions_of, seeded_pose, seeded_velocity,
};
use crate::spatial::linear::{dot, rotate};
use crate::spatial::{Force, Motion, Transform};

/// Explicit force of a contact model, and the change of its bristle over the step.
pub(super) struct LinearizedForce<T> {
    /// On each body, in it; none on the ground.
    pub(super) forces: [Option<Force<OfBody<T>>>; 2],
    /// m⁺ − m, or ṁ at an instant, in the world.
    pub(super) bristle_step: [OfBody<T>; ROWS],
}

/// Contact kinematics of a point on dual numbers: in the directions of one of its bodies, or in those of the numbers of contacts over `P`.
pub(super) struct LinearizedPoint<'a, P: Scalar = f64, T: Scalar = f64> {
    contacts: &'a Contacts<P>,
    law: ContactLaw<P>,
    /// Δt, s.
    dt: f64,
    place: PointOnBodies<T>,
    /// Of its bristle, in the world; zero where the law has none.
    deflection: Vector3<OfBody<T>>,
    /// Zero, with the derivatives of the Delassus diagonal.
    delassus: OfBody<T>,
    /// Torsional and rolling friction; `None` without.
    turning: Option<Turning<P, OfBody<T>>>,
}

impl<'a, T: Scalar> LinearizedPoint<'a, f64, T> {
    /// A point between bodies, in the directions of one of them.
    ///
    /// * `side` – 0 or 1: the body
    /// * `motions` – those of both bodies
    pub(super) fn between(
        at: &EvaluationPoint<'a, f64, T>,
        point: &PairPoint,
        side: usize,
        motions: &[CarrierMotion<T>; 2],
    ) -> Self {
        let contacts = at.simulator.contacts().expect("a contact point");
        let moved = in_directions_of(side, motions);
        let (X, V) = (moved.map_each(|at| at.X_WB), moved.map_each(|at| at.V));
        let state = contacts.pair_state(point, &X, &V);
        let friction = contacts.turning_between(point.shapes);
        Self {
            delassus: Dual::variable(T::zero(), DELASSUS),
            turning: friction.map(|friction| turning_of(friction, &X, &V)),
            ..Self::of_pair(contacts, contacts.pair_law(point.shapes), at, &X, state)
        }
    }

    /// A point of a simulator's contacts at a state; its body has a pose in the world, and a velocity in itself.
    pub(super) fn new(
        at: &EvaluationPoint<'a, f64, T>,
        index: usize,
        X_WB: &Transform<T>,
        V_B: &Motion<T>,
    ) -> Self {
        let contacts = at.simulator.contacts().expect("a contact point");
        let mut deflection = deflection_of(at.state, index);
        for (k, x) in deflection.iter_mut().enumerate() {
            x.eps[BRISTLE + k] = T::one();
        }
        let body = MovedBody {
            X_WB: seeded_pose(X_WB),
            V: seeded_velocity(V_B),
        };
        Self {
            deflection,
            delassus: Dual::variable(T::zero(), DELASSUS),
            ..Self::on(contacts, at, index, body)
        }
    }
}

impl<'a, T: Scalar> LinearizedPoint<'a, OfBody<T>, T> {
    /// A point at a state over the numbers of [`seeded`](super::seeds::seeded) contacts.
    pub(super) fn over_numbers(
        contacts: &'a Contacts<OfBody<T>>,
        at: &EvaluationPoint<'_, f64, T>,
        index: usize,
        X_WB: &Transform<T>,
        V_B: &Motion<T>,
    ) -> Self {
        let body = MovedBody {
            X_WB: constant_pose(X_WB),
            V: constant_motion(V_B),
        };
        Self {
            deflection: deflection_of(at.state, index),
            ..Self::on(contacts, at, index, body)
        }
    }
}

impl<'a, T: Scalar> LinearizedPoint<'a, OfBody<T>, T> {
    /// A point between bodies over the numbers of [`seeded`](super::seeds::seeded) contacts, of the shapes those of one.
    pub(super) fn between_numbers(
        contacts: &'a Contacts<OfBody<T>>,
        at: &EvaluationPoint<'_, f64, T>,
        point: &PairPoint,
        side: usize,
        X: &[Transform<T>; 2],
        V: &[Motion<T>; 2],
    ) -> Self {
        let (X, V) = (
            X.map_each(|X| constant_pose(&X)),
            V.map_each(|V| constant_motion(&V)),
        );
        let state = contacts.pair_state_by_sizes(point, side, &X, &V);
        let law = contacts.pair_law_by_side(point.shapes, side);
        let some = contacts.turning_between(point.shapes);
        let friction = some.map(|_| contacts.pair_turning_by_side(point.shapes, side));
        Self {
            turning: friction.map(|friction| turning_of(friction, &X, &V)),
            ..Self::of_pair(contacts, law, at, &X, state)
        }
    }
}

/// Moments at a point between two bodies, of which the second may be the world.
fn turning_of<P: Scalar, T: Scalar>(
    friction: TurningFriction<P>,
    X: &[Transform<OfBody<T>>; 2],
    V: &[Motion<OfBody<T>>; 2],
) -> Turning<P, OfBody<T>> {
    let [first, second] = [0, 1].map_each(|side| rotate(&X[side].rotation, &V[side].angular));
    let rate = first - second;
    Turning { friction, rate }
}

/// Pose in the world and velocity in itself of a body.
struct MovedBody<T> {
    X_WB: Transform<OfBody<T>>,
    V: Motion<OfBody<T>>,
}

/// Deflection of the bristle of a point; zero where there is none.
fn deflection_of<T: Scalar>(state: &State<T>, index: usize) -> Vector3<OfBody<T>> {
    let bristles = state.contact.as_slice().as_chunks::<ROWS>().0;
    let deflection = bristles.get(index).copied().unwrap_or([T::zero(); ROWS]);
    Vector3::from(deflection).map(OfBody::constant_of)
}

impl<'a, P: Scalar, T: Scalar> LinearizedPoint<'a, P, T>
where
    OfBody<T>: Over<P>,
{
    fn on(
        contacts: &'a Contacts<P>,
        at: &EvaluationPoint<'_, f64, T>,
        index: usize,
        body: MovedBody<T>,
    ) -> Self {
        let MovedBody { X_WB, V } = body;
        let point = vectorized(
            #[inline(always)]
            || {
                let body = BodyMotion {
                    X_WB: &X_WB,
                    V_B: &V,
                    duration: at.contact_duration().into(),
                };
                contacts.state(index, &body)
            },
        );
        let friction = contacts.turning(index);
        let turning = friction.map(|friction| Turning {
            friction,
            rate: rotate(&X_WB.rotation, &V.angular),
        });
        Self {
            contacts,
            turning,
            law: contacts.laws()[index],
            dt: at.dt(),
            deflection: Vector3::zeros(),
            delassus: Dual::from(0.0),
            place: PointOnBodies {
                R_WB: X_WB.rotation,
                axes: point.axes(),
                point,
                second: None,
            },
        }
    }

    fn of_pair(
        contacts: &'a Contacts<P>,
        law: ContactLaw<P>,
        at: &EvaluationPoint<'_, f64, T>,
        X: &[Transform<OfBody<T>>; 2],
        state: PairState<OfBody<T>>,
    ) -> Self {
        Self {
            contacts,
            law,
            dt: at.dt(),
            place: PointOnBodies {
                R_WB: X[0].rotation,
                axes: state.point.axes_of_any_normal(),
                point: state.point,
                second: Some(SecondBody {
                    R_WB: X[1].rotation,
                    in_body: state.in_second,
                }),
            },
            deflection: Vector3::zeros(),
            delassus: Dual::from(0.0),
            turning: None,
        }
    }

    /// y = J ã − reference + R f, where the bodies move with Ã and forces along the axes are given.
    ///
    /// * `seen` – Ã of both bodies; the second one does not matter at a point with the ground
    /// * `delassus` – entry of J M⁻¹ Jᵀ on the diagonal of the normal, 1/kg
    pub(super) fn rows(
        &self,
        seen: &[Motion<T>; 2],
        delassus: T,
        forces: &[T],
    ) -> [OfBody<T>; ROWS] {
        let own = (self.contacts.rows(&self.law, &self.kinematics(delassus))).rows;
        self.place.y_of(&own, &self.place.velocity(seen), forces)
    }

    fn kinematics(&self, delassus: T) -> PointKinematics<'_, f64, OfBody<T>> {
        PointKinematics {
            state: &self.place.point,
            axes: &self.place.axes,
            deflection: Some(self.deflection),
            delassus: Dual::new(delassus, self.delassus.eps),
            dt: self.dt,
            kappa: self.contacts.kappa_over_step(self.dt),
            speculative: self.is_speculative(),
        }
    }

    /// [`rows`](Self::rows) of the moments about all axes; `None` without.
    pub(super) fn moment_rows(
        &self,
        seen: &[Motion<T>; 2],
        delassus: T,
        moments: &[T],
    ) -> Option<[OfBody<T>; ROWS]> {
        let turning = self.turning.as_ref()?;
        let kinematics = self.kinematics(delassus);
        let across = &self.contacts.rows(&self.law, &kinematics).rows[1];
        let own = (self.contacts).turning_rows(&self.law, &kinematics, turning, across);
        Some(
            self.place
                .y_of(&own, &self.place.turning_rate(seen), moments),
        )
    }

    /// Coefficients of all blocks of moments, as the solver sees them.
    pub(super) fn moment_bounds(&self) -> Option<[OfBody<T>; 2]> {
        let turning = self.turning.as_ref()?;
        let blocks = turning.blocks(self.place.point.depth, self.is_speculative());
        Some(blocks.map_each(|(_, bound)| bound))
    }

    /// Spatial force on each body of given moments about the axes, in the body.
    pub(super) fn couples(&self, moments: &[T]) -> [Option<Force<OfBody<T>>>; 2] {
        self.place.couples(&self.place.along_axes(moments))
    }

    /// Change m⁺ − m of the bristle over a step, in the world, for given forces along the axes at its end.
    pub(super) fn bristle_step(&self, forces: &[T]) -> [OfBody<T>; ROWS] {
        let across = self.place.axes[1..].iter().zip(&forces[1..]);
        let friction = across.fold(Vector3::zeros(), |sum, (axis, &f)| {
            sum + axis.map(|x| x.each(|x| x * f))
        });
        let point = &self.place.point;
        let separation = dot(&point.normal, &point.velocity);
        let step = self.law.bristle_step(&BristleLoad {
            depth: point.depth,
            separation,
            friction: &friction,
            deflection: &self.deflection,
            dt: self.dt,
        });
        [step.x, step.y, step.z]
    }

    /// The explicit force of the contact model at the start of a step on each body, in the body, and the change of the bristle over the step, or its
    /// rate at an instant; `None` if only a solver finds the force.
    pub(super) fn explicit_force(&self, is_instant: bool) -> Option<LinearizedForce<T>> {
        let own = (self.law).explicit_force(&self.place.point, &self.deflection)?;
        let step = if is_instant {
            own.bristle.deflection
        } else {
            own.bristle.step::<f64>(self.dt)
        };
        let mut forces = self.place.forces(&own.force);
        if let Some(turning) = &self.turning {
            let normal = &self.place.point.normal;
            let moment = turning.explicit_moment(normal, dot(normal, &own.force));
            let couples = self.place.couples(&moment);
            let all = forces.iter_mut().flatten().zip(couples.iter().flatten());
            all.for_each(|(force, couple)| *force += *couple);
        }
        Some(LinearizedForce {
            forces,
            bristle_step: [step.x, step.y, step.z],
        })
    }

    /// Gap of the point, m.
    pub(super) fn gap(&self) -> OfBody<T> {
        -self.place.point.depth
    }

    /// The velocity at the point along the normal, when the bodies move with `V`.
    pub(super) fn along_normal(&self, V: &[Motion<T>; 2]) -> OfBody<T> {
        dot(&self.place.axes[0], &self.place.velocity(V))
    }

    /// μ as the solver sees it.
    pub(super) fn friction(&self) -> OfBody<T> {
        self.law
            .friction_at(self.place.point.depth, self.is_speculative())
    }

    fn is_speculative(&self) -> bool {
        self.place.second.is_some() && self.contacts.are_pairs_speculative()
    }

    /// Spatial force on each body of given forces along the axes, in the body.
    pub(super) fn forces(&self, forces: &[T]) -> [Option<Force<OfBody<T>>>; 2] {
        self.place.forces(&self.place.along_axes(forces))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{
        ContactLaw, ContactRow, HeightField, HuntCrossley, RelaxedRigid, Rigid, SoftContact,
        Terrain,
    };
    use crate::dynamics::forward_kinematics;
    use crate::sim::terms::local::BodyDerivatives;
    use crate::spatial::SPATIAL;
    use crate::{Integrator, Model, Simulator};
    use nalgebra::Matrix3;

    /// Inputs of the rows of a point, as plain numbers.
    #[derive(Clone)]
    struct Inputs {
        X_WB: Transform<f64>,
        V_B: Motion<f64>,
        delassus: f64,
        bristle: Vector3<f64>,
    }

    const FORCES: [f64; ROWS] = [7.0, 1.5, -2.0];

    /// A robot over curved ground, with a point of it that touches.
    struct Touching {
        simulator: Simulator,
        state: State,
        index: usize,
        inputs: Inputs,
        A_B: Motion<f64>,
    }

    impl Touching {
        fn new(robot: &str, law: ContactLaw) -> Self {
            let path = format!("{}/assets/{robot}.urdf", env!("CARGO_MANIFEST_DIR"));
            let model = Model::from_urdf_file(&path).expect("an asset");
            let heights: Vec<f64> = (0..81).map(|k| 0.04 * f64::from(k).sin()).collect();
            let field = HeightField::new([-2.0, -2.0], [0.5, 0.5], [9, 9], &heights);
            let contacts = Contacts::new(&model, Terrain::HeightField(field), law);
            let simulator = Simulator::new(model)
                .with_contacts(contacts)
                .with_integrator(Integrator::ImplicitVelocity);
            let mut state = simulator.neutral_state();
            let q = [0.1, -0.2, 0.0, 0.8, 0.3, -0.1, 0.5];
            let length = q[3..].iter().map(|x| x * x).sum::<f64>().sqrt();
            for (own, x) in state.q.iter_mut().zip(q) {
                *own = x;
            }
            state.q.rows_mut(3, 4).unscale_mut(length);
            for (k, v) in state.v.iter_mut().enumerate() {
                *v = 0.3 * (k as f64 + 1.0).cos();
            }
            let contacts = simulator.contacts().expect("contacts");
            let (q, v) = (state.q.as_slice(), state.v.as_slice());
            let states = contacts.states(simulator.model(), q, v);
            let index = (0..states.len())
                .max_by(|&a, &b| states[a].depth.total_cmp(&states[b].depth))
                .expect("a point");
            assert!(states[index].depth > 0.0);
            let bristle = Vector3::new(0.002, -0.001, 0.003);
            if !state.contact.is_empty() {
                state
                    .contact
                    .rows_mut(ROWS * index, ROWS)
                    .copy_from(&bristle);
            }
            let kinematics = forward_kinematics(simulator.model(), q, v);
            let body = contacts.points()[index].body;
            let inputs = Inputs {
                X_WB: kinematics.pose(Some(body)),
                V_B: kinematics.velocity(Some(body)),
                delassus: 2.5,
                bristle,
            };
            let A_B = Motion::from_array([0.4, -1.0, 3.0, 0.7, 0.2, -0.6]);
            Self {
                simulator,
                state,
                index,
                inputs,
                A_B,
            }
        }

        fn linearized(&self) -> LinearizedPoint<'_> {
            let Inputs { X_WB, V_B, .. } = &self.inputs;
            let at = EvaluationPoint::of_step(&self.simulator, &self.state, &[]);
            LinearizedPoint::new(&at, self.index, X_WB, V_B)
        }

        /// y = J ã − reference + R f, then the step of the bristle at these forces.
        fn values(&self, at: &Inputs) -> [f64; 2 * ROWS] {
            let (contacts, dt) = (
                self.simulator.contacts().expect("contacts"),
                self.simulator.time_step(),
            );
            let body = BodyMotion {
                X_WB: &at.X_WB,
                V_B: &at.V_B,
                duration: dt,
            };
            let state = contacts.state(self.index, &body);
            let axes = state.axes();
            let rows = contacts.rows(
                &contacts.laws()[self.index],
                &PointKinematics {
                    state: &state,
                    axes: &axes,
                    deflection: Some(at.bristle),
                    delassus: at.delassus,
                    dt,
                    kappa: None,
                    speculative: false,
                },
            );
            let acceleration = state.velocity_of(&at.X_WB.rotation, &self.A_B);
            let friction = axes[1] * FORCES[1] + axes[2] * FORCES[2];
            let step = contacts.laws()[self.index].bristle_step(&BristleLoad {
                depth: state.depth,
                separation: state.normal.dot(&state.velocity),
                friction: &friction,
                deflection: &at.bristle,
                dt,
            });
            std::array::from_fn(|k| match k.checked_sub(ROWS) {
                None => {
                    let ContactRow {
                        reference,
                        compliance,
                    } = rows.rows[k];
                    axes[k].dot(&acceleration) - reference + compliance * FORCES[k]
                }
                Some(k) => step[k],
            })
        }

        /// Central differences of the values along a change of the inputs.
        fn slopes(&self, change: impl Fn(&mut Inputs, f64)) -> [f64; 2 * ROWS] {
            const BY: f64 = 1e-6;
            let [after, before] = [BY, -BY].map(|by| {
                let mut at = self.inputs.clone();
                change(&mut at, by);
                self.values(&at)
            });
            std::array::from_fn(|k| (after[k] - before[k]) / (2.0 * BY))
        }
    }

    fn assert_near(what: &str, found: [f64; 2 * ROWS], expected: [f64; 2 * ROWS]) {
        let size = expected.iter().fold(1.0, |a: f64, x| a.max(x.abs()));
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() < 1e-7 * size,
                "{what}: {found} {expected}"
            );
        }
    }

    #[test]
    fn rows_and_bristle_of_a_point_have_the_slopes_of_finite_differences() {
        let soft = SoftContact {
            normal: HuntCrossley {
                stiffness: 2e3,
                damping: 40.0,
                stiffness_exponent: 0.5,
                damping_exponent: 0.5,
            },
            friction: 0.6,
        };
        for robot in ["box", "sphere"] {
            for law in [
                ContactLaw::Soft(soft),
                ContactLaw::RelaxedRigid(RelaxedRigid::default()),
                ContactLaw::Rigid(Rigid::default()),
            ] {
                let at = Touching::new(robot, law);
                let point = at.linearized();
                let rows = point.rows(&[at.A_B, Motion::zero()], at.inputs.delassus, &FORCES);
                let bristle = point.bristle_step(&FORCES);
                let all: Vec<OfBody> = rows.into_iter().chain(bristle).collect();
                let each = |of: &dyn Fn(&OfBody) -> f64| std::array::from_fn(|k| of(&all[k]));
                assert_near("value", each(&|x| x.re), at.values(&at.inputs));
                for k in 0..SPATIAL {
                    let mut unit = Motion::zero();
                    *unit.coordinate_mut(k) = 1.0;
                    let moved = at.slopes(|at, by| at.X_WB = displaced(&at.X_WB, k, by));
                    assert_near("pose", each(&|x| x.by_pose(&unit)), moved);
                    let faster = at.slopes(|at, by| *at.V_B.coordinate_mut(k) += by);
                    assert_near("velocity", each(&|x| x.by_velocity(&unit)), faster);
                }
                let lighter = at.slopes(|at, by| at.delassus += by);
                assert_near("Delassus diagonal", each(&|x| x.eps[DELASSUS]), lighter);
                if law.kind().bristle {
                    for k in 0..ROWS {
                        let stretched = at.slopes(|at, by| at.bristle[k] += by);
                        assert_near("bristle", each(&|x| x.eps[BRISTLE + k]), stretched);
                    }
                }
            }
        }
    }

    /// X exp(ξ) for a small ξ along one coordinate.
    fn displaced(X: &Transform<f64>, k: usize, by: f64) -> Transform<f64> {
        let e = Vector3::ith(k % 3, by);
        if k < 3 {
            return Transform::new(X.rotation, X.translation + X.rotation * e);
        }
        let turn: Matrix3<f64> = nalgebra::Rotation3::new(e).into_inner();
        Transform::new(X.rotation * turn, X.translation)
    }

    // The derivative of the contact state in the forces across is taken from steps under unit forces.
    #[test]
    fn step_of_the_bristle_is_linear_in_the_friction() {
        let at = Touching::new("box", ContactLaw::Soft(SoftContact::estimate(1.0, 4, 1e-3)));
        let point = at.linearized();
        let step = |forces: [f64; ROWS]| point.bristle_step(&forces).map(|x| x.re);
        let none = step([3.0, 0.0, 0.0]);
        let [first, second] = [step([3.0, 1.0, 0.0]), step([3.0, 0.0, 1.0])];
        let both = step([3.0, FORCES[1], FORCES[2]]);
        for k in 0..ROWS {
            let change = FORCES[1] * (first[k] - none[k]) + FORCES[2] * (second[k] - none[k]);
            assert!((both[k] - none[k] - change).abs() < 1e-14);
        }
    }
}
