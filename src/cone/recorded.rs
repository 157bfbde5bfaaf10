//! The solver for numbers that are recorded: a fixed number of steps along the path, without a decision.
//!
//! A graph has no loops and no branches, so the active set cannot be looked for. The interior-point method of `interior.rs` needs
//! none: each of its steps is the same arithmetic, and the number of them that leads to the end is nearly the same for every problem. It is
//! recorded [`STEPS`] times, to the κ of [`RELATIVE`], at which the smoothed law is nearly the exact one, and once more over the numbers as
//! they are, which gives the derivatives by the implicit function theorem: the steps before it use values only.
//!
//! How far the last step ends from there is a [condition](crate::scalar::traced::Graph::conditions) of the graph.
//!
//! Rows that may give way without a force, as those of points above the ground do, stay: without a coupling to others, and as if they were
//! left fast, so that their force vanishes along the path like that of any contact that opens.
//!
//! A bound that is next to nothing, or infinite, is replaced by one that the path can follow, and forces are brought back within the one that is given.

use super::interior::Interior;
use super::interval::clamped;
use super::newton::largest;
use super::problem::{Block, ConeProblem, Law};
use super::system::{Kind, System, Unit};
use crate::linalg::Symmetric;
use crate::scalar::Scalar;

/// Steps along the path. Problems along motions of a quadruped and of a box are near their end after at most 20; of random ones of four to eight contacts,
/// regularised as relaxed contact is, among them heavy bodies on light ones and more contacts than determine the forces on a body, 99 of 100 after at most 23.
const STEPS: usize = 24;
/// Steps where there are only bilateral rows: one solves them, and each further step removes an error by the ridge of redundant rows.
const BILATERAL_STEPS: usize = 2;
/// κ beside the size of the problem squared at the end of the path: smaller ones leave the matrices no digits. Forces differ from the exact law's by about as
/// much of them where a contact clearly sticks, slides or opens, by more the slower it slides, and by the root of it between two pieces.
const RELATIVE: f64 = 1e-11;
/// The largest distance from the end of the path, relative to the size of the problem, at which forces are taken for found.
const FOUND: f64 = 1e-9;
/// The size of a problem in which no row takes part, √J; smaller ones count as that.
const LEAST_SIZE: f64 = 1e-9;

/// Working memory for problems that are recorded.
#[derive(Clone, Debug)]
pub(super) struct Recorded<T> {
    /// The problem with all that its numbers hold.
    full: System<T>,
    /// The problem of their values.
    values: System<T>,
    interior: Interior<T>,
    factors: Symmetric<T>,
    /// 1 for rows that take part, else 0.
    takes_part: Vec<T>,
}

impl<T: Scalar> Default for Recorded<T> {
    fn default() -> Self {
        Self {
            full: System::default(),
            values: System::default(),
            interior: Interior::default(),
            factors: Symmetric::default(),
            takes_part: Vec::new(),
        }
    }
}

impl<T: Scalar> Recorded<T> {
    /// Finds the forces of a problem.
    ///
    /// * `smoothing` – κ of the smoothed law, J; 0 for the exact one
    ///
    /// # Panics
    /// If it has cones after Coulomb's law, whose matrices are not symmetric, or smooths some laws and not others.
    #[track_caller]
    pub(super) fn solve(&mut self, problem: &ConeProblem<'_, T>, smoothing: f64, f: &mut [T]) {
        check(problem, smoothing);
        let size = self.load(problem);
        let kappa = (size * size * RELATIVE).max(T::constant(smoothing));
        let bilateral = self.full.units.iter().all(|unit| unit.kind == Kind::Row);
        let steps = if bilateral { BILATERAL_STEPS } else { STEPS };
        let Self {
            full,
            values,
            interior,
            factors,
            takes_part,
        } = self;
        interior.start(values, problem.law, size);
        interior.g.clone_from(&values.g);
        interior.walk(values, factors, kappa, steps);
        interior.g.clone_from(&full.g);
        let residual = interior.arrive(full, factors, kappa);
        // A force that is not a number is not found.
        let found = T::constant(FOUND);
        let residual = residual.select_lt(found, residual, T::constant(f64::INFINITY));
        residual.is_at_most(FOUND, "the forces of contact and constraints are found");
        for unit in full.units.iter().filter(|u| u.kind == Kind::Interval) {
            let own = &mut interior.f[unit.row];
            *own = clamped(*own, unit.mu);
        }
        for (i, f) in f.iter_mut().enumerate() {
            *f = interior.f[i] * full.scale[i] * takes_part[i];
        }
    }

