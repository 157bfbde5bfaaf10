//! Options of the contact solver: how exactly, and for how long, forces of rigid contact are looked for.

use crate::cone::ConeOptions;
use crate::numbers::Domain;

/// Options of the solver of the forces of contact points and constraints in each step.
///
/// # Cost
/// Robots with all their collision shapes that are dropped with limp joints and come to lie, in steps of 10 ms, as `benches/landing.rs` does
/// from 0.1 m (mean over all steps, ms):
///
/// | robot | points | relaxed rigid | rigid |
/// |---|---|---|---|
/// | `ANYmal` B, from 0.1 m, 400 steps | 252 | 0.067 | 0.23 |
/// | `ANYmal` B, from 0.3 m, 400 steps | 252 | 0.060 | 0.16 |
/// | Go2, from 0.1 m, 400 steps | 1216 | 0.058 | 0.28 |
///
/// Most steps of such heaps of points end with an acceptable residual; of those of Go2, a quarter end with one between that and 1e-4, as
/// [`Status::IterationLimit`](crate::cone::Status) says.
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
    /// Largest residual, beside the forces and velocities of the step, see [`Certificate`](crate::cone::Certificate); default 1e-12. A larger
    /// one saves at most an iteration, as the last ones gain many digits each.
    pub tolerance: f64,
    /// Most matrices that are factorised in looking for the forces of a step; default 200. With fewer a hard impact may end with the best
    /// forces so far, and [`Status::IterationLimit`](crate::cone::Status); more lets single steps take longer. For more than 48 rows of a pile three times as many,
    /// since their matrices have few blocks and cost little.
    pub iterations: usize,
    /// Residual that is taken where the tolerance is not reached within some ten iterations, with
    /// [`Status::Acceptable`](crate::cone::Status); default 1e-6, at 10 ms some µm/s. Forces of many points that press against each other
    /// drift towards their last digits while the motion has long been found. In a pile of more than 48 rows the search first goes on to 5e-10. 0 takes none: more steps then take as many iterations as they
    /// may. Robots with kinematic constraints are not concerned.
    pub acceptable: f64,
    /// Most points of a link that [`Rigid`](super::Rigid) contact starts a step with; default 4. They are those that would go deepest and, of
    /// the others, those farthest apart; points that would go into the ground with the forces of these are added, again at most so many
    /// of each link at once. So all obey the law, and more only spread the same load over more points, at a higher cost.
    pub points_per_link: usize,
    /// Most points of a robot or an object that take part in a step, in the mean over those of a world; default 256, for which memory is set aside. Of more,
    /// those come first that lack most of their velocity or are deepest, and the status is [`Status::IterationLimit`](crate::cone::Status). The rows of one
    /// robot need the square of it: [`Contacts::check_memory`](super::Contacts::check_memory).
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
        assert!(iterations > 0, "forces cannot be found in 0 iterations");
        assert!(points_per_link > 0, "0 points of a link carry nothing");
        assert!(points > 0, "0 points of a robot carry nothing");
    }
}
