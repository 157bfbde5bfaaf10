//! Sizes that memory has no room for.

use dualbody::contact::{
    ContactLaw, ContactOptions, Contacts, HeightField, MeshHulls, Rigid, SoftContact,
    SolverOptions, Terrain,
};
use dualbody::linearize::Linearization;
use dualbody::model::{Geometry, samples};
use dualbody::{Model, Simulator};

use super::refused;

/// More vertices than rows of a step have room for: three matrices of 600,000 rows, 8.64e12 bytes.
const MANY: usize = 200_000;

/// A mesh of many vertices, all of them on its hull for all that is known.
struct Dense(Vec<[f32; 3]>);

impl MeshHulls for Dense {
    fn vertices(&mut self, _: &Geometry) -> Result<&[[f32; 3]], String> {
        Ok(&self.0)
    }
}

/// A free link of so many points under a law.
fn dense(law: ContactLaw) -> (Model, Contacts) {
    let text = "<robot name='r'><link name='l'><inertial><mass value='1'/>\
        <inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>\
        <collision><geometry><mesh filename='dense'/></geometry></collision></link></robot>";
    let model = Model::from_urdf_str(text).expect("a link");
    let mut mesh = Dense((0..MANY).map(|k| [k as f32, 0.0, 0.0]).collect());
    let options = ContactOptions { mesh_points: MANY };
    let made = Contacts::with_meshes(&model, Terrain::flat(0.0), law, &options, &mut mesh);
    let contacts = made.expect("room for points");
    assert_eq!(contacts.points().len(), MANY);
    (model, contacts)
}

#[test]
fn more_points_in_a_step_than_memory_has_room_for() {
    let (model, contacts) = dense(ContactLaw::Rigid(Rigid::default()));
    contacts
        .check_memory()
        .expect("room for 256 points at a time");
    let all = contacts.with_solver_options(SolverOptions {
        points: usize::MAX,
        ..SolverOptions::default()
    });
    let said = "forces of 200000 contact points in a step need 8.6e12 bytes";
    let error = all.check_memory().expect_err("too many").to_string();
    assert!(error.starts_with(said), "{error}");
    refused(said, || {
        let _ = Simulator::new(model.clone()).with_contacts(all.clone());
    });
}

// Three deflections of each point, beside twelve coordinates of the free body.
#[test]
fn jacobians_of_more_bristles_than_memory_has_room_for() {
    let (model, contacts) = dense(ContactLaw::Soft(SoftContact::estimate(1.0, 4, 1e-3)));
    let simulator = Simulator::new(model).with_contacts(contacts);
    refused("Jacobians of 600012 coordinates of the state need", || {
        let _: Linearization = Linearization::zeros(&simulator);
    });
}

#[test]
fn grids_whose_nodes_cannot_be_counted() {
    for size in [[usize::MAX, 2], [2, usize::MAX], [usize::MAX; 2]] {
        refused("a height for each node", || {
            let _ = HeightField::new([0.0; 2], [1.0; 2], size, &[0.0; 4]);
        });
    }
}

#[test]
fn random_trees_that_memory_has_no_room_for() {
    let said = format!("{} random links need", usize::MAX);
    refused(&said, || {
        let _ = samples::random_tree(usize::MAX, 1);
    });
}
