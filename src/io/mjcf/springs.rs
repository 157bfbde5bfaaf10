//! Springs and dampers by their time constant and damping ratio.

use nalgebra::Vector3;

use super::body::Bodies;
use super::reference::reference;
use crate::dynamics::forward_dynamics;
use crate::error::LoadError;
use crate::model::{Base, Model, ModelBuilder, Spring};
use crate::nested::IntoNested;

/// Largest product of such joints and of all degrees of freedom: some seconds of work.
pub(super) const MOST: usize = 10_000_000;

/// The inertia that resists a motion while all that it does not hold moves freely, 1 / (cᵀ M⁻¹ c), as a function of coordinates with their coefficients;
/// O(n) each.
pub(super) fn inertia(model: &Model, q: &[f64]) -> impl Fn(&[(usize, f64)]) -> f64 {
    let still = model.clone().with_gravity(Vector3::zeros());
    let rest = vec![0.0; model.nv()];
    move |along| {
        let mut unit = rest.clone();
        along.iter().for_each(|&(k, c)| unit[k] += c);
        let a = forward_dynamics(&still, q, &rest, &unit);
        along.iter().map(|&(k, c)| c * a[k]).sum::<f64>().recip()
    }
}

/// Sets stiffness and damping of joints that state a time constant T and a damping ratio ζ: with the inertia I that resists the joint while all others
/// move freely, where the file has the bodies, k = I / (T ζ)² and d = 2 I / T. I = 1 / (M⁻¹)ₖₖ.
///
/// # References
/// The attribute `springdamper` in the XML reference of `MuJoCo`.
pub(super) fn add(
    mut builder: ModelBuilder,
    bodies: &Bodies,
    base: Base,
    floats: bool,
) -> Result<ModelBuilder, LoadError> {
    let all = bodies.entries.iter().nested(|body| &body.joints);
    let wanted: Vec<_> = all
        .filter_map(|joint| {
            let [time, ratio] = joint.springdamper?;
            (time > 0.0 && ratio > 0.0).then_some((joint, time, ratio))
        })
        .collect();
    if wanted.is_empty() {
        return Ok(builder);
    }
    let model = builder.clone().with_base(base).build()?;
    if wanted.len().saturating_mul(model.nv()) > MOST {
        let (joint, ..) = wanted[0];
        let reason = "too many joints state a springdamper: give them stiffness and damping";
        return Err(joint.place.unsupported(reason));
    }
    // A joint without resistance has no such inertia.
    if model.check_mass_matrix().is_err() {
        return Ok(builder);
    }
    let q = reference(&model, bodies, floats);
    let inertia_of = inertia(&model, q.as_slice());
    let mut joints = builder.joints.to_vec();
    for (joint, time, ratio) in wanted {
        let Some(id) = model.joint(&joint.name) else {
            continue;
        };
        let inertia = inertia_of(&[(model.joint_v(id).start, 1.0)]);
        let spec = joints.iter_mut().find(|spec| spec.name == joint.name);
        if let Some(spec) = spec {
            let mut axis = joint.axis.clone();
            axis.spring = Spring {
                stiffness: inertia / (time * ratio).powi(2),
                ..axis.spring
            };
            axis.damping = 2.0 * inertia / time;
            *spec = spec.clone().along(axis);
        }
    }
    builder.set_joints(joints);
    Ok(builder)
}
