//! Contacts of a robot: points, contact models, terrain and settings.

use std::mem::discriminant;

use super::laws::{ContactLaw, ROWS};
use super::material::Materials;
use super::part::ContactPart;
use super::point::ContactPoint;
use super::point_laws::PointLaws;
use super::shape_pairs::ShapePairs;
use super::shapes::{ContactOptions, MeshHulls, ShapeWithoutPoints, points_of};
use super::smoothing::Smoothing;
use super::solver_options::SolverOptions;
use super::terrain::Terrain;
use super::turning::TurningFriction;
use crate::error::{OutOfMemory, UnknownName};
use crate::memory;
use crate::model::{FrameId, Generation, Model, Structure};
use crate::numbers::{Domain, EachIn, Numbers, of};
use crate::scalar::{Cast, Over, Scalar};

/// The contact points of a robot, their contact models, and the terrain.
#[derive(Clone, Debug)]
pub struct Contacts<P = f64> {
    terrain: Terrain<P>,
    points: Vec<ContactPoint<P>>,
    /// Of the points, then that of pairs of shapes, if there are any.
    laws: PointLaws<P>,
    pairs: ShapePairs<P>,
    /// `None` for the exact law.
    smoothing: Option<Smoothing>,
    solver: SolverOptions,
    shapes_without_points: Vec<ShapeWithoutPoints>,
    mesh_remarks: Vec<String>,
    /// Of the robot that they are for.
    structure: Structure,
    /// Of the numbers of points, laws and ground.
    generation: Generation,
}

