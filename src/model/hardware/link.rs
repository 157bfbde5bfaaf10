//! Links with design parameters: selection and properties.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::ops::Range;

use super::dimension::{Dimension, dimensions_of, noun, sizes_of};
use super::stretch::Stretch;
use crate::error::EditError;
use crate::model::{Geometry, LinkSpec, Mass, Model, short_reference};
use crate::scalar::Scalar;
use crate::spatial::{Inertia, Transform};

/// Selection of the shape of a link that defines its sizes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum LinkShape {
    /// The first visual shape; for a link without visual shapes the first collision shape.
    #[default]
    First,
    /// The visual shape with this index.
    Visual(usize),
    /// The collision shape with this index.
    Collision(usize),
}

/// Distribution of mass in a link.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[non_exhaustive]
pub enum MassDistribution {
    /// That of the description: all particles move with the points of the shape. At the sizes of the description the inertia is unchanged; the
    /// inertia of a homogeneous solid remains that of a homogeneous solid. For a capsule, the deviation of the inertia from that of a homogeneous
    /// solid moves as if the ends were stretched as well.
    #[default]
    Described,
    /// A homogeneous solid of the shape with the mass of the description; inertia and centre of mass of the description are ignored.
    Homogeneous,
}

/// Selection of a link with its design parameters.
///
/// # Examples
/// ```
/// use dualbody::model::{Dimension, MassDistribution, ScaledLink};
///
/// let forearm = ScaledLink::new("forearm", &[Dimension::Length, Dimension::Density])
///     .with_mass_distribution(MassDistribution::Homogeneous);
/// assert_eq!(forearm.name, "forearm");
/// ```
#[derive(Clone, Debug, PartialEq)]
#[non_exhaustive]
pub struct ScaledLink {
    /// Name of the link.
    pub name: String,
    /// Its design parameters, in order.
    pub dimensions: Vec<Dimension>,
    /// The shape with these sizes; the first by default.
    pub shape: LinkShape,
    /// Distribution of its mass; as described by default.
    pub masses: MassDistribution,
}

impl ScaledLink {
    /// Selects design parameters of a link.
    pub fn new(name: impl Into<String>, dimensions: &[Dimension]) -> Self {
        Self {
            name: name.into(),
            dimensions: dimensions.to_vec(),
            shape: LinkShape::default(),
            masses: MassDistribution::default(),
        }
    }

    /// Sets the shape that defines the sizes.
    #[must_use]
    pub fn with_shape(mut self, shape: LinkShape) -> Self {
        self.shape = shape;
        self
    }

    /// Sets the distribution of the mass.
    #[must_use]
    pub fn with_mass_distribution(mut self, masses: MassDistribution) -> Self {
        self.masses = masses;
        self
    }

    /// Selects all links with a shape, with all sizes, and the density of links with mass.
    pub fn all_of(model: &Model) -> Vec<Self> {
        let builder = model.to_builder();
        let links = builder.links.iter();
        let chosen = links.filter_map(|link| {
            let (_, shape) = LinkShape::First.of(link)?;
            let mut dimensions = dimensions_of(shape).to_vec();
            dimensions.extend((link.inertia.mass > 0.0).then_some(Dimension::Density));
            Some(Self::new(&link.name, &dimensions))
        });
        chosen.collect()
    }
}

impl LinkShape {
    /// The shape with its pose in the link; `None` if the link does not have it.
    fn of(self, link: &LinkSpec) -> Option<(&Transform<f64>, &Geometry)> {
        let visual = |k: usize| link.visuals.get(k).map(|s| (&s.placement, &s.geometry));
        let collision = |k: usize| link.collisions.get(k).map(|s| (&s.placement, &s.geometry));
        match self {
            Self::First => visual(0).or_else(|| collision(0)),
            Self::Visual(k) => visual(k),
            Self::Collision(k) => collision(k),
        }
    }
}

/// Source of the inertias of meshes as solids.
pub trait MeshSolids {
    /// Inertia of a mesh as a solid of density 1 kg/m³ in its own frame, without its scale; or why there is none, as an end of the sentence "the mesh …".
    ///
    /// * `mesh` – a [`Geometry::Mesh`]
    ///
    /// # Errors
    /// If it has none, with the reason.
    fn solid(&mut self, mesh: &Geometry) -> Result<Inertia<f64>, String>;
}

/// A selected link, and the data of its inertia.
#[derive(Clone, Debug)]
pub(super) struct Scaled {
    /// Index in the description.
    pub(super) link: usize,
    pub(super) X_LG: Transform<f64>,
    pub(super) geometry: Geometry,
    /// Sizes, in the order of [`dimensions_of`], then the density, as far as they are requested.
    nominal: Vec<f64>,
    /// Its parameters.
    pub(super) range: Range<usize>,
    /// Index of each of its parameters in `nominal`.
    slots: Vec<usize>,
    /// Inertia in the frame of the shape.
    inertia_G: Inertia<f64>,
    /// The share that is a homogeneous solid.
    solid: Inertia<f64>,
}

