//! External forces and frame actuators, which act on bodies.
//!
//! Each force depends on the pose and the velocity of its body and on one input. For its derivatives, one evaluation on dual numbers in these
//! directions tells all, and the joints that carry the body do the rest.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::marker::PhantomData;

use super::adjoint::{AdjointPoint, StepSlopes, TermAdjoint};
use super::chain::Chain;
use super::linear_point::{ForceColumns, LinearPoint};
use super::moved::{faster, moved};
use super::place::PlaceSlopes;
use super::term::{Term, TermDerivatives};
use crate::dynamics::{Blocks, Kinematics, Sweep, forward_kinematics_into};
use crate::model::{BodyId, Model};
use crate::scalar::{Differentiable, Dual, Over, Scalar};
use crate::sim::force::{FrameTerm, PLACE_NUMBERS};
use crate::sim::forces::Forces;
use crate::sim::moment::Moment;
use crate::sim::parameter_slots::{PartSlots, add_to_part};
use crate::sim::simulator::Simulator;
use crate::spatial::{Force, Motion, SPATIAL, Transform};

/// The term, with the motions that its forces follow.
#[derive(Clone, Debug)]
pub(crate) struct FrameForces<T> {
    /// `None` where no force asks how its body moves.
    kinematics: Option<Box<Kinematics<T>>>,
    /// `true` if there are forces.
    any: bool,
}

impl<T: Scalar> FrameForces<T> {
    pub(super) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let terms = simulator.frame_terms();
        let follows = terms.iter().any(|term| !term.is_fixed_to_body());
        Self {
            kinematics: follows.then(|| Box::new(Kinematics::new(simulator.model()))),
            any: !terms.is_empty(),
        }
    }
}

impl<P: Scalar, T: Over<P>> Term<P, T> for FrameForces<T> {
    #[inline]
    fn add_forces(&mut self, at: &Moment<'_, P, T>, forces: &mut Forces<T>) {
        let (model, terms) = (at.model(), at.simulator.frame_terms());
        assert_eq!(
            self.any,
            !terms.is_empty(),
            "the scratch is of a simulator without these forces"
        );
        if let Some(kinematics) = &mut self.kinematics {
            forward_kinematics_into(model, at.q(), at.v(), kinematics);
        }
        let u = at.simulator.frame_inputs(at.u);
        for term in terms.iter() {
            let Some(mount) = term.mount(model) else {
                continue;
            };
            let u = term.input().map_or(T::zero(), |input| u[input]);
            let (mut X_WB, mut V_B) = (Transform::identity(), Motion::zero());
            if let Some(kinematics) = &self.kinematics {
                X_WB = kinematics.pose(Some(mount.body));
                V_B = kinematics.velocity(Some(mount.body));
            }
            forces.bodies[mount.body.0] += term.body_force(&mount.X_BA, &X_WB, &V_B, u);
        }
    }
}

/// The direction after those of the pose of the body (a motion of the body, in the body) and of its velocity (in the body).
const INPUT: usize = 2 * SPATIAL;

/// A number with its derivatives in these directions.
type Local<T> = Dual<T, { INPUT + 1 }>;

/// Derivatives of the term.
#[derive(Clone, Debug)]
pub(crate) struct FrameForceColumns<T> {
    kinematics: Kinematics<T>,
    chain: Chain<T>,
    /// Whose chain it is.
    body: Option<BodyId>,
    /// Derivative of the velocity of the body in the position of each coordinate.
    turns: Vec<Motion<T>>,
}

impl<T: Scalar> FrameForceColumns<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let model = simulator.model();
        Self {
            kinematics: Kinematics::new(model),
            chain: Chain::new(model),
            body: None,
            turns: Vec::with_capacity(model.n_bodies().max(model.nv())),
        }
    }

    fn follow(&mut self, model: &Model, body: BodyId, v: &[T]) {
        if self.body.replace(body) != Some(body) {
            self.chain.follow(model, &self.kinematics, body);
            self.chain.turns(v, &mut self.turns);
        }
    }

    /// The force follows pose and velocity of the body.
    fn add_motion(&self, F: &Force<Local<T>>, columns: &mut Blocks<T>) {
        let by_pose = |V: &Motion<T>| part(F, |x| along(&x.eps[..SPATIAL], V));
        let by_velocity = |V: &Motion<T>| part(F, |x| along(&x.eps[SPATIAL..INPUT], V));
        // A velocity for each coordinate, after as many positions.
        let nv = columns.rows();
        for (&(l, S), turn) in self.chain.coordinates.iter().zip(&self.turns) {
            self.subtract(&(by_pose(&S) + by_velocity(turn)), l, columns);
            self.subtract(&by_velocity(&S), nv + l, columns);
        }
    }

    /// A column loses Jᵀ δF, with a change of the force on the body, in the body.
    fn subtract(&self, change: &Force<T>, column: usize, columns: &mut Blocks<T>) {
        for (k, S) in &self.chain.coordinates {
            *columns.at(*k, column) -= S.power(change);
        }
    }
}

/// Pose and velocity of a body.
struct BodyState<T> {
    X_WB: Transform<T>,
    V_B: Motion<T>,
}

impl<T: Scalar> BodyState<T> {
    fn of(kinematics: &Kinematics<T>, body: BodyId) -> Self {
        Self {
            X_WB: kinematics.pose(Some(body)),
            V_B: kinematics.velocity(Some(body)),
        }
    }
}

/// A force on its body, in the body, with its derivatives.
fn local_force<T: Scalar>(
    term: &FrameTerm<'_, f64>,
    X_BA: &Transform<f64>,
    body: &BodyState<T>,
    u: &[T],
) -> Force<Local<T>> {
    let X_WB = moved(&body.X_WB);
    let V_B = faster(&body.V_B, SPATIAL);
    let own = term.input().map(|input| Dual::variable(u[input], INPUT));
    term.body_force(X_BA, &X_WB, &V_B, own.unwrap_or(Dual::from(0.0)))
}

