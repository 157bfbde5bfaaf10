//! Contact of points with the ground and between bodies: soft at an instant, where forces follow from the state; else rows whose forces a solver finds.

use nalgebra::Vector3;

use super::kept::KeptForces;
use super::pairs::PairPoints;
use super::places::{RowPlaces, has_block};
use super::touching::Touching;
use super::working_set::{StepKinematics, WorkingSet};
use crate::cone::Block;
use crate::contact::{BristleRate, Contacts, PairPoint, PointKinematics, PointState, ROWS};
use crate::dynamics::Kinematics;
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::forces::Forces;
use crate::sim::rows::Mark;
use crate::sim::simulator::Simulator;
use crate::sim::terms::term::Term;
use crate::spatial::linear::dot;

/// Height above the ground up to which a point is soon to touch, m. It chooses between two ways to the same motion: lanes that differ are computed both ways,
/// which costs more than it saves, and robots that walk differ from lane to lane where their feet are lower. States that are never computed in lanes need none.
const SOON: f64 = 0.05;

/// Share of the mobility across a contact up to which its normal counts as immovable, as that of a puck on two sliders. Without friction no force along it
/// changes the motion, so that none is determined, and the point has none.
const IMMOVABLE: f64 = 1e-12;

/// Contact at an instant: empty where there is none.
#[derive(Clone, Debug)]
pub(crate) struct Contact<T> {
    pub(crate) kinematics: Kinematics<T>,
    /// Those with the ground, then those between bodies.
    pub(crate) points: Vec<PointState<T>>,
    pub(super) pairs: PairPoints<T>,
    /// Force on each point, in the world: on the first body of two.
    pub(crate) forces: Vec<Vector3<T>>,
    /// Rate of each bristle; empty for laws without.
    pub(super) rates: Vec<BristleRate<T>>,
    /// Moment of torsional and rolling friction at each point, in the world: on the first body of two; empty without.
    pub(super) moments: Vec<Vector3<T>>,
    /// Points that have rows.
    pub(super) working: WorkingSet<T>,
    /// Axes of each of them (normal, tangent, tangent) in the world.
    pub(super) axes: Vec<[Vector3<T>; ROWS]>,
    /// Delassus diagonal of their normals.
    pub(super) delassus: Vec<T>,
    /// Where their rows are.
    pub(super) places: RowPlaces,
    /// Forces of the last solution.
    pub(super) kept: KeptForces<T>,
    /// Index of its first row.
    pub(super) first: Mark,
    /// The acceleration without rows, for points to be judged at.
    free: Vec<T>,
    /// Whether each body sleeps, and has no contact; empty where none does.
    pub(super) asleep: Vec<bool>,
}

impl<T: Scalar> Contact<T> {
    pub(crate) fn new<P: Scalar>(simulator: &Simulator<P>) -> Self {
        let (model, nv) = (simulator.model(), simulator.model().nv());
        let n = simulator.contacts().map_or(0, |c| c.points().len());
        let solved = if simulator.needs_solver() { n } else { 0 };
        let of_each = simulator.contacts().map(|c| c.solver_options().points);
        let roots = model.bodies().iter().filter(|body| body.parent.is_none());
        let limit = of_each.unwrap_or(0).saturating_mul(roots.count());
        Self {
            kinematics: Kinematics::new(model),
            points: vec![PointState::zero(); n],
            pairs: PairPoints::new(),
            forces: vec![Vector3::zeros(); n],
            rates: vec![BristleRate::zero(); simulator.n_contact() / ROWS],
            moments: Vec::new(),
            working: WorkingSet::new(solved, nv, limit),
            axes: Vec::with_capacity(solved),
            delassus: Vec::with_capacity(solved),
            places: RowPlaces::new(solved),
            kept: KeptForces::new(),
            first: Mark::default(),
            free: Vec::with_capacity(nv),
            asleep: Vec::new(),
        }
    }

