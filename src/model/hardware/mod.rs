//! Design parameters: sizes and densities of links, over any scalar.
//!
//! A [`Hardware`] is a robot with design parameters of some [links](ScaledLink): edges of a box, radius and length of a cylinder or capsule, radius
//! of a sphere, the scale of a mesh along each axis, the density. They are one named vector. For other values of it, [`Hardware::model`] builds the
//! robot over their scalar, so that all results have derivatives in them.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

mod dimension;
mod link;
mod shapes;
mod stretch;

use std::collections::{HashMap, HashSet};

use nalgebra::{DMatrix, Vector3};

use super::description::indices;
use super::numbers::Numbers;
use super::{FrameId, Model, ModelBuilder, assembly};
use crate::error::{EditError, UnknownName};
use crate::scalar::{CHUNK, Dual, Scalar};
use crate::spatial::Transform;
pub use dimension::Dimension;
use link::Scaled;
pub(super) use link::solid_of;
pub use link::{LinkShape, MassDistribution, MeshSolids, ScaledLink};
pub(crate) use stretch::Stretch;

/// A robot with sizes and densities of links as design parameters, over any scalar.
///
/// | part of a selected link | effect of a size |
/// |---|---|
/// | origin, at its joint | unchanged |
/// | joints and fixed links on it, frames, centres of shapes, contact points | move with the points of the shape: scaled by its factors along its axes, from the origin |
/// | the shape itself | has the new sizes |
/// | other shapes | lengths scale with their direction, radii of balls with the radius of the shape, or with the cube root of the volume of a box or mesh |
/// | mass, centre of mass, inertia | particles move with the points of the shape; their density scales with the density parameter, see [`MassDistribution`] |
///
/// Angles, axes, limits, motors, springs, damping and other links are unchanged. Attachment frames of [constraints](crate::constraint) do not move.
///
/// For a rollout of an `f64` robot, compute the gradient in the [parameters of the model](Model::parameters) by
/// [`Simulator::rollout_gradients`](crate::Simulator::rollout_gradients) with the [option](crate::linearize::RolloutGradientOptions::parameters) for
/// model parameters only; multiplication by the transposed [`Hardware::parameter_jacobian`] gives the gradient in sizes and densities.
///
/// # Examples
/// ```
/// use dualbody::model::{Dimension, Hardware, LinkSpec, JointSpec, Mass, ModelBuilder, ScaledLink};
/// use dualbody::{dynamics, joint::JointKind, scalar::Dual};
///
/// // A rod of 1 m on a hinge at its middle: J = m l² / 12, and m grows with l.
/// let mut builder = ModelBuilder::new("spinner");
/// builder.add_link(LinkSpec::new("world"));
/// builder.add_link(LinkSpec::solid_cylinder("rod", 1e-6, 1.0, Mass::Kilograms(12.0)));
/// builder.add_joint(JointSpec::new("hinge", JointKind::Continuous, "world", "rod"));
/// let hardware = Hardware::new(&builder.build()?, &[ScaledLink::new("rod", &[Dimension::Length])])?;
/// assert_eq!((hardware.names()[0].as_str(), hardware.nominal()), ("rod: length", &[1.0][..]));
/// let longer = hardware.model(&[Dual::<f64, 1>::variable(2.0, 0)])?;
/// let inertia = dynamics::mass_matrix(&longer, &[Dual::<f64, 1>::from(0.0)])[0];
/// assert!((inertia.re - 8.0).abs() < 1e-9 && (inertia.eps[0] - 12.0).abs() < 1e-9); // l³ and 3 l²
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Hardware {
    model: Model,
    builder: ModelBuilder,
    scaled: Vec<Scaled>,
    names: Vec<String>,
    nominal: Vec<f64>,
    link_of_name: HashMap<String, usize>,
}