fn part<T: Scalar>(F: &Force<Local<T>>, of: impl Fn(&Local<T>) -> T) -> Force<T> {
    Force::from_array(F.to_array().map(|x| of(&x)))
}

fn along<T: Scalar>(slopes: &[T], V: &Motion<T>) -> T {
    let products = slopes.iter().zip(V.to_array());
    products.fold(T::zero(), |sum, (&slope, x)| sum + slope * x)
}

impl<T: Differentiable> TermDerivatives<T> for FrameForceColumns<T> {
    type Term = FrameForces<T>;

    /// That J follows the pose is the part of inverse dynamics, which takes the forces as fixed to their bodies.
    fn add_forces(
        &mut self,
        at: &LinearPoint<'_, T>,
        _: &FrameForces<T>,
        forces: &mut ForceColumns<T>,
    ) {
        let (moment, simulator) = (at.moment, at.moment.simulator);
        let (model, terms) = (simulator.model(), simulator.frame_terms());
        if terms.is_empty() {
            return;
        }
        forward_kinematics_into(model, moment.q(), moment.v(), &mut self.kinematics);
        self.body = None;
        let first = simulator.n_tangent() + simulator.actuated().len();
        let u = simulator.frame_inputs(moment.u);
        for term in terms.iter() {
            let Some(mount) = term.mount(model) else {
                continue;
            };
            let F = local_force(
                &term,
                &mount.X_BA,
                &BodyState::of(&self.kinematics, mount.body),
                u,
            );
            forces.bodies[mount.body.0] += part(&F, |x| x.re);
            self.follow(model, mount.body, moment.v());
            if !term.is_fixed_to_body() {
                self.add_motion(&F, forces.columns());
            }
            if let Some(input) = term.input() {
                let by_input = part(&F, |x| x.eps[INPUT]);
                self.subtract(&by_input, first + input, forces.columns());
            }
        }
    }
}

/// The gradient of the term.
#[derive(Clone, Debug)]
pub(crate) struct FrameForceAdjoint<T> {
    slots: PartSlots,
    of: PhantomData<T>,
}

impl<T: Scalar> FrameForceAdjoint<T> {
    pub(super) fn new(simulator: &Simulator) -> Self {
        Self {
            slots: PartSlots::new(simulator),
            of: PhantomData,
        }
    }
}

impl<T: Scalar> TermAdjoint<T> for FrameForceAdjoint<T> {
    type Term = FrameForces<T>;

    /// W · F; that J follows the pose is the part of inverse dynamics, which takes the forces as fixed to their bodies.
    fn add_forces(
        &mut self,
        at: &AdjointPoint<'_, T>,
        forces: &FrameForces<T>,
        sweep: &mut Sweep<T>,
        out: &mut StepSlopes<'_, T>,
    ) {
        let (simulator, model) = (at.moment.simulator, at.moment.model());
        let (first, u) = (
            simulator.actuated().len(),
            simulator.frame_inputs(at.moment.u),
        );
        for (k, term) in simulator.frame_terms().iter().enumerate() {
            let Some(mount) = term.mount(model) else {
                continue;
            };
            let rest = || BodyState {
                X_WB: Transform::identity(),
                V_B: Motion::zero(),
            };
            let kinematics = forces.kinematics.as_deref();
            let state = kinematics.map_or_else(rest, |all| BodyState::of(all, mount.body));
            let F = local_force(&term, &mount.X_BA, &state, u);
            let body = &mut sweep.bodies[mount.body.0];
            let power = F
                .to_array()
                .iter()
                .zip(body.W.to_array())
                .fold(Local::from(0.0), |sum, (&F, W)| sum + F.each(|x| x * W));
            if !term.is_fixed_to_body() {
                body.by_pose = body.by_pose - slopes_of(&power, 0);
                body.by_V = body.by_V - slopes_of(&power, SPATIAL);
            }
            if let Some(input) = term.input() {
                out.u[first + input] -= power.eps[INPUT];
            }
            if let Some(frame) = term.place().frame.filter(|_| !out.parameters.is_empty()) {
                // A frame that moves on its body by ξ is a body that moves by ξ under what stays: X⁻¹ M changes by X⁻¹ (M × ξ).
                let [by_pose, by_V] = [0, SPATIAL].map(|first| slopes_of(&power, first));
                let (F, minus) = (part(&F, |x| x.re), -T::one());
                let turned = by_pose - (state.V_B.cross_force(&by_V) + body.W.cross_force(&F));
                let placement = &model.frame_of(frame).placement;
                let slopes = PlaceSlopes::of(&turned, Some(placement), &mount.X_BA);
                let slot = sweep.slots.frames[frame.0];
                let own = slot..slot + SPATIAL;
                add_to_part(out.parameters, &own, &slopes.frame.to_array(), minus);
                let own = &self.slots.frame_terms[k];
                add_to_part(out.parameters, own, &slopes.place.to_array(), minus);
                let u = term.input().map_or(T::zero(), |input| u[input]);
                let mut slot = own.start + PLACE_NUMBERS;
                term.each_slope(&mount.X_BA, &state.X_WB, &state.V_B, u, &mut |F| {
                    let own = slot..slot + 1;
                    add_to_part(out.parameters, &own, &[body.W.power(&F)], minus);
                    slot += 1;
                });
            }
        }
    }
}

/// Derivatives of a number from a direction on: a force.
fn slopes_of<T: Scalar>(x: &Local<T>, first: usize) -> Force<T> {
    Force::from_array(std::array::from_fn(|k| x.eps[first + k]))
}