impl Contacts<f64> {
    /// Makes contact points for all collision shapes of a robot on a terrain, with one contact model. Reads meshes with the feature `formats`. Allocates.
    ///
    /// Meshes may give hundreds of points: for walking, [`with_links`](Self::with_links) keeps those of the feet. A mesh that cannot be read has no
    /// points, and the robot falls through the ground there: check [`shapes_without_points`](Self::shapes_without_points).
    ///
    /// # Panics
    /// If a parameter of the contact model or of the terrain is out of range: friction negative or NaN, restitution or an impedance outside 0..1, a
    /// time, width or ratio not positive, stiffness, damping or an exponent negative, a height not finite. If the points would need more memory than
    /// the [limit](crate::memory).
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Model, contact::{ContactLaw, Contacts, SoftContact, Terrain}};
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let model = Model::from_urdf_file(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/box.urdf"))?;
    /// let law = ContactLaw::Soft(SoftContact::estimate(model.total_mass(), 4, 1e-3));
    /// let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    /// assert_eq!(contacts.points().len(), 8);
    /// # Ok(())
    /// # }
    /// ```
    pub fn new(model: &Model, terrain: Terrain, law: ContactLaw) -> Self {
        memory::granted(Self::with_options(
            model,
            terrain,
            law,
            &ContactOptions::default(),
        ))
    }

    /// As [`with_options`](Self::with_options), with mesh vertices from the caller instead of files. Allocates.
    ///
    /// # Panics
    /// As [`new`](Self::new), and if the points would need more memory than the [limit](crate::memory): [`with_meshes`](Self::with_meshes).
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
    /// assert_eq!(contacts?.points().len(), 3);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_meshes(
        model: &Model,
        terrain: Terrain,
        law: ContactLaw,
        options: &ContactOptions,
        meshes: &mut dyn MeshHulls,
    ) -> Result<Self, OutOfMemory> {
        law.check();
        terrain.check_numbers();
        let shapes = points_of(model, options, meshes)?;
        Ok(Self {
            laws: PointLaws::repeated(law, shapes.points.len()),
            structure: model.structure(),
            terrain,
            points: shapes.points,
            pairs: ShapePairs::none(),
            smoothing: None,
            solver: SolverOptions::default(),
            shapes_without_points: shapes.shapes_without_points,
            mesh_remarks: meshes.remarks(),
            generation: Generation::next(),
        })
    }

    /// Keeps only the points of these links. The other links pass through the ground.
    ///
    /// # Errors
    /// If the model has no frame with this name.
    ///
    /// # Panics
    /// If the contacts are those of another robot.
    pub fn with_links(self, model: &Model, links: &[&str]) -> Result<Self, UnknownName> {
        self.check(model);
        let find = |name: &&str| model.find_frame(name);
        let links = links.iter().map(find).collect::<Result<Vec<_>, _>>()?;
        Ok(self.with_selection(|point| links.contains(&point.link)))
    }

    /// Keeps only the points for which `keep` returns `true`.
    #[must_use]
    pub fn with_selection(mut self, keep: impl Fn(&ContactPoint) -> bool) -> Self {
        let kept: Vec<bool> = self.points.iter().map(keep).collect();
        let mut own = kept.iter();
        self.points.retain(|_| own.next() == Some(&true));
        self.generation = Generation::next();
        self.laws.retain(&kept);
        self
    }

    /// Adds a point with its own contact model, after the others.
    ///
    /// # Panics
    /// If the contact model differs in kind from that of the other points, or a parameter is out of range, as in [`new`](Self::new). If a centre or
    /// an angle of the point is not finite, a radius is not positive, or an axis is not a unit vector.
    /// [`Simulator::with_contacts`](crate::Simulator::with_contacts) checks that link and body exist.
    #[must_use]
    pub fn with_point(mut self, point: ContactPoint, law: ContactLaw) -> Self {
        point.check();
        self.laws.insert(self.points.len(), law);
        self.points.push(point);
        self.generation = Generation::next();
        self
    }

    /// Sets the contact model of the points of a link: friction, stiffness and so on of this link against the ground.
    ///
    /// # Errors
    /// If the model has no frame of that name.
    ///
    /// # Panics
    /// If the contact model differs in kind from that of the other points, if a parameter is out of range as in [`new`](Self::new), or if the
    /// contacts belong to another robot.
    pub fn with_law(
        mut self,
        model: &Model,
        link: &str,
        law: ContactLaw,
    ) -> Result<Self, UnknownName> {
        self.check(model);
        let link = model.find_frame(link)?;
        let is_own = on_link(&self.points, link);
        self.laws.replace(law, is_own);
        self.generation = Generation::next();
        Ok(self)
    }

    /// Sets torsional and rolling friction of the points of a link against the ground. Between bodies they are properties of
    /// [materials](super::Material), or those [of all pairs](super::CollisionOptions::turning).
    ///
    /// # Errors
    /// If the model has no frame of that name.
    ///
    /// # Panics
    /// If a coefficient is negative or not finite, or the contacts belong to another robot.
    pub fn with_turning_friction(
        mut self,
        model: &Model,
        link: &str,
        turning: TurningFriction,
    ) -> Result<Self, UnknownName> {
        self.check(model);
        turning.check_numbers();
        let link = model.find_frame(link)?;
        let is_own = on_link(&self.points, link);
        self.laws.set_turning(turning, is_own);
        self.generation = Generation::next();
        Ok(self)
    }

    /// Sets the height above the ground at which contact of the points of a link begins, m: their depth counts from there. Between bodies it is a property of
    /// [materials](super::Material::margin).
    ///
    /// # Errors
    /// If the model has no frame of that name.
    ///
    /// # Panics
    /// If the margin is negative or not finite, or the contacts belong to another robot.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{Simulator, contact::{ContactLaw, Contacts, Rigid, Terrain}};
    ///
    /// let model = dualbody::Model::from_urdf_file(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/sphere.urdf"))?;
    /// let contacts = Contacts::new(&model, Terrain::flat(0.0), ContactLaw::Rigid(Rigid::default()));
    /// let contacts = contacts.with_margin(&model, model.link_names()[0], 0.02)?;
    /// let simulator = Simulator::new(model).with_contacts(contacts);
    /// let mut state: dualbody::State = simulator.neutral_state();
    /// state.q[2] = 0.12; // 2 cm above the ground, at rest
    /// assert!(simulator.step(&state, &[]).v.norm() < 1e-12);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_margin(
        mut self,
        model: &Model,
        link: &str,
        margin: f64,
    ) -> Result<Self, UnknownName> {
        self.check(model);
        let own = model.find_frame(link)?;
        let phrase = format_args!("the margin {margin} m of link \"{link}\"");
        Domain::NotNegative.hold(phrase, margin);
        self.laws.set_margin(margin, on_link(&self.points, own));
        self.generation = Generation::next();
        Ok(self)
    }

    /// Collision shapes of the robot that have no points, with the reason.
    pub fn shapes_without_points(&self) -> &[ShapeWithoutPoints] {
        &self.shapes_without_points
    }

    /// Remarks on mesh files, one sentence each: files that were [rotated](crate::model::UpAxis) so that z points up, that seem to be truncated, or
    /// whose hull has more than 20,000 points, of which a subset is used (for a ball the error is at most 0.2 % of the radius).
    pub fn mesh_remarks(&self) -> &[String] {
        &self.mesh_remarks
    }
}

