//! Detection of singular mass matrices: joints whose motion no inertia resists.
//!
//! Joints are eliminated from the leaves to the root, as in the articulated-body algorithm. The pivot of an axis is the inertia that resists it while
//! all joints of its subtree move freely, so a zero pivot identifies the joint. The check uses values at one generic configuration. Its result holds
//! for all configurations except those with aligned axes (a universal joint with a massless cross at a right angle).

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use nalgebra::{DMatrix, Matrix6, Vector6};

use super::crba::mass_matrix;
use crate::error::{SingularMassMatrix, UnresistedJoint};
use crate::joint::Axis;
use crate::model::{Body, BodyId, Model};
use crate::nested::IntoNested;
use crate::scalar::{MapEach, Scalar, from_each};
use crate::sorting::sort_seldom;
use crate::spatial::{Inertia, Motion, SPATIAL, Symmetric3, Transform};

/// Part of the inertia of all bodies behind a joint, locked, below which what resists with them free is taken for the rounding of the differences
/// that lead there: some hundred roundings. A link of so little inertia by itself, without rounding, counts as solid.
const ROUNDING: f64 = 1e-13;

/// Part of the moments of inertia of all bodies behind a joint, summed over three axes, below which that about its own axis is the rounding of the
/// turn to it: a rod on its own axis, tilted.
const TURNED: f64 = 1e-14;

/// Inertia whose inverse times anything overflows, kg·m² or kg.
const VANISHING: f64 = 1e-100;

/// Part of the moments about the origin above which moments about the centre of mass are not the rounding of their difference.
const CLEARLY_SOLID: f64 = 1e-9;

/// Most coordinates of a robot with mimic joints whose mass matrix is formed to decide: a third of a billion products.
const MAX_DENSE: usize = 1000;

impl<P: Scalar> Model<P> {
    /// Checks that inertia resists the motion of all joints, so that the mass matrix is positive definite at (almost) all configurations.
    ///
    /// Robots that fail this check can be loaded, because [kinematics, inverse dynamics and the mass matrix](crate::dynamics) are correct.
    /// [`Simulator::new`](crate::Simulator::new) and the working memory of forward dynamics call this function and panic with its message. Rotor
    /// inertia ([`armature`](Self::armature)) also resists motion. At exceptional configurations with aligned axes, a mass matrix may still be
    /// singular.
    ///
    /// Cost: linear in the number of bodies, without allocation if all bodies are solid; O(nv³) if some are not and there are mimic joints. In such
    /// robots with more than 1,000 degrees of freedom, mimic joints are treated as independent.
    ///
    /// # Errors
    /// Lists all joints without inertia, or with negative inertia only.
    ///
    /// # Examples
    /// ```
    /// use dualbody::joint::JointKind;
    /// use dualbody::model::{JointSpec, LinkSpec, ModelBuilder};
    ///
    /// let mut builder = ModelBuilder::new("vane");
    /// builder.add_link(LinkSpec::new("world")).add_link(LinkSpec::new("vane"));
    /// builder.add_joint(JointSpec::new("pivot", JointKind::Continuous, "world", "vane"));
    /// let vane = builder.build()?;
    /// assert_eq!(vane.check_mass_matrix().unwrap_err().joints[0].link, "vane");
    /// assert!(vane.with_armature(0, 0.01).check_mass_matrix().is_ok());
    /// # Ok::<(), dualbody::LoadError>(())
    /// ```
    pub fn check_mass_matrix(&self) -> Result<(), SingularMassMatrix> {
        let find = |lane| self.unresisted(lane);
        match (0..P::LANES).map(find).find(|found| !found.is_empty()) {
            None => Ok(()),
            Some(found) => Err(self.singular(&found)),
        }
    }

    /// Panics with the message of [`check_mass_matrix`](Self::check_mass_matrix), if it fails.
    pub(crate) fn assert_mass_matrix(&self) {
        if let Err(error) = self.check_mass_matrix() {
            panic!("{error}");
        }
    }

