//! Constraints and the ground in pictures.

use nalgebra::Vector3;
use serde_json::Value;

use super::super::{Appearance, Recording, model_page};
use super::models;
use super::page::data;
use crate::constraint::{Anchor, Constraint};
use crate::contact::{ContactLaw, Contacts, HeightField, RelaxedRigid, Terrain};
use crate::dynamics::forward_kinematics;
use crate::io::temporary::Folder;
use crate::model::{BodyId, Model, samples};
use crate::tests::SAME_ALGEBRA;
use crate::{Simulator, State};

fn numbers(value: &Value) -> Vec<f64> {
    let items = value.as_array().unwrap().iter();
    items.map(|x| x.as_f64().unwrap()).collect()
}

/// A double pendulum with a constraint of each kind.
fn constrained() -> (Model, Vec<[Anchor; 2]>, Vec<Constraint>) {
    let model = samples::double_pendulum();
    let upper = Anchor::frame(&model, "upper")
        .unwrap()
        .moved([0.1, -0.2, 0.3]);
    let lower = Anchor::frame(&model, "lower")
        .unwrap()
        .moved([0.0, 0.4, -0.1]);
    let nail = Anchor::world().moved([1.0, 2.0, 3.0]);
    let anchors = vec![[upper, nail], [lower, nail], [upper, lower]];
    let mut constraints = vec![
        Constraint::distance(anchors[0], 2.0),
        Constraint::ball(anchors[1]),
        Constraint::weld(anchors[2]),
    ];
    let [first, second] = [model.joint_names()[0], model.joint_names()[1]];
    constraints.push(Constraint::coupler(&model, [first, second], 1.0, 0.0).unwrap());
    (model, anchors, constraints)
}

#[test]
fn ends_of_drawn_constraints_equal_their_anchors_in_motion() {
    let (model, anchors, constraints) = constrained();
    let mut recording = Recording::new(&model);
    let (q, v) = ([0.7, -1.1], [0.0; 2]);
    recording.push(0.0, &State::new(&q, &v), &[]);
    recording.robot_mut(0).show_constraints(&constraints);
    let page = data(&recording.to_html());
    let bonds = page["robots"][0]["bonds"].as_array().unwrap();
    let kinds: Vec<_> = bonds
        .iter()
        .map(|bond| bond["kind"].as_str().unwrap())
        .collect();
    assert_eq!(kinds, ["rod", "ball", "weld", "coupler"]);
    let kinematics = forward_kinematics(&model, &q, &v);
    let place = |bond: usize, end: usize| {
        let end = &bonds[bond]["ends"][end];
        let body = end["body"].as_u64().map(|body| BodyId(body as usize));
        kinematics
            .pose(body)
            .point(&Vector3::from_vec(numbers(&end["at"])))
    };
    for (bond, anchors) in anchors.iter().enumerate() {
        for (end, anchor) in anchors.iter().enumerate() {
            let expected = anchor.pose_in_world(&model, &q).translation;
            let error = (place(bond, end) - expected).amax();
            assert!(error < SAME_ALGEBRA, "bond {bond}, end {end}: {error}");
        }
    }
    // A coupler ends at the joints.
    for end in 0..2 {
        let expected = kinematics.pose(Some(BodyId(end))).translation;
        assert!((place(3, end) - expected).amax() < SAME_ALGEBRA);
    }
}

#[test]
fn constraints_and_ground_read_back_from_json() {
    let (model, _, constraints) = constrained();
    let mut recording = Recording::new(&model);
    recording.push(0.0, &State::new(&[0.1, 0.2], &[0.0; 2]), &[]);
    recording.robot_mut(0).show_constraints(&constraints);
    recording.show_ground(&Terrain::incline(0.3));
    let folder = Folder::new();
    let path = folder.write("a.json", recording.to_json());
    let again = Recording::read_json(path, &models(&recording)).unwrap();
    assert_eq!(again.robots()[0].bonds, recording.robots()[0].bonds);
    assert_eq!(again.scene_objects(), recording.scene_objects());
    for (from, to) in [
        ("[2,2]", "[2,3]"),
        ("[2,2]", "[1,4]"),
        ("\"spacing\":[", "\"spacing\":[-"),
    ] {
        let text = recording.to_json().replacen(from, to, 1);
        let path = folder.write("b.json", text);
        assert!(
            Recording::read_json(path, &models(&recording)).is_err(),
            "{to}"
        );
    }
    let text = recording.to_json().replacen("\"upper\"", "\"nothing\"", 1);
    let error = Recording::read_json(folder.write("c.json", text), &models(&recording));
    assert!(
        error
            .unwrap_err()
            .to_string()
            .contains("no frame \"nothing\"")
    );
}

#[test]
fn heights_of_a_drawn_ground_equal_the_terrain_around_the_motion() {
    let hill = HeightField::new(
        [-1.0; 2],
        [1.0; 2],
        [3, 3],
        &[0.0, 0.1, 0.0, 0.2, 0.9, 0.3, 0.0, 0.1, 0.0],
    );
    let mut recording = Recording::new(&samples::cartpole());
    for k in 0..3 {
        let x = f64::from(k);
        recording.push(x, &State::new(&[x, 0.0], &[0.0; 2]), &[]);
    }
    for terrain in [Terrain::HeightField(hill), Terrain::incline(0.4)] {
        recording.show_ground(&terrain);
        let ground = recording.scene_objects().last().unwrap();
        let Appearance::Ground(heights) = &ground.appearance else {
            panic!("{ground:?}")
        };
        let [nx, ny] = heights.size;
        let at = |i: usize, axis: usize| heights.origin[axis] + heights.spacing[axis] * i as f64;
        for (k, &z) in heights.heights.iter().enumerate() {
            assert_eq!(z, terrain.surface(&at(k % nx, 0), &at(k / nx, 1)).height);
        }
        assert!(
            at(0, 1) < 0.0 && at(ny - 1, 1) > 2.0,
            "it reaches beyond the rail"
        );
        assert!(at(0, 0) < 0.0 && at(nx - 1, 0) > 0.0);
    }
    // Each surface has its triangles, two a cell, on the page.
    let page = data(&recording.to_html());
    let shapes = page["fixtures"].as_array().unwrap().iter();
    let drawn: Vec<_> = shapes
        .map(|ground| ground["shapes"].as_array().unwrap().len())
        .collect();
    assert_eq!(
        (drawn, page["meshes"].as_array().unwrap().len()),
        (vec![1, 1], 2)
    );
}

#[test]
fn level_ground_is_the_floor_of_the_page() {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/sphere.urdf");
    let model = Model::from_urdf_file(file).unwrap();
    let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let contacts = Contacts::new(&model, Terrain::flat(-0.25), law);
    let simulator = Simulator::new(model).with_contacts(contacts);
    let rollout = simulator.rollout(&simulator.neutral_state(), 3, |_, _, _| {});
    let page = data(&Recording::of_simulation(&simulator, &rollout).to_html());
    let ground = &page["fixtures"][0];
    assert_eq!(ground["level"], -0.25);
    assert_eq!(ground["is_ground"], true);
    assert!(ground["shapes"].as_array().unwrap().is_empty());
    let none = data(&model_page(simulator.model()));
    assert!(none["fixtures"].as_array().unwrap().is_empty());
}
