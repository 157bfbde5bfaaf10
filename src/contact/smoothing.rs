//! Smoothed rigid contact: forces, and so derivatives, before touch-down.

use crate::numbers::Domain;

/// Smoothing of rigid and relaxed rigid contact, for gradients where the exact law has none: above the ground, while a point sticks, and
/// across the speed at which it slides.
///
/// The law `fₙ ŷₙ = 0` becomes `fₙ ŷₙ = κ` (the central path, see [`cone`](crate::cone)), with the force fₙ and the velocity ŷₙ by which the
/// point exceeds after the step what the exact law asks of it. A point at rest at a height h feels about
///
/// * κ Δt / h with [`Rigid`](super::Rigid), as ŷₙ is h / Δt;
/// * κ / (Δt k d h) with [`RelaxedRigid`](super::RelaxedRigid), whose reference acceleration there is k d h; above the ground it also gives
///   way by R = Δt (k d h)² / κ more, so that the force falls with κ however fast the point comes down.
///
/// So a body of weight m g on n points hovers at h = n κ Δt / (m g) with [`Rigid`](super::Rigid): take κ = h m g / (n Δt) with the height h that may be wrong,
/// and smaller ones as an optimisation converges.
///
/// As κ falls to 0, forces tend to the exact ones, and derivatives to the exact ones away from the points between modes.
///
/// # Limitations
/// An impact still falls in a step of its own: the law of [`Rigid`](super::Rigid) itself, and so the smoothed one, jumps where one step more
/// or less goes by before it. The force at the reach drops to zero from what is said above. A body squeezed between two contacts has smoothed
/// forces with [`RelaxedRigid`](super::RelaxedRigid) only. A step costs more than with the exact law, as every point within reach
/// takes part, and forces are found along the path. Stops of joints keep their law.
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

/// Height up to which points feel a smoothed ground where nothing else is said, m.
const DEFAULT_REACH: f64 = 0.1;

impl Smoothing {
    /// Smoothing with a κ, W (N·m/s: force times velocity), up to a reach of 0.1 m. A larger one makes forces reach farther ahead of the
    /// contact, carry from higher above the ground, and friction set in more softly; 0 is the exact law.
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

    /// With another reach: the height up to which points take part, m. Larger gives gradients from farther, and costs the time of more
    /// points in each step.
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
    pub fn kappa(&self) -> f64 {
        self.kappa
    }

    /// The height up to which points take part, m.
    pub fn reach(&self) -> f64 {
        self.reach
    }
}
