//! Contact of points with the ground and between bodies: soft at an instant, where forces follow from the state; else rows whose forces a solver finds.

use nalgebra::Vector3;

use super::kept::KeptForces;
use super::pairs::PairPoints;
use super::touching::Touching;
use super::working_set::{StepKinematics, WorkingSet};
use crate::cone::{Block, Mode};
use crate::contact::{
    BristleLoad, BristleRate, ContactLaw, Contacts, PairPoint, PointKinematics, PointState, ROWS,
};
use crate::dynamics::{Kinematics, forward_kinematics_into};
use crate::model::{BodyId, FrameId};
use crate::scalar::{Over, Scalar};
use crate::sim::balance::Balance;
use crate::sim::evaluation_point::EvaluationPoint;
use crate::sim::forces::Forces;
use crate::sim::island::Start;
use crate::sim::rows::Mark;
use crate::sim::simulator::Simulator;
use crate::sim::terms::term::Term;
use crate::spatial::Force;
use crate::spatial::linear::{dot, scale};

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
    rates: Vec<BristleRate<T>>,
    /// Points that have rows.
    working: WorkingSet<T>,
    /// Axes of each of them (normal, tangent, tangent) in the world.
    axes: Vec<[Vector3<T>; ROWS]>,
    /// Forces of the last solution.
    kept: KeptForces<T>,
    /// Index of its first row.
    first: Mark,
    /// The acceleration without rows, for points to be judged at.
    free: Vec<T>,
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
            working: WorkingSet::new(solved, nv, limit),
            axes: Vec::with_capacity(solved),
            kept: KeptForces::new(),
            first: Mark::default(),
            free: Vec::with_capacity(nv),
        }
    }

    /// The points that had rows in the last solution, in order.
    pub(crate) fn touching(&self) -> &[usize] {
        self.working.active()
    }

    /// The points that had rows in the last solution, with their modes in the first lane.
    pub(crate) fn modes<'a>(
        &'a self,
        balance: &'a Balance<T>,
    ) -> impl Iterator<Item = (usize, Mode)> + 'a {
        let points = self.touching();
        let modes = balance.last_modes(points.len()).iter();
        points.iter().copied().zip(modes.copied())
    }

    /// Spatial force of the contact at a point on one of its bodies, in the body frame.
    fn force_on<P: Scalar>(&self, contacts: &Contacts<P>, point: usize, side: usize) -> Force<T> {
        let force = self.forces[point];
        self.touching_in(contacts).force(point, side, &force)
    }

    /// The law of a point, and the links that touch there: of a point with the ground one, twice.
    pub(crate) fn law_and_links<P: Scalar>(
        &self,
        contacts: &Contacts<P>,
        point: usize,
    ) -> (ContactLaw<P>, [FrameId; 2]) {
        let links = match point.checked_sub(contacts.points().len()) {
            None => [contacts.points()[point].link; 2],
            Some(k) => (self.pairs.get(k).shapes).map(|k| contacts.shape_link(k)),
        };
        (self.touching_in(contacts).law(point), links)
    }

    /// Passes each force on a link, on its body and in it, to `each`.
    pub(crate) fn each_force_on<P: Scalar>(
        &self,
        contacts: &Contacts<P>,
        link: FrameId,
        mut each: impl FnMut(Force<T>),
    ) {
        let n = contacts.points().len();
        for i in 0..self.points.len() {
            let (_, links) = self.law_and_links(contacts, i);
            let sides = if i < n { 1 } else { 2 };
            for side in (0..sides).filter(|&side| links[side] == link) {
                each(self.force_on(contacts, i, side));
            }
        }
    }

    /// Passes each force on a body, in it, to `each`, with the link that it is on; `None` is what is fixed to the world.
    pub(in crate::sim) fn each_force<P: Scalar>(
        &self,
        contacts: &Contacts<P>,
        mut each: impl FnMut(FrameId, Option<BodyId>, Force<T>),
    ) {
        let n = contacts.points().len();
        let touching = self.touching_in(contacts);
        for i in 0..self.points.len() {
            let (_, links) = self.law_and_links(contacts, i);
            let sides = if i < n { 1 } else { 2 };
            for (side, body) in touching.bodies(i).into_iter().enumerate().take(sides) {
                each(links[side], body, self.force_on(contacts, i, side));
            }
        }
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

    /// The rates of all numbers of the contact state, in sequence.
    pub(crate) fn rates(&self) -> impl Iterator<Item = T> + '_ {
        let rates = self.rates.iter();
        rates.flat_map(|BristleRate { deflection: m, .. }| [m.x, m.y, m.z])
    }

    /// Changes of the contact state over a step of Δt.
    pub(crate) fn steps<D: Scalar>(&self, dt: D) -> impl Iterator<Item = T> + '_
    where
        T: Over<D>,
    {
        let rates = self.rates.iter();
        let steps = rates.map(move |rate| rate.step(dt));
        steps.flat_map(|step| [step.x, step.y, step.z])
    }

    /// Rate of each bristle; empty for laws without.
    pub(super) fn bristle_rates(&self) -> &[BristleRate<T>] {
        &self.rates
    }

    /// Forces of soft contact on points and bodies at a state.
    fn push<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        contacts: &Contacts<P>,
        bodies: &mut [Force<T>],
    ) where
        T: Over<P>,
    {
        forward_kinematics_into(at.model(), at.q(), at.v(), &mut self.kinematics);
        self.points.truncate(contacts.points().len());
        contacts.states_into(&self.kinematics, &mut self.points);
        (self.pairs).find(contacts, &self.kinematics, P::zero(), &mut self.points);
        self.forces.clear();
        self.forces.resize(self.points.len(), Vector3::zeros());
        let (bristles, _) = at.state.contact.as_slice().as_chunks::<ROWS>();
        for i in 0..self.points.len() {
            let touching = self.touching_in(contacts);
            let deflection = bristles.get(i).map_or_else(Vector3::zeros, |&m| m.into());
            let own = touching.law(i).explicit_force(&self.points[i], &deflection);
            let Some(own) = own else { continue };
            for (side, body) in touching.bodies(i).into_iter().enumerate() {
                if let Some(body) = body {
                    bodies[body.0] += touching.force(i, side, &own.force);
                }
            }
            self.forces[i] = own.force;
            if let Some(rate) = self.rates.get_mut(i) {
                *rate = own.bristle;
            }
        }
    }

    /// Updates the rates of the bristles over a step at whose end the forces are those that are known.
    fn update_bristles<P: Scalar>(&mut self, at: &EvaluationPoint<'_, P, T>, contacts: &Contacts<P>)
    where
        T: Over<P>,
    {
        let dt = at.dt();
        let (bristles, _) = at.state.contact.as_slice().as_chunks::<ROWS>();
        for (i, (law, &m)) in contacts.laws().iter().zip(bristles).enumerate() {
            let (at, f) = (&self.points[i], &self.forces[i]);
            let step = law.bristle_step(&BristleLoad {
                depth: at.depth,
                separation: dot(&at.normal, &at.velocity),
                friction: &(f - scale(&at.normal, dot(&at.normal, f))),
                deflection: &Vector3::from(m),
                dt,
            });
            self.rates[i] = BristleRate {
                deflection: scale(&step, T::from(P::one() / dt)),
                relaxation: T::zero(),
            };
        }
    }

    /// Selects the points that could touch within the step; with a working set, those that would enter the ground without forces.
    fn choose<P: Scalar>(
        &mut self,
        at: &EvaluationPoint<'_, P, T>,
        contacts: &Contacts<P>,
        balance: &Balance<T>,
    ) where
        T: Over<P>,
    {
        let of_ground = contacts.activation_margin(at.dt());
        let of_pairs = contacts.pair_margin(at.dt());
        let n = contacts.points().len();
        let margin = |i: usize| if i < n { &of_ground } else { &of_pairs };
        let points = self.points.iter().enumerate();
        let points = points.filter(|(i, _)| at.left_out != Some(*i));
        let inside = points.filter(|(i, point)| margin(*i).contains(point));
        self.working
            .start(inside.map(|(i, point)| (i, margin(i).distance_inside(point))));
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
        let mut all = std::mem::take(&mut self.axes);
        all.clear();
        let touching = self.touching_in(contacts);
        for &i in self.working.active() {
            let axes = touching.axes(i);
            let mut own = balance.rows.grow(ROWS);
            touching.each_jacobian_column(model, i, |k, column| {
                for (row, axis) in axes.iter().enumerate() {
                    own.add(row, k, dot(axis, &column));
                }
            });
            all.push(axes);
        }
        self.axes = all;
    }

    /// Lets each step start from the forces of the last one.
    pub(crate) fn keep_for_next_step(&mut self) {
        self.kept.stay = true;
    }

    /// Keeps the forces of the last solution.
    fn keep_forces<P: Scalar>(&mut self, contacts: &Contacts<P>, balance: &Balance<T>) {
        let touching = Touching {
            contacts,
            pairs: &self.pairs,
            points: &self.points,
            kinematics: &self.kinematics,
        };
        let (forces, _) = (balance.rows.last_forces(ROWS * self.axes.len())).as_chunks::<ROWS>();
        let points = self.working.active().iter().zip(forces);
        (self.kept).keep(points.map(|(&i, &f)| (touching.key(i), f)));
    }

    /// Lets points take part that had a force in the last solution.
    fn add_kept<P: Scalar>(&mut self, contacts: &Contacts<P>) {
        let touching = Touching {
            contacts,
            pairs: &self.pairs,
            points: &self.points,
            kinematics: &self.kinematics,
        };
        self.working.add(|i| {
            let force = self.kept.find(touching.key(i));
            force.is_some_and(|f| !f[0].is_zero())
        });
    }

    /// Lets the next solution start from the forces that are kept: within an instant from those along normals alone, since redundant ones across them would stay.
    fn start_from_kept<P: Scalar>(&self, contacts: &Contacts<P>, balance: &mut Balance<T>) {
        let stay = self.kept.stay;
        let touching = self.touching_in(contacts);
        let points = self.working.active().iter();
        let kept = points.map(|&i| self.kept.find(touching.key(i)));
        let (start, first) = (Start::of(stay), self.first);
        let forces = kept.map(|f| {
            f.map(|[along, x, y]| match stay {
                true => [along, x, y],
                false => [along, T::zero(), T::zero()],
            })
        });
        balance.rows.start_from(start, first, forces);
    }
}