    /// The points that had rows in the last solution, in order.
    pub(crate) fn touching(&self) -> &[usize] {
        self.working.active()
    }

    /// All points, with what touches there.
    pub(super) fn touching_in<'a, P: Scalar>(
        &'a self,
        contacts: &'a Contacts<P>,
    ) -> Touching<'a, P, T> {
        Touching {
            contacts,
            pairs: &self.pairs,
            points: &self.points,
            kinematics: &self.kinematics,
        }
    }

    /// The points between bodies, each with its index among all points.
    pub(super) fn pair_points<P: Scalar>(
        &self,
        contacts: &Contacts<P>,
    ) -> impl Iterator<Item = (&PairPoint, usize)> {
        let first = contacts.points().len();
        let indices = first..self.points.len();
        indices.map(move |index| (self.pairs.get(index - first), index))
    }

    /// Axes of a point that takes part, by its place among these.
    pub(super) fn axes_of(&self, of: usize) -> [Vector3<T>; ROWS] {
        self.axes[of]
    }

    /// Finds the points of rows, and those of them that could touch within the step.
    pub(crate) fn find_candidates<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        balance: &Balance<T>,
    ) where
        T: Over<P>,
    {
        let Some(contacts) = at.solved_contacts() else {
            return;
        };
        let (poses, velocities) = balance.motions();
        self.kinematics.place(at.model(), poses, velocities);
        self.find_points(contacts, at.dt(), at.contact_duration().into());
        let of_ground = contacts.activation_margin(at.dt());
        let of_pairs = contacts.pair_margin(at.dt());
        let n = contacts.points().len();
        let margin = |i: usize| if i < n { &of_ground } else { &of_pairs };
        let points = self.points.iter().enumerate();
        let points = points.filter(|(i, _)| at.left_out != Some(*i));
        let inside = points.filter(|(i, point)| margin(*i).contains(point));
        self.working
            .start(inside.map(|(i, point)| (i, margin(i).distance_inside(point))));
    }

    /// 1 in lanes in which no point could touch within the step, nor is soon to touch the ground; 0 in others.
    pub(crate) fn are_apart<P: Scalar>(&self, at: &EvaluationPoint<'_, P, T>) -> T
    where
        T: Over<P>,
    {
        let apart = self.working.are_apart();
        let contacts = at.solved_contacts().filter(|_| !self.pairs.is_full());
        let Some(contacts) = contacts else {
            return T::zero();
        };
        let known_alone = contacts.have_pairs() || at.simulator.may_bounce();
        if known_alone || (0..T::LANES).all(|lane| apart.value(lane) == 0.0) {
            return apart;
        }
        let of_ground = contacts.activation_margin(at.dt());
        let points = self.points.iter().take(contacts.points().len());
        let reach = T::constant(-SOON);
        points.fold(apart, |apart, point| {
            let inside = of_ground.distance_inside(point);
            reach.select_lt(inside, T::zero(), apart)
        })
    }

    /// No point has a force.
    pub(crate) fn rest<P: Scalar>(&mut self, contacts: &Contacts<P>) {
        self.clear_forces(contacts);
        if self.kept.stay {
            self.kept.keep(std::iter::empty());
        }
    }

    /// Selects points of those that could touch within the step; with a working set, those that would enter the ground without forces.
    fn choose<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        contacts: &Contacts<P>,
        balance: &Balance<T>,
    ) where
        T: Over<P>,
    {
        self.working.restart();
        if contacts.use_working_set() {
            let mut free = std::mem::take(&mut self.free);
            balance.free_acceleration_into(&mut free);
            self.grow(at, contacts, &free);
            self.free = free;
            if self.kept.stay {
                self.add_kept(contacts);
            }
        } else {
            self.working.take_all(&self.points);
        }
    }

    /// Activates points that would be slower than their contact model allows. Returns whether there are any.
    fn grow<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        contacts: &Contacts<P>,
        a: &[T],
    ) -> bool
    where
        T: Over<P>,
    {
        let step = StepKinematics {
            model: at.model(),
            touching: Touching {
                contacts,
                pairs: &self.pairs,
                points: &self.points,
                kinematics: &self.kinematics,
            },
            v: at.v(),
            dt: at.dt(),
        };
        self.working.grow(&step, a)
    }

    /// Takes part with the points of a solution over other numbers, and with forces of rows that are known.
    pub(crate) fn follow<S: Scalar, P: Scalar>(
        &mut self,
        other: &Contact<S>,
        contacts: &Contacts<P>,
        balance: &Balance<T>,
    ) where
        T: Over<P>,
    {
        self.axes.clear();
        self.places.clear();
        self.working.restart();
        self.working.activate(other.touching());
        for &i in other.touching() {
            let touching = self.touching_in(contacts);
            let (axes, turning) = (touching.axes(i), touching.turning(i));
            self.axes.push(axes);
            self.places.push(turning.as_ref());
        }
        self.take_forces(contacts, balance);
    }

    /// J of the points that take part.
    fn add_jacobians<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        contacts: &Contacts<P>,
        balance: &mut Balance<T>,
    ) where
        T: Over<P>,
    {
        let model = at.model();
        balance.rows.truncate(self.first);
        self.axes.clear();
        self.places.clear();
        let touching = Touching {
            contacts,
            pairs: &self.pairs,
            points: &self.points,
            kinematics: &self.kinematics,
        };
        for &i in self.working.active() {
            let axes = touching.axes(i);
            let mut own = balance.rows.grow(ROWS);
            let [n, t_1, t_2] = &axes;
            T::vectorized(
                #[inline(always)]
                || {
                    touching.each_jacobian_column(
                        model,
                        i,
                        #[inline(always)]
                        |k, column| {
                            let entries = [dot(n, &column), dot(t_1, &column), dot(t_2, &column)];
                            own.add_column(k, entries);
                        },
                    );
                },
            );
            let turning = touching.turning(i);
            if let Some(turning) = &turning {
                add_moments(&touching, model, i, &axes[turning.friction.axes()], balance);
            }
            self.axes.push(axes);
            self.places.push(turning.as_ref());
        }
    }
}

