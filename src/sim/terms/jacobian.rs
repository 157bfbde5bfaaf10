//! The sink of A and B: propagates derivatives of forces and rows along the joints of a body into columns.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::ops::Range;

use super::chain::{Chain, Turns, most_coordinates};
use super::columns::RowColumns;
use super::delassus::DelassusColumns;
use super::local::{BodyDerivatives, FURTHER, INPUT, OfBody, OfCoordinate, POSITION, RATE, part};
use super::sink::{
    ActingPlace, BodyRow, BodySink, CoordinateSink, DerivativePoint, Normal, Own, Sink,
};
use crate::constraint::CarrierMotion;
use crate::contact::ROWS;
use crate::dynamics::{
    AccelerationDerivatives, Blocks, Calls, Entries, Kinematics, forward_kinematics_into,
};
use crate::model::BodyId;
use crate::nested::IntoNested;
use crate::scalar::{Differentiable, MapEach, Scalar, each};
use crate::sim::simulator::Simulator;
use crate::spatial::{Force, Motion, SPATIAL};

/// Derivatives of the balance of forces, and the forces on bodies at this point.
#[derive(Clone, Debug)]
pub(crate) struct ForceColumns<T: Differentiable = f64> {
    /// Its columns: −∂τ − ∂(Jᵀ f) in q, v, the contact state and the input.
    pub(crate) acceleration: AccelerationDerivatives<T>,
    /// Δt c + Δt² k of drives and joint limits whose forces are those of the end of a step; zeros where none are.
    pub(crate) resistance: Vec<OfCoordinate<T>>,
    /// On each body, in the body.
    pub(crate) bodies: Vec<Force<T>>,
}

impl<T: Differentiable> ForceColumns<T> {
    /// Makes memory for a simulator.
    pub(crate) fn new(simulator: &Simulator, calls: Calls) -> Self {
        let model = simulator.model();
        let further = simulator.n_contact() + simulator.nu();
        Self {
            acceleration: AccelerationDerivatives::new(model, further, calls),
            resistance: vec![OfCoordinate::from(0.0); model.nv()],
            bodies: vec![Force::zero(); model.n_bodies()],
        }
    }

    /// Starts anew without forces.
    pub(crate) fn clear(&mut self) {
        self.acceleration.columns.clear();
        self.resistance.fill(OfCoordinate::from(0.0));
        self.bodies.fill(Force::zero());
    }
}

/// Working memory of a [`JacobianSink`].
#[derive(Clone, Debug)]
pub(crate) struct JacobianMemory<T: Differentiable> {
    /// ∂ of changes of the contact state over the step; of its rates at an instant.
    pub(crate) rates: Blocks<T>,
    /// For terms that do not know their own.
    kinematics: Kinematics<T>,
    is_placed: bool,
    /// The body that derivatives are taken in, and the one before it, on which forces may act too.
    carried: [Carried<T>; 2],
    /// The index of the former one.
    moving: usize,
    delassus: DelassusColumns<T>,
}

/// A body and the coordinates of its motion.
#[derive(Clone, Debug)]
struct Carried<T> {
    /// `None` before the first.
    body: Option<BodyId>,
    chain: Chain<T>,
    /// Derivatives in the position of each coordinate of the velocity, and of the motion that ã gives.
    velocity: Vec<Motion<T>>,
    seen: Vec<Motion<T>>,
    /// Those of the acceleration while ã = 0.
    bias: Turns<T>,
}

impl<T: Differentiable> JacobianMemory<T> {
    /// Makes memory for a simulator.
    pub(crate) fn new(simulator: &Simulator) -> Self {
        let model = simulator.model();
        let turns = || Vec::with_capacity(most_coordinates(model));
        let carried = || Carried {
            body: None,
            chain: Chain::new(model),
            velocity: turns(),
            seen: turns(),
            bias: Turns::new(model),
        };
        Self {
            rates: Blocks::new(simulator.n_contact(), simulator.n_motion() + simulator.nu()),
            kinematics: Kinematics::new(model),
            is_placed: false,
            carried: [carried(), carried()],
            moving: 0,
            delassus: DelassusColumns::new(model),
        }
    }
}

impl<T: Differentiable> JacobianMemory<T> {
    fn moving(&self) -> &Carried<T> {
        &self.carried[self.moving]
    }
}

/// The sink that adds derivatives of terms to columns.
pub(crate) struct JacobianSink<'a, T: Differentiable> {
    at: &'a DerivativePoint<'a, T>,
    forces: &'a mut ForceColumns<T>,
    /// ∂y of all rows, or of those of constraints alone; with ã.
    rows: &'a mut RowColumns<T>,
    memory: &'a mut JacobianMemory<T>,
    /// `None` is the world, which does not move.
    moving: Option<BodyId>,
}

