//! Softness of equalities: `solref`, `solimp`, and the inverse inertias in proportion to which their rows yield.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::cell::OnceCell;
use std::collections::HashMap;

use nalgebra::Vector3;

use super::body::{Bodies, BodyEntry};
use super::entry::Entry;
use super::joint::{JointEntry, Kind};
use super::solver_parameters::{SOLIMP, SOLREF, impedance, reference};
use crate::constraint::{Anchor, Constraint, Regularisation};
use crate::dynamics::{forward_dynamics, frame_jacobian, frame_pose};
use crate::error::LoadError;
use crate::model::{FrameId, Model};
use crate::nested::IntoNested;
use crate::scalar::MapEach;
use crate::spatial::{Inertia, Representation};

/// Rows of a Jacobian of position, of as many as there are.
const LINEAR: usize = 3;

/// Inverse inertias of a model in a configuration, as `MuJoCo` estimates them for its solver.
pub(super) struct InverseInertias<'a> {
    model: &'a Model,
    q: &'a [f64],
    bodies: &'a Bodies,
    /// The model without weight, and its acceleration under no other forces than those of its springs; `None` if its mass matrix is singular.
    still: OnceCell<Option<(Model, Vec<f64>)>>,
    /// The body of each site by its frame.
    on_sites: OnceCell<HashMap<FrameId, &'a BodyEntry>>,
}

impl<'a> InverseInertias<'a> {
    pub(super) fn new(model: &'a Model, q: &'a [f64], bodies: &'a Bodies) -> Self {
        Self {
            model,
            q,
            bodies,
            still: OnceCell::new(),
            on_sites: OnceCell::new(),
        }
    }

    /// cᵀ M⁻¹ c of a motion c; 1 where the mass matrix is singular.
    pub(super) fn along(&self, c: &[f64]) -> f64 {
        let rest = vec![0.0; c.len()];
        let still = self.still.get_or_init(|| {
            self.model.check_mass_matrix().ok()?;
            let still = self.model.clone().with_gravity(Vector3::zeros());
            let a = forward_dynamics(&still, self.q, &rest, &rest);
            Some((still, a.as_slice().to_vec()))
        });
        let Some((still, own)) = still else {
            return 1.0;
        };
        let a = forward_dynamics(still, self.q, &rest, c);
        let entries = a.iter().zip(own).zip(c);
        entries.map(|((a, own), c)| (a - own) * c).sum()
    }

    /// Mean inverse mass and inverse inertia of the centre of mass of a body; 0 for the world. The mean is over three axes, also where the body moves along
    /// fewer; only of a [slider](Bodies::is_slider) the inverse mass is that of the body.
    pub(super) fn of_body(&self, body: Option<&BodyEntry>) -> [f64; 2] {
        let Some(body) = body else {
            return [0.0; 2];
        };
        let Some(frame) = self.model.frame(&body.name) else {
            return [0.0; 2];
        };
        if self.bodies.is_slider(body) {
            return [1.0 / body.inertia.mass, 0.0];
        }
        let com = match body.inertia.mass {
            mass if mass > 0.0 => body.inertia.com(),
            // Without mass `MuJoCo` takes the place of the body in its parent for that of the centre of mass in the body, as was measured.
            _ => body.X_PB.translation,
        };
        let mut J = frame_jacobian(self.model, self.q, frame, Representation::Mixed);
        let R = frame_pose(self.model, self.q, frame).rotation;
        let arm = R * com;
        for mut column in J.column_iter_mut() {
            let moved = column.fixed_rows::<3>(LINEAR).cross(&arm);
            for k in 0..LINEAR {
                column[k] += moved[k];
            }
        }
        let row = |k: usize| self.along(&J.row(k).iter().copied().collect::<Vec<_>>());
        [0, LINEAR].map_each(|first| (first..first + LINEAR).map(row).sum::<f64>() / LINEAR as f64)
    }

    /// The body of a name.
    pub(super) fn body_named(&self, name: &str) -> Option<&'a BodyEntry> {
        self.bodies
            .entries
            .iter()
            .skip(1)
            .find(|own| own.name == name)
    }

    /// The body of a site.
    pub(super) fn body_of_site(
        &self,
        anchor: &Anchor,
        frames: &HashMap<String, String>,
    ) -> Option<&'a BodyEntry> {
        let on_sites = self.on_sites.get_or_init(|| {
            let all = self.bodies.entries.iter().skip(1);
            let sites = all.nested(|body| body.sites.iter().map(move |site| (body, site)));
            let placed = sites.filter_map(|(body, site)| {
                Some((self.model.frame(frames.get(&site.name)?)?, body))
            });
            placed.collect()
        });
        on_sites.get(&anchor.frame?).copied()
    }
}

impl Bodies {
    /// Whether a body on the ground, which carries no other, moves along axes of its own frame alone, and that is the frame of its inertia: `MuJoCo` handles
    /// such bodies apart.
    fn is_slider(&self, body: &BodyEntry) -> bool {
        let Inertia {
            mass,
            first_moment,
            rotational: I,
        } = &body.inertia;
        let has_mass = *mass > 0.0 && *first_moment == Vector3::zeros();
        let is_diagonal = [I.xy, I.xz, I.yz] == [0.0; 3];
        let slides = |joint: &JointEntry| {
            let along = joint.axis.axis.iter().filter(|x| **x != 0.0).count() == 1;
            joint.kind == Kind::Slide && along && joint.anchor == Vector3::zeros()
        };
        let carries = |other: &BodyEntry| std::ptr::eq(&raw const self.entries[other.parent], body);
        has_mass
            && is_diagonal
            && !body.joints.is_empty()
            && body.joints.iter().all(slides)
            && self.is_fixed(body.parent)
            && !self.entries.iter().skip(1).any(carries)
    }

    /// Whether a body and all that carry it have no joints.
    fn is_fixed(&self, index: usize) -> bool {
        let body = &self.entries[index];
        body.joints.is_empty() && (index == 0 || self.is_fixed(body.parent))
    }
}

/// Regularises a constraint with the solver parameters of its element.
///
/// * `inverses` – inverse masses and inertias of both bodies together, or of both joints or tendons
pub(super) fn soften(
    constraint: Constraint,
    entry: &Entry<'_, '_>,
    inverses: [f64; 2],
    time_step: f64,
) -> Result<Constraint, LoadError> {
    let solref = entry.some_numbers("solref", SOLREF)?;
    let solimp = entry.some_numbers("solimp", SOLIMP)?;
    // Without a torque scale there are no angular rows.
    let lever = match torque_scale(entry)? {
        0.0 => 0.5,
        scale => 0.5 * scale.abs(),
    };
    let soft = Regularisation {
        reference: reference(solref, time_step),
        impedance: impedance(solimp),
        inverse_mass: inverses[0],
        // The rows of `MuJoCo` are those of this library times the lever.
        inverse_inertia: inverses[1] / lever.powi(2),
        lever,
    };
    let numbers = [soft.inverse_mass, soft.inverse_inertia, lever];
    Ok(match numbers.iter().all(|x| x.is_finite() && *x >= 0.0) {
        true => constraint.with_regularisation(soft),
        false => constraint,
    })
}

/// The torque scale of a weld.
pub(super) fn torque_scale(entry: &Entry<'_, '_>) -> Result<f64, LoadError> {
    Ok(match entry.node.tag() {
        "weld" => entry.number("torquescale")?.unwrap_or(1.0),
        _ => 1.0,
    })
}
