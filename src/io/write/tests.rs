//! Round trips through URDF; structure of MJCF.

#![expect(non_snake_case, reason = "monogram notation, see the conventions")]

use std::collections::HashSet;

use rand::SeedableRng;
use rand::rngs::Xoshiro256PlusPlus;

use crate::dynamics;
use crate::error::WriteError;
use crate::io::ModelOptions;
use crate::io::temporary::Folder;
use crate::joint::JointKind;
use crate::model::Mimicry;
use crate::model::{Base, JointSpec, LinkSpec, Mimic, Model, ModelBuilder, Visual, samples};
use crate::model::{Geometry, Limits, Mass, UpAxis};
use crate::spatial::{Inertia, Quaternion, Transform};

/// Rounding of roll, pitch and yaw, and of moments about the centre of mass.
const TEXT_ROUNDING: f64 = 1e-13;
/// Roundings of a whole tree.
const OF_A_TREE: f64 = 1e-10;

/// A name that needs every escape.
const AWKWARD: &str = "a & b < c > \"d\" 'e' ü";

fn assets() -> Vec<Model> {
    let folder = format!("{}/assets", env!("CARGO_MANIFEST_DIR"));
    let files = std::fs::read_dir(folder)
        .unwrap()
        .map(|file| file.unwrap().path());
    let urdf = files.filter(|path| {
        path.extension()
            .is_some_and(|extension| extension == "urdf")
    });
    urdf.map(|path| Model::from_urdf_file(path).unwrap())
        .collect()
}

/// A robot with every kind of shape, limit and name.
fn everything() -> Model {
    let mut builder = ModelBuilder::new(AWKWARD).with_gravity([0.0, 0.0, -1.6]);
    let mass = Mass::Density(900.0);
    builder.add_link(LinkSpec::solid_box("torso", [0.3, 0.2, 0.1], mass));
    let solids = [
        LinkSpec::solid_sphere(AWKWARD, 0.1, mass),
        LinkSpec::solid_cylinder("arm", 0.1, 0.3, mass),
        LinkSpec::solid_capsule("leg", 0.1, 0.3, mass),
    ];
    let limits = [
        (Some(-1.0), None),
        (None, Some(0.1 + 0.2)),
        (Some(-0.5), Some(0.5)),
    ];
    for (i, (link, (lower, upper))) in solids.into_iter().zip(limits).enumerate() {
        let mesh = Visual {
            name: Some(AWKWARD.into()),
            placement: Transform::from_translation([0.1, 0.0, 0.0].into()),
            geometry: Geometry::Mesh {
                uri: "package://x/--y.stl".into(),
                path: None,
                scale: [0.001; 3],
                up_axis: UpAxis::Auto,
            },
            color: Some([0.1, 0.2, 0.3, 1.0]),
        };
        let (child, link) = (link.name().to_owned(), link.with_visual(mesh));
        builder.add_link(link);
        let limits = Limits {
            lower,
            upper,
            velocity: None,
            effort: Some(i as f64),
        };
        let joint = JointSpec::new(format!("{AWKWARD}{i}"), JointKind::Revolute, "torso", child)
            .with_axis([0.3, -0.4, 1.7])
            .with_limits(limits)
            .with_friction(0.25)
            .with_damping(0.5);
        let leader = format!("{AWKWARD}0");
        builder.add_joint(if i == 2 {
            joint.with_mimic(Mimic {
                leader,
                multiplier: -1.5,
                offset: 0.1,
            })
        } else {
            joint
        });
    }
    builder.add_frame(
        "tool <1>",
        AWKWARD,
        Transform::from_translation([0.0, 0.1, 0.0].into()),
    );
    builder.build().unwrap()
}

/// Kinds of joints that URDF has, but for fixed ones.
const IN_URDF: [JointKind; 6] = [
    JointKind::Revolute,
    JointKind::Continuous,
    JointKind::Prismatic,
    JointKind::Spherical,
    JointKind::Planar,
    JointKind::Floating,
];

