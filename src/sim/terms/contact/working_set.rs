//! Working set of the points in the problem of rigid contact.
//!
//! Most points that could touch within a step do not, and few points of a flat patch carry a load as well as all of them. A point without a force
//! satisfies its contact model if the forces of the others leave it fast enough, yₙ ≥ 0; so the solution for some points is a solution for all as
//! soon as this holds for the others. The set starts with the points that would enter the ground without forces, a limited number per link, and grows
//! by those that the last solution leaves too slow, until there are none: a working set [Nocedal, Wright 2006, section 16.5].
//!
//! Accelerations that all solutions share do not depend on the choice. Where solutions differ, for example in the rotation of a sliding patch by
//! friction, the choice is one of many.

use nalgebra::Vector3;

use super::touching::Touching;
use crate::contact::PointState;
use crate::model::Model;
use crate::scalar::{Over, Scalar};
use crate::spatial::linear::dot;

/// Tolerance on the velocity by which a point falls short of the least one that its law allows, relative to the velocities that the difference is made of:
/// well above their rounding, and far below what can be seen.
const TOLERANCE: f64 = 1e-9;
/// Rounds in which the set grows by a few points of each link; after these it takes all that are too slow.
const ROUNDS: usize = 8;

/// Points that take part in the problem of a step, and those that may have to.
#[derive(Clone, Debug)]
pub(super) struct WorkingSet<T> {
    /// Those that could touch within the step.
    candidates: Vec<usize>,
    /// Positive in the lanes in which each of them could.
    margins: Vec<T>,
    /// Shortfall of the velocity of each candidate after the step, minus a tolerance, m/s; negative for none.
    shortfalls: Vec<T>,
    /// The active points.
    members: Members<T>,
    /// a with the correction ω × (v + ω × c) of axes that carry linear velocities.
    corrected: Vec<T>,
    /// Candidates that become active, by index among the candidates.
    chosen: Vec<usize>,
    /// Most members in all.
    limit: usize,
    rounds: usize,
    /// Whether some were left out because there were too many.
    full: bool,
}

/// Points that take part.
#[derive(Clone, Debug)]
struct Members<T> {
    /// In order, each once.
    points: Vec<usize>,
    /// For each, positive in the lanes in which it is a member; in the others it is there for the sake of those.
    lanes: Vec<T>,
}

/// Motion of the points in a step, which decides which candidates become active.
pub(super) struct StepKinematics<'a, P, T> {
    pub(super) model: &'a Model<P>,
    pub(super) touching: Touching<'a, P, T>,
    /// Velocity along the coordinates before the step.
    pub(super) v: &'a [T],
    pub(super) dt: P,
}

impl<T: Scalar> WorkingSet<T> {
    /// Memory for so many points and coordinates.
    ///
    /// * `limit` – maximum number of active points
    pub(super) fn new(points: usize, nv: usize, limit: usize) -> Self {
        Self {
            limit,
            candidates: Vec::with_capacity(points),
            margins: Vec::with_capacity(points),
            shortfalls: Vec::with_capacity(points),
            members: Members {
                points: Vec::with_capacity(points),
                lanes: Vec::with_capacity(points),
            },
            corrected: vec![T::zero(); nv],
            chosen: Vec::with_capacity(points),
            rounds: 0,
            full: false,
        }
    }

    pub(super) fn clear(&mut self) {
        self.candidates.clear();
        self.margins.clear();
        self.restart();
    }

    /// Keeps the candidates, of which none takes part now.
    pub(super) fn restart(&mut self) {
        self.members.points.clear();
        self.members.lanes.clear();
        (self.rounds, self.full) = (0, false);
    }

    /// 1 in lanes without candidates, 0 in others.
    pub(super) fn are_apart(&self) -> T {
        let is_near = |lane| self.margins.iter().any(|margin| margin.value(lane) > 0.0);
        T::from_values(|lane| if is_near(lane) { 0.0 } else { 1.0 })
    }

    /// Whether points were dropped because there were too many.
    pub(super) fn is_full(&self) -> bool {
        self.full
    }

    /// The points that take part, in order.
    pub(super) fn active(&self) -> &[usize] {
        &self.members.points
    }

    /// Positive in the lanes in which an active point, the `of`-th, takes part.
    pub(super) fn takes_part(&self, of: usize) -> T {
        self.members.lanes[of]
    }

    /// Activates points, in order.
    pub(super) fn activate(&mut self, points: &[usize]) {
        self.members.points.extend_from_slice(points);
        self.members.lanes.extend(points.iter().map(|_| T::one()));
    }