    fn singular(&self, found: &[Unresisted]) -> SingularMassMatrix {
        let mut first_link = vec![""; self.n_bodies()];
        for frame in self
            .links()
            .iter()
            .rev()
            .map(|link| &self.frames()[link.frame.0])
        {
            if let Some(body) = frame.body {
                first_link[body.0] = &frame.name;
            }
        }
        let describe = |at: &Unresisted| UnresistedJoint {
            joint: (self.body_joint(at.body)).map(|joint| self.joints()[joint.0].name.clone()),
            link: first_link[at.body.0].to_owned(),
            inertia: at.inertia,
        };
        SingularMassMatrix {
            model: self.name().to_owned(),
            joints: found.iter().map(describe).collect(),
        }
    }

    /// The joints that nothing resists in one lane, each once.
    fn unresisted(&self, lane: usize) -> Vec<Unresisted> {
        // Later joints cannot be checked.
        let known = self.bodies().iter().all(|body| has_values(&body.inertia));
        let solid = |body: &Body<P>| is_solid(&body.inertia, lane);
        if !known || self.bodies().iter().all(solid) {
            return Vec::new();
        }
        let values = self.values(lane);
        let mut found = eliminate(&values);
        if !found.is_empty() && self.has_coupling() && self.nv() <= MAX_DENSE {
            found = eliminate_dense(&values);
        }
        // A universal joint is reached by the outer of its bodies, which has a link.
        for at in &mut found {
            let joint = self.body_joint(at.body);
            at.body = joint.map_or(at.body, |joint| self.joint_body(joint));
        }
        sort_seldom(&mut found, |a, b| a.body.cmp(&b.body));
        found.dedup_by_key(|at| at.body);
        found
    }
}

/// Eliminates joint after joint; mimic joints move by themselves, which they would have to if nothing resisted them.
fn eliminate(model: &Model) -> Vec<Unresisted> {
    let mut found = Vec::new();
    // Of each body with all behind it: locked, and moving freely.
    let locked = locked_inertias(model);
    let mut free = own_inertias(model);
    for (i, body) in model.bodies().iter().enumerate().rev() {
        for k in (0..body.joint.nv()).rev() {
            let S = Vector6::from(body.joint.axis(k).motion::<f64>().to_array());
            let leads = body.coupling.is_none();
            let rotor = if leads {
                model.armature()[body.v + k]
            } else {
                0.0
            };
            let noise = rounding(&locked[i], body.joint.axis(k), rotor);
            let inertia = eliminate_axis(&mut free[i], &S, rotor, noise);
            if !resists(inertia, noise) {
                let body = BodyId(i);
                found.push(Unresisted { body, inertia });
            }
        }
        if let Some(BodyId(parent)) = body.parent {
            let X = from_parent(i, body);
            let own = X.transpose() * free[i] * X;
            free[parent] += own;
        }
    }
    found
}

/// Of each body alone.
fn own_inertias(model: &Model) -> Vec<Matrix6<f64>> {
    let bodies = model.bodies().iter();
    bodies.map(|body| body.inertia.to_matrix()).collect()
}

/// Of each body with all behind it, joints locked.
fn locked_inertias(model: &Model) -> Vec<Matrix6<f64>> {
    let mut locked = own_inertias(model);
    for (i, body) in model.bodies().iter().enumerate().rev() {
        if let Some(BodyId(parent)) = body.parent {
            let X = from_parent(i, body);
            let own = X.transpose() * locked[i] * X;
            locked[parent] += own;
        }
    }
    locked
}

/// The inertia about or along an axis that is rounding of the subtree only.
fn rounding(locked: &Matrix6<f64>, axis: Axis, rotor: f64) -> f64 {
    let S = Vector6::from(axis.motion::<f64>().to_array());
    let whole = (S.dot(&(locked * S)) + rotor).abs();
    let turned = match axis.is_angular() {
        true => (3..SPATIAL).map(|k| locked[(k, k)].abs()).sum(),
        false => 0.0,
    };
    (ROUNDING * whole).max(TURNED * turned)
}

