//! Contact with the ground: terrain, points, and the laws of force.
//!
//! [`Contacts`] says where a robot can touch which [`Terrain`] and by which law. Points come from the collision shapes of its links:
//!
//! | shape | points | on a plane |
//! |---|---|---|
//! | box | its corners | exact |
//! | sphere | the lowest point, which rolls | exact |
//! | capsule | the lowest points of its two end spheres | exact |
//! | cylinder | three points of each rim, one of them the lowest | exact |
//! | mesh | vertices of its convex hull, at most [`ContactOptions::mesh_points`] | exact for the hull, if it has not more |
//!
//! On curved ground spheres, capsules and cylinders that roll touch where they are nearest to it; see [`Contacts::states_into`] for the limits. A
//! circle of a cylinder that is tilted by less than a milliradian stands on three points that are fixed to it.
//!
//! [`Contacts::new`] and [`Contacts::with_options`] read the mesh files of these shapes, as [`io`](crate::io) does, where they are written;
//! [`Contacts::with_meshes`] takes vertices from elsewhere. A mesh file that is missing or damaged is reported by [`Contacts::untouched`].
//!
//! Laws know no robot: [`SoftContact`] gives a force for depth, velocity and deflection of a point; [`RelaxedRigid`] and [`Rigid`] say
//! which acceleration is wanted of it, and the solver in [`cone`] finds the forces of all points together. [`Smoothing`] gives rigid contact
//! forces and derivatives before it touches; [`Materials`] say which friction holds between which link and the ground.
//!
//! | question | answer | cost | reference |
//! |---|---|---|---|
//! | where can a robot touch? | [`Contacts::new`], [`Contacts::with_links`], [`Contacts::with_point`] | once; reads meshes | |
//! | which shapes have no points? | [`Contacts::untouched`] | | |
//! | on what ground? | [`Terrain`]: a plane, [`HeightField`], [`TerrainFunction`] | constant for each point | [de Boor 1978] |
//! | forces with gradients from touch-down on? | [`SoftContact`] | O(points); in [implicit steps](crate::Integrator::ImplicitVelocity) that of the solver | [Hunt, Crossley 1975]; [Azad, Featherstone 2010] |
//! | forces like those of `MuJoCo`? | [`RelaxedRigid`] | the solver's | [Todorov 2014] |
//! | forces that neither penetrate nor creep? | [`Rigid`] | the solver's, more of it | [De Saxcé & Feng 1998] |
//! | gradients before touch-down? | [`Contacts::with_smoothing`] | the solver's, with every point within reach | [Howell et al. 2022] |
//! | how exact are forces, how long are they looked for? | [`SolverOptions`], [`cone`] | O(rows³) an iteration; measured at [`SolverOptions`] | |
//! | which friction for which link? | [`Contacts::with_law`], [`Materials`] | | |
//! | where are the points, how fast, how do they depend on v? | [`Contacts::states`], [`Contacts::jacobian`] | O(points), O(depth) | |
//! | what happens at them, and why is a derivative zero? | [`Simulator::contact_report`](crate::Simulator::contact_report) | that of a step | |

mod candidates;
pub mod cone;
mod convex;
mod directions;
mod hull;
mod impedance;
mod kinematics;
mod material;
mod point;
mod rigid;
mod rolling;
mod shapes;
mod smoothing;
mod soft;
mod solver_options;
mod terrain;

pub(crate) use hull::hull;
pub use impedance::{Impedance, Sigmoid};
pub use kinematics::PointState;
pub(crate) use kinematics::each_column;
pub(crate) use material::bounded;
pub use material::{Material, Materials};
pub(crate) use point::body_force;
pub use point::{ContactPoint, Feature};
pub(crate) use rigid::{PointRows, is_at_rest};
pub use rigid::{Reference, RelaxedRigid, Rigid};
pub(crate) use rolling::Moving;
pub use shapes::{ContactOptions, MeshHulls, UntouchedShape};
pub use smoothing::Smoothing;
pub use soft::{HuntCrossley, SoftContact, SoftResponse};
pub(crate) use soft::{StepForce, step_of_bristle};
pub use solver_options::SolverOptions;
pub use terrain::{
    Ground, HeightField, HeightFunction, MAX_TERRAIN_PARAMETERS, Plane, Terrain, TerrainFunction,
};

