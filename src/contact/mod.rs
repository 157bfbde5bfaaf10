//! Contact with the ground and between bodies: terrain, contact points, and contact models.
//!
//! [`Contacts`] contains the contact points of a robot, their contact models and the [`Terrain`]. Points come from the collision shapes of the links:
//!
//! | shape | points | on a plane |
//! |---|---|---|
//! | box | its corners | exact |
//! | sphere | the lowest point, which rolls | exact |
//! | capsule | the lowest points of its two end spheres | exact |
//! | cylinder | three points of each rim, one of them the lowest | exact |
//! | mesh | vertices of its convex hull, at most [`ContactOptions::mesh_points`] | exact for hulls with at most that many vertices |
//!
//! On curved ground, spheres, capsules and rolling cylinders touch at their nearest point; see [`Contacts::states_into`] for the limits. The circle
//! of a cylinder that is tilted by less than a milliradian has three contact points that are fixed to it.
//!
//! [`Contacts::new`] and [`Contacts::with_options`] read the mesh files of these shapes, with the functions of [`io`](crate::io);
//! [`Contacts::with_meshes`] takes vertices from the caller. [`Contacts::shapes_without_points`] lists missing or damaged mesh files.
//!
//! Contact models do not depend on the robot. [`SoftContact`] computes a force from depth, velocity and deflection of a point. [`RelaxedRigid`] and
//! [`Rigid`] define its reference acceleration, and the solver in [`cone`](crate::cone) finds the forces of all points together. [`Smoothing`] adds
//! forces and derivatives of rigid contact before touch-down; [`Materials`] define the friction between links and the ground.
//!
//! | question | answer | cost | reference |
//! |---|---|---|---|
//! | where can a robot touch? | [`Contacts::new`], [`Contacts::with_links`], [`Contacts::with_point`] | once; reads meshes | |
//! | contact points for other link sizes? | [`Contacts::with_hardware`] | O(links) | |
//! | which shapes have no points? | [`Contacts::shapes_without_points`] | | |
//! | which ground? | [`Terrain`]: a plane, [`HeightField`], [`TerrainFunction`] | constant for each point | [de Boor 1978] |
//! | forces with gradients from touch-down on? | [`SoftContact`] | O(points); in [implicit steps](crate::Integrator::ImplicitVelocity) also the solver | [Hunt, Crossley 1975]; [Azad, Featherstone 2010] |
//! | damping for a restitution, duration of an impact? | [`SoftContact::with_restitution`], [`HuntCrossley::restitution`], [`HuntCrossley::impact_time`] | closed forms | [Hunt, Crossley 1975] |
//! | is the step short enough for it? | [`Simulator::remarks`](crate::Simulator::remarks) | O(points · nv²) | |
//! | bodies that touch each other? | [`Contacts::with_collisions`], [`CollisionOptions`] | O(n log n) for pairs of n shapes; solver | |
//! | ground meshes, materials, fast and thin bodies? | [`CollisionOptions::with_surface`], [`CollisionOptions::with_material`], [`CollisionOptions::with_speculative_contact`] | O(log n) a step for n triangles, and time for those that are near | |
//! | forces like those of `MuJoCo`? | [`RelaxedRigid`] | solver | [Todorov 2014] |
//! | forces that neither penetrate nor creep? | [`Rigid`] | solver, more iterations | [De Saxcé & Feng 1998] |
//! | gradients before touch-down? | [`Contacts::with_smoothing`] | solver, with every point within reach | [Howell et al. 2022] |
//! | accuracy and iterations of the solver? | [`SolverOptions`], [`cone`](crate::cone) | O(rows³) an iteration; measured at [`SolverOptions`] | |
//! | soft fingers, rolling resistance of wheels? | [`TurningFriction`], [`Contacts::with_turning_friction`], [`Material`] | up to three more rows a point | |
//! | which friction for which link? | [`Contacts::with_law`], [`Materials`] | | |
//! | positions, velocities and Jacobians of the points? | [`Contacts::states`], [`Contacts::jacobian`] | O(points), O(depth) | |
//! | links in contact, frames at the points, their Jacobians and rates? | [`Contacts::links_in_contact`], [`Contacts::frames`], [`Contacts::frame_jacobians`], [`Contacts::frame_jacobian_derivatives`] | O(points · depth) | |
//! | distance of two links, nearest points, gradient? | [`nearest`], [`LinkShapes::nearest_into`] | O(shapes²) of the two links | [Gilbert, Johnson, Keerthi 1988] |
//! | distances that are smooth where nearest features switch? | [`LinkShapes::with_smoothing`] | some steps of Newton's method | |
//! | which links can touch each other? | [`LinkShapes::pairs`], [`LinkShapes::touching`], [`LinkShapes::exclude`] | O(n log n) | |
//! | what happens at a contact point, and why is a derivative zero? | [`Simulator::contact_report`](crate::Simulator::contact_report) | that of a step | |

mod activation;
mod compliance;
mod contacts;
mod frames;
mod hardware;
mod kinematics;
mod laws;
mod link_pairs;
mod link_shapes;
mod material;
mod moments;
mod nearest;
mod pairs;
mod part;
mod point;
mod point_laws;
mod point_state;
pub(crate) mod reason;
mod relations;
mod rolling;
mod shape_pairs;
mod shapes;
mod smoothing;
mod soft_distance;
mod solver_options;
mod step;
mod terrain;
mod turning;
#[cfg(not(feature = "formats"))]
mod without_files;

pub use crate::constraint::{Impedance, Reference, Sigmoid};
pub(crate) use compliance::COMPLIANCE_NUMBERS;
pub use compliance::Compliance;
pub use contacts::Contacts;
pub(crate) use frames::AttachedFrame;
pub(crate) use kinematics::{BodyPoint, each_jacobian_column, each_turning_column};
pub use laws::*;
pub use link_pairs::LinkPairs;
pub use link_shapes::{LinkShape, LinkShapes};
pub use material::{Material, Materials};
pub(crate) use moments::Turning;
pub use nearest::{Nearest, NearestError, nearest};
pub use pairs::CollisionOptions;
pub(crate) use pairs::{FoundPairs, PairFinder, PairPoint, PairState};
pub(crate) use part::{ContactPart, MaterialOf};
pub use point::{ContactPoint, Feature};
pub(crate) use point::{POINT_NUMBERS, body_force, velocity_at};
pub use point_state::PointState;
pub(crate) use rolling::BodyMotion;
pub(crate) use shape_pairs::{MATERIAL_NUMBERS, SHAPE_NUMBERS, TURNING_NUMBERS};
pub use shapes::{ContactOptions, MeshHulls, NoMeshes, ShapeWithoutPoints};
pub use smoothing::Smoothing;
pub use solver_options::SolverOptions;
pub(crate) use terrain::PLANE_NUMBERS;
pub use terrain::{
    Ground, HeightField, HeightFunction, MAX_TERRAIN_PARAMETERS, Plane, Terrain, TerrainFunction,
};
pub use turning::TurningFriction;