fn models_of(tree: impl Fn(u64) -> Model) -> Vec<Model> {
    let mut models = assets();
    models.extend([
        samples::pendulum(),
        samples::double_pendulum(),
        samples::cartpole(),
        samples::arm(),
    ]);
    models.extend((0..6).map(tree));
    models.push(everything());
    models
}

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
        for link in model.to_builder().links() {
            let builder = again.to_builder();
            let found = builder
                .links()
                .iter()
                .find(|found| found.name() == link.name());
            let Some(found) = found else {
                panic!("{name}: link {}", link.name())
            };
            let shapes = |link: &LinkSpec| (link.visuals().len(), link.collisions().len());
            assert_eq!(shapes(found), shapes(link), "{name}: link {}", link.name());
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
    let spring = crate::model::Spring {
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
fn names_in_mjcf_are_those_of_the_model_and_none_is_there_twice() {
    for model in models_of(|seed| samples::random_tree(16, seed)) {
        let Ok(xml) = model.to_mjcf() else { continue };
        let document = roxmltree::Document::parse(&xml).unwrap();
        let elements = || document.descendants().filter(roxmltree::Node::is_element);
        let mut seen = HashSet::new();
        for node in elements().filter(|node| node.tag_name().name() != "mesh") {
            let kind = node.parent_element().map(|parent| parent.tag_name().name());
            let kind = if kind == Some("actuator") {
                "motor"
            } else {
                node.tag_name().name()
            };
            if let Some(name) = node.attribute("name") {
                assert!(seen.insert((kind, name.to_owned())), "{kind} {name}");
            }
        }
        for link in model
            .link_names()
            .into_iter()
            .filter(|&link| link != "world")
        {
            assert!(
                seen.contains(&("body", link.to_owned())),
                "{}: {link}",
                model.name()
            );
        }
        for joint in model.joints() {
            let simple = joint.kind.nv() == 1 || joint.kind == JointKind::Spherical;
            assert!(
                !simple || seen.contains(&("joint", joint.name.clone())),
                "{}",
                joint.name
            );
        }
        let mass: f64 = elements()
            .filter_map(|node| node.attribute("mass"))
            .map(|mass| mass.parse::<f64>().unwrap())
            .sum();
        let links = model.to_builder();
        let described: f64 = links.links().iter().map(|link| link.inertia().mass).sum();
        assert!(
            (mass - described).abs() < TEXT_ROUNDING * described,
            "{}",
            model.name()
        );
    }
}

#[test]
fn mjcf_of_the_cartpole_equals_what_a_person_expects() {
    let xml = samples::cartpole().to_mjcf().unwrap();
    for part in [
        "<compiler angle=\"radian\" autolimits=\"true\" inertiafromgeom=\"false\"/>",
        "<option gravity=\"0 0 -9.81\"/>",
        "<body name=\"cart\" pos=\"0 0 1.2\">",
        "<joint name=\"linear\" type=\"slide\" axis=\"0 1 0\" range=\"-2.4 2.4\"/>",
        "<inertial pos=\"0 0 0.5\" mass=\"0.5\" fullinertia=",
        "<motor name=\"linear\" joint=\"linear\" ctrlrange=\"-500 500\"/>",
    ] {
        assert!(xml.contains(part), "{part} is not in\n{xml}");
    }
    let xml = everything().to_mjcf().unwrap();
    assert!(xml.contains("polycoef=\"0.1 -1.5 0 0 0\""), "{xml}");
    assert_eq!(
        xml.matches("<motor").count(),
        1,
        "one is limited to 0, one follows"
    );
}

#[test]
fn what_mjcf_cannot_hold_is_an_error_that_names_it() {
    let tree = |kind| samples::random_tree_of(&[kind], 2, 1);
    let planar = tree(JointKind::Planar)
        .with_armature(0, 0.1)
        .with_armature(1, 0.1)
        .with_armature(2, 0.1);
    let ball = tree(JointKind::Spherical).with_damping(0, 10.0);
    let mut massless = samples::double_pendulum().to_builder();
    massless.set_link_inertia("upper", Inertia::zero()).unwrap();
    for (model, name) in [
        (planar, "joint0"),
        (ball, "joint0"),
        (massless.build().unwrap(), "upper"),
    ] {
        let WriteError::Unsupported { name: found, .. } = model.to_mjcf().unwrap_err();
        assert_eq!(found, name);
    }
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

// Two plates, one impossible for itself: the sum of both is written at the first.
#[test]
fn inertia_in_mjcf_is_the_sum_over_the_links_of_a_body() {
    let mut builder = samples::pendulum().to_builder();
    builder.add_link(LinkSpec::new("dummy").with_mass(1e-3, [0.0; 3], [1e-3, 1e-3, 1.0]));
    builder.add_joint(
        JointSpec::new("weld", JointKind::Fixed, "rod", "dummy").with_translation([0.0, 0.0, 2.0]),
    );
    builder.add_link(LinkSpec::new("post").with_mass(1e-3, [0.0; 3], [1e-3, 1e-3, 1.0]));
    builder.add_joint(JointSpec::new("stand", JointKind::Fixed, "world", "post"));
    let error = builder.build().unwrap().to_mjcf().unwrap_err();
    assert!(error.to_string().contains("\"rod\""), "{error}");
    builder
        .set_link_inertia(
            "dummy",
            Inertia::from_com(
                1e-3,
                &nalgebra::Vector3::zeros(),
                &crate::spatial::Symmetric3::diagonal(&[1e-9, 1e-9, 1e-3].into()),
            ),
        )
        .unwrap();
    let model = builder.build().unwrap();
    assert_eq!(model.inertia_flaws().len(), 2);
    let xml = model.to_mjcf().unwrap();
    assert_eq!(xml.matches("<inertial").count(), 1, "{xml}");
    assert!(
        xml.contains("mass=\"1.001\"") && xml.contains("left out: the inertia of post"),
        "{xml}"
    );
}

const TETRAHEDRON: [[[f32; 3]; 3]; 4] = {
    const CORNERS: [[f32; 3]; 4] = [
        [0.0, 0.0, 0.0],
        [2.0, 0.0, 0.0],
        [0.0, 3.0, 0.0],
        [0.0, 0.0, 4.0],
    ];
    let [o, a, b, c] = CORNERS;
    [[o, b, a], [o, a, c], [o, c, b], [a, b, c]]
};

fn text_stl(triangles: &[[[f32; 3]; 3]]) -> String {
    let mut out = "solid t\n".to_owned();
    for triangle in triangles {
        out += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in triangle {
            out += &format!("vertex {x} {y} {z}\n");
        }
        out += "endloop\nendfacet\n";
    }
    out + "endsolid t\n"
}

fn binary_stl(triangles: &[[[f32; 3]; 3]]) -> Vec<u8> {
    let mut out = vec![0; 80];
    out.extend((triangles.len() as u32).to_le_bytes());
    for triangle in triangles {
        out.extend([0; 12]);
        out.extend(triangle.iter().flatten().flat_map(|x| x.to_le_bytes()));
        out.extend([0; 2]);
    }
    out
}

#[test]
fn meshes_in_mjcf_are_such_that_mujoco_takes_them() {
    let folder = Folder::new();
    let flat = [
        [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]],
        [[1.0, 1.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]],
    ];
    folder.write("text.stl", text_stl(&TETRAHEDRON));
    folder.write("flat.stl", text_stl(&flat));
    std::fs::write(folder.path("binary.stl"), binary_stl(&TETRAHEDRON)).unwrap();
    std::fs::write(folder.path("one.stl"), binary_stl(&TETRAHEDRON[..1])).unwrap();
    let mut builder = samples::pendulum().to_builder();
    let mut link = LinkSpec::new("meshes").with_mass(1.0, [0.0; 3], [1.0; 3]);
    for name in [
        "text.stl",
        "flat.stl",
        "binary.stl",
        "one.stl",
        "none.stl",
        "scene.dae",
    ] {
        link = link.with_collision(crate::model::Collision {
            name: None,
            placement: Transform::identity(),
            geometry: Geometry::Mesh {
                uri: name.into(),
                path: Some(folder.path(name)),
                scale: [1.0; 3],
                up_axis: UpAxis::default(),
            },
        });
    }
    builder.add_link(link);
    builder.add_joint(JointSpec::new("weld", JointKind::Fixed, "rod", "meshes"));
    let xml = builder.build().unwrap().to_mjcf().unwrap();
    let document = roxmltree::Document::parse(&xml).unwrap();
    let assets: Vec<_> = document
        .descendants()
        .filter(|node| node.has_tag_name("mesh"))
        .collect();
    assert!(
        assets
            .iter()
            .all(|asset| asset.attribute("inertia") == Some("shell"))
    );
    let numbers = |k: usize, attribute| assets[k].attribute(attribute).unwrap().split(' ').count();
    assert_eq!(
        (numbers(0, "vertex"), numbers(0, "face")),
        (12, 12),
        "{xml}"
    );
    assert_eq!((numbers(1, "vertex"), numbers(1, "face")), (12, 6));
    assert!(assets[2].attribute("file").unwrap().ends_with("binary.stl"));
    assert_eq!(assets.len(), 3);
    let geoms = document
        .descendants()
        .filter(|node| node.attribute("type") == Some("mesh"));
    let types: Vec<_> = geoms
        .map(|geom| (geom.attribute("mesh"), geom.attribute("contype")))
        .collect();
    assert_eq!(
        types,
        [
            (Some("mesh_0"), Some("1")),
            (Some("mesh_1"), None),
            (Some("mesh_2"), Some("1"))
        ]
    );
    for left_out in [
        "mesh one.stl",
        "mesh none.stl",
        "mesh scene.dae",
        "does not collide: its mesh is flat",
    ] {
        assert!(xml.contains(left_out), "{left_out} is not in\n{xml}");
    }
}

#[test]
fn geoms_of_collisions_touch_the_ground_only() {
    let mut builder = samples::pendulum().to_builder();
    builder.add_link(LinkSpec::solid_sphere("ball", 0.1, Mass::Kilograms(1.0)));
    builder.add_joint(JointSpec::new("weld", JointKind::Fixed, "rod", "ball"));
    let xml = builder.build().unwrap().to_mjcf().unwrap();
    let document = roxmltree::Document::parse(&xml).unwrap();
    let geoms = document
        .descendants()
        .filter(|node| node.has_tag_name("geom"));
    // The first is that of the defaults.
    let bits: Vec<_> = geoms
        .map(|geom| {
            (
                geom.attribute("group"),
                geom.attribute("contype"),
                geom.attribute("conaffinity"),
            )
        })
        .collect();
    let expected = [
        (None, Some("0"), Some("0")),
        (Some("1"), None, None),
        (Some("3"), Some("1"), None),
    ];
    assert_eq!(bits[..1], expected[..1]);
    assert!(
        bits[1..].iter().all(|geom| expected[1..].contains(geom)),
        "{bits:?}"
    );
    assert!(bits.contains(&expected[2]));
}