/// J of the moments of a point about some axes, block by block.
fn add_moments<P: Scalar, T: Over<P>>(
    touching: &Touching<'_, P, T>,
    model: &Model<P>,
    i: usize,
    axes: &[Vector3<T>],
    balance: &mut Balance<T>,
) {
    let mut own = balance.rows.grow(axes.len());
    touching.each_turning_column(model, i, |k, column| {
        own.add_column(k, axes.iter().map(|axis| dot(axis, &column)));
    });
}

impl<P: Scalar, T: Over<P>> Term<P, T> for Contact<T> {
    #[inline]
    fn add_forces(&mut self, at: &EvaluationPoint<'_, P, T>, forces: &mut Forces<T>) {
        self.working.clear();
        self.axes.clear();
        self.places.clear();
        if let Some(contacts) = at.explicit_contacts() {
            self.push(at, contacts, &mut forces.bodies);
        }
    }

    fn add_rows(&mut self, at: &EvaluationPoint<'_, P, T>, balance: &mut Balance<T>) {
        let Some(contacts) = at.solved_contacts() else {
            return;
        };
        self.first = balance.rows.mark();
        self.choose(at, contacts, balance);
        self.add_jacobians(at, contacts, balance);
        if self.kept.stay {
            self.start_from_kept(contacts, balance);
        }
    }