impl<'a, T: Differentiable> JacobianSink<'a, T> {
    /// Starts from columns that are zero.
    pub(crate) fn new(
        at: &'a DerivativePoint<'a, T>,
        forces: &'a mut ForceColumns<T>,
        rows: &'a mut RowColumns<T>,
        memory: &'a mut JacobianMemory<T>,
    ) -> Self {
        memory.is_placed = false;
        memory.carried.iter_mut().for_each(|own| own.body = None);
        memory.rates.clear();
        Self {
            at,
            forces,
            rows,
            memory,
            moving: None,
        }
    }

    /// First columns of the contact state and of the input.
    fn first_columns(&self) -> (usize, usize) {
        let simulator = self.at.point.simulator;
        (2 * simulator.model().nv(), simulator.n_motion())
    }

    /// Columns and directions that are a term's own.
    fn own_columns(&self, own: &Own) -> Option<(usize, Range<usize>)> {
        let (contact, input) = self.first_columns();
        match own {
            Own::Nothing | Own::Parameters(_) => None,
            Own::Input(k) => Some((input + k, FURTHER..FURTHER + 1)),
            Own::Contact(first) => Some((contact + first, BRISTLE..BRISTLE + ROWS)),
        }
    }
}

/// The first direction of the contact state.
pub(super) const BRISTLE: usize = FURTHER + 1;

impl<T: Differentiable> CoordinateSink<OfCoordinate<T>> for JacobianSink<'_, T> {
    #[inline]
    fn coordinate(&mut self, k: usize, input: Option<usize>, force: OfCoordinate<T>) {
        let first = self.at.point.simulator.n_motion();
        let columns = &mut self.forces.acceleration.columns;
        columns.add(k, k, -force.eps[POSITION], -force.eps[RATE]);
        if let Some(input) = input {
            *columns.at(k, first + input) -= force.eps[INPUT];
        }
    }

    fn coupled(&mut self, k: usize, l: usize, force: OfCoordinate<T>) {
        let columns = &mut self.forces.acceleration.columns;
        columns.add(k, l, -force.eps[POSITION], -force.eps[RATE]);
    }

    #[inline]
    fn resistance(&mut self, k: usize, resistance: OfCoordinate<T>) {
        self.forces.resistance[k] += resistance;
        let a = self.at.a[k];
        self.coordinate(k, None, -resistance.each(|x| x * a));
    }

    fn coordinate_row(&mut self, row: usize, k: usize, input: Option<usize>, y: OfCoordinate<T>) {
        let (nv, first) = (self.at.a.len(), self.at.point.simulator.n_motion());
        if let Some(input) = input {
            *self.rows.columns.at(row, first + input) += y.eps[INPUT];
        }
        *self.rows.columns.at(row, k) += y.eps[POSITION];
        *self.rows.columns.at(row, nv + k) += y.eps[RATE];
    }
}

impl<T: Differentiable> BodySink<T> for JacobianSink<'_, T> {
    /// −∂(Jᵀ F) at fixed J: that J follows the pose is the part of inverse dynamics, which takes forces as fixed to their bodies.
    fn force(&mut self, on: Option<BodyId>, force: &Force<OfBody<T>>, own: Own) {
        let acting = self.memory.carried.iter().find(|own| own.body == on);
        let Some((body, acting)) = on.zip(acting) else {
            return;
        };
        self.forces.bodies[body.0] += part(force, |x| x.re);
        let (nv, further) = (self.at.a.len(), self.own_columns(&own));
        let columns = &mut self.forces.acceleration.columns;
        let mut subtract = |column: usize, change: [T; SPATIAL]| {
            let change = Force::from_array(change);
            for (k, S) in &acting.chain.coordinates {
                *columns.at(*k, column) -= S.power(&change);
            }
        };
        let F = force.to_array();
        let depends_on = |directions: Range<usize>| {
            let mut slopes = F.iter().nested(|x| &x.eps[directions.clone()]);
            slopes.any(|x| !x.is_zero())
        };
        let by_velocity = depends_on(SPATIAL..FURTHER);
        let moving = self.moving.map(|_| self.memory.moving());
        if let Some(moving) = moving.filter(|_| by_velocity || depends_on(0..SPATIAL)) {
            for (&(l, S), turn) in moving.chain.coordinates.iter().zip(&moving.velocity) {
                subtract(l, each(|k| F[k].by_pose(&S) + F[k].by_velocity(turn)));
                if by_velocity {
                    subtract(nv + l, each(|k| F[k].by_velocity(&S)));
                }
            }
        }
        if let Some((first, directions)) = further {
            for (column, direction) in (first..).zip(directions) {
                subtract(column, each(|k| F[k].eps[direction]));
            }
        }
    }

    fn rows(&mut self, rows: &[BodyRow<T>], own: Own) {
        if self.moving.is_none() {
            return;
        }
        let (nv, further) = (self.at.a.len(), self.own_columns(&own));
        let (carried, columns) = (self.memory.moving(), &mut self.rows.columns);
        for row in rows {
            carried.add_body(row.row, &row.y, nv, columns);
            carried.add_accelerations(row, nv, columns);
            add_own(row.row, &row.y, &further, columns);
        }
    }

    fn rates(&mut self, first: usize, rates: &[OfBody<T>]) {
        let own = self.own_columns(&Own::Contact(first));
        let (nv, memory) = (self.at.a.len(), &mut *self.memory);
        let carried = &memory.carried[memory.moving];
        for (row, rate) in (first..).zip(rates) {
            carried.add_body(row, rate, nv, &mut memory.rates);
            add_own(row, rate, &own, &mut memory.rates);
        }
    }

    /// The friction of a point does not depend on the state.
    fn friction(&mut self, _: usize, _: OfBody<T>) {}

    fn delassus(&mut self, rows: &[BodyRow<T>], normal: &Normal<'_, T>) {
        let Some(balance) = self.at.balance() else {
            return;
        };
        let memory = &mut *self.memory;
        let model = self.at.point.model();
        let chains = normal.on.map_each(|on| {
            let own = memory.carried.iter().find(|own| own.body == on);
            own.filter(|_| on.is_some()).map(|own| &own.chain)
        });
        let slopes = &mut memory.delassus;
        slopes.differentiate(model, balance, chains, rows[0].row, normal);
        slopes.add_to(rows, &mut self.rows.columns);
        if normal.with_mass {
            slopes.add_dampers_to(rows, &self.forces.resistance, &mut self.rows.columns);
        }
    }
}

