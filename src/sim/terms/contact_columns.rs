//! Contribution of contact points to the Jacobians of a step.
//!
//! The rows and the force of a point depend on the pose and the velocity of its body: one evaluation on dual numbers in these directions
//! gives their derivatives, and the joints that carry the body do the rest.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::Vector3;

use super::chain::Chain;
use super::columns::RowColumns;
use super::contact::Contact;
use super::linear_point::{ForceColumns, LinearPoint, OfCoordinate};
use super::term::TermDerivatives;
use super::touch::{Local, Touch};
use crate::contact::{Contacts, ROWS};
use crate::dynamics::{Blocks, kinetic_energy_gradient_into};
use crate::model::BodyId;
use crate::scalar::Linear;
use crate::sim::balance::Balance;
use crate::sim::simulator::Simulator;
use crate::sim::state::State;
use crate::spatial::{Force, Motion, SPATIAL};

/// Derivatives of the term.
#[derive(Clone, Debug)]
pub(crate) struct ContactColumns {
    /// ∂(m⁺ − m) of all bristles; ∂ṁ at an instant.
    pub(crate) bristles: Blocks,
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

/// Where contact is linearised.
#[derive(Clone, Copy)]
struct Place<'a> {
    simulator: &'a Simulator,
    state: &'a State,
    contacts: &'a Contacts,
    at: &'a Contact<f64>,
    is_instant: bool,
}

impl<'a> Place<'a> {
    fn new(at: &LinearPoint<'a>, term: &'a Contact<f64>, contacts: &'a Contacts) -> Self {
        Self {
            simulator: at.moment.simulator,
            state: at.moment.state,
            contacts,
            at: term,
            is_instant: at.moment.is_instant,
        }
    }
}

impl ContactColumns {
    pub(super) fn new(simulator: &Simulator) -> Self {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let points = simulator.contacts().map_or(0, |c| c.points().len());
        let columns = simulator.n_tangent() + simulator.nu();
        Self {
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
    fn clear(&mut self) {
        self.bristles.clear();
        self.body = None;
        self.solved.clear();
    }

    /// Contact whose laws give the forces by themselves, at the start of the step: adds −∂Jᵀ f to the columns.
    fn add_explicit_forces(&mut self, place: &Place<'_>, forces: &mut ForceColumns) {
        let bristles = place.contacts.have_bristles();
        for i in 0..place.contacts.laws().len() {
            self.approach(place, i, None);
            let touch = self.touch(place, i);
            let Some((force, change)) = touch.explicit_force(place.is_instant) else {
                continue;
            };
            self.add_force(&force, (place, i), forces.columns());
            let changes = change.iter().enumerate().filter(|_| bristles);
            for (row, change) in changes {
                self.add_bristle(ROWS * i + row, change, (place, i));
            }
            let body = place.contacts.points()[i].body;
            forces.bodies[body.0] += place.at.body_force(place.contacts, i);
        }
    }

    /// Contact whose forces a solver found: computes ∂y at fixed forces and accelerations, and adds −∂Jᵀ f to the columns.
    fn hold(
        &mut self,
        place: &Place<'_>,
        balance: &Balance<f64>,
        rows: &mut RowColumns,
        forces: &mut ForceColumns,
    ) {
        let touching = place.at.touching();
        let mut first = balance.rows().count() - ROWS * touching.len();
        let mut touching = touching.iter().copied().peekable();
        let bristles = place.contacts.have_bristles();
        for i in 0..place.contacts.laws().len() {
            let takes_part = touching.next_if_eq(&i).is_some();
            if !takes_part && !bristles {
                continue;
            }
            self.approach(place, i, Some(&rows.seen));
            let touch = self.touch(place, i);
            let mut pushes = &[0.0; ROWS][..];
            if takes_part {
                pushes = &balance.rows().forces()[first..first + ROWS];
                self.add_point(place, (i, first), (&touch, balance), rows, forces);
            }
            if bristles {
                let (step, slopes) = touch.bristle_step(pushes);
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
        (touch, balance): (&Touch<'_>, &Balance<f64>),
        rows: &mut RowColumns,
        forces: &mut ForceColumns,
    ) {
        let body = place.contacts.points()[i].body;
        let mobility = balance.rows().mobility(first);
        let pushes = &balance.rows().forces()[first..first + ROWS];
        let seen = self.chain.motion(&rows.seen);
        let y = touch.rows((&seen, mobility), pushes);
        let axes = touch.unit_forces();
        for row in 0..ROWS {
            forces.bodies[body.0] += axes[row].scaled(pushes[row]);
            self.add_row(first + row, (&y[row], &axes[row]), (place, i), rows);
        }
        self.add_force(&touch.force(pushes), (place, i), forces.columns());
        if place.contacts.read_delassus() {
            self.find_mobility(place, balance, (first, &axes[0]), touch);
            for (row, y) in y.iter().enumerate() {
                self.add_by_mobility((first + row, y), &forces.resistance, rows);
            }
        }
    }

    /// ∂y of a row by its mobility, which depends on the configuration, and on the velocity where dampers do.
    fn add_by_mobility(
        &self,
        (row, y): (usize, &Local),
        resistance: &[OfCoordinate],
        rows: &mut RowColumns,
    ) {
        for (k, x) in self.mobility.iter().enumerate() {
            *rows.columns.at(row, k) += y.by_mobility() * x;
        }
        let nv = self.response.len();
        for (k, (resistance, s)) in resistance.iter().zip(&self.response).enumerate() {
            let change = -s * s * resistance.eps[1];
            *rows.columns.at(row, nv + k) += y.by_mobility() * change;
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
        balance: &Balance<f64>,
        (row, axis): (usize, &Force<f64>),
        touch: &Touch<'_>,
    ) {
        let half = balance.rows().half(row);
        let response = self.response.iter_mut().zip(half);
        response.for_each(|(s, x)| *s = x);
        balance.factor().solve_from_world(&mut self.response);
        kinetic_energy_gradient_into(
            place.simulator.model(),
            balance.motions().0,
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

impl TermDerivatives for ContactColumns {
    type Term = Contact<f64>;

    fn add_forces(&mut self, at: &LinearPoint<'_>, term: &Contact<f64>, forces: &mut ForceColumns) {
        self.clear();
        if let Some(contacts) = at.moment.explicit_contacts() {
            self.add_explicit_forces(&Place::new(at, term, contacts), forces);
        }
    }

    fn add_rows(
        &mut self,
        at: &LinearPoint<'_>,
        term: &Contact<f64>,
        rows: &mut RowColumns,
        forces: &mut ForceColumns,
    ) {
        if let Some((contacts, balance)) = at.moment.solved_contacts().zip(at.balance) {
            self.hold(&Place::new(at, term, contacts), balance, rows, forces);
        }
    }

    /// Adds to ∂(m⁺ − m) of the bristles the part by the forces of a solution.
    fn accept(&mut self, rows: &RowColumns) {
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
