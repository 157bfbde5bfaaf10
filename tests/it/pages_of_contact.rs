//! Contact on pages: points and forces of a motion, and which links a page with sliders looks at.

use dualbody::contact::{CollisionOptions, ContactLaw, RelaxedRigid, Terrain};
use dualbody::model::{Mass, Object, World};
use dualbody::spatial::Transform;
use dualbody::view::model_page;
use dualbody::{Contacts, Model, Recording, Simulator};

fn balls() -> Model {
    let mut world = World::new("balls");
    for (name, z) in [("a", 0.1), ("b", 0.3), ("c", 1.0)] {
        let at = Transform::from_translation([0.0, 0.0, z].into());
        let ball = Object::free(Mass::Kilograms(1.0)).at(at);
        world.add_sphere(name, 0.1, &ball).expect("a ball");
    }
    world.build().expect("a world")
}

fn simulator() -> Simulator {
    let (model, law) = (balls(), ContactLaw::RelaxedRigid(RelaxedRigid::default()));
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
        .with_collisions(&model, law, &CollisionOptions::default())
        .expect("links");
    Simulator::new(model).with_contacts(contacts)
}

#[test]
fn page_with_sliders_names_links_that_touch_from_the_start_and_looks_at_the_others() {
    let page = model_page(&balls());
    // a and b touch as they were put; a and c, b and c may.
    assert!(page.contains(r#""pairs":[[0,2],[1,2]]"#));
    assert!(page.contains(r#""touching":[["a","b"]]"#));
    // One that moves has no sliders.
    let simulator = simulator();
    let rollout = simulator.rollout(&simulator.neutral_state(), 3, |_, _, _| {});
    let page = Recording::of_simulation(&simulator, &rollout).to_html();
    assert!(!page.contains(r#""touching":[["#));
}

#[test]
fn contacts_of_a_recording_are_on_its_page_and_in_its_file() {
    let simulator = simulator();
    let rollout = simulator.rollout(&simulator.neutral_state(), 200, |_, _, _| {});
    let plain = Recording::from_rollout(simulator.model(), &rollout);
    assert!(!plain.to_html().contains(r#""contacts""#) && !plain.to_json().contains("moment"));
    let recording = Recording::of_simulation(&simulator, &rollout);
    assert!(recording.to_html().contains(r#""contacts":{"counts""#));
    let models = [simulator.model()];
    let read = Recording::from_json(recording.to_json(), &models).expect("the recording");
    assert_eq!(read.to_json(), recording.to_json());
    assert_eq!(read.to_html(), recording.to_html());
    // Moments that are not in order are refused.
    let text = recording.to_json();
    let broken = text.replacen(r#""moment":0"#, r#""moment":999"#, 1);
    assert_ne!(text, broken);
    let error = Recording::from_json(broken, &models).unwrap_err();
    assert!(error.to_string().contains("999"), "{error}");
}