use crate::error::UnknownName;
use crate::model::{Model, Structure};
use crate::scalar::{Over, Scalar};

/// Law of the contact force at a point. All points of a robot have laws of one kind; their numbers may differ from link to link.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum ContactLaw<P = f64> {
    /// Springs, dampers and bristles.
    Soft(SoftContact<P>),
    /// No penetration but what a convex problem lets through, as in `MuJoCo`.
    RelaxedRigid(RelaxedRigid<P>),
    /// No penetration, Coulomb's friction, impacts; with semi-implicit Euler.
    Rigid(Rigid<P>),
}

impl<P: Scalar> ContactLaw<P> {
    /// Converts the law to another scalar type.
    pub fn cast<Q: Over<P>>(&self) -> ContactLaw<Q> {
        match self {
            Self::Soft(law) => ContactLaw::Soft(law.cast()),
            Self::RelaxedRigid(law) => ContactLaw::RelaxedRigid(law.cast()),
            Self::Rigid(law) => ContactLaw::Rigid(law.cast()),
        }
    }

    fn name(&self) -> &'static str {
        match self {
            Self::Soft(_) => "soft",
            Self::RelaxedRigid(_) => "relaxed rigid",
            Self::Rigid(_) => "rigid",
        }
    }
}

/// Where a robot can touch the ground, and how it is answered.
#[derive(Clone, Debug)]
pub struct Contacts<P = f64> {
    terrain: Terrain<P>,
    points: Vec<ContactPoint<P>>,
    /// One for each point, all of one kind.
    laws: Vec<ContactLaw<P>>,
    /// `None` for the exact law.
    smoothing: Option<Smoothing>,
    solver: SolverOptions,
    untouched: Vec<UntouchedShape>,
    mesh_remarks: Vec<String>,
    /// Of the robot that they are for.
    structure: Structure,
}

impl Contacts<f64> {
    /// As [`with_options`](Self::with_options), with the vertices of meshes from elsewhere than files. Allocates.
    ///
    /// # Panics
    /// As [`new`](Self::new).
    ///
    /// # Examples
    /// ```
    /// use dualbody::Model;
    /// use dualbody::contact::{ContactLaw, ContactOptions, Contacts, MeshHulls, Rigid, Terrain};
    /// use dualbody::model::Geometry;
    ///
    /// /// A program's own meshes.
    /// struct Triangle([[f32; 3]; 3]);
    ///
    /// impl MeshHulls for Triangle {
    ///     fn vertices(&mut self, _: &Geometry) -> Result<&[[f32; 3]], String> {
    ///         Ok(&self.0)
    ///     }
    /// }
    ///
    /// let model = Model::from_urdf_str(r#"<robot name="plate"><link name="plate"><collision>
    ///   <geometry><mesh filename="plate"/></geometry></collision></link></robot>"#)?;
    /// let mut meshes = Triangle([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
    /// let law = ContactLaw::Rigid(Rigid::default());
    /// let contacts = Contacts::with_meshes(&model, Terrain::flat(0.0), law, &ContactOptions::default(), &mut meshes);
    /// assert_eq!(contacts.points().len(), 3);
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn with_meshes(
        model: &Model,
        terrain: Terrain,
        law: ContactLaw,
        options: &ContactOptions,
        meshes: &mut dyn MeshHulls,
    ) -> Self {
        law.check();
        terrain.check();
        let shapes = shapes::points_of(model, options, meshes);
        Self {
            laws: vec![law; shapes.points.len()],
            structure: model.structure(),
            terrain,
            points: shapes.points,
            smoothing: None,
            solver: SolverOptions::default(),
            untouched: shapes.untouched,
            mesh_remarks: meshes.remarks(),
        }
    }