impl Contacts<f64> {
    /// Sets the shapes that can touch each other, with the law of all pairs.
    pub(super) fn set_shape_pairs(
        &mut self,
        pairs: ShapePairs<f64>,
        law: ContactLaw,
        turning: TurningFriction,
    ) {
        let n = self.points.len();
        self.laws.truncate(n);
        self.laws.push(law);
        self.laws.set_turning(turning, |point| point == n);
        self.pairs = pairs;
        self.generation = Generation::next();
    }

    pub(super) fn add_shapes_without_points(&mut self, shapes: Vec<ShapeWithoutPoints>) {
        self.shapes_without_points.extend(shapes);
    }
}

/// Whether the point of an index is one of a link.
fn on_link<P>(points: &[ContactPoint<P>], link: FrameId) -> impl Fn(usize) -> bool {
    move |i| points.get(i).is_some_and(|point| point.link == link)
}

impl<P: Scalar> Contacts<P> {
    /// The ground.
    pub fn terrain(&self) -> &Terrain<P> {
        &self.terrain
    }

    /// The ground, mutable.
    pub(crate) fn terrain_mut(&mut self) -> &mut Terrain<P> {
        self.generation = Generation::next();
        &mut self.terrain
    }

    /// Replaces the ground.
    ///
    /// # Panics
    /// If one of its parameters is not finite.
    #[must_use]
    pub fn with_terrain(mut self, terrain: Terrain<P>) -> Self {
        terrain.check_numbers();
        self.terrain = terrain;
        self.generation = Generation::next();
        self
    }

    /// Smooths rigid or regularised rigid contact, so that it has gradients before points touch; without this call contact is exact.
    ///
    /// # Panics
    /// If contact is soft: soft contact already has gradients from touch-down on; use a softer one instead.
    #[must_use]
    pub fn with_smoothing(mut self, smoothing: Smoothing) -> Self {
        if let Some(kind) = self.laws.kind() {
            assert!(
                kind.can_be_smoothed,
                "{} contact is smooth from touch-down on and cannot be smoothed further",
                kind.name
            );
        }
        self.smoothing = Some(smoothing).filter(|smoothing| smoothing.kappa() > 0.0);
        self.generation = Generation::next();
        self
    }

    /// Smoothing of rigid contact; `None` for exact and for soft contact.
    pub fn smoothing(&self) -> Option<Smoothing> {
        let exact = self.laws.kind().is_some_and(|kind| !kind.can_be_smoothed);
        self.smoothing.filter(|_| !exact)
    }

    /// Sets the options of the solver of the contact forces.
    ///
    /// # Panics
    /// If the tolerance is not positive and finite, or the number of iterations or points is zero.
    #[must_use]
    pub fn with_solver_options(mut self, options: SolverOptions) -> Self {
        options.check();
        self.solver = options;
        self
    }

    /// Options of the solver of the contact forces.
    pub fn solver_options(&self) -> SolverOptions {
        self.solver
    }

