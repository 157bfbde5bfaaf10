//! The sink of a gradient: weights forces and rows, and propagates derivatives in motions of bodies to the joints by the sweep along the tree.
//!
//! The sum is  μᵀ (ID(q, v, a) − τ − Σ Jᵀ F) + λᵀ y + νᵀ Δm  at fixed accelerations and forces of rows, with the changes Δm of the contact state.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use super::delassus::{DELASSUS, DelassusAdjoint, WeightedDiagonal};
use super::jacobian::BRISTLE;
use super::local::{BodyDerivatives, FURTHER, INPUT, OfBody, OfCoordinate, POSITION, RATE, part};
use super::place::PlaceDerivatives;
use super::sink::{
    ActingPlace, BodyRow, BodySink, CoordinateSink, DerivativePoint, Normal, Own, Sink,
};
use super::weights::{StepGradientSum, TermWeights};
use crate::constraint::CarrierMotion;
use crate::contact::Contacts;
use crate::dynamics::{EnergyGradientSum, Kinematics, Sweep, world_acceleration};
use crate::model::{BodyId, Model};
use crate::scalar::Scalar;
use crate::sim::parameter_slots::{PartSlots, add_to_part};
use crate::sim::simulator::Simulator;
use crate::spatial::{Force, Motion, SPATIAL};

/// Working memory of an [`AdjointSink`].
#[derive(Clone, Debug)]
pub(crate) struct AdjointMemory<T: Scalar> {
    /// Implicit damping diagonal, and its weights through Delassus diagonals.
    resistance: Vec<OfCoordinate<T>>,
    pub(super) by_resistance: Vec<T>,
    /// For contact models that depend on the Delassus diagonal.
    delassus: Option<Box<DelassusAdjoint<T>>>,
    /// Motions of both bodies along which normals look, times their weights, by the rows of the normals.
    pub(super) along_normals: Vec<(usize, [Motion<T>; 2])>,
    pub(super) slots: PartSlots,
}

impl<T: Scalar> AdjointMemory<T> {
    /// Makes memory for a simulator.
    pub(crate) fn new(simulator: &Simulator) -> Self {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let contacts = simulator.contacts();
        let read = contacts.is_some_and(Contacts::read_delassus) && simulator.needs_solver();
        Self {
            resistance: vec![OfCoordinate::from(0.0); nv],
            by_resistance: vec![T::zero(); nv],
            delassus: read.then(|| Box::new(DelassusAdjoint::new(model))),
            along_normals: Vec::with_capacity(contacts.map_or(0, |c| c.points().len())),
            slots: PartSlots::new(simulator),
        }
    }
}

/// The sink that weights derivatives of terms.
pub(crate) struct AdjointSink<'a, 'b, T: Scalar> {
    pub(super) at: &'a DerivativePoint<'a, T>,
    pub(super) weights: &'a TermWeights<'a, T>,
    /// Between its passes, with the motions W of bodies for the rates μ; with rows it uses ã.
    pub(super) sweep: &'a mut Sweep<T>,
    pub(super) memory: &'a mut AdjointMemory<T>,
    pub(super) out: &'a mut StepGradientSum<'b, T>,
    carried: Carried<T>,
}

/// Derivatives in the motion of the current body of all terms since it was selected, as forces on it, in the body.
#[derive(Clone, Copy)]
struct Carried<T> {
    /// `None` is the world.
    on: Option<BodyId>,
    motion: CarrierMotion<T>,
    W: Motion<T>,
    by_pose: Force<T>,
    by_V: Force<T>,
    by_bias: Force<T>,
    by_U: Force<T>,
    by_W: Force<T>,
}

impl<'a, 'b, T: Scalar> AdjointSink<'a, 'b, T> {
    /// Starts from a sweep between its passes.
    pub(crate) fn new(
        at: &'a DerivativePoint<'a, T>,
        weights: &'a TermWeights<'a, T>,
        sweep: &'a mut Sweep<T>,
        memory: &'a mut AdjointMemory<T>,
        out: &'a mut StepGradientSum<'b, T>,
    ) -> Self {
        memory.resistance.fill(OfCoordinate::from(0.0));
        memory.by_resistance.fill(T::zero());
        memory.along_normals.clear();
        Self {
            at,
            weights,
            sweep,
            memory,
            out,
            carried: Carried::new(None, CarrierMotion::at_rest(), Motion::zero()),
        }
    }