    /// Starts with candidates, each with a number that is positive in the lanes in which it is one; none takes part yet.
    pub(super) fn start(&mut self, candidates: impl Iterator<Item = (usize, T)>) {
        self.clear();
        for (point, margin) in candidates {
            self.candidates.push(point);
            self.margins.push(margin);
        }
    }

    /// Activates all candidates, or the deepest ones of too many.
    pub(super) fn take_all(&mut self, points: &[PointState<T>]) {
        let limit = self.limit;
        if self.candidates.len() <= limit {
            self.members.points.extend_from_slice(&self.candidates);
            self.members.lanes.extend_from_slice(&self.margins);
            return;
        }
        for lane in 0..T::LANES {
            let may = |at: &usize| self.margins[*at].value(lane) > 0.0;
            let depth = |&at: &usize| points[self.candidates[at]].depth.value(lane);
            self.chosen.clear();
            self.chosen.extend((0..self.candidates.len()).filter(may));
            let deeper = |a: &usize, b: &usize| depth(b).total_cmp(&depth(a)).then(a.cmp(b));
            self.chosen.sort_unstable_by(deeper);
            let left_out = self.chosen.drain(limit.min(self.chosen.len())..);
            self.full |= { left_out }.any(|at| depth(&at) > 0.0);
            self.insert_chosen(lane);
        }
    }