    /// Sets the materials of the ground and of some links. The contact models of these links take friction, margin, for rigid contact restitution, and for the others
    /// [compliance](super::Compliance), if given, from the pair of materials. Other links keep their contact models.
    ///
    /// * `ground` – the material of the ground
    /// * `links` – name of link and material
    ///
    /// # Errors
    /// If the model has no frame, or the table no material, of a given name.
    ///
    /// # Panics
    /// If the contacts are those of another robot, or the compliance of a pair is for another contact model.
    ///
    /// # Examples
    /// ```
    /// use dualbody::contact::{ContactLaw, Contacts, Material, Materials, Rigid, Terrain};
    ///
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let model = dualbody::Model::from_urdf_file(concat!(env!("CARGO_MANIFEST_DIR"), "/assets/quadruped.urdf"))?;
    /// let materials = Materials::default()
    ///     .with_material("rubber", Material { friction: 0.9, restitution: 0.6, ..Material::default() })
    ///     .with_material("ice", Material { friction: 0.1, restitution: 0.1, ..Material::default() });
    /// let contacts = Contacts::new(&model, Terrain::flat(0.0), ContactLaw::Rigid(Rigid::default()))
    ///     .with_links(&model, &["FR_foot", "FL_foot"])?
    ///     .with_materials(&model, &materials, "ice", &[("FR_foot", "rubber")])?;
    /// let ContactLaw::Rigid(foot) = contacts.laws()[0] else { panic!("rigid") };
    /// assert!((foot.friction - 0.18).abs() < 1e-15); // 2 · 0.9 · 0.1 / 1
    /// # Ok(())
    /// # }
    /// ```
    pub fn with_materials<M: Scalar>(
        mut self,
        model: &Model<M>,
        materials: &Materials,
        ground: &str,
        links: &[(&str, &str)],
    ) -> Result<Self, UnknownName> {
        self.check(model);
        for (link, material) in links {
            let pair = materials.between(material, ground)?;
            let link = model.find_frame(link)?;
            let is_own = on_link(&self.points, link);
            let pair = pair.map_numbers(&mut |x| P::constant(x));
            if let Some(law) = self.laws.first() {
                law.check_compliance(&pair);
            }
            self.laws.set_material(pair, is_own);
        }
        self.generation = Generation::next();
        Ok(self)
    }

    /// Checks the memory for the largest force problem of a step. It grows with the square of [`SolverOptions::points`], or of the number of points
    /// if that is smaller.
    ///
    /// # Errors
    /// If it would need more memory than the [limit](crate::memory). [`Simulator::with_contacts`](crate::Simulator::with_contacts) panics with this message.
    ///
    /// # Examples
    /// ```
    /// use dualbody::{contact::{ContactLaw, Contacts, Rigid, Terrain}, model::samples};
    ///
    /// let contacts = Contacts::new(&samples::cartpole(), Terrain::flat(0.0), ContactLaw::Rigid(Rigid::default()));
    /// assert!(contacts.check_memory().is_ok());
    /// ```
    pub fn check_memory(&self) -> Result<(), OutOfMemory> {
        /// Of the rows of a step, its equations, and their factors.
        const MATRICES: usize = 3;
        let points = self.points.len().min(self.solver.points);
        let rows = points.saturating_mul(self.rows_of_each());
        let bytes = rows.saturating_mul(rows);
        let bytes = bytes.saturating_mul(MATRICES * size_of::<f64>());
        memory::check(
            format_args!("forces of {points} contact points in a step"),
            bytes,
        )
    }

    /// The points, link by link.
    pub fn points(&self) -> &[ContactPoint<P>] {
        &self.points
    }

    /// The contact model of each point.
    pub fn laws(&self) -> &[ContactLaw<P>] {
        &self.laws.as_slice()[..self.points.len()]
    }

    /// Torsional and rolling friction of a point with the ground.
    pub(super) fn point_turning(&self, point: usize) -> TurningFriction<P> {
        self.laws.turning(point)
    }

    /// Torsional and rolling friction between bodies, without their materials.
    pub(super) fn turning_of_pairs(&self) -> TurningFriction<P> {
        self.laws.turning(self.points.len())
    }

    /// The contact model between bodies, without their materials.
    ///
    /// # Panics
    /// If there is no contact between bodies.
    pub(super) fn law_of_pairs(&self) -> &ContactLaw<P> {
        &self.laws.as_slice()[self.points.len()]
    }

    /// The shapes that can touch each other.
    pub(super) fn shape_pairs(&self) -> &ShapePairs<P> {
        &self.pairs
    }