/// Eliminates coordinate after coordinate from the mass matrix; a vanishing pivot names the joint that has the coordinate.
fn eliminate_dense(model: &Model) -> Vec<Unresisted> {
    let leaders = || model.independent_with_ids();
    let q: Vec<f64> = leaders()
        .nested(|(id, body)| ordinary_coordinates(id.0, body))
        .collect();
    let mut M = mass_matrix(model, &q);
    let (whole, locked) = (M.diagonal(), locked_inertias(model));
    let mut found = Vec::new();
    for (id, body) in leaders().collect::<Vec<_>>().into_iter().rev() {
        for k in (body.v..body.v + body.joint.nv()).rev() {
            let inertia = M[(k, k)];
            let own = rounding(&locked[id.0], body.joint.axis(k - body.v), 0.0);
            if resists(inertia, own.max(ROUNDING * whole[k].abs())) {
                subtract_outer(&mut M, k, inertia);
            } else {
                found.push(Unresisted { body: id, inertia });
            }
        }
    }
    found
}

/// A joint that nothing resists.
struct Unresisted {
    body: BodyId,
    /// The pivot.
    inertia: f64,
}

/// Whether a pivot is an inertia, and not rounding of the subtree.
fn resists(inertia: f64, noise: f64) -> bool {
    inertia > VANISHING && inertia > noise
}

/// Lets an axis move freely: I − I s sᵀ I / d  with the pivot  d = sᵀ I s + rotor, which is returned. Where nothing resists, the axis takes no force.
fn eliminate_axis(I: &mut Matrix6<f64>, S: &Vector6<f64>, rotor: f64, noise: f64) -> f64 {
    let column = *I * S;
    let d = S.dot(&column) + rotor;
    if resists(d, noise) {
        *I -= column * column.transpose() / d;
    } else {
        // The remainder along the axis is rounding.
        let across = Matrix6::identity() - S * S.transpose() / S.norm_squared();
        *I = across * *I * across;
    }
    d
}

/// The rows and columns before the k-th: M − m mᵀ / d.
fn subtract_outer(M: &mut DMatrix<f64>, k: usize, d: f64) {
    let column = M.view((0, k), (k, 1)).into_owned();
    M.view_mut((0, 0), (k, k))
        .ger(-1.0 / d, &column.column(0), &column.column(0), 1.0);
}

/// Whether all entries of an inertia are known values, not expressions of inputs.
fn has_values<P: Scalar>(inertia: &Inertia<P>) -> bool {
    let j = &inertia.rotational;
    let turning = [j.xx, j.xy, j.xz, j.yy, j.yz, j.zz];
    let numbers = inertia.first_moment.iter().chain(&turning);
    numbers.chain([&inertia.mass]).all(P::has_value)
}

/// Whether mass and moments about the centre of mass are positive, by more than rounding: then every motion of the body is resisted.
fn is_solid<P: Scalar>(inertia: &Inertia<P>, lane: usize) -> bool {
    let value = |x: &P| x.value(lane);
    let (m, h) = (
        value(&inertia.mass),
        inertia.first_moment.map(|x| value(&x)),
    );
    if m < VANISHING {
        return false;
    }
    let j = &inertia.rotational;
    let [xx, xy, xz, yy, yz, zz] = [&j.xx, &j.xy, &j.xz, &j.yy, &j.yz, &j.zz].map_each(value);
    let least = CLEARLY_SOLID * (xx + yy + zz);
    // J about the centre of mass, less least · 1, by its pivots.
    let J = Symmetric3::new(xx, xy, xz, yy, yz, zz)
        - Symmetric3::parallel_axis(&(h / (2.0 * m)), &h)
        - Symmetric3::scalar(least);
    let (second, yz) = (J.yy - J.xy * J.xy / J.xx, J.yz - J.xy * J.xz / J.xx);
    let third = J.zz - J.xz * J.xz / J.xx - yz * yz / second;
    least > VANISHING && J.xx > 0.0 && second > 0.0 && third > 0.0
}

/// The coordinates of a joint at a configuration that is nothing special: multiples of the golden ratio, less their whole parts.
fn ordinary_coordinates(i: usize, body: &Body<f64>) -> Vec<f64> {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let displacement: Vec<f64> = (0..body.joint.nv())
        .map(|k| ((SPATIAL * i + k + 1) as f64 * GOLDEN).fract() * 2.0 - 1.0)
        .collect();
    let (mut neutral, mut q) = (vec![0.0; body.joint.nq()], vec![0.0; body.joint.nq()]);
    body.joint.neutral(&mut neutral);
    body.joint.integrate(&neutral, &displacement, &mut q);
    q
}