    /// Adds the parts that are known only after all terms.
    pub(crate) fn finish(&mut self) {
        let weighted = self
            .memory
            .resistance
            .iter()
            .zip(&self.memory.by_resistance);
        for (v, (resistance, &weight)) in self.out.v.iter_mut().zip(weighted) {
            *v += weight * resistance.eps[RATE];
        }
    }

    /// Starts rows, which look along ã.
    pub(crate) fn look(&mut self, seen: &[T]) {
        self.sweep.look(self.at.point.model(), seen);
    }

    /// Adds the derivatives of a weighted number to those of its body.
    fn add(&mut self, x: &OfBody<T>) {
        let (by_pose, by_V) = (x.in_pose(), x.in_velocity());
        self.carried.by_pose += by_pose;
        self.carried.by_V += by_V;
        if let Some(body) = self.carried.on {
            let own = &mut self.sweep.bodies[body.0];
            own.by_pose += by_pose;
            own.by_V += by_V;
        }
    }

    /// Adds the derivatives in a term's own parameters.
    fn add_own(&mut self, x: &OfBody<T>, own: &Own) {
        match own {
            Own::Nothing => {}
            Own::Input(k) => self.out.u[*k] += x.eps[FURTHER],
            Own::Contact(first) => {
                let own = self.out.contact[*first..].iter_mut().zip(&x.eps[BRISTLE..]);
                own.for_each(|(own, &x)| *own += x);
            }
            Own::Parameters(slots) => {
                let slopes = &x.eps[FURTHER + 1..];
                add_to_part(self.out.parameters, slots, slopes, T::one());
            }
        }
    }
}

impl<T: Scalar> CoordinateSink<OfCoordinate<T>> for AdjointSink<'_, '_, T> {
    #[inline]
    fn coordinate(&mut self, k: usize, input: Option<usize>, force: OfCoordinate<T>) {
        let weight = -self.weights.mu[k];
        self.out.q[k] += weight * force.eps[POSITION];
        self.out.v[k] += weight * force.eps[RATE];
        if let Some(input) = input {
            self.out.u[input] += weight * force.eps[INPUT];
        }
    }

    fn coupled(&mut self, k: usize, l: usize, force: OfCoordinate<T>) {
        let weight = -self.weights.mu[k];
        self.out.q[l] += weight * force.eps[POSITION];
        self.out.v[l] += weight * force.eps[RATE];
    }

    #[inline]
    fn resistance(&mut self, k: usize, resistance: OfCoordinate<T>) {
        self.memory.resistance[k] += resistance;
        let a = self.at.a[k];
        self.coordinate(k, None, -resistance.each(|x| x * a));
    }

    fn coordinate_row(&mut self, row: usize, k: usize, input: Option<usize>, y: OfCoordinate<T>) {
        let weight = self.weights.y[row];
        if let Some(input) = input {
            self.out.u[input] += weight * y.eps[INPUT];
        }
        self.out.q[k] += weight * y.eps[POSITION];
        self.out.v[k] += weight * y.eps[RATE];
    }
}

impl<T: Scalar> BodySink<T> for AdjointSink<'_, '_, T> {
    /// −W · F: that J follows the pose is the part of inverse dynamics, which takes forces as fixed to their bodies.
    fn force(&mut self, on: Option<BodyId>, force: &Force<OfBody<T>>, own: Own) {
        let W = on.map_or_else(Motion::zero, |body| self.sweep.bodies[body.0].W);
        let sum = TermWeights::force(force, &W);
        self.add(&sum);
        self.add_own(&sum, &own);
        let F = part(force, |x| x.re);
        if on == self.carried.on {
            self.carried.by_W = self.carried.by_W - F;
        }
        if let Some(body) = on {
            let own = &mut self.sweep.bodies[body.0];
            own.F = own.F - F;
        }
    }

    fn rows(&mut self, rows: &[BodyRow<T>], own: Own) {
        let sum = self.weights.rows(rows);
        self.add(&sum);
        self.add_own(&sum, &own);
        let (mut by_U, mut by_bias) = (Force::zero(), Force::zero());
        for row in rows {
            let weight = self.weights.y[row.row];
            by_U += row.by_seen.scaled(weight);
            if let Some(slope) = &row.by_bias {
                by_bias += slope.scaled(weight);
            }
        }
        self.carried.by_U += by_U;
        self.carried.by_bias += by_bias;
        match self.carried.on {
            None => self.sweep.by_A_W += by_bias,
            Some(body) => {
                self.sweep.bodies[body.0].by_A += by_bias;
                self.sweep.seen[body.0].by_U += by_U - by_bias;
            }
        }
    }

