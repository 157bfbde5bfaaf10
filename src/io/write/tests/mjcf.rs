//! Structure of MJCF.

use std::collections::HashSet;

use super::{TEXT_ROUNDING, everything, models_of};
use crate::error::WriteError;
use crate::joint::JointKind;
use crate::model::{JointSpec, LinkSpec, Mass, samples};
use crate::spatial::Inertia;

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
        let described: f64 = links.links.iter().map(|link| link.inertia.mass).sum();
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
        "<!-- left out: the speed limit 10 of the next joint -->",
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
    let lower = massless.links.iter_mut().find(|link| link.name == "lower");
    lower.unwrap().inertia = Inertia::zero();
    for (model, name) in [
        (planar, "joint0"),
        (ball, "joint0"),
        (massless.build().unwrap(), "lower"),
    ] {
        let WriteError::Unsupported { name: found, .. } = model.to_mjcf().unwrap_err();
        assert_eq!(found, name);
    }
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
    let dummy = builder.links.iter_mut().find(|link| link.name == "dummy");
    dummy.unwrap().inertia = Inertia::from_com(
        1e-3,
        &nalgebra::Vector3::zeros(),
        &crate::spatial::Symmetric3::diagonal(&[1e-9, 1e-9, 1e-3].into()),
    );
    let model = builder.build().unwrap();
    assert_eq!(model.inertia_flaws().len(), 2);
    let xml = model.to_mjcf().unwrap();
    assert_eq!(xml.matches("<inertial").count(), 1, "{xml}");
    assert!(
        xml.contains("mass=\"1.001\"") && xml.contains("left out: the inertia of post"),
        "{xml}"
    );
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
