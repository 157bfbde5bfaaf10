//! Inertias as `MuJoCo` accepts them.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::{HashMap, HashSet};

use nalgebra::{Matrix3, Vector3};

use super::{Writer, number, numbers, quaternion, unsupported};
use crate::error::WriteError;
use crate::io::write::AboutCom;
use crate::linalg::symmetric_eigen3;
use crate::model::{LinkSpec, Model, ModelBuilder, inertia_flaw};
use crate::spatial::{Inertia, Symmetric3, Transform};

/// Smallest principal moment that is written, kg·m²: well above what `MuJoCo` refuses (10⁻¹⁴), far below any part of a
/// robot.
const LEAST_MOMENT: f64 = 1e-12;
/// Relative distance from the triangle inequality below which its rounding in `MuJoCo` may decide: above that of its
/// eigenvalues.
const MARGIN: f64 = 1e-9;
/// Whether a body is one of the world's.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Moves {
    Always,
    Never,
}

/// Inertias by the link at which they are written: that of a body that moves, with all links that are fixed to one
/// another, at its first link. So a flaw of a link on a healthy body vanishes in the sum.
pub(super) struct Inertias {
    /// Inertia in the frame of a link, by its name; nothing for the others on the same body.
    of_link: HashMap<String, Inertia<f64>>,
    /// The first link on the first body, and the inertia of that body in its own frame.
    base: Option<(String, Inertia<f64>)>,
    /// Links on whose inertia here gravity does not act.
    weightless: HashSet<String>,
}

impl Inertias {
    pub(super) fn new(model: &Model<f64>, builder: &ModelBuilder) -> Self {
        let own: HashMap<&str, &Inertia<f64>> = (builder.links.iter())
            .map(|link| (link.name.as_str(), &link.inertia))
            .collect();
        // By body, its first link and how many links have inertia.
        let mut first: Vec<Option<(&str, Transform<f64>)>> = vec![None; model.n_bodies()];
        let mut parts = vec![0; model.n_bodies()];
        let mut of_link = HashMap::new();
        for frame in model
            .links()
            .iter()
            .map(|link| &model.frames()[link.frame.0])
        {
            let name = frame.name.as_str();
            let Some(body) = frame.body else {
                of_link.insert(name.to_owned(), *own[name]);
                continue;
            };
            first[body.0].get_or_insert((name, frame.placement));
            parts[body.0] += usize::from(*own[name] != Inertia::zero());
        }
        let base = first.first().copied().flatten();
        for (i, first) in first.into_iter().enumerate() {
            // The first body of a universal joint has no link.
            let Some((name, X_BL)) = first else { continue };
            // One part, if it is the first, is written without the rounding of a change of frames.
            let is_alone = parts[i] <= 1 && *own[name] != Inertia::zero();
            let sum = || X_BL.inverse().inertia(&model.bodies()[i].inertia);
            let inertia = if is_alone { *own[name] } else { sum() };
            of_link.insert(name.to_owned(), inertia);
        }
        let mut out = Self {
            of_link,
            base: base.map(|(name, _)| (name.to_owned(), model.bodies()[0].inertia)),
            weightless: HashSet::new(),
        };
        out.split(model, builder);
        out
    }

    /// Writes what gravity does not act on at the first link that it does not act on, the rest of the body at the first of the others.
    fn split(&mut self, model: &Model<f64>, builder: &ModelBuilder) {
        for own in model.weightless() {
            let specs = builder.links.iter().map(|link| (link.name.as_str(), link));
            let specs: HashMap<&str, &LinkSpec> = specs.collect();
            let frames = model
                .links()
                .iter()
                .map(|link| &model.frames()[link.frame.0]);
            let on_body: Vec<_> = frames
                .filter(|frame| frame.body == Some(own.body))
                .collect();
            if own.is_whole() {
                let first = on_body.first().map(|frame| frame.name.clone());
                self.weightless.extend(first);
                continue;
            }
            for has_gravity in [true, false] {
                let mut part = (on_body.iter())
                    .filter(|f| specs[&*f.name].has_gravity == has_gravity)
                    .peekable();
                let Some(first) = part.peek().copied() else {
                    continue;
                };
                let sum = part.fold(Inertia::zero(), |sum, frame| {
                    sum + frame.placement.inertia(&specs[&*frame.name].inertia)
                });
                let inertia = first.placement.inverse().inertia(&sum);
                self.of_link.insert(first.name.clone(), inertia);
                if !has_gravity {
                    self.weightless.insert(first.name.clone());
                }
            }
        }
    }

    /// Whether gravity does not act on the inertia that is written for a link.
    pub(super) fn is_weightless(&self, link: &str) -> bool {
        self.weightless.contains(link)
    }

