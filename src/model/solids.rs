//! Homogeneous solids: volume and inertia of shapes, and links that are a solid.

use std::f64::consts::PI;

use super::LinkSpec;
use super::parts::{Collision, Geometry, Visual};
use crate::scalar::{MapEach, Scalar};
use crate::spatial::{Inertia, Transform};

/// Mass of a solid, given directly or by its density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Mass {
    /// The mass, kg.
    Kilograms(f64),
    /// The density, kg/m³.
    Density(f64),
}

impl Mass {
    /// The mass of a volume, kg.
    fn of(self, volume: f64) -> f64 {
        match self {
            Self::Kilograms(mass) => mass,
            Self::Density(density) => density * volume,
        }
    }
}

/// Volume of a ball, in r³.
const BALL: f64 = 4.0 / 3.0 * PI;

/// Volume of a capsule, m³.
pub(super) fn capsule_volume<T: Scalar>(radius: T, length: T) -> T {
    radius * radius * (length * PI + radius * BALL)
}

impl Geometry {
    /// The volume, m³; `None` for a mesh, whose file is not read here: see [`inertia`](Self::inertia).
    pub(crate) fn volume(&self) -> Option<f64> {
        match *self {
            Self::Box { size: [x, y, z] } => Some(x * y * z),
            Self::Cylinder { radius, length } => Some(PI * radius * radius * length),
            Self::Capsule { radius, length } => Some(capsule_volume(radius, length)),
            Self::Sphere { radius } => Some(BALL * radius * radius * radius),
            Self::Ellipsoid { size: [x, y, z] } => Some(BALL / 8.0 * x * y * z),
            Self::Mesh { .. } => None,
        }
    }

    /// The inertia of a homogeneous solid of this shape in its own frame; `None` for a mesh, whose file is not read here.
    ///
    /// [`Hardware`](super::Hardware) computes inertias of closed meshes, with sizes and densities as design parameters, from a
    /// [`LinkShape`](super::LinkShape) of the mesh and a reader of its file, [`MeshSolids`](super::MeshSolids).
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::{Geometry, Mass};
    ///
    /// let cube = Geometry::Box { size: [0.1; 3] };
    /// let water = cube.inertia(Mass::Density(1000.0)).unwrap();
    /// assert!((water.mass - 1.0).abs() < 1e-15);
    /// ```
    pub fn inertia(&self, mass: Mass) -> Option<Inertia<f64>> {
        let mass = mass.of(self.volume()?);
        match *self {
            Self::Box { size } => Some(Inertia::solid_box(mass, size)),
            Self::Cylinder { radius, length } => {
                Some(Inertia::solid_cylinder(mass, radius, length))
            }
            Self::Capsule { radius, length } => Some(Inertia::solid_capsule(mass, radius, length)),
            Self::Sphere { radius } => Some(Inertia::solid_sphere(mass, radius)),
            // Of a box it is m (b² + c²) / 12 with the full lengths, of an ellipsoid m (b² + c²) / 20.
            Self::Ellipsoid { size } => {
                let side = (12.0_f64 / 20.0).sqrt();
                Some(Inertia::solid_box(mass, size.map_each(|x| x * side)))
            }
            Self::Mesh { .. } => None,
        }
    }
}

impl LinkSpec {
    /// A solid box with full edge lengths `size` (m), centred at the origin of the link, with visual and collision shape.
    ///
    /// # Examples
    /// ```
    /// use dualbody::model::{LinkSpec, Mass, ModelBuilder};
    ///
    /// let mut builder = ModelBuilder::new("brick");
    /// builder.add_link(LinkSpec::solid_box("brick", [0.2, 0.1, 0.05], Mass::Kilograms(2.0)));
    /// assert_eq!(builder.build()?.total_mass(), 2.0);
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn solid_box(name: impl Into<String>, size: [f64; 3], mass: Mass) -> Self {
        let inertia = Inertia::solid_box(mass.of(size.iter().product()), size);
        Self::new(name).with_solid(Geometry::Box { size }, inertia)
    }