/// The matrix that takes motions of the parent to a body, at an ordinary configuration of its joint.
fn from_parent(i: usize, body: &Body<f64>) -> Matrix6<f64> {
    let X_PB: Transform<f64> =
        (body.joint).compose(&body.placement, &ordinary_coordinates(i, body));
    let columns: [[f64; SPATIAL]; SPATIAL] =
        from_each(|k| X_PB.motion_inverse::<f64>(&Motion::basis(k)).to_array());
    Matrix6::from_fn(|row, k| columns[k][row])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::joint::JointKind;
    use crate::model::{JointSpec, LinkSpec, Mimic, Mimicry, ModelBuilder, samples};
    use rand::SeedableRng;
    use rand::rngs::Xoshiro256PlusPlus;

    /// Links on the world, one on the other, each by a joint about or along an axis.
    fn chain(links: &[(LinkSpec, JointKind, [f64; 3])]) -> ModelBuilder {
        let mut builder = ModelBuilder::new("chain");
        builder.add_link(LinkSpec::new("world"));
        let mut parent = "world".to_owned();
        for (k, (link, kind, axis)) in links.iter().enumerate() {
            let child = link.name.to_owned();
            builder.add_link(link.clone());
            let joint = JointSpec::new(format!("j{k}"), *kind, parent, &child);
            builder.add_joint(joint.with_axis(*axis).with_translation([0.1, 0.2, 0.3]));
            parent = child;
        }
        builder
    }

    fn unresisted(builder: &ModelBuilder) -> Vec<String> {
        match builder.build().unwrap().check_mass_matrix() {
            Ok(()) => Vec::new(),
            Err(error) => error.joints.into_iter().map(|at| at.link).collect(),
        }
    }

    const X: [f64; 3] = [1.0, 0.0, 0.0];
    const Y: [f64; 3] = [0.0, 1.0, 0.0];
    const Z: [f64; 3] = [0.0, 0.0, 1.0];

    fn empty(name: &str) -> LinkSpec {
        LinkSpec::new(name)
    }

    fn solid(name: &str) -> LinkSpec {
        LinkSpec::new(name).with_mass(1.0, [0.1, 0.0, 0.2], [0.1, 0.2, 0.25])
    }

    // The smallest eigenvalue of M at random configurations is the definition.
    #[test]
    fn verdict_equals_that_of_the_eigenvalues_of_the_mass_matrix() {
        use JointKind::{Continuous, Floating, Prismatic, Spherical};
        let rod = LinkSpec::new("rod").with_mass(1.0, [0.0, 0.0, 0.4], [0.1, 0.1, 0.0]);
        let point = LinkSpec::new("point").with_mass(1.0, [0.0, 0.3, 0.4], [0.0; 3]);
        let cases = [
            (vec![(solid("a"), Continuous, X)], vec![]),
            (vec![(empty("a"), Continuous, X)], vec!["a"]),
            (
                vec![(empty("a"), Continuous, X), (solid("b"), Continuous, Y)],
                vec![],
            ),
            (
                vec![(empty("a"), Continuous, X), (solid("b"), Continuous, X)],
                vec![],
            ),
            (
                vec![(solid("a"), Continuous, X), (empty("b"), Continuous, X)],
                vec!["b"],
            ),
            (
                vec![(empty("a"), Prismatic, X), (solid("b"), Prismatic, X)],
                vec!["a"],
            ),
            (
                vec![(empty("a"), Floating, X), (solid("b"), Continuous, X)],
                vec!["a"],
            ),
            (vec![(rod.clone(), Continuous, Z)], vec!["rod"]),
            (vec![(rod, Continuous, X)], vec![]),
            (vec![(point.clone(), Continuous, X)], vec![]),
            (vec![(point, Spherical, X)], vec!["point"]),
            (
                vec![
                    (empty("a"), Continuous, X),
                    (empty("b"), Prismatic, Y),
                    (empty("c"), Continuous, Z),
                ],
                vec!["a", "b", "c"],
            ),
        ];
        for (links, expected) in cases {
            let builder = chain(&links);
            assert_eq!(unresisted(&builder), expected, "{builder:?}");
            let model = builder.build().unwrap();
            let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
            let least = (0..5).map(|_| {
                let q = model.random_configuration(&mut rng);
                let eigen = mass_matrix(&model, q.as_slice()).symmetric_eigenvalues();
                eigen.min() / eigen.max().max(1e-9)
            });
            let least = least.fold(0.0, f64::max);
            assert_eq!(
                least > 1e-9,
                expected.is_empty(),
                "{least:e} of {builder:?}"
            );
        }
    }

    #[test]
    fn samples_and_their_lanes_resist_and_negative_inertia_does_not() {
        for model in [
            samples::pendulum(),
            samples::arm(),
            samples::random_tree(30, 2),
        ] {
            assert_eq!(model.check_mass_matrix(), Ok(()), "{}", model.name());
        }
        let negative = LinkSpec::new("rod").with_mass(1.0, [0.0; 3], [-1.0; 3]);
        let builder = chain(&[(negative, JointKind::Continuous, X)]);
        let negative = builder.build().unwrap();
        let error = negative.check_mass_matrix().unwrap_err();
        assert_eq!((error.joints.len(), error.joints[0].inertia), (1, -1.0));
        let solid = Inertia {
            rotational: Symmetric3::scalar(1.0),
            ..negative.body(BodyId(0)).inertia
        };
        let positive = negative.clone().with_inertia(BodyId(0), solid);
        let lanes = Model::side_by_side([&positive, &negative]).unwrap();
        assert_eq!(lanes.check_mass_matrix(), Err(error));
    }

    // A rod turns about its own axis without resistance, for any direction of the axis in the link.
    #[test]
    fn tilted_rod_on_its_own_axis_is_found() {
        use crate::ModelOptions;
        let rod = |axis: &str| {
            format!(
                r#"<robot name="r"><link name="world"/><link name="rod"><inertial><origin rpy="0.3 0.2 0.1"/><mass value="1"/>
                <inertia ixx="0.0833333333333" ixy="0" ixz="0" iyy="0.0833333333333" iyz="0" izz="0"/></inertial></link>
                <joint name="pivot" type="continuous"><parent link="world"/><child link="rod"/><axis xyz="{axis}"/></joint></robot>"#
            )
        };
        let own = rod("0.21835066314633442 -0.27509584731824366 0.9362933635841992");
        let (model, _) = ModelOptions::default().load_urdf_str(&own).unwrap();
        let error = model.check_mass_matrix().unwrap_err();
        assert_eq!(error.joints[0].link, "rod");
        let (model, _) = ModelOptions::default()
            .load_urdf_str(&rod("1 0 0"))
            .unwrap();
        assert_eq!(model.check_mass_matrix(), Ok(()));
    }

    // A massless finger that follows a heavy one is moved by it; one that leads is not moved by anything but its mimic joint.
    #[test]
    fn followers_without_inertia_are_resisted_by_their_leaders() {
        let mut builder = ModelBuilder::new("gripper");
        builder
            .add_link(empty("world"))
            .add_link(solid("left"))
            .add_link(empty("right"));
        builder.add_joint(JointSpec::new("l", JointKind::Prismatic, "world", "left"));
        let mimic = Mimic {
            leader: "l".into(),
            multiplier: -1.0,
            offset: 0.0,
        };
        builder.add_joint(
            JointSpec::new("r", JointKind::Prismatic, "world", "right").with_mimic(mimic),
        );
        assert_eq!(unresisted(&builder), [""; 0]);
        assert_eq!(
            unresisted(&builder.clone().with_mimicry(Mimicry::Independent)),
            ["right"]
        );
        let left = builder.links.iter_mut().find(|link| link.name == "left");
        left.unwrap().inertia = Inertia::zero();
        assert_eq!(unresisted(&builder), ["left"]);
    }

    // Two hundred names would be a long message.
    #[test]
    fn message_names_joints_links_and_ways_out_and_is_bounded() {
        let links: Vec<_> = (0..200)
            .map(|k| (empty(&format!("link{k}")), JointKind::Continuous, Z))
            .collect();
        let error = chain(&links)
            .build()
            .unwrap()
            .check_mass_matrix()
            .unwrap_err();
        let text = error.to_string();
        for part in [
            "joint \"j39\" (link \"link39\", inertia 0e0)",
            "160 more",
            "with_locked_joint",
        ] {
            assert!(text.contains(part), "{text}");
        }
        assert!(!text.contains("link40"), "{text}");
    }
}