    /// The first link on the base, while its inertia is still to be written.
    pub(super) fn base_link(&self) -> Option<&str> {
        self.base.as_ref().map(|(link, _)| link.as_str())
    }

    /// The inertia to write for the first body in its own frame; no link has it then.
    pub(super) fn take_base(&mut self) -> Inertia<f64> {
        let Some((link, inertia)) = self.base.take() else {
            return Inertia::zero();
        };
        self.of_link.remove(&link);
        inertia
    }

    /// The inertia to write for a link, which has it no more.
    pub(super) fn take(&mut self, link: &str) -> Inertia<f64> {
        self.of_link.remove(link).unwrap_or_else(Inertia::zero)
    }
}

impl Writer<'_> {
    /// Writes the inertia of a body; `moves` says whether it enters the dynamics.
    pub(super) fn inertial(
        &mut self,
        name: &str,
        inertia: &Inertia<f64>,
        moves: Moves,
    ) -> Result<(), WriteError> {
        let refuse = |reason: String| unsupported("link", name, reason);
        if *inertia == Inertia::zero() {
            return Ok(());
        }
        if let Some(flaw) = inertia_flaw(inertia) {
            if moves == Moves::Never {
                self.xml.comment(&format!(
                    "left out: the inertia of {name}, which does not move: {flaw}"
                ));
                return Ok(());
            }
            return Err(refuse(flaw.to_string()));
        }
        let no_mass = || refuse("it has a first moment without mass".into());
        let AboutCom { mass, com, moments } = AboutCom::of(inertia).ok_or_else(no_mass)?;
        let mut attributes = vec![("pos", numbers(com.as_slice())), ("mass", number(mass))];
        match limiting_case(&moments) {
            None => {
                let j = &moments;
                let entries = [j.xx, j.yy, j.zz, j.xy, j.xz, j.yz];
                attributes.push(("fullinertia", numbers(&entries)));
            }
            Some((principal, axes)) => {
                attributes.push(("quat", quaternion(&axes)));
                attributes.push(("diaginertia", numbers(principal.as_slice())));
            }
        }
        self.xml.leaf("inertial", &attributes);
        Ok(())
    }
}

/// Principal moments, moved to where `MuJoCo` accepts them, and axes of points, rods and plates; `None` for other
/// bodies.
fn limiting_case(moments: &Symmetric3<f64>) -> Option<(Vector3<f64>, Matrix3<f64>)> {
    let matrix = moments.to_matrix();
    let size = matrix.amax().max(f64::MIN_POSITIVE);
    let (values, mut axes) = symmetric_eigen3(&(matrix / size))?;
    let mut principal = values * size;
    let largest = principal.imax();
    let others = |principal: &Vector3<f64>| principal.sum() - principal[largest];
    let is_thin = principal.min() < LEAST_MOMENT;
    let is_flat = principal[largest] > others(&principal) * (1.0 - MARGIN);
    if !is_thin && !is_flat {
        return None;
    }
    principal
        .iter_mut()
        .for_each(|moment| *moment = moment.max(LEAST_MOMENT));
    if is_flat {
        principal[largest] = principal[largest].min(others(&principal) * (1.0 - f64::EPSILON));
    }
    if axes.determinant() < 0.0 {
        axes = -axes;
    }
    Some((principal, axes))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tests::ROUNDING;

    #[test]
    fn moved_moments_of_rods_and_plates_equal_the_moments_to_rounding() {
        let turn = crate::spatial::Quaternion::exp(&Vector3::new(0.3, -1.0, 0.5)).to_matrix();
        for (moments, is_limiting) in [
            ([1.0, 2.0, 2.5], false),
            ([0.1, 0.1, 0.0], true),
            ([1.0, 2.0, 3.0], true),
            ([0.3, 0.1, 0.4], true),
            ([0.0; 3], true),
            ([1e-15, 1e-15, 1e-15], true),
        ] {
            let turned = Symmetric3::diagonal(&moments.into()).rotated(&turn);
            let found = limiting_case(&turned);
            assert_eq!(found.is_some(), is_limiting, "{moments:?}");
            let Some((principal, axes)) = found else {
                continue;
            };
            let again = axes * Matrix3::from_diagonal(&principal) * axes.transpose();
            assert!(
                (again - turned.to_matrix()).amax() < 2.0 * LEAST_MOMENT,
                "{moments:?}"
            );
            let [a, b, c]: [f64; 3] = principal.into();
            assert!(a + b >= c && a + c >= b && b + c >= a && principal.min() >= LEAST_MOMENT);
            assert!((axes.determinant() - 1.0).abs() < 10.0 * ROUNDING);
        }
    }
}