    fn add_references(&mut self, at: &EvaluationPoint<'_, P, T>, balance: &mut Balance<T>) {
        let Some(contacts) = at.solved_contacts() else {
            return;
        };
        let first = balance.rows.n_references();
        self.delassus.clear();
        for of in 0..self.working.active().len() {
            let row = first + self.places.start(of).row;
            self.delassus.push(balance.bare_delassus(row));
        }
        let rows = &mut balance.rows;
        let touching = self.touching_in(contacts);
        let (bristles, _) = at.state.contact.as_slice().as_chunks::<ROWS>();
        for (of, (&i, axes)) in self.working.active().iter().zip(&self.axes).enumerate() {
            let kinematics = PointKinematics {
                state: &self.points[i],
                axes,
                deflection: bristles.get(i).map(|&m| Vector3::from(m)),
                delassus: self.delassus[of],
                dt: at.dt(),
                kappa: contacts.kappa_over_step(at.dt()),
                speculative: touching.is_speculative(i),
            };
            let law = touching.law(i);
            let mut own = contacts.rows(&law, &kinematics);
            if T::LANES > 1 || !T::HAS_VALUES {
                own = own.within(self.working.takes_part(of));
            }
            let turning = touching.turning(i);
            if turning.is_none() {
                let row = first + self.places.start(of).row;
                let across = rows.delassus(row + 1) + rows.delassus(row + 2);
                let mobility = self.delassus[of] - across * IMMOVABLE;
                let margin = T::zero().select_lt(own.friction, T::one(), mobility);
                own = own.within(margin);
            }
            for row in own.rows {
                rows.push_reference(row.reference, row.compliance);
            }
            rows.push_block(Block::Cone, own.friction);
            let Some(turning) = turning else {
                continue;
            };
            let used = turning.friction.axes();
            let moments = contacts.turning_rows(&law, &kinematics, &turning, &own.rows[1]);
            for row in &moments[used.clone()] {
                rows.push_reference(row.reference, row.compliance);
            }
            let all = turning.blocks(self.points[i].depth, kinematics.speculative);
            for (block, bound) in all.into_iter().filter(|(own, _)| has_block(*own, &used)) {
                rows.push_block(block, bound);
            }
        }
    }

    fn add_violated(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        balance: &mut Balance<T>,
        a: &[T],
    ) -> bool {
        let some = at.solved_contacts().filter(|c| c.use_working_set());
        let Some(contacts) = some else { return false };
        let keeps = self.kept.stay || balance.rows.are_sparse();
        if keeps {
            self.keep_forces(contacts, balance);
        }
        let any = self.grow(at, contacts, a);
        if any {
            self.add_jacobians(at, contacts, balance);
            if keeps {
                self.start_from_kept(contacts, balance);
            }
        }
        any
    }

