//! Options of the contact solver: accuracy and iterations.

use crate::cone::ConeOptions;
use crate::numbers::Domain;

/// Options of the solver for contact and constraint forces in each step.
///
/// # Cost
/// Time of a step in ms, mean over all steps: robots with all their collision shapes and unactuated joints fall until they lie on the ground, in steps of
/// 10 ms (`benches/landing.rs`). Measured at commit 6191871d on a shared machine of two cores; compare the values with each other only.
///
/// | robot | points | regularised rigid | rigid |
/// |---|---|---|---|
/// | `ANYmal` B, from 0.1 m, 400 steps | 252 | 0.067 | 0.23 |
/// | `ANYmal` B, from 0.3 m, 400 steps | 252 | 0.060 | 0.16 |
/// | Go2, from 0.1 m, 400 steps | 1216 | 0.058 | 0.28 |
///
/// Most steps with so many points end with an acceptable residual. For Go2, a quarter of the steps end between that and 1e-4, with
/// [`Status::IterationLimit`](crate::cone::Status).
///
/// # Examples
/// ```
/// use dualbody::contact::{ContactLaw, Contacts, Rigid, SolverOptions, Terrain};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let model = dualbody::Model::from_urdf_file(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/box.urdf"))?;
/// let contacts = Contacts::new(&model, Terrain::flat(0.0), ContactLaw::Rigid(Rigid::default()))
///     .with_solver_options(SolverOptions { iterations: 50, ..SolverOptions::default() });
/// assert_eq!(contacts.solver_options().points_per_link, 4);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SolverOptions {
    /// Largest residual, relative to the forces and velocities of the step, see [`Certificate`](crate::cone::Certificate); default 1e-12. A larger
    /// tolerance saves at most one iteration, because each of the last iterations gains many digits.
    pub tolerance: f64,
    /// Maximum number of matrix factorisations in a step; default 200. With fewer, a hard impact may end with the best forces so far and
    /// [`Status::IterationLimit`](crate::cone::Status); with more, single steps may take longer. For more than 48 rows of
    /// a pile three times as many are allowed, since their matrices have few blocks and cost little.
    pub iterations: usize,
    /// Residual that is accepted if the tolerance is not reached within about ten iterations, with [`Status::Acceptable`](crate::cone::Status);
    /// default 1e-6, at 10 ms some µm/s. The forces of many points that press against each other converge slowly in their last digits, when the
    /// motion has already converged. With 0, more steps use all their iterations. It has no effect on robots with kinematic constraints.
    /// In a pile of more than 48 rows the search first goes on to 5e-10.
    pub acceptable: f64,
    /// Maximum number of points of a link with which [`Rigid`](super::Rigid) contact starts a step; default 4. These are the points that would go
    /// deepest and, of the others, those farthest apart. Points that would enter the ground under the forces of these are added, again at most this
    /// many per link at once. So all points satisfy the contact model; a larger number only spreads the same load over more points, at a higher cost.
    pub points_per_link: usize,
    /// Maximum number of points per robot or object that take part in a step, averaged over a world; default 256, for which memory is reserved. If
    /// there are more, those with the largest violation of velocity or depth take part, and the status is
    /// [`Status::IterationLimit`](crate::cone::Status). Memory for the rows of one robot grows with its square:
    /// [`Contacts::check_memory`](super::Contacts::check_memory).
    pub points: usize,
    /// Whether each step of a rollout starts from the forces of the step before, see
    /// [`StepScratch::with_warm_start`](crate::sim::StepScratch::with_warm_start) for steps by themselves; default false. Each rollout starts from none, and
    /// depends on its arguments alone. Batches, single steps and derivatives always start from none.
    pub warm_start: bool,
}

impl Default for SolverOptions {
    fn default() -> Self {
        let cone = ConeOptions::default();
        Self {
            tolerance: cone.tolerance,
            iterations: cone.iterations,
            acceptable: 1e-6,
            points_per_link: 4,
            points: 256,
            warm_start: false,
        }
    }
}

impl SolverOptions {
    pub(crate) fn cone(&self) -> ConeOptions {
        ConeOptions {
            tolerance: self.tolerance,
            iterations: self.iterations,
            acceptable: self.acceptable,
            ..ConeOptions::default()
        }
    }

    /// # Panics
    /// If the tolerance is not positive, or a number is 0.
    pub(super) fn check(&self) {
        let Self {
            tolerance,
            iterations,
            acceptable,
            points_per_link,
            points,
            warm_start: _,
        } = *self;
        Domain::Positive.hold(format_args!("a tolerance of {tolerance}"), tolerance);
        let phrase = format_args!("an acceptable residual of {acceptable}");
        Domain::NotNegative.hold(phrase, acceptable);
        assert!(iterations > 0, "iterations is 0, expected at least 1");
        assert!(
            points_per_link > 0,
            "points_per_link is 0, expected at least 1"
        );
        assert!(points > 0, "points is 0, expected at least 1");
    }
}
