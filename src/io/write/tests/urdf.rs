//! Round trips through URDF.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

use super::{TEXT_ROUNDING, everything, models_of};
use crate::dynamics;
use crate::io::ModelOptions;
use crate::joint::JointKind;
use crate::model::{
    Base, JointSpec, LinkSpec, Mass, Mimicry, Model, ModelBuilder, Spring, samples,
};
use crate::spatial::{Quaternion, Transform};

/// Roundings of a whole tree.
const OF_A_TREE: f64 = 1e-10;

/// Kinds of joints that URDF has, except fixed ones.
const IN_URDF: [JointKind; 6] = [
    JointKind::Revolute,
    JointKind::Continuous,
    JointKind::Prismatic,
    JointKind::Spherical,
    JointKind::Planar,
    JointKind::Floating,
];

fn assert_equal_poses(model: &Model, again: &Model, q: &[f64]) {
    for name in model.frame_names() {
        let pose = |model: &Model| dynamics::frame_pose(model, q, model.frame(name).unwrap());
        let (a, b) = (pose(model), pose(again));
        let error = (a.rotation - b.rotation)
            .amax()
            .max((a.translation - b.translation).amax());
        assert!(
            error < OF_A_TREE,
            "{}: frame {name}: {error:e}",
            model.name()
        );
    }
}

#[test]
fn model_read_back_from_its_urdf_equals_the_model() {
    for model in models_of(|seed| samples::random_tree_of(&IN_URDF, 16, seed)) {
        let xml = model.to_urdf().unwrap();
        let options = ModelOptions::default().with_gravity((*model.gravity()).into());
        let (again, report) = options.load_urdf_str(&xml).unwrap();
        let name = model.name();
        assert!(report.ignored.is_empty(), "{report}");
        assert_eq!(again.name(), name);
        assert_eq!(again.joint_names(), model.joint_names(), "{name}");
        assert_eq!(again.damping(), model.damping(), "{name}");
        for (a, b) in again.joints().iter().zip(model.joints()) {
            assert_eq!(
                (a.kind, a.limits, a.friction),
                (b.kind, b.limits, b.friction),
                "{name}: {}",
                a.name
            );
            assert_eq!(a.mimic, b.mimic, "{name}");
            assert!(
                (a.axis - b.axis).amax() < TEXT_ROUNDING,
                "{name}: {}",
                a.name
            );
        }
        for (a, b) in again.bodies().iter().zip(model.bodies()) {
            let (a, b) = (a.inertia.to_matrix(), b.inertia.to_matrix());
            assert!(
                (a - b).amax() < TEXT_ROUNDING * b.amax().max(1.0),
                "{name}: {a}{b}"
            );
        }
        // Frames have become links, in between.
        for link in &model.to_builder().links {
            let builder = again.to_builder();
            let found = builder.links.iter().find(|found| found.name == link.name);
            let Some(found) = found else {
                panic!("{name}: link {}", link.name)
            };
            let shapes = |link: &LinkSpec| (link.visuals.len(), link.collisions.len());
            assert_eq!(shapes(found), shapes(link), "{name}: link {}", &link.name);
        }
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
        let (q, v) = (
            model.random_configuration(&mut rng),
            model.random_velocity(&mut rng, 1.0),
        );
        let forces = |model: &Model| dynamics::bias_forces(model, q.as_slice(), v.as_slice());
        let (a, b) = (forces(&again), forces(&model));
        assert!(
            (&a - &b).amax() <= OF_A_TREE * b.amax().max(1.0),
            "{name}: {a}{b}"
        );
        assert_equal_poses(&model, &again, q.as_slice());
    }
}

#[test]
fn base_in_urdf_and_mjcf_equals_the_base_of_the_model() {
    let mut builder = samples::pendulum().to_builder();
    builder.add_link(LinkSpec::new("plate").with_mass(1.0, [0.0; 3], [0.1; 3]));
    builder.add_joint(JointSpec::new("weld", JointKind::Fixed, "rod", "plate"));
    let mut floating = ModelBuilder::new("floating").with_base(Base::Floating);
    floating
        .add_link(LinkSpec::new("world"))
        .add_link(LinkSpec::new("box").with_mass(1.0, [0.0; 3], [0.1; 3]));
    floating.add_joint(JointSpec::new("hold", JointKind::Fixed, "world", "box"));
    let mut fixed = ModelBuilder::new("fixed").with_base(Base::Fixed);
    fixed.add_link(LinkSpec::new("stone").with_mass(1.0, [0.0; 3], [0.1; 3]));
    for (builder, nv) in [(builder, 1), (floating, 6), (fixed, 0)] {
        let model = builder.build().unwrap();
        let again = Model::from_urdf_str(&model.to_urdf().unwrap()).unwrap();
        assert_eq!((model.nv(), again.nv()), (nv, nv), "{}", model.name());
        assert_eq!(again.has_floating_base(), model.has_floating_base());
        let mjcf = model.to_mjcf().unwrap();
        let free = mjcf.matches("<freejoint").count();
        assert_eq!(free, usize::from(model.has_floating_base()), "{mjcf}");
    }
}