    /// Keeps the points of these links only.
    ///
    /// # Errors
    /// If the model has no frame of a name.
    ///
    /// # Panics
    /// If the contacts are those of another robot.
    pub fn with_links(self, model: &Model, links: &[&str]) -> Result<Self, UnknownName> {
        self.check(model);
        let find = |name: &&str| model.find_frame(name);
        let links = links.iter().map(find).collect::<Result<Vec<_>, _>>()?;
        Ok(self.with_selection(|point| links.contains(&point.link)))
    }

    /// Keeps the points for which `keep` holds; the others are switched off.
    #[must_use]
    pub fn with_selection(mut self, keep: impl Fn(&ContactPoint) -> bool) -> Self {
        let kept: Vec<bool> = self.points.iter().map(keep).collect();
        let mut own = kept.iter();
        self.points.retain(|_| own.next() == Some(&true));
        let mut own = kept.iter();
        self.laws.retain(|_| own.next() == Some(&true));
        self
    }

    /// Adds a point with a law of its own, after the others.
    ///
    /// # Panics
    /// If the law is of another kind than those of the other points, if a number of it makes no sense, as in [`new`](Self::new), or one of
    /// the point: a centre or an angle that is not finite, a radius that is not positive, an axis that is no unit vector. Whether
    /// there are such a link and body is checked where a simulator takes the contacts.
    #[must_use]
    pub fn with_point(mut self, point: ContactPoint, law: ContactLaw) -> Self {
        self.check_kind(&law);
        point.check();
        law.check();
        self.points.push(point);
        self.laws.push(law);
        self
    }

    /// Gives the points of a link a law of their own: friction, stiffness and so on of this link against the ground.
    ///
    /// # Errors
    /// If the model has no frame of that name.
    ///
    /// # Panics
    /// If the law is of another kind than those of the other points, if a number of it makes no sense, as in [`new`](Self::new), or if the
    /// contacts are those of another robot.
    pub fn with_law(
        mut self,
        model: &Model,
        link: &str,
        law: ContactLaw,
    ) -> Result<Self, UnknownName> {
        self.check(model);
        self.check_kind(&law);
        law.check();
        let link = model.find_frame(link)?;
        for (point, own) in self.points.iter().zip(&mut self.laws) {
            if point.link == link {
                *own = law;
            }
        }
        Ok(self)
    }

    fn check_kind(&self, law: &ContactLaw) {
        if let Some(first) = self.laws.first() {
            let (first, other) = (first.name(), law.name());
            assert_eq!(first, other, "all points have laws of one kind");
        }
    }

    /// Collision shapes of the robot that have no points, with the reason.
    pub fn untouched(&self) -> &[UntouchedShape] {
        &self.untouched
    }

    /// Remarks on how mesh files were read, a sentence each: on those that were
    /// [turned](crate::model::UpAxis) so that z is up, seem to be cut off, or have so many points on their hull (more than 20,000) that some of
    /// them stand for all: of a ball these lack at most 0.2 % of the radius.
    pub fn mesh_remarks(&self) -> &[String] {
        &self.mesh_remarks
    }
}

impl<P: Scalar> Contacts<P> {
    /// The ground.
    pub fn terrain(&self) -> &Terrain<P> {
        &self.terrain
    }

    /// Replaces the ground.
    ///
    /// # Panics
    /// If a number of it is not finite.
    #[must_use]
    pub fn with_terrain(mut self, terrain: Terrain<P>) -> Self {
        terrain.check();
        self.terrain = terrain;
        self
    }

    /// Smooths rigid or relaxed rigid contact, so that it has gradients before points touch; without this call it is exact.
    ///
    /// # Panics
    /// If contact is soft: that has its own gradients from touch-down on, and a softer law reaches farther.
    #[must_use]
    pub fn with_smoothing(mut self, smoothing: Smoothing) -> Self {
        assert!(
            !self.are_soft(),
            "soft contact is smooth from touch-down on and cannot be smoothed further"
        );
        self.smoothing = Some(smoothing).filter(|smoothing| smoothing.kappa() > 0.0);
        self
    }

