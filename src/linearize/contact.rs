//! Contribution of contact points to the Jacobians of a step.
//!
//! The rows and the force of a point depend on the pose and the velocity of its body: one evaluation on dual numbers in these directions
//! gives their derivatives, and the joints that carry the body do the rest.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::chain::Chain;
use super::rows::RowColumns;
use super::touch::{Local, Touch};
use crate::autodiff::Dual;
use crate::contact::{Contacts, ROWS};
use crate::dynamics::Blocks;
use crate::dynamics::kinetic_energy_gradient_into;
use crate::model::BodyId;
use crate::scalar::Linear;
use crate::sim::{ConstrainedScratch, ContactScratch, Simulator, State};
use crate::spatial::{Force, Motion, SPATIAL};

/// Working memory for contact.
#[derive(Clone, Debug)]
pub(super) struct ContactColumns {
    /// Force on each body, in the body.
    pub(super) external: Vec<Force<f64>>,
    /// ∂(m⁺ − m) of all bristles.
    pub(super) bristles: Blocks,
    chain: Chain,
    /// Whose chain it is: points come link after link.
    body: Option<BodyId>,
    /// Derivatives of the motions of a body at v, ã and a response in the position of each coordinate.
    turns: [Vec<Motion<f64>>; 3],
    /// M⁻¹ Jᵀ of a row.
    response: Vec<f64>,
    momenta: Vec<(Motion<f64>, Force<f64>)>,
    /// ∂G of a row and itself.
    mobility: Vec<f64>,
    /// The first row of each point that takes part in the solution, the point, and how its forces across move its bristle.
    solved: Vec<(usize, usize, [Vector3<f64>; 2])>,
}

/// Where a step is linearised.
#[derive(Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) simulator: &'a Simulator,
    pub(super) state: &'a State,
    pub(super) contacts: &'a Contacts,
    pub(super) at: &'a ContactScratch<f64>,
}