impl Hardware {
    /// Selects links of a robot and their design parameters, with inertias of meshes from the caller. [`new`](Self::new) reads mesh files.
    ///
    /// # Errors
    /// If a link is unknown or chosen twice, has no such shape or its shape no such size, if a size is zero, if the density is selected for a link
    /// without mass or a mesh without volume.
    pub fn with_meshes(
        model: &Model,
        links: &[ScaledLink],
        meshes: &mut dyn MeshSolids,
    ) -> Result<Self, EditError> {
        let builder = model.to_builder();
        let mut out = Self {
            model: model.clone(),
            link_of_name: indices(builder.links.iter().map(|link| link.name.as_str())),
            scaled: Vec::with_capacity(links.len()),
            names: Vec::new(),
            nominal: Vec::new(),
            builder,
        };
        let mut seen = HashSet::new();
        for choice in links {
            let index = out.builder.link_index(&choice.name)?;
            if !seen.insert(index) {
                let (element, name) = ("chosen link".into(), choice.name.clone());
                return Err(EditError::DuplicateName { element, name });
            }
            let (link, first) = (&out.builder.links[index], out.nominal.len());
            let scaled = Scaled::new(choice, index, link, first, meshes)?;
            out.nominal.extend(scaled.nominal());
            let name = |dimension| format!("{}: {dimension}", choice.name);
            out.names.extend(choice.dimensions.iter().map(name));
            out.scaled.push(scaled);
        }
        Ok(out)
    }

    /// Name of each parameter: link and quantity, as in `forearm: length`.
    pub fn names(&self) -> &[String] {
        &self.names
    }

    /// Values of the parameters in the description: m, kg/m³, and scales of meshes.
    pub fn nominal(&self) -> &[f64] {
        &self.nominal
    }

    /// Index of the parameter with a name.
    ///
    /// # Errors
    /// If the list is empty.
    pub fn find(&self, name: &str) -> Result<usize, UnknownName> {
        let found = self.names.iter().position(|own| own == name);
        found.ok_or_else(|| {
            let known = self.names.iter().map(String::as_str);
            self.builder.unknown("hardware parameter", name, known)
        })
    }

    /// Returns the robot with other values of the parameters, over their scalar. Its shapes and its [description](Model::to_builder), and so written
    /// files, are those of the values in the first lane.
    ///
    /// Cost: O(n) in the number of links; allocates.
    ///
    /// * `x` – all parameters, each positive
    ///
    /// # Errors
    /// If one is not positive and finite; the error names it.
    ///
    /// # Panics
    /// If there are not as many as [`names`](Self::names).
    pub fn model<T: Scalar>(&self, x: &[T]) -> Result<Model<T>, EditError> {
        self.check(x)?;
        let pairs = x.iter().zip(&self.nominal);
        let values = pairs.map(|(x, &nominal)| if x.has_value() { x.value(0) } else { nominal });
        let builder = self.described(&values.collect::<Vec<_>>());
        Ok(assembly::build_over(&builder, &self.numbers(x))?)
    }

    /// Returns the description of the robot with other values of the parameters.
    ///
    /// * `x` – all parameters, each positive
    ///
    /// # Errors
    /// If one is not positive and finite; the error names it.
    ///
    /// # Panics
    /// If there are not as many as [`names`](Self::names).
    pub fn description(&self, x: &[f64]) -> Result<ModelBuilder, EditError> {
        self.check(x)?;
        Ok(self.described(x))
    }

