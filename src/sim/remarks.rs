//! Remarks on a simulator: what it is asked for and cannot do well.

use std::fmt;

use super::integrator::Integrator;
use super::simulator::Simulator;
use crate::contact::{ContactLaw, Contacts, HuntCrossley};
use crate::dynamics::mass_matrix;
use nalgebra::{Cholesky, DVector, Dyn};

/// Speed of impact that a step should be short enough for, m/s: a fall from five centimetres.
const SPEED: f64 = 1.0;

/// Steps of an impact below which it is called short.
const FEW_STEPS: f64 = 10.0;

/// Remark on a simulator that works as it is, though hardly as meant. It is a sentence as text.
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub enum SimulatorRemark {
    /// The step is too long for soft contact at the start of the step, as semi-implicit Euler takes it: what lands is thrown up again, and what
    /// lies on a slope chatters.
    UnstableSoftContact {
        /// Link with the point of contact that is worst.
        link: String,
        /// The longest step that is stable there in an impact at 1 m/s, s.
        longest: f64,
        /// The time step, s.
        time_step: f64,
    },
    /// An impact lasts a few steps only: it takes energy in steps that are implicit in velocity, and derivatives through it scatter.
    ShortImpact {
        /// Link with the point of contact that is worst.
        link: String,
        /// How long an impact at 1 m/s lasts there, without damping, s.
        duration: f64,
        /// The time step, s.
        time_step: f64,
    },
}

impl fmt::Display for SimulatorRemark {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::UnstableSoftContact {
                link,
                longest,
                time_step,
            } => write!(
                f,
                "steps of {time_step} s are too long for soft contact of \"{link}\" at the start of a step: in an impact at {SPEED} m/s \
                 those up to {longest:.1e} s are stable; use Integrator::ImplicitVelocity, shorter steps, or a softer law"
            ),
            Self::ShortImpact {
                link,
                duration,
                time_step,
            } => write!(
                f,
                "an impact of \"{link}\" at {SPEED} m/s lasts {duration:.1e} s, {:.1} steps: motions lose energy in it, and derivatives through it \
                 scatter; 50 steps resolve it: use shorter steps, or a softer law",
                duration / time_step
            ),
        }
    }
}

impl Simulator<f64> {
    /// Remarks on the simulator, for the robot in poses like one; empty where there are none. Allocates.
    ///
    /// Looks at the points of soft contact: each by itself, with the effective mass that the robot has there along the normal, in an impact at 1
    /// m/s. Whether a step that is found too long does harm depends on the motion.
    ///
    /// * `q` – configuration, length `nq`
    ///
    /// # Panics
    /// If the slice has the wrong length.
    ///
    /// # Examples
    /// ```
    /// use dualbody::contact::{ContactLaw, Contacts, SoftContact, Terrain};
    /// use dualbody::{Integrator, Model, Simulator};
    ///
    /// let ball = Model::from_urdf_file("assets/sphere.urdf")?;
    /// let law = ContactLaw::Soft(SoftContact::estimate(1.0, 1, 1e-3));
    /// let contacts = Contacts::new(&ball, Terrain::flat(0.0), law);
    /// let simulator = Simulator::new(ball).with_contacts(contacts).with_time_step(5e-3);
    /// let said = simulator.remarks(simulator.model().neutral().as_slice())[0].to_string();
    /// assert!(said.contains("too long for soft contact"), "{said}");
    /// let implicit = simulator.with_time_step(1e-3).with_integrator(Integrator::ImplicitVelocity);
    /// assert!(implicit.remarks(implicit.model().neutral().as_slice()).is_empty());
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn remarks(&self, q: &[f64]) -> Vec<SimulatorRemark> {
        self.model().check_q(q);
        let worst = self.contacts().and_then(|contacts| self.worst(contacts, q));
        worst.into_iter().collect()
    }

    /// The remark on the point of soft contact that is worst.
    fn worst(&self, contacts: &Contacts, q: &[f64]) -> Option<SimulatorRemark> {
        let time_step = self.time_step();
        let is_implicit = self.integrator() == Integrator::ImplicitVelocity;
        let of_points = self.soft_points(contacts, q);
        let times = of_points
            .into_iter()
            .map(|(link, law, mass)| match is_implicit {
                true => (link, law.impact_time(mass, SPEED) / FEW_STEPS),
                false => (link, longest_step(&law, mass)),
            });
        let (link, longest) = times.min_by(|a, b| a.1.total_cmp(&b.1))?;
        if time_step <= longest {
            return None;
        }
        Some(match is_implicit {
            true => SimulatorRemark::ShortImpact {
                link,
                duration: longest * FEW_STEPS,
                time_step,
            },
            false => SimulatorRemark::UnstableSoftContact {
                link,
                longest,
                time_step,
            },
        })
    }

    /// Link, normal force and effective mass (kg) of each point of soft contact that moves and has a spring.
    fn soft_points(&self, contacts: &Contacts, q: &[f64]) -> Vec<(String, HuntCrossley, f64)> {
        let model = self.model();
        let is_soft = |law: &ContactLaw| matches!(law, ContactLaw::Soft(_));
        let factor = match contacts.laws().iter().any(is_soft) {
            true => mass_matrix(model, q).cholesky(),
            false => None,
        };
        let Some(factor) = factor else {
            return Vec::new();
        };
        let states = contacts.states(model, q, &vec![0.0; model.nv()]);
        let each = contacts.laws().iter().enumerate();
        let of_point = |(i, law): (usize, &ContactLaw)| {
            let ContactLaw::Soft(law) = law else {
                return None;
            };
            let along = contacts.jacobian(model, q, i).tr_mul(&states[i].normal);
            let mass = effective_mass(&factor, along)?;
            let link = model.frame_of(contacts.points()[i].link).name.clone();
            (law.normal.stiffness > 0.0).then_some((link, law.normal, mass))
        };
        each.filter_map(of_point).collect()
    }
}

/// (j M⁻¹ jᵀ)⁻¹, kg; `None` where nothing moves along j.
fn effective_mass(factor: &Cholesky<f64, Dyn>, along: DVector<f64>) -> Option<f64> {
    let mobility = along.dot(&factor.solve(&along));
    (mobility > 1e-12).then(|| 1.0 / mobility)
}

/// The longest step of semi-implicit Euler that is stable at the deepest point of an impact, s.
///
/// There v⁺ = v − Δt (s x + c v) / m and x⁺ = x + Δt v⁺ with the slope s of the spring and the damper c, which is stable where
/// Δt² s + 2 Δt c < 4 m.
fn longest_step(law: &HuntCrossley, mass: f64) -> f64 {
    let (depth, n) = (law.impact_depth(mass, SPEED), 1.0 + law.stiffness_exponent);
    let spring = law.stiffness * n * depth.powf(law.stiffness_exponent);
    let damper = law.damping * depth.powf(law.damping_exponent);
    4.0 * mass / (damper + (damper * damper + 4.0 * mass * spring).sqrt())
}