    /// Returns the contacts with other parameters of all points, and the same contact models and ground: over dual numbers, for derivatives in
    /// positions and radii, for example in the length of a leg that moves its foot.
    ///
    /// # Panics
    /// If the number of points differs, a point is on another link or has another kind of feature, or a parameter is out of range as in
    /// [`with_point`](Self::with_point).
    pub fn with_points<Q: Over<P>>(&self, points: &[ContactPoint<Q>]) -> Contacts<Q> {
        let (given, own) = (points.len(), self.points.len());
        assert_eq!(
            given, own,
            "number of contact points, which must stay the same"
        );
        for (k, (point, own)) in points.iter().zip(&self.points).enumerate() {
            let own = own.cast::<Q>();
            let is_alike = discriminant(&point.feature) == discriminant(&own.feature);
            let stays = (point.link, point.body) == (own.link, own.body) && is_alike;
            assert!(
                stays,
                "contact point {k} must stay on its link, and must stay of its kind"
            );
            point.check();
        }
        Contacts {
            points: points.to_vec(),
            ..self.cast()
        }
    }

    /// Returns the contacts with other contact models, one for each point, and the same points and ground: over dual numbers, for derivatives in
    /// their parameters.
    ///
    /// # Panics
    /// If their number differs from that of the points, if they differ in kind, or if a parameter is out of range as in [`new`](Self::new).
    pub fn with_laws<Q: Over<P>>(&self, laws: &[ContactLaw<Q>]) -> Contacts<Q> {
        assert_eq!(
            laws.len(),
            self.points.len(),
            "a contact model for each point"
        );
        let of_pairs = self.laws.as_slice()[self.points.len()..].iter();
        let of_pairs = of_pairs.map(|law| law.lift());
        let laws = PointLaws::new(laws.iter().copied().chain(of_pairs).collect());
        Contacts {
            laws: laws.with_rest_of(&self.laws),
            ..self.cast()
        }
    }

    /// Identity of the parameters of points, contact models and ground, for working memory with derived data.
    pub(crate) fn generation(&self) -> Generation {
        self.generation
    }

    /// Passes each parameter of points, contact models and ground with its owner and name to `each`.
    pub(crate) fn each_number(&mut self, each: &mut EachIn<'_, ContactPart, P>) {
        self.generation = Generation::next();
        for (i, point) in self.points.iter_mut().enumerate() {
            point.each_number(&mut of(ContactPart::Point(i), each));
        }
        let n = self.points.len();
        for i in 0..n {
            (self.laws).each_number_of(i, [ContactPart::Law(i), ContactPart::Turning(i)], each);
            self.laws.each_margin_of(i, ContactPart::Margin(i), each);
        }
        self.terrain
            .each_number(&mut of(ContactPart::Terrain, each));
        self.pairs.each_number(each);
        self.pairs.each_given_number(each);
        (self.laws).each_number_of(n, [ContactPart::PairLaw, ContactPart::PairTurning], each);
    }

    /// # Panics
    /// If they belong to another robot than `model`, or a point is on a link or body that there is not.
    pub(crate) fn check<M: Scalar>(&self, model: &Model<M>) {
        self.structure.check(model, "the contacts");
        for (i, point) in self.points.iter().enumerate() {
            let link = model.frame_of(point.link);
            assert!(
                link.body == Some(point.body),
                "contact point {i} is on body {}, but its link \"{}\" is not",
                point.body.0,
                link.name
            );
        }
    }

    /// Number of entries of [`State::contact`](crate::State) that the contacts need: three for each bristle.
    pub(crate) fn n_states(&self) -> usize {
        let bristle = self.laws.kind().is_some_and(|kind| kind.bristle);
        if bristle { ROWS * self.points.len() } else { 0 }
    }

    /// Laws of the points, all of one kind.
    pub(super) fn point_laws(&self) -> &PointLaws<P> {
        &self.laws
    }
}

impl<P: Scalar> Cast<P> for Contacts<P> {
    type To<Q: Scalar> = Contacts<Q>;

    fn cast<Q: Over<P>>(&self) -> Contacts<Q> {
        Contacts {
            terrain: self.terrain.cast(),
            points: self.points.lift(),
            laws: self.laws.lift(),
            pairs: self.pairs.cast(),
            smoothing: self.smoothing,
            solver: self.solver,
            shapes_without_points: self.shapes_without_points.clone(),
            mesh_remarks: self.mesh_remarks.clone(),
            structure: self.structure,
            generation: Generation::next(),
        }
    }
}