    /// Smoothing of rigid contact; `None` where it is exact, and for soft contact.
    pub fn smoothing(&self) -> Option<Smoothing> {
        self.smoothing.filter(|_| !self.are_soft())
    }

    /// The points, link after link.
    pub fn points(&self) -> &[ContactPoint<P>] {
        &self.points
    }

    /// The law of each point.
    pub fn laws(&self) -> &[ContactLaw<P>] {
        &self.laws
    }

    /// Returns the contacts with other numbers of the points, one for each point, and the same laws and ground: over dual numbers, for
    /// derivatives in where they are and how large, as in the length of a leg with a foot at its end.
    ///
    /// # Panics
    /// If there are not as many, if one is on another link or of another kind of feature, or if a number of one makes no sense, as in
    /// [`new`](Self::new).
    pub fn with_points<Q: Over<P>>(&self, points: &[ContactPoint<Q>]) -> Contacts<Q> {
        let (given, own) = (points.len(), self.points.len());
        assert_eq!(given, own, "as many points as there are");
        for (k, (point, own)) in points.iter().zip(&self.points).enumerate() {
            let stays = (point.link, point.body) == (own.link, own.body) && point.is_like(own);
            assert!(stays, "point {k} stays on its link, and of its kind");
            point.check();
        }
        Contacts {
            points: points.to_vec(),
            ..self.cast()
        }
    }

    /// Returns the contacts with other laws, one for each point, and the same points and ground: over dual numbers, for derivatives in
    /// their parameters.
    ///
    /// # Panics
    /// If there are not as many as points, if they are of different kinds, or if a number of one makes no sense, as in [`new`](Self::new).
    pub fn with_laws<Q: Over<P>>(&self, laws: &[ContactLaw<Q>]) -> Contacts<Q> {
        assert_eq!(laws.len(), self.points.len(), "a law for each point");
        let one_kind = laws.iter().all(|law| law.name() == laws[0].name());
        assert!(one_kind, "all points have laws of one kind");
        laws.iter().for_each(ContactLaw::check);
        Contacts {
            laws: laws.to_vec(),
            ..self.cast()
        }
    }

    /// Converts the contacts to another scalar type.
    pub fn cast<Q: Over<P>>(&self) -> Contacts<Q> {
        Contacts {
            terrain: self.terrain.cast(),
            points: self.points.iter().map(ContactPoint::cast).collect(),
            laws: self.laws.iter().map(ContactLaw::cast).collect(),
            smoothing: self.smoothing,
            solver: self.solver,
            untouched: self.untouched.clone(),
            mesh_remarks: self.mesh_remarks.clone(),
            structure: self.structure,
        }
    }

    /// # Panics
    /// If they are those of another robot than `model`, or a point is on a link or body that there is not.
    pub(crate) fn check<M: Scalar>(&self, model: &Model<M>) {
        self.structure.check(model, "the contacts");
        for (i, point) in self.points.iter().enumerate() {
            let link = model.frame_of(point.link);
            assert!(
                link.body == Some(point.body),
                "point {i} of contact is on body {}, but its link \"{}\" is not",
                point.body.0,
                link.name
            );
        }
    }

    /// Whether the law of the points is the rigid one, and not smoothed.
    pub(crate) fn are_exactly_rigid(&self) -> bool {
        self.smoothing.is_none() && matches!(self.laws.first(), Some(ContactLaw::Rigid(_)))
    }

    /// Whether the law of the points is the soft one.
    pub(crate) fn are_soft(&self) -> bool {
        matches!(self.laws.first(), Some(ContactLaw::Soft(_)))
    }

    /// Number of entries of [`State::contact`](crate::State) that the contacts need: three for each bristle.
    pub fn n_states(&self) -> usize {
        let soft = |law: &&ContactLaw<P>| matches!(law, ContactLaw::Soft(_));
        3 * self.laws.iter().filter(soft).count()
    }
}