    /// Computes the derivatives of all [parameters of the model](Model::parameters) (rows) in the design parameters (columns), by dual numbers.
    ///
    /// For a gradient g in the parameters of the model at `x`, the gradient in sizes and densities is Jᵀ g. Contact points move with links, but are
    /// not parameters of the model: for these use [`Contacts::with_hardware`](crate::contact::Contacts::with_hardware).
    ///
    /// * `x` – all parameters, each positive
    ///
    /// # Errors
    /// If one is not positive and finite; the error names it.
    ///
    /// # Panics
    /// If there are not as many as [`names`](Self::names).
    // Compiled where it is called: it builds the robot over dual numbers, which few programs do.
    #[inline]
    pub fn parameter_jacobian(&self, x: &[f64]) -> Result<DMatrix<f64>, EditError> {
        self.check(x)?;
        let rows = self.model.parameters().len();
        let mut out = DMatrix::zeros(rows, self.names().len());
        let mut duals: Vec<Dual<f64, CHUNK>> = x.iter().map(|&x| x.into()).collect();
        for first in (0..self.names().len()).step_by(CHUNK) {
            let end = self.names().len().min(first + CHUNK);
            (first..end).for_each(|k| duals[k].eps[k - first] = 1.0);
            let slopes = self.model(&duals)?.parameter_derivatives();
            out.columns_mut(first, end - first)
                .copy_from(&slopes.columns(0, end - first));
            (first..end).for_each(|k| duals[k].eps[k - first] = 0.0);
        }
        Ok(out)
    }

    /// The robot as it was given.
    pub(crate) fn nominal_model(&self) -> &Model {
        &self.model
    }

    /// The map of the link that a frame is on, and the pose of the frame in it; `None` where that is not chosen.
    pub(crate) fn stretch_of<T: Scalar>(
        &self,
        frame: FrameId,
        x: &[T],
    ) -> Option<(Stretch<T>, Transform<f64>)> {
        let name = self.model.frames()[frame.0].name.as_str();
        let added = self.builder.frames.iter().find(|frame| frame.name == name);
        let X_LF = added.map_or_else(Transform::identity, |frame| frame.placement);
        let link = added.map_or(name, |frame| frame.link.as_str());
        let link = self.link_of_name.get(link)?;
        let scaled = self.scaled.iter().find(|scaled| scaled.link == *link)?;
        Some((scaled.stretch(x), X_LF))
    }

    fn check<T: Scalar>(&self, x: &[T]) -> Result<(), EditError> {
        let (own, given) = (self.names().len(), x.len());
        assert_eq!(
            given,
            own,
            "the hardware of \"{}\" has {own} parameters",
            self.model.name()
        );
        for (name, x) in self.names.iter().zip(x).filter(|(_, x)| x.has_value()) {
            for lane in 0..T::LANES {
                super::operations::positive(&format!("parameter \"{name}\""), x.value(lane))?;
            }
        }
        Ok(())
    }

    /// The description at parameters in their domains.
    fn described(&self, x: &[f64]) -> ModelBuilder {
        let mut builder = self.builder.clone();
        self.numbers(x).put_into(&mut builder);
        for scaled in &self.scaled {
            let link = &mut builder.links[scaled.link];
            shapes::rescale(link, scaled, &scaled.stretch(x), x);
        }
        builder
    }

    /// Inertias and poses at parameters in their domains.
    fn numbers<T: Scalar>(&self, x: &[T]) -> Numbers<T> {
        let mut out = Numbers::of(&self.builder);
        let mut stretches: Vec<Option<Stretch<T>>> = vec![None; self.builder.links.len()];
        for scaled in &self.scaled {
            let stretch = scaled.stretch(x);
            out.inertias[scaled.link] = scaled.inertia(&stretch, x);
            stretches[scaled.link] = Some(stretch);
        }
        let displacement = |link: &str, p_L: &Vector3<f64>| {
            let stretch = stretches[*self.link_of_name.get(link)?].as_ref()?;
            Some(stretch.displacement(p_L))
        };
        let joints = self.builder.joints.iter().zip(&mut out.placements);
        for (joint, placement) in joints {
            if let Some(moved) = displacement(&joint.parent, &joint.placement.translation) {
                placement.translation += moved;
            }
        }
        for (frame, placement) in self.builder.frames.iter().zip(&mut out.frames) {
            if let Some(moved) = displacement(&frame.link, &frame.placement.translation) {
                placement.translation += moved;
            }
        }
        out
    }
}
