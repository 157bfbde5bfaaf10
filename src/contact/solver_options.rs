//! How exactly, and for how long, forces of rigid contact are looked for.

use super::Contacts;
use super::cone::ConeOptions;
use crate::scalar::Scalar;

/// How the forces of points of contact and of constraints are found in each step.
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
    /// Largest residual, beside the forces and velocities of the step, see [`Certificate`](super::cone::Certificate); default 1e-12. A larger
    /// one saves at most an iteration, as the last ones gain many digits each.
    pub tolerance: f64,
    /// Most matrices that are factorised in looking for the forces of a step; default 200. With fewer a hard impact may end with the best
    /// forces so far, and [`Status::IterationLimit`](super::cone::Status); more lets single steps take longer.
    pub iterations: usize,
    /// Most points of a link that [`Rigid`](super::Rigid) contact starts a step with; default 4. They are those that would go deepest and, of
    /// the others, those farthest apart; points that would go into the ground with the forces of these are added, again at most so many
    /// of each link at once. So all obey the law, and more only spread the same load over more points, at a higher cost.
    pub points_per_link: usize,
}

impl Default for SolverOptions {
    fn default() -> Self {
        let cone = ConeOptions::default();
        Self {
            tolerance: cone.tolerance,
            iterations: cone.iterations,
            points_per_link: 4,
        }
    }
}

impl SolverOptions {
    pub(crate) fn cone(&self) -> ConeOptions {
        ConeOptions {
            tolerance: self.tolerance,
            iterations: self.iterations,
            ..ConeOptions::default()
        }
    }

    /// # Panics
    /// If the tolerance is not positive, or a number is 0.
    fn check(&self) {
        let Self {
            tolerance,
            iterations,
            points_per_link,
        } = *self;
        assert!(
            tolerance > 0.0 && tolerance.is_finite(),
            "a tolerance of {tolerance} is not positive and finite"
        );
        assert!(iterations > 0, "forces cannot be found in 0 iterations");
        assert!(points_per_link > 0, "0 points of a link carry nothing");
    }
}

impl<P: Scalar> Contacts<P> {
    /// The same contacts, whose forces are looked for otherwise.
    ///
    /// # Panics
    /// If the tolerance is not positive and finite, or the iterations or points are none.
    #[must_use]
    pub fn with_solver_options(mut self, options: SolverOptions) -> Self {
        options.check();
        self.solver = options;
        self
    }

    /// How their forces are looked for.
    pub fn solver_options(&self) -> SolverOptions {
        self.solver
    }
}
