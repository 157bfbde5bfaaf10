//! Remarks on soft contact, point by point.

use nalgebra::{Cholesky, DVector, Dyn};

use super::remark::{FEW_STEPS, SPEED, SimulatorRemark};
use super::spring_damper::SpringDamper;
use crate::contact::{ContactLaw, Contacts, HuntCrossley};
use crate::dynamics::mass_matrix;
use crate::sim::integrator::Integrator;
use crate::sim::simulator::Simulator;

impl Simulator<f64> {
    /// The remark on the point of soft contact that is worst, in an impact at 1 m/s in poses like `q`.
    pub(crate) fn remark_on_soft_contact(&self, q: &[f64]) -> Option<SimulatorRemark> {
        let time_step = self.time_step();
        let is_implicit = self.integrator() == Integrator::ImplicitVelocity;
        let longest = match self.integrator() {
            Integrator::RungeKutta4 => SpringDamper::longest_of_runge_kutta,
            _ => SpringDamper::longest_of_euler,
        };
        let of_points = self.soft_points(self.contacts()?, q);
        let times = of_points
            .into_iter()
            .map(|(link, law, mass)| match is_implicit {
                true => (link, law.impact_time(mass, SPEED) / FEW_STEPS),
                false => (link, longest(SpringDamper::in_impact(&law, mass))),
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