impl<P: Scalar, T: Over<P>> Term<P, T> for Contact<T> {
    #[inline]
    fn add_forces(&mut self, at: &EvaluationPoint<'_, P, T>, forces: &mut Forces<T>) {
        self.working.clear();
        self.axes.clear();
        if let Some(contacts) = at.explicit_contacts() {
            self.push(at, contacts, &mut forces.bodies);
        }
    }

    fn add_rows(&mut self, at: &EvaluationPoint<'_, P, T>, balance: &mut Balance<T>) {
        let Some(contacts) = at.solved_contacts() else {
            return;
        };
        let (poses, velocities) = balance.motions();
        self.kinematics.place(at.model(), poses, velocities);
        self.find_points(contacts, at.dt(), at.contact_duration().into());
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
        let rows = &mut balance.rows;
        let first = rows.n_references();
        let touching = self.touching_in(contacts);
        let (bristles, _) = at.state.contact.as_slice().as_chunks::<ROWS>();
        for (of, (&i, axes)) in self.working.active().iter().zip(&self.axes).enumerate() {
            let kinematics = PointKinematics {
                state: &self.points[i],
                axes,
                deflection: bristles.get(i).map(|&m| Vector3::from(m)),
                delassus: rows.delassus(first + ROWS * of),
                dt: at.dt(),
                kappa: contacts.kappa_over_step(at.dt()),
                speculative: touching.is_speculative(i),
            };
            let mut own = contacts.rows(&touching.law(i), &kinematics);
            if T::LANES > 1 || !T::HAS_VALUES {
                own = own.within(self.working.takes_part(of));
            }
            for row in own.rows {
                rows.push_reference(row.reference, row.compliance);
            }
            rows.push_block(Block::Cone, own.friction);
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
        self.forces.clear();
        self.forces.resize(self.points.len(), Vector3::zeros());
        let own = balance.rows.last_forces(ROWS * self.axes.len());
        let (forces, _) = own.as_chunks::<ROWS>();
        for ((&i, axes), f) in self.working.active().iter().zip(&self.axes).zip(forces) {
            let [n, t_1, t_2] = axes;
            self.forces[i] = scale(n, f[0]) + scale(t_1, f[1]) + scale(t_2, f[2]);
        }
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