    /// A solid ball, centred at the origin of the link, with visual and collision shape; radius in m.
    pub fn solid_sphere(name: impl Into<String>, radius: f64, mass: Mass) -> Self {
        let shape = Geometry::Sphere { radius };
        let inertia = Inertia::solid_sphere(mass.of(shape.volume().unwrap_or_default()), radius);
        Self::new(name).with_solid(shape, inertia)
    }

    /// A solid cylinder about z, centred at the origin of the link, with visual and collision shape; radius and full length in m.
    pub fn solid_cylinder(name: impl Into<String>, radius: f64, length: f64, mass: Mass) -> Self {
        let shape = Geometry::Cylinder { radius, length };
        let mass = mass.of(shape.volume().unwrap_or_default());
        Self::new(name).with_solid(shape, Inertia::solid_cylinder(mass, radius, length))
    }

    /// A solid capsule about z, centred at the origin of the link, with visual and collision shape; radius, and length of the cylinder without the
    /// hemispheres, in m.
    pub fn solid_capsule(name: impl Into<String>, radius: f64, length: f64, mass: Mass) -> Self {
        let shape = Geometry::Capsule { radius, length };
        let mass = mass.of(shape.volume().unwrap_or_default());
        Self::new(name).with_solid(shape, Inertia::solid_capsule(mass, radius, length))
    }

    fn with_solid(self, geometry: Geometry, inertia: Inertia<f64>) -> Self {
        self.with_inertia(inertia)
            .with_visual(Visual {
                name: None,
                placement: Transform::identity(),
                geometry: geometry.clone(),
                color: None,
            })
            .with_collision(Collision {
                name: None,
                placement: Transform::identity(),
                geometry,
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::UpAxis;
    use crate::tests::ROUNDING;

    const SHAPES: [Geometry; 5] = [
        Geometry::Ellipsoid {
            size: [0.3, 0.5, 0.7],
        },
        Geometry::Box {
            size: [1.0, 0.5, 0.2],
        },
        Geometry::Cylinder {
            radius: 0.3,
            length: 0.7,
        },
        Geometry::Capsule {
            radius: 0.3,
            length: 0.7,
        },
        Geometry::Sphere { radius: 0.4 },
    ];

    // m = ρ V, J of density ρ = J of mass ρ V.
    #[test]
    fn inertia_from_density_equals_inertia_from_mass() {
        const RHO: f64 = 700.0;
        for shape in SHAPES {
            let volume = shape.volume().unwrap();
            let from_density = shape.inertia(Mass::Density(RHO)).unwrap();
            let from_mass = shape.inertia(Mass::Kilograms(RHO * volume)).unwrap();
            assert_eq!(from_density, from_mass, "{shape:?}");
        }
    }

    #[test]
    fn volume_of_a_capsule_equals_cylinder_and_ball() {
        let [_, _, cylinder, capsule, _] = SHAPES.map(|shape| shape.volume().unwrap());
        let ball = Geometry::Sphere { radius: 0.3 }.volume().unwrap();
        assert!((capsule - cylinder - ball).abs() < ROUNDING);
    }

    #[test]
    fn solid_links_equal_the_inertia_of_their_shapes() {
        let mass = Mass::Density(500.0);
        for link in [
            LinkSpec::solid_box("box", [1.0, 0.5, 0.2], mass),
            LinkSpec::solid_cylinder("cylinder", 0.3, 0.7, mass),
            LinkSpec::solid_capsule("capsule", 0.3, 0.7, mass),
            LinkSpec::solid_sphere("sphere", 0.4, mass),
        ] {
            let shape = &link.visuals[0].geometry;
            assert_eq!(shape, &link.collisions[0].geometry);
            assert_eq!(shape.inertia(mass), Some(link.inertia), "{}", link.name);
        }
    }

    #[test]
    fn mesh_has_neither_volume_nor_inertia() {
        let mesh = Geometry::Mesh {
            uri: "hand.stl".into(),
            path: None,
            scale: [1.0; 3],
            up_axis: UpAxis::Auto,
        };
        assert_eq!(mesh.volume(), None);
        assert_eq!(mesh.inertia(Mass::Density(1.0)), None);
    }
}