    /// Forces on points in the world, and how bristles move under them.
    fn accept(&mut self, at: &EvaluationPoint<'_, P, T>, balance: &mut Balance<T>) {
        if self.working.is_full() || self.pairs.is_full() {
            balance.report_limit();
        }
        let Some(contacts) = at.solved_contacts() else {
            return;
        };
        self.take_forces(contacts, balance);
        if self.kept.stay {
            self.keep_forces(contacts, balance);
        }
        if contacts.have_bristles() {
            self.update_bristles(at, contacts);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ContactLaw, HuntCrossley, RelaxedRigid, Rigid, SoftContact, Terrain};
    use crate::dynamics::Calls;
    use crate::model::Model;
    use crate::sim::evaluation_point::AtEnd;
    use crate::sim::integrators::AccelerationScratch;
    use crate::sim::state::State;
    use crate::spatial::Force;
    use crate::{Integrator, Simulator};

    /// A box of 1 kg and 0.36 m × 0.24 m × 0.12 m, whose lower corners are so deep in flat ground, at rest.
    fn standing(law: ContactLaw, depth: f64) -> (Simulator, State<f64>) {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/box.urdf");
        let model = Model::from_urdf_file(path).expect("an asset");
        let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
        let simulator = Simulator::new(model)
            .with_contacts(contacts)
            .with_time_step(0.01);
        let mut state = simulator.neutral_state();
        state.q[2] = 0.06 - depth;
        (simulator, state)
    }

    // Gₙₙ = 1 / m + y² / I_xx + x² / I_yy and across 1 / m + y² / I_zz + z² / I_yy …, at (0.18, 0.12, −0.06) with
    // I = (0.006, 0.012, 0.0156).
    #[test]
    fn delassus_diagonal_of_a_corner_equals_its_closed_form() {
        let (simulator, state) = standing(ContactLaw::Rigid(Rigid::default()), 1e-4);
        let mut found = AccelerationScratch::new(&simulator, Calls::One);
        simulator.accelerate(
            &EvaluationPoint::of_step(&simulator, &state, &[]),
            &mut found,
        );
        let solved = found.balance.as_ref().expect("a solver");
        assert_eq!(found.terms.contact.touching().len(), 4);
        let (x, y, z): (f64, f64, f64) = (0.18, 0.12, 0.06);
        let expected = [
            1.0 + y * y / 0.006 + x * x / 0.012,
            1.0 + z * z / 0.012 + y * y / 0.0156,
            1.0 + z * z / 0.006 + x * x / 0.0156,
        ];
        for row in 0..solved.rows().count() {
            let (found, expected) = (solved.rows().delassus(row), expected[row % ROWS]);
            assert!(
                (found - expected).abs() < 1e-13,
                "{row}: {found} {expected}"
            );
        }
    }

    // Contacts that a solver considers, by contact model and by the forces that are evaluated at the end of a step.
    #[test]
    fn solver_finds_the_forces_that_laws_leave_to_it() {
        let soft = ContactLaw::Soft(SoftContact::estimate(1.0, 4, 1e-3));
        let relaxed = ContactLaw::RelaxedRigid(RelaxedRigid::default());
        for (law, explicit) in [(soft, false), (relaxed, true)] {
            let (simulator, state) = standing(law, 0.0);
            let solved = |at_end| {
                let instant = EvaluationPoint::instant(&simulator, &state, &[]);
                let at = EvaluationPoint { at_end, ..instant };
                at.solved_contacts().is_some()
            };
            for at_end in [AtEnd::Nothing, AtEnd::Joints] {
                assert_eq!(solved(at_end), explicit);
            }
            assert!(solved(AtEnd::JointsAndContact));
            let lasts = |simulator: &Simulator| {
                EvaluationPoint::of_step(simulator, &state, &[]).contact_duration()
            };
            assert_eq!(lasts(&simulator) > 0.0, explicit);
            let implicit = simulator.with_integrator(Integrator::ImplicitVelocity);
            assert_eq!(lasts(&implicit), 0.01);
        }
    }

    // Four corners with K = 500 N/m at 10 mm: 5 N each, in the body through its centre.
    #[test]
    fn explicit_forces_add_up_on_the_body() {
        let normal = HuntCrossley::linear(500.0, 1.0);
        let law = SoftContact {
            normal,
            friction: 0.5,
        };
        let (simulator, mut state) = standing(ContactLaw::Soft(law), 0.01);
        let mut term = Contact::new(&simulator);
        let mut forces = Forces::new(&simulator);
        forces.bodies[0] = Force::new(Vector3::x(), Vector3::zeros());
        term.add_forces(
            &EvaluationPoint::instant(&simulator, &state, &[]),
            &mut forces,
        );
        let expected = Force::new(Vector3::new(1.0, 0.0, 20.0), Vector3::zeros());
        let found = forces.bodies[0].to_array();
        let mut both = found.iter().zip(expected.to_array());
        assert!(both.all(|(a, b)| (a - b).abs() < 1e-12), "{found:?}");
        // A bristle that is stretched pulls back: s = 500 N/m by 2 mm, on one corner.
        let lower = term
            .forces
            .iter()
            .position(|f| f.z > 0.0)
            .expect("a lower corner");
        state.contact[ROWS * lower] = 2e-3;
        term.add_forces(
            &EvaluationPoint::instant(&simulator, &state, &[]),
            &mut forces,
        );
        assert!((term.forces[lower].x + 1.0).abs() < 1e-12);
    }
}
