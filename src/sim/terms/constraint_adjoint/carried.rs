//! Constraints between anchors: derivatives in the motions of the two bodies that carry them.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::HeldConstraint;
use crate::constraint::{
    Anchor, CarrierMotion, Constraint, ConstraintKind, ConstraintRow, Mounted,
};
use crate::dynamics::{Sweep, world_acceleration};
use crate::model::Model;
use crate::scalar::{Dual, Scalar, vectorized};
use crate::sim::parameter_slots::add_to_part;
use crate::sim::terms::adjoint::StepSlopes;
use crate::sim::terms::moved::{faster, fixed, fixed_motion, moved};
use crate::sim::terms::place::PlaceSlopes;
use crate::spatial::{Force, Motion, SPATIAL, Transform};

/// Directions: the pose of a body (a motion of it, in it), then V, the bias of a row, and the numbers that are not those of a place.
const V: usize = SPATIAL;
const BIAS: usize = 2 * SPATIAL;
const NUMBERS: usize = BIAS + 1;
/// A length and a time constant.
const MOST_NUMBERS: usize = 2;

/// A number with its derivatives in these directions.
pub(super) type Number<T> = Dual<T, { NUMBERS + MOST_NUMBERS }>;

/// Numbers of a place: its origin, and its turn where it is welded.
const ORIGIN: usize = 3;

impl<T: Scalar> HeldConstraint<'_, T> {
    /// Adds the derivatives of λᵀ (J ã + bias) − μᵀ Jᵀ f to those of the two bodies.
    ///
    /// * `bias` – of a row
    pub(super) fn add(
        &self,
        bias: &dyn Fn(&ConstraintRow<Number<T>>) -> Number<T>,
        sweep: &mut Sweep<T>,
        out: &mut StepSlopes<'_, T>,
    ) {
        let [first, second] = self.constraint.kind().anchors() else {
            return;
        };
        let anchors = [first, second];
        let mounted = anchors.map(|anchor| anchor.mounted(self.model));
        let motions = mounted.map(|at| motion_of(self.model, sweep, &at));
        let constraint = self.constraint.seeded(NUMBERS);
        for side in 0..2 {
            let bodies = std::array::from_fn(|i| match i == side {
                true => in_all_directions(&motions[i]),
                false => in_none(&motions[i]),
            });
            let slopes = vectorized(
                #[inline(always)]
                || self.slopes(&constraint, &mounted, &bodies, side, bias),
            );
            slopes.add_to(&mounted[side], sweep);
            if !out.parameters.is_empty() {
                let turned = slopes.turned(&motions[side]);
                self.add_place(side, anchors[side], &mounted[side], &turned, sweep, out);
            }
            if side == 0 {
                let numbers = self.slots.end - self.constraint.own_numbers()..self.slots.end;
                let own = &slopes.sum.eps[NUMBERS..];
                add_to_part(out.parameters, &numbers, own, T::one());
            }
        }
    }

    /// The derivatives in the motion of one body, on which the anchors' rows act as forces: what is linear in accelerations and rates follows from these.
    #[inline(always)]
    fn slopes(
        &self,
        constraint: &Constraint<Number<T>>,
        mounted: &[Mounted<f64>; 2],
        bodies: &[CarrierMotion<Number<T>>; 2],
        side: usize,
        bias: &dyn Fn(&ConstraintRow<Number<T>>) -> Number<T>,
    ) -> CarrierSlopes<T> {
        let mut out = CarrierSlopes {
            sum: Number::from(0.0),
            by_A: Force::zero(),
            by_U: Force::zero(),
            by_W: Force::zero(),
        };
        let mut weights = self.y.iter().zip(self.forces);
        constraint.each_carried_row(mounted, bodies, |mut own| {
            let Some((&y, &force)) = weights.next() else {
                return;
            };
            own.row.bias.eps[BIAS] = T::one();
            let stabilized = bias(&own.row);
            out.sum += (own.along_seen + stabilized).each(|x| x * y)
                - own.along_weights.each(|x| x * force);
            let unit = Force::from_array(own.unit_forces[side].to_array().map(|x| x.re));
            let of_bias = y * stabilized.eps[BIAS];
            out.by_A += unit.scaled(of_bias);
            out.by_U += unit.scaled(y - of_bias);
            out.by_W = out.by_W - unit.scaled(force);
        });
        out
    }

    /// Adds the gradient in the place of an anchor, in its frame, and in that of the frame.
    ///
    /// * `turned` – derivative in a small motion of the place, seen from the body
    fn add_place(
        &self,
        side: usize,
        anchor: &Anchor,
        mounted: &Mounted<f64>,
        turned: &Force<T>,
        sweep: &Sweep<T>,
        out: &mut StepSlopes<'_, T>,
    ) {
        let placement = anchor
            .frame
            .map(|frame| &self.model.frame_of(frame).placement);
        let slopes = PlaceSlopes::of(turned, placement, &mounted.X_BA);
        if let Some(frame) = anchor.frame {
            let slot = sweep.slots.frames[frame.0];
            let slots = slot..slot + SPATIAL;
            add_to_part(out.parameters, &slots, &slopes.frame.to_array(), T::one());
        }
        let first = self.slots.start + ORIGIN * side;
        let origin = slopes.place.linear.as_slice();
        add_to_part(out.parameters, &(first..first + ORIGIN), origin, T::one());
        if let ConstraintKind::Weld(_) = self.constraint.kind() {
            let first = first + 2 * ORIGIN;
            let turn = slopes.place.angular;
            add_to_part(
                out.parameters,
                &(first..first + ORIGIN),
                turn.as_slice(),
                T::one(),
            );
        }
    }
}

