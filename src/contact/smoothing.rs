//! Smoothed rigid contact: forces, and so derivatives, before touch-down.

use crate::numbers::Domain;

/// Smoothing of rigid and regularised rigid contact, for gradients where exact contact has none: above the ground, while a point sticks, and in the slip speed.
///
/// The law `fₙ ŷₙ = 0` becomes `fₙ ŷₙ = κ` (the central path, see [`cone`](crate::cone)), with the force fₙ and the excess ŷₙ of the velocity after
/// the step over its reference. A point at rest at a height h feels about
///
/// * κ Δt / h with [`Rigid`](super::Rigid), as ŷₙ is h / Δt;
/// * κ / (Δt k d h) with [`RelaxedRigid`](super::RelaxedRigid), whose reference acceleration there is k d h. Above the ground its regularisation is
///   larger by R = Δt (k d h)² / κ, so that the force decreases with κ at any approach speed.
///
/// So a body of weight m g on n points hovers at h = n κ Δt / (m g) with [`Rigid`](super::Rigid): use κ = h m g / (n Δt) with an acceptable height
/// error h, and reduce κ as an optimisation converges.
///
/// For κ → 0, forces converge to the exact forces; derivatives converge to the exact derivatives, except at transitions between modes.
///
/// # Limitations
/// An impact still belongs to one step: [`Rigid`](super::Rigid) contact, exact or smoothed, jumps where the number of steps before the impact
/// changes. The force drops to zero at the reach, from the value above. A body squeezed between two contacts has smoothed forces with
/// [`RelaxedRigid`](super::RelaxedRigid) only. A step costs more than with exact contact, because every point within reach takes part and the solver
/// follows the central path. Joint limits are not smoothed.
///
/// # Switches of vertices
/// Where the nearest corner switches, as under a box that rocks, forces and derivatives are continuous: with the ground each corner has its own force, and
/// between bodies each point of flat parts that are within 0.05 rad of parallel. Farther tilted, only the nearest point between bodies has one; there, and where the normal
/// switches to that of another face or edge, forces jump. Distances for planning have a width of their own: [`LinkShapes::with_smoothing`](super::LinkShapes::with_smoothing).
///
/// # References
/// [Howell et al. 2022]; the barrier is that of interior-point methods.
///
/// # Examples
/// ```
/// use dualbody::{Simulator, contact::{ContactLaw, Contacts, Rigid, Smoothing, Terrain}};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let model = dualbody::Model::from_urdf_file(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/sphere.urdf"))?;
/// let contacts = Contacts::new(&model, Terrain::flat(0.0), ContactLaw::Rigid(Rigid::default()));
/// let slope_of_the_speed_after_a_step_in_height = |contacts| {
///     let simulator = Simulator::new(model.clone()).with_contacts(contacts);
///     let mut state = simulator.neutral_state();
///     state.q[2] = 0.11; // 1 cm above the ground
///     simulator.linearize(&state, &[]).a[(8, 2)]
/// };
/// assert_eq!(slope_of_the_speed_after_a_step_in_height(contacts.clone()), 0.0);
/// let smoothed = contacts.with_smoothing(Smoothing::new(1.0));
/// assert!(slope_of_the_speed_after_a_step_in_height(smoothed) < -1e-3);
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Smoothing {
    kappa: f64,
    reach: f64,
}

/// Default height up to which a smoothed ground acts on points, m.
const DEFAULT_REACH: f64 = 0.1;

impl Smoothing {
    /// Smoothing with κ, W (N·m/s: force times velocity), up to a reach of 0.1 m. With a larger κ, forces begin earlier before contact, carry the
    /// weight higher above the ground, and friction sets in more smoothly; 0 is exact contact.
    ///
    /// # Panics
    /// If it is negative or not finite.
    pub fn new(kappa: f64) -> Self {
        Domain::NotNegative.hold(format_args!("κ of {kappa} W"), kappa);
        Self {
            kappa,
            reach: DEFAULT_REACH,
        }
    }

    /// Sets the reach: the height up to which points take part, m. A larger reach gives gradients at larger heights, and costs time for more points in each step.
    ///
    /// # Panics
    /// If it is negative or not finite.
    #[must_use]
    pub fn with_reach(mut self, reach: f64) -> Self {
        Domain::NotNegative.hold(format_args!("a reach of {reach} m"), reach);
        self.reach = reach;
        self
    }

    /// κ, W.
    pub(crate) fn kappa(&self) -> f64 {
        self.kappa
    }

    /// The height up to which points take part, m.
    pub(crate) fn reach(&self) -> f64 {
        self.reach
    }
}