impl<T: Differentiable> Sink<T> for JacobianSink<'_, T> {
    fn turn_to(
        &mut self,
        at: &DerivativePoint<'_, T>,
        on: Option<BodyId>,
        kinematics: Option<&Kinematics<T>>,
    ) -> CarrierMotion<T> {
        self.moving = on;
        let Some(body) = on else {
            return CarrierMotion::at_rest();
        };
        let (point, memory) = (at.point, &mut *self.memory);
        let (model, v) = (point.model(), point.v());
        if kinematics.is_none() && !std::mem::replace(&mut memory.is_placed, true) {
            forward_kinematics_into(model, point.q(), v, &mut memory.kinematics);
        }
        let kinematics = kinematics.unwrap_or(&memory.kinematics);
        let has_rows = at.balance().is_some() || at.has_biased_rows();
        if memory.carried[memory.moving].body != on {
            memory.moving = 1 - memory.moving;
        }
        let carried = &mut memory.carried[memory.moving];
        if carried.body.replace(body) != on {
            carried.chain.follow(model, kinematics, body);
            carried.chain.turns(v, &mut carried.velocity);
            if has_rows {
                carried.chain.turns(&self.rows.seen, &mut carried.seen);
            }
        }
        let mut motion = CarrierMotion {
            X_WB: kinematics.pose(on),
            V: kinematics.velocity(on),
            ..CarrierMotion::at_rest()
        };
        if has_rows {
            motion.U = carried.chain.motion(&self.rows.seen);
        }
        if at.has_biased_rows() {
            motion.bias = carried.chain.bias(model, v, &mut carried.bias);
        }
        motion
    }

    fn place(&mut self, _: &ActingPlace) {}

    fn wants_parameters(&self) -> bool {
        false
    }
}

impl<T: Scalar> Carried<T> {
    /// Adds the derivatives of a number in pose and velocity of the body to a row.
    #[inline]
    fn add_body(&self, row: usize, x: &OfBody<T>, nv: usize, out: &mut Blocks<T>) {
        for (&(k, S), turn) in self.chain.coordinates.iter().zip(&self.velocity) {
            *out.at(row, k) += x.by_pose(&S) + x.by_velocity(turn);
            *out.at(row, nv + k) += x.by_velocity(&S);
        }
    }

    /// Adds those in its accelerations.
    fn add_accelerations(&self, row: &BodyRow<T>, nv: usize, out: &mut Blocks<T>) {
        for (i, &(k, _)) in self.chain.coordinates.iter().enumerate() {
            *out.at(row.row, k) += self.seen[i].power(&row.by_seen);
            if let Some(by_bias) = &row.by_bias {
                *out.at(row.row, k) += self.bias.by_position[i].power(by_bias);
                *out.at(row.row, nv + k) += self.bias.by_rate[i].power(by_bias);
            }
        }
    }
}

/// Adds the derivatives in a term's own parameters.
fn add_own<T: Scalar>(
    row: usize,
    x: &OfBody<T>,
    own: &Option<(usize, Range<usize>)>,
    out: &mut Blocks<T>,
) {
    if let Some((first, directions)) = own.clone() {
        for (column, direction) in (first..).zip(directions) {
            *out.at(row, column) += x.eps[direction];
        }
    }
}