/// Motion of the body under an anchor, or of the world.
fn motion_of<T: Scalar>(model: &Model, sweep: &Sweep<T>, at: &Mounted<f64>) -> CarrierMotion<T> {
    let Some(body) = at.body else {
        return CarrierMotion {
            X_WB: Transform::identity(),
            V: Motion::zero(),
            A: world_acceleration(model),
            U: Motion::zero(),
            W: Motion::zero(),
        };
    };
    let own = &sweep.bodies[body.0];
    CarrierMotion {
        X_WB: sweep.pose(model, body),
        V: own.V,
        A: own.A,
        U: sweep
            .seen
            .get(body.0)
            .map_or_else(Motion::zero, |seen| seen.U),
        W: own.W,
    }
}

fn in_all_directions<T: Scalar>(at: &CarrierMotion<T>) -> CarrierMotion<Number<T>> {
    CarrierMotion {
        X_WB: moved(&at.X_WB),
        V: faster(&at.V, V),
        ..in_none(at)
    }
}

fn in_none<T: Scalar>(at: &CarrierMotion<T>) -> CarrierMotion<Number<T>> {
    CarrierMotion {
        X_WB: fixed(&at.X_WB),
        V: fixed_motion(&at.V),
        A: fixed_motion(&at.A),
        U: fixed_motion(&at.U),
        W: fixed_motion(&at.W),
    }
}

/// Derivatives in the motion of a body, all forces on it, in it.
struct CarrierSlopes<T: Scalar> {
    /// Those in pose and velocity.
    sum: Number<T>,
    by_A: Force<T>,
    by_U: Force<T>,
    by_W: Force<T>,
}

impl<T: Scalar> CarrierSlopes<T> {
    fn by_pose(&self) -> Force<T> {
        Force::from_array(std::array::from_fn(|k| self.sum.eps[k]))
    }

    fn by_V(&self) -> Force<T> {
        Force::from_array(std::array::from_fn(|k| self.sum.eps[V + k]))
    }

    fn add_to(&self, at: &Mounted<f64>, sweep: &mut Sweep<T>) {
        let Some(body) = at.body else {
            sweep.by_A_W += self.by_A;
            return;
        };
        let own = &mut sweep.bodies[body.0];
        own.by_pose += self.by_pose();
        own.by_V += self.by_V();
        own.by_A += self.by_A;
        own.F += self.by_W;
        if let Some(seen) = sweep.seen.get_mut(body.0) {
            seen.by_U += self.by_U;
        }
    }

    /// In a small motion of a place on the body, which is that of the body under what stays: X⁻¹ M changes by X⁻¹ (M × ξ).
    fn turned(&self, at: &CarrierMotion<T>) -> Force<T> {
        let of_rates = at.V.cross_force(&self.by_V()) + at.A.cross_force(&self.by_A);
        let of_joints = at.U.cross_force(&self.by_U) + at.W.cross_force(&self.by_W);
        self.by_pose() - (of_rates + of_joints)
    }
}