    /// Reads and scales a problem. Returns its size: the largest free velocity.
    fn load(&mut self, problem: &ConeProblem<'_, T>) -> T {
        let system = &mut self.full;
        system.n = problem.free_velocity.len();
        system.law = problem.law;
        system.list_units(problem.blocks, |_| false, |block| problem.friction[block]);
        find_those_that_take_part(system, problem.regularization, &mut self.takes_part);
        fill(system, problem, &self.takes_part);
        system.scale.resize(system.n, T::one());
        system.find_scale();
        system.scale_bounds();
        system.rescale(|_| {});
        let size = largest(&system.g).detached().max(T::constant(LEAST_SIZE));
        let opens = |unit: &&Unit<T>| matches!(unit.kind, Kind::Ray | Kind::Cone);
        for unit in system.units.iter().filter(opens) {
            let left_out = -self.takes_part[unit.row] + 1.0;
            system.g[unit.row] += left_out * size;
        }
        self.values.clone_from(system);
        let values = &mut self.values;
        let numbers = values.w.iter_mut().chain(&mut values.g);
        let friction = values.units.iter_mut().map(|unit| &mut unit.mu);
        numbers.chain(friction).for_each(|x| *x = x.detached());
        size
    }
}

/// # Panics
/// If a problem cannot be solved by a fixed number of steps.
#[track_caller]
fn check<T: Scalar>(problem: &ConeProblem<'_, T>, smoothing: f64) {
    let has = |kind| problem.blocks.contains(&kind);
    assert!(
        problem.law == Law::Convex || !has(Block::Cone),
        "{}: the forces of Coulomb's law, of rigid contact and of soft contact in implicit steps, are found by a search that depends on the values \
         of numbers, which traced numbers do not have; use regularised contact (RelaxedRigid)",
        file!()
    );
    assert!(
        !problem.blocks.iter().any(|block| block.is_moment()),
        "{}: torsional and rolling friction is found by a search that decides on the values of numbers, which traced ones do not have",
        file!()
    );
    assert!(
        smoothing == 0.0 || !(has(Block::Ray) || has(Block::Interval)),
        "{}: smoothed contact beside joint limits or bounded forces cannot be traced",
        file!()
    );
}

/// 1 for the rows of units of which none has an infinite R, 0 for others.
fn find_those_that_take_part<T: Scalar>(system: &System<T>, r: &[T], out: &mut Vec<T>) {
    let (far, one) = (T::constant(f64::INFINITY), T::one());
    out.clear();
    for unit in &system.units {
        let rows = unit.row..unit.row + unit.rows();
        let finite = |r: T| r.detached().select_lt(far, one, T::zero());
        let all = r[rows.clone()].iter().fold(one, |all, &r| all * finite(r));
        out.extend(rows.map(|_| all));
    }
}

/// W = G + R and g of the rows that take part; the others have 1 on the diagonal, and nothing beside it.
fn fill<T: Scalar>(system: &mut System<T>, problem: &ConeProblem<'_, T>, takes_part: &[T]) {
    let n = system.n;
    system.w.clear();
    system.w.extend_from_slice(problem.matrix);
    system.g.clear();
    system.g.extend_from_slice(problem.free_velocity);
    let only = |taken: T, x: T| T::zero().select_lt(taken, x, T::zero());
    for (j, &taken) in takes_part.iter().enumerate() {
        system.g[j] = only(taken, system.g[j]);
        for (i, &other) in takes_part.iter().enumerate() {
            let w = &mut system.w[n * j + i];
            *w = only(taken * other, *w);
        }
        system.w[n * j + j] += taken.select_lt(T::one(), T::one(), problem.regularization[j]);
    }
}