    fn rates(&mut self, first: usize, rates: &[OfBody<T>]) {
        let sum = self.weights.rates(first, rates);
        self.add(&sum);
        self.add_own(&sum, &Own::Contact(first));
    }

    /// The friction of a point does not depend on the state.
    fn friction(&mut self, _: usize, _: OfBody<T>) {}

    fn delassus(&mut self, rows: &[BodyRow<T>], normal: &Normal<'_, T>) {
        let weight = self.weights.rows(rows).eps[DELASSUS];
        let memory = &mut *self.memory;
        let parts = memory.delassus.as_mut().zip(self.at.balance());
        let Some((delassus, balance)) = parts.filter(|_| !weight.is_zero()) else {
            return;
        };
        let mut slopes = EnergyGradientSum {
            q: &mut *self.out.q,
            parameters: &mut *self.out.parameters,
        };
        let diagonal = WeightedDiagonal {
            balance,
            row: rows[0].row,
            weight,
        };
        let V = delassus.add(
            self.at.point,
            &diagonal,
            normal,
            self.sweep,
            &mut slopes,
            &mut memory.by_resistance,
        );
        if normal.with_mass {
            memory.along_normals.push((diagonal.row, V));
        }
    }
}

impl<T: Scalar> Sink<T> for AdjointSink<'_, '_, T> {
    fn turn_to(
        &mut self,
        at: &DerivativePoint<'_, T>,
        on: Option<BodyId>,
        kinematics: Option<&Kinematics<T>>,
    ) -> CarrierMotion<T> {
        let model = at.point.model();
        let motion = motion_in(self.sweep, model, on, kinematics);
        let W = on.map_or_else(Motion::zero, |body| self.sweep.bodies[body.0].W);
        self.carried = Carried::new(on, motion, W);
        motion
    }

    fn place(&mut self, place: &ActingPlace) {
        if self.out.parameters.is_empty() {
            return;
        }
        let turned = self.carried.turned();
        let frame = place
            .frame
            .map(|frame| &self.at.point.model().frame_of(frame).placement);
        let slopes = PlaceDerivatives::of(&turned, frame, &place.X_BA);
        if let Some(frame) = place.frame {
            let slot = self.sweep.slots.frames[frame.0];
            let slots = slot..slot + SPATIAL;
            add_to_part(
                self.out.parameters,
                &slots,
                &slopes.frame.to_array(),
                T::one(),
            );
        }
        let (origin, turn) = (slopes.place.linear, slopes.place.angular);
        for (slots, slopes) in [(&place.origin, origin), (&place.turn, turn)] {
            add_to_part(self.out.parameters, slots, slopes.as_slice(), T::one());
        }
    }

    fn wants_parameters(&self) -> bool {
        !self.out.parameters.is_empty()
    }
}

impl<T: Scalar> Carried<T> {
    fn new(on: Option<BodyId>, motion: CarrierMotion<T>, W: Motion<T>) -> Self {
        let zero = Force::zero;
        Self {
            on,
            motion,
            W,
            by_pose: zero(),
            by_V: zero(),
            by_bias: zero(),
            by_U: zero(),
            by_W: zero(),
        }
    }

    /// In a small motion of an attachment frame on the body, equal to that of the body under the rest: X⁻¹ M changes by X⁻¹ (M × ξ).
    fn turned(&self) -> Force<T> {
        let CarrierMotion { V, bias, U, .. } = &self.motion;
        let of_rates = V.cross_force(&self.by_V) + bias.cross_force(&self.by_bias);
        let of_joints = U.cross_force(&self.by_U) + self.W.cross_force(&self.by_W);
        self.by_pose - (of_rates + of_joints)
    }
}

/// Motion of a body, or of the world, in a sweep between its passes. The acceleration includes that of the world (gravity).
fn motion_in<T: Scalar>(
    sweep: &Sweep<T>,
    model: &Model,
    on: Option<BodyId>,
    kinematics: Option<&Kinematics<T>>,
) -> CarrierMotion<T> {
    let Some(body) = on else {
        return CarrierMotion {
            bias: world_acceleration(model),
            ..CarrierMotion::at_rest()
        };
    };
    let (own, seen) = (&sweep.bodies[body.0], sweep.seen.get(body.0));
    let U = seen.map_or_else(Motion::zero, |seen| seen.U);
    CarrierMotion {
        X_WB: kinematics.map_or_else(|| sweep.pose(model, body), |all| all.pose(on)),
        V: own.V,
        bias: own.A - U,
        U,
    }
}