impl Scaled {
    /// * `index` – that of the link in the description
    /// * `first` – index of its first parameter
    pub(super) fn new(
        choice: &ScaledLink,
        index: usize,
        link: &LinkSpec,
        first: usize,
        meshes: &mut dyn MeshSolids,
    ) -> Result<Self, EditError> {
        let cannot = |reason: String| EditError::CannotScale {
            link: choice.name.clone(),
            reason,
        };
        let (X_LG, geometry) = (choice.shape.of(link)).ok_or_else(|| cannot(no(choice.shape)))?;
        let mut inertia_G = X_LG.inverse().inertia(&link.inertia);
        let mut solid = Inertia::zero();
        let reads_volume = choice.dimensions.contains(&Dimension::Density)
            || choice.masses == MassDistribution::Homogeneous
            || matches!(geometry, Geometry::Capsule { .. });
        let mut nominal = sizes_of(geometry);
        if reads_volume && link.inertia.mass > 0.0 {
            let unit = solid_of(geometry, meshes).map_err(cannot)?;
            let density = link.inertia.mass / unit.mass;
            solid = unit.scaled(density);
            nominal.push(density);
        }
        if choice.masses == MassDistribution::Homogeneous {
            inertia_G = solid;
        }
        let slots = (choice.dimensions.iter())
            .map(|&wanted| slot(wanted, geometry, &nominal).map_err(|e| e.of(choice, geometry)));
        Ok(Self {
            link: index,
            X_LG: *X_LG,
            geometry: geometry.clone(),
            slots: slots.collect::<Result<_, _>>()?,
            nominal,
            range: first..first + choice.dimensions.len(),
            inertia_G,
            solid,
        })
    }

    /// Values of its parameters in the description.
    pub(super) fn nominal(&self) -> impl Iterator<Item = f64> {
        self.slots.iter().map(|&slot| self.nominal[slot])
    }

    /// Ratio of each parameter to its value in the description: sizes, then density.
    ///
    /// * `x` – all parameters
    fn ratios<T: Scalar>(&self, x: &[T]) -> Vec<T> {
        let n = dimensions_of(&self.geometry).len() + 1;
        let mut ratios = vec![T::one(); n];
        for (&slot, &x) in self.slots.iter().zip(&x[self.range.clone()]) {
            ratios[slot] = x / self.nominal[slot];
        }
        ratios
    }

    pub(super) fn stretch<T: Scalar>(&self, x: &[T]) -> Stretch<T> {
        Stretch::new(self.X_LG, &self.geometry, &self.ratios(x))
    }

    /// Inertia in the link.
    pub(super) fn inertia<T: Scalar>(&self, stretch: &Stretch<T>, x: &[T]) -> Inertia<T> {
        let density = self.ratios(x)[dimensions_of(&self.geometry).len()];
        stretch.inertia(&self.inertia_G, &self.solid, density)
    }

    /// Sizes of the shape at values of all parameters.
    pub(super) fn sizes(&self, x: &[f64]) -> Vec<f64> {
        let mut sizes = self.nominal.clone();
        for (&slot, &x) in self.slots.iter().zip(&x[self.range.clone()]) {
            sizes[slot] = x;
        }
        sizes.truncate(dimensions_of(&self.geometry).len());
        sizes
    }
}

/// Reason why a quantity of a link is not a parameter.
enum NoSlot {
    Unknown(Dimension),
    Zero(Dimension),
    NoMass,
}

impl NoSlot {
    fn of(self, choice: &ScaledLink, shape: &Geometry) -> EditError {
        let link = choice.name.clone();
        let reason = match self {
            Self::NoMass => return EditError::NoMass { link },
            Self::Unknown(wanted) => format!("its shape is {}, without {wanted}", noun(shape)),
            Self::Zero(wanted) => format!("the {wanted} of its shape, {}, is zero", noun(shape)),
        };
        EditError::CannotScale { link, reason }
    }
}

/// Index of a parameter among the sizes of a shape and the density.
fn slot(wanted: Dimension, shape: &Geometry, nominal: &[f64]) -> Result<usize, NoSlot> {
    let dimensions = dimensions_of(shape);
    let slot = match wanted {
        Dimension::Density => dimensions.len(),
        _ => (dimensions.iter().position(|own| *own == wanted)).ok_or(NoSlot::Unknown(wanted))?,
    };
    match nominal.get(slot) {
        None => Err(NoSlot::NoMass),
        Some(&0.0) => Err(NoSlot::Zero(wanted)),
        Some(_) => Ok(slot),
    }
}

fn no(shape: LinkShape) -> String {
    match shape {
        LinkShape::First => "it has no shape".into(),
        LinkShape::Visual(k) => format!("it has no visual shape {k}"),
        LinkShape::Collision(k) => format!("it has no collision shape {k}"),
    }
}

/// Inertia of a shape as a solid of density 1 in its own frame, or why there is none.
pub(in crate::model) fn solid_of(
    shape: &Geometry,
    meshes: &mut dyn MeshSolids,
) -> Result<Inertia<f64>, String> {
    let solid = match shape {
        Geometry::Mesh { uri, scale, .. } => {
            let unit = meshes.solid(shape);
            let unit =
                unit.map_err(|reason| format!("the mesh {} {reason}", short_reference(uri)))?;
            super::stretch::pushed(&unit, scale, scale.iter().product::<f64>().signum())
        }
        _ => shape
            .inertia(Mass::Density(1.0))
            .unwrap_or_else(Inertia::zero),
    };
    if solid.mass > 0.0 && solid.mass.is_finite() {
        Ok(solid)
    } else {
        Err(format!(
            "its shape, {}, has the volume {}",
            noun(shape),
            solid.mass
        ))
    }
}