    /// Adds candidates that an acceleration leaves slower than the law allows; whether there are any.
    pub(super) fn grow<P: Scalar>(&mut self, step: &StepKinematics<'_, P, T>, a: &[T]) -> bool
    where
        T: Over<P>,
    {
        if self.candidates.is_empty() {
            return false;
        }
        self.find_shortfalls(step, a);
        self.rounds += 1;
        let mut limit = step.touching.contacts.solver_options().points_per_link;
        if self.rounds > ROUNDS {
            limit = usize::MAX;
        }
        let mut grown = false;
        for lane in 0..T::LANES {
            let mut first = 0;
            let mut room = self.limit.saturating_sub(self.members.count(lane));
            while first < self.candidates.len() {
                let group = step.touching.group(self.candidates[first]);
                let rest = self.candidates[first..].iter();
                let same = rest.take_while(|&&i| step.touching.group(i) == group);
                let end = first + same.count();
                self.choose(step, first..end, limit.min(room), lane);
                grown |= !self.chosen.is_empty();
                room -= self.chosen.len();
                self.insert_chosen(lane);
                first = end;
            }
        }
        grown
    }

    /// Computes the velocity shortfalls of candidates:  least − (vₙ + Δt nᵀ J ã).
    fn find_shortfalls<P: Scalar>(&mut self, step: &StepKinematics<'_, P, T>, a: &[T])
    where
        T: Over<P>,
    {
        self.corrected.copy_from_slice(a);
        for body in step.model.independent() {
            body.turning(step.v, |k, x| self.corrected[k] += x);
        }
        self.shortfalls.clear();
        for &i in &self.candidates {
            self.shortfalls.extend(shortfall(step, i, &self.corrected));
        }
    }

    /// Adds candidates, up to the limit.
    pub(super) fn add(&mut self, is_wanted: impl Fn(usize) -> bool) {
        for lane in 0..T::LANES {
            let room = self.limit.saturating_sub(self.members.count(lane));
            let may = |&at: &usize| {
                let point = self.candidates[at];
                self.margins[at].value(lane) > 0.0
                    && !self.members.contains(point, lane)
                    && is_wanted(point)
            };
            self.chosen.clear();
            let wanted = (0..self.candidates.len()).filter(may).take(room);
            self.chosen.extend(wanted);
            self.insert_chosen(lane);
        }
    }

    /// Chooses, of the candidates of one link in a range, the one with the largest shortfall in a lane, and others far from it and from each other, up to
    /// a limit.
    fn choose<P: Scalar>(
        &mut self,
        step: &StepKinematics<'_, P, T>,
        range: std::ops::Range<usize>,
        limit: usize,
        lane: usize,
    ) {
        let (chosen, candidates, members) = (&mut self.chosen, &self.candidates, &self.members);
        chosen.clear();
        let shortfall = |at: &usize| self.shortfalls[*at].value(lane);
        let may = |at: &usize| self.margins[*at].value(lane) > 0.0;
        let free =
            |at: &usize| may(at) && shortfall(at) > 0.0 && !members.contains(candidates[*at], lane);
        let position = |at: usize| {
            let point = &step.touching.points[candidates[at]];
            point.in_body.map(|x| x.value(lane))
        };
        let mut next = first_largest(range.clone().filter(free), |at| shortfall(&at));
        while let Some(at) = next.filter(|_| chosen.len() < limit) {
            chosen.push(at);
            let apart = |at: usize| {
                let others = chosen.iter();
                let distances = others.map(|&other| square(position(at) - position(other)));
                distances.fold(f64::INFINITY, f64::min)
            };
            let others = range.clone().filter(free).filter(|at| !chosen.contains(at));
            next = first_largest(others, apart);
        }
        self.full |= limit == 0 && next.is_some();
    }

    fn insert_chosen(&mut self, lane: usize) {
        for &candidate in &self.chosen {
            self.members.insert(self.candidates[candidate], lane);
        }
    }
}

impl<T: Scalar> Members<T> {
    /// Number of members in a lane.
    fn count(&self, lane: usize) -> usize {
        let own = self.lanes.iter().filter(|own| own.value(lane) > 0.0);
        own.count()
    }

    fn contains(&self, point: usize, lane: usize) -> bool {
        let found = self.points.binary_search(&point);
        found.is_ok_and(|at| self.lanes[at].value(lane) > 0.0)
    }

    fn insert(&mut self, point: usize, lane: usize) {
        let at = match self.points.binary_search(&point) {
            Ok(at) => at,
            Err(at) => {
                self.points.insert(at, point);
                self.lanes.insert(at, T::zero());
                at
            }
        };
        let others = self.lanes[at];
        self.lanes[at] = T::from_values(|l| if l == lane { 1.0 } else { others.value(l) });
    }
}

/// Shortfall of the normal velocity of a point after a step against the bound of its contact model, minus a tolerance; `None` for models without such a bound.
fn shortfall<P: Scalar, T: Over<P>>(
    step: &StepKinematics<'_, P, T>,
    i: usize,
    a: &[T],
) -> Option<T> {
    let point = &step.touching.points[i];
    let mut gained = T::zero();
    (step.touching).each_jacobian_column(step.model, i, |k, column| {
        gained = dot(&point.normal, &column).mul_add(a[k], gained);
    });
    let before = dot(&point.normal, &point.velocity);
    let law = step.touching.law(i);
    let least = law.least_velocity(point.depth, before, step.dt)?;
    let dt = T::from(step.dt);
    Some(T::from_values(|lane| {
        let dt = dt.value(lane);
        let gained = dt * gained.value(lane);
        let (before, least) = (before.value(lane), least.value(lane));
        let nothing = TOLERANCE * (dt + gained.abs() + before.abs() + least.abs());
        least - before - gained - nothing
    }))
}

fn square(x: Vector3<f64>) -> f64 {
    x.dot(&x)
}

/// The first of those with the largest key.
fn first_largest(of: impl Iterator<Item = usize>, key: impl Fn(usize) -> f64) -> Option<usize> {
    let keyed = of.map(|at| (at, key(at)));
    let larger = |best: (usize, f64), other: (usize, f64)| {
        if other.1 > best.1 { other } else { best }
    };
    keyed.reduce(larger).map(|(at, _)| at)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::{ContactLaw, Contacts, RelaxedRigid, Rigid, SolverOptions, Terrain};
    use crate::dynamics::{Kinematics, forward_kinematics};
    use crate::sim::terms::contact::pairs::PairPoints;

    /// A box of 0.36 m × 0.24 m × 0.12 m whose lower four corners are on the ground, and points of it that take part with a limit for each
    /// link.
    struct Standing {
        model: Model,
        contacts: Contacts,
        kinematics: Kinematics<f64>,
        points: Vec<PointState<f64>>,
        pairs: PairPoints<f64>,
    }

    impl Standing {
        fn new(points_per_link: usize) -> Self {
            let path = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/box.urdf");
            let model = Model::from_urdf_file(path).expect("an asset");
            let options = SolverOptions {
                points_per_link,
                ..SolverOptions::default()
            };
            let law = ContactLaw::Rigid(Rigid::default());
            let contacts =
                Contacts::new(&model, Terrain::flat(0.0), law).with_solver_options(options);
            let q = [0.0, 0.0, 0.06, 1.0, 0.0, 0.0, 0.0];
            let kinematics = forward_kinematics(&model, &q, &[0.0; 6]);
            let mut points = vec![PointState::zero(); contacts.points().len()];
            contacts.states_into(&kinematics, &mut points);
            Self {
                pairs: PairPoints::new(),
                model,
                contacts,
                kinematics,
                points,
            }
        }

        fn step(&self) -> StepKinematics<'_, f64, f64> {
            StepKinematics {
                model: &self.model,
                touching: Touching {
                    contacts: &self.contacts,
                    pairs: &self.pairs,
                    points: &self.points,
                    kinematics: &self.kinematics,
                },
                v: &[0.0; 6],
                dt: 0.01,
            }
        }

        /// A set with all corners for candidates.
        fn set(&self) -> WorkingSet<f64> {
            let mut set = WorkingSet::new(self.points.len(), 6, 256);
            set.start((0..self.points.len()).map(|i| (i, 1.0)));
            set
        }

        fn lower(&self) -> Vec<usize> {
            let points = self.points.iter().enumerate();
            points
                .filter(|(_, p)| p.in_body.z < 0.0)
                .map(|(i, _)| i)
                .collect()
        }
    }

    const FALL: [f64; 6] = [0.0, 0.0, -9.81, 0.0, 0.0, 0.0];

    // vₙ + Δt aₙ = −0.0981 m/s where the law allows 0; an upper corner may fall by 0.12 m.
    #[test]
    fn shortfall_is_the_velocity_that_the_law_does_not_allow() {
        let standing = Standing::new(4);
        for (i, point) in standing.points.iter().enumerate() {
            let found = shortfall(&standing.step(), i, &FALL).expect("a rigid law");
            let expected = if point.in_body.z < 0.0 {
                0.0981
            } else {
                -12.0 + 0.0981
            };
            assert!((found - expected).abs() < 1e-7, "{i}: {found}");
        }
    }

    #[test]
    fn corners_that_would_go_into_the_ground_take_part_and_no_others() {
        let standing = Standing::new(8);
        let mut set = standing.set();
        assert!(set.grow(&standing.step(), &FALL));
        assert_eq!(set.active(), standing.lower());
        // With forces under which nothing moves the set is complete.
        assert!(!set.grow(&standing.step(), &[0.0; 6]) && !set.is_full());
    }

    // Of four corners that fall as fast, two that are farthest apart: those of a diagonal.
    #[test]
    fn few_points_of_a_link_are_far_from_each_other() {
        let standing = Standing::new(2);
        let mut set = standing.set();
        assert!(set.grow(&standing.step(), &FALL));
        let &[a, b] = set.active() else {
            panic!("{:?}", set.active())
        };
        let apart = standing.points[a].in_body - standing.points[b].in_body;
        assert!((apart.norm() - 0.36_f64.hypot(0.24)).abs() < 1e-12);
        // The next round adds the other two.
        assert!(set.grow(&standing.step(), &FALL));
        assert_eq!(set.active(), standing.lower());
    }

    #[test]
    fn deepest_points_come_first_where_there_are_too_many() {
        let depths = [0.01, 0.03, -0.01, 0.02];
        let points = depths.map(|depth| PointState {
            depth,
            ..PointState::zero()
        });
        let mut set = WorkingSet::new(4, 6, 2);
        set.start((0..4).map(|i| (i, 1.0)));
        set.take_all(&points);
        assert_eq!(set.active(), [1, 3]);
        assert!(set.is_full());
        let mut set = WorkingSet::new(4, 6, 4);
        set.start((0..4).map(|i| (i, 1.0)));
        set.take_all(&points);
        assert_eq!(set.active(), [0, 1, 2, 3]);
        assert!(!set.is_full());
    }

    // Lanes: a point is there for the sake of the lanes in which it takes part.
    #[test]
    fn members_are_those_of_their_lanes() {
        use crate::scalar::Lanes;
        let mut members = Members::<Lanes<2>> {
            points: Vec::new(),
            lanes: Vec::new(),
        };
        members.insert(7, 1);
        members.insert(3, 0);
        members.insert(7, 0);
        assert_eq!(members.points, [3, 7]);
        assert_eq!([0, 1].map(|lane| members.count(lane)), [2, 1]);
        assert!(members.contains(3, 0) && !members.contains(3, 1));
    }

    #[test]
    fn laws_with_compliance_have_no_least_velocity() {
        let mut standing = Standing::new(4);
        let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
        standing.contacts = Contacts::new(&standing.model, Terrain::flat(0.0), law);
        assert!(shortfall(&standing.step(), 0, &FALL).is_none());
        assert!(!standing.contacts.use_working_set());
    }
}