#[test]
fn urdf_lists_what_it_leaves_out() {
    let spring = Spring {
        stiffness: 3.0,
        rest: 0.1,
    };
    let model = samples::cartpole()
        .with_armature(0, 0.2)
        .with_spring(1, spring);
    let xml = model.to_urdf().unwrap();
    assert!(xml.contains("armature 0.2 of joint linear"), "{xml}");
    assert!(
        xml.contains("spring 3 with rest position 0.1 of joint pivot"),
        "{xml}"
    );
    assert!(everything().to_urdf().unwrap().contains("gravity 0 0 -1.6"));
    let mut names = samples::pendulum().to_builder();
    names.add_frame("two\nlines", "rod", Transform::identity());
    let error = names.build().unwrap().to_urdf().unwrap_err();
    assert!(error.to_string().contains("control characters"), "{error}");
}

#[test]
fn independent_followers_read_back_independent() {
    let builder = everything().to_builder().with_mimicry(Mimicry::Independent);
    let model = builder.build().unwrap();
    let xml = model.to_urdf().unwrap();
    let again = Model::from_urdf_str(&xml).unwrap();
    assert_eq!((again.nq(), again.nv()), (model.nq(), model.nv()));
    assert!(
        xml.contains("moves independently of") && !xml.contains("<mimic"),
        "{xml}"
    );
    let q = model.neutral();
    let (a, b) = (
        dynamics::mass_matrix(&again, q.as_slice()),
        dynamics::mass_matrix(&model, q.as_slice()),
    );
    assert!((a - b).amax() < OF_A_TREE);
}

/// A floating robot on a turned fixed joint to the world.
fn turned_base() -> Model {
    let mut builder = ModelBuilder::new("turned").with_base(Base::Floating);
    builder
        .add_link(LinkSpec::solid_box(
            "world",
            [1.0, 1.0, 0.1],
            Mass::Kilograms(0.0),
        ))
        .add_link(LinkSpec::new("box").with_mass(1.0, [0.1, 0.0, 0.0], [0.1; 3]));
    let X_WL = Transform::new(
        Quaternion::exp(&[-1.57, 0.0, 0.0].into()).to_matrix(),
        [0.0, 0.0, 0.5].into(),
    );
    builder
        .add_joint(JointSpec::new("hold", JointKind::Fixed, "world", "box").with_placement(X_WL));
    builder.build().unwrap()
}

#[test]
fn turned_floating_base_reads_back_with_its_turn() {
    let model = turned_base();
    let again = Model::from_urdf_str(&model.to_urdf().unwrap()).unwrap();
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    let q = model.random_configuration(&mut rng);
    let pose =
        |model: &Model| dynamics::frame_pose(model, q.as_slice(), model.frame("box").unwrap());
    assert!((pose(&model).rotation - pose(&again).rotation).amax() < TEXT_ROUNDING);
    let mass = |model: &Model| dynamics::mass_matrix(model, q.as_slice());
    assert!((mass(&model) - mass(&again)).amax() < TEXT_ROUNDING);
    // The box stands in a body that is the frame of the base; the world's shapes stay in the world.
    let xml = model.to_mjcf().unwrap();
    let document = roxmltree::Document::parse(&xml).unwrap();
    let body = |name: &str| {
        document
            .descendants()
            .find(|node| node.attribute("name") == Some(name))
            .unwrap()
    };
    assert_eq!(body("box").parent_element(), Some(body("floating_base")));
    assert!(
        body("floating_base")
            .children()
            .any(|node| node.has_tag_name("freejoint"))
    );
    assert_eq!(xml.matches("<inertial").count(), 1);
    let world = body("floating_base").parent_element().unwrap();
    assert!(
        world.has_tag_name("worldbody") && world.children().any(|node| node.has_tag_name("geom")),
        "{xml}"
    );
}