impl ContactColumns {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let points = simulator.contacts().map_or(0, |c| c.points().len());
        let columns = simulator.n_tangent() + simulator.nu();
        Self {
            external: vec![Force::zero(); model.n_bodies()],
            bristles: Blocks::new(simulator.n_contact(), columns),
            chain: Chain::new(model),
            body: None,
            turns: std::array::from_fn(|_| Vec::with_capacity(model.n_bodies().max(nv))),
            response: vec![0.0; nv],
            momenta: vec![(Motion::zero(), Force::zero()); model.n_bodies()],
            mobility: vec![0.0; nv],
            solved: Vec::with_capacity(points),
        }
    }

    /// Starts anew without contact.
    pub(super) fn clear(&mut self) {
        self.external.fill(Force::zero());
        self.bristles.clear();
        self.body = None;
        self.solved.clear();
    }

    /// Contact whose laws give the forces by themselves, at the start of the step: adds −∂Jᵀ f to the columns.
    pub(super) fn add_explicit_forces(&mut self, place: &Place<'_>, columns: &mut Blocks) {
        for i in 0..place.contacts.laws().len() {
            self.approach(place, i, None);
            let touch = self.touch(place, i);
            let Some((force, step)) = touch.explicit_force() else {
                continue;
            };
            self.add_force(&force, (place, i), columns);
            if place.contacts.have_bristles() {
                for (row, step) in step.iter().enumerate() {
                    self.add_bristle(3 * i + row, step, (place, i));
                }
            }
            let body = place.contacts.points()[i].body;
            self.external[body.0] += place.at.body_force(place.contacts, i);
        }
    }

    /// Contact whose forces a solver found: computes ∂y at fixed forces and accelerations, and adds −∂Jᵀ f to the columns.
    pub(super) fn hold(
        &mut self,
        place: &Place<'_>,
        (constrained, resistance): (&ConstrainedScratch<f64>, &[Dual<f64, 3>]),
        rows: &mut RowColumns,
        columns: &mut Blocks,
    ) {
        let mut first = constrained.rows().count() - ROWS * constrained.touching().count();
        let mut touching = constrained.touching().peekable();
        let bristles = place.contacts.have_bristles();
        for i in 0..place.contacts.laws().len() {
            let takes_part = touching.next_if_eq(&i).is_some();
            if !takes_part && !bristles {
                continue;
            }
            self.approach(place, i, Some(&rows.seen));
            let touch = self.touch(place, i);
            let mut forces = &[0.0; ROWS][..];
            if takes_part {
                forces = &constrained.rows().forces()[first..first + ROWS];
                let solution = (constrained, resistance);
                self.add_point(place, (i, first), (&touch, solution), rows, columns);
            }
            if bristles {
                let (step, slopes) = touch.bristle_step(forces);
                for (row, step) in step.iter().enumerate() {
                    self.add_bristle(3 * i + row, step, (place, i));
                }
                if takes_part {
                    self.solved.push((first, i, slopes));
                }
            }
            first += if takes_part { ROWS } else { 0 };
        }
    }

    /// Adds to ∂(m⁺ − m) of the bristles the part by the forces of a solution, whose derivatives are known.
    pub(super) fn settle(&mut self, rows: &RowColumns) {
        for (bristles, f) in self.bristles.blocks_mut().zip(rows.columns.blocks()) {
            for &(first, i, slopes) in &self.solved {
                for row in 0..ROWS {
                    let own = &mut bristles[3 * i + row];
                    *own = f[first + 1].times_plus(slopes[0][row], *own);
                    *own = f[first + 2].times_plus(slopes[1][row], *own);
                }
            }
        }
    }

    /// Follows the joints that carry a point.
    fn approach(&mut self, place: &Place<'_>, i: usize, seen: Option<&[f64]>) {
        let model = place.simulator.model();
        let body = place.contacts.points()[i].body;
        if self.body.replace(body) == Some(body) {
            return;
        }
        self.chain.follow(model, &place.at.kinematics, body);
        self.chain
            .turns(place.state.v.as_slice(), &mut self.turns[0]);
        if let Some(seen) = seen {
            self.chain.turns(seen, &mut self.turns[1]);
        }
    }

    fn touch<'a>(&self, place: &Place<'a>, i: usize) -> Touch<'a> {
        let body = Some(place.contacts.points()[i].body);
        let kinematics = &place.at.kinematics;
        let motion = (&kinematics.pose(body), &kinematics.velocity(body));
        Touch::new((place.simulator, place.state), i, motion)
    }

    /// A point that takes part in the solution.
    fn add_point(
        &mut self,
        place: &Place<'_>,
        (i, first): (usize, usize),
        (touch, (constrained, resistance)): (
            &Touch<'_>,
            (&ConstrainedScratch<f64>, &[Dual<f64, 3>]),
        ),
        rows: &mut RowColumns,
        columns: &mut Blocks,
    ) {
        let body = place.contacts.points()[i].body;
        let mobility = constrained.rows().mobility(first);
        let forces = &constrained.rows().forces()[first..first + ROWS];
        let seen = self.chain.motion(&rows.seen);
        let y = touch.rows((&seen, mobility), forces);
        let axes = touch.unit_forces();
        for row in 0..ROWS {
            self.external[body.0] += axes[row].scaled(forces[row]);
            self.add_row(first + row, (&y[row], &axes[row]), (place, i), rows);
        }
        self.add_force(&touch.force(forces), (place, i), columns);
        if place.contacts.read_delassus() {
            self.find_mobility(place, constrained, (first, &axes[0]), touch);
            for (row, y) in y.iter().enumerate() {
                for (k, x) in self.mobility.iter().enumerate() {
                    *rows.columns.at(first + row, k) += y.by_mobility() * x;
                }
                let damped = resistance.iter().zip(&self.response).enumerate();
                for (k, (resistance, s)) in damped {
                    let change = -s * s * resistance.eps[1];
                    *rows.columns.at(first + row, self.response.len() + k) +=
                        y.by_mobility() * change;
                }
            }
        }
    }

    /// ∂y of a row from what it does locally and how the joints move the body, at fixed mobility.
    fn add_row(
        &self,
        row: usize,
        (y, axis): (&Local, &Force<f64>),
        at: (&Place<'_>, usize),
        rows: &mut RowColumns,
    ) {
        let carried = (&self.chain, &self.turns[0][..]);
        add_local(row, y, carried, at, &mut rows.columns);
        for (&(k, _), turn) in self.chain.coordinates.iter().zip(&self.turns[1]) {
            *rows.columns.at(row, k) += turn.power(axis);
        }
    }

    fn add_bristle(&mut self, row: usize, step: &Local, at: (&Place<'_>, usize)) {
        let carried = (&self.chain, &self.turns[0][..]);
        add_local(row, step, carried, at, &mut self.bristles);
    }

    /// −∂(Jᵀ F) at fixed J: forces follow pose and velocity of the body, and the bristle; that J follows the pose is the part of inverse
    /// dynamics.
    fn add_force(
        &self,
        force: &[Local; SPATIAL],
        (place, i): (&Place<'_>, usize),
        columns: &mut Blocks,
    ) {
        let nv = place.simulator.model().nv();
        let mut add = |column: usize, change: [f64; SPATIAL]| {
            let change = Force::from_array(change);
            for (k, S) in &self.chain.coordinates {
                *columns.at(*k, column) -= S.power(&change);
            }
        };
        for (&(l, S), turn) in self.chain.coordinates.iter().zip(&self.turns[0]) {
            add(l, force.map(|x| x.by_pose(&S) + x.by_velocity(turn)));
            add(nv + l, force.map(|x| x.by_velocity(&S)));
        }
        if place.simulator.n_contact() > 0 {
            for j in 0..ROWS {
                add(2 * nv + 3 * i + j, force.map(|x| x.by_bristle()[j]));
            }
        }
    }

    /// ∂(J M⁻¹ Jᵀ) of a row and itself: with its response s,  2 δJ s − sᵀ δM s; the part of dampers in M is not in it.
    fn find_mobility(
        &mut self,
        place: &Place<'_>,
        constrained: &ConstrainedScratch<f64>,
        (row, axis): (usize, &Force<f64>),
        touch: &Touch<'_>,
    ) {
        let half = constrained.rows().half(row);
        let response = self.response.iter_mut().zip(half);
        response.for_each(|(s, x)| *s = x);
        constrained.factor().solve_from_world(&mut self.response);
        kinetic_energy_gradient_into(
            place.simulator.model(),
            constrained.placements(),
            &self.response,
            &mut self.momenta,
            &mut self.mobility,
        );
        self.mobility.iter_mut().for_each(|x| *x *= -2.0);
        let along = touch.along_normal(&self.chain.motion(&self.response));
        self.chain.turns(&self.response, &mut self.turns[2]);
        for (&(k, S), turn) in self.chain.coordinates.iter().zip(&self.turns[2]) {
            self.mobility[k] += 2.0 * (along.by_pose(&S) + turn.power(axis));
        }
    }
}

/// The derivatives of a number in q, v and the bristle of its point, whose body is carried by a chain and turns with it.
fn add_local(
    row: usize,
    x: &Local,
    (chain, turns): (&Chain, &[Motion<f64>]),
    (place, i): (&Place<'_>, usize),
    out: &mut Blocks,
) {
    let nv = place.simulator.model().nv();
    for (&(k, S), turn) in chain.coordinates.iter().zip(turns) {
        *out.at(row, k) += x.by_pose(&S) + x.by_velocity(turn);
        *out.at(row, nv + k) += x.by_velocity(&S);
    }
    if place.simulator.n_contact() > 0 {
        for (j, slope) in x.by_bristle().into_iter().enumerate() {
            *out.at(row, 2 * nv + 3 * i + j) += slope;
        }
    }
}
