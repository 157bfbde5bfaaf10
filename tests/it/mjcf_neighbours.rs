//! Which bodies of an MJCF file touch, against the contacts that `MuJoCo` 4.0 finds for the same text.

use std::collections::BTreeSet;

use dualbody::ModelOptions;
use dualbody::io::MjcfScene;

const OFF: &str = "<option><flag filterparent='disable'/></option>";

/// An arm of three moving links on a base that is fixed to the world, or that moves freely. All shapes overlap, and `b2` and `l1f` are fixed to their
/// parents.
fn arm(option: &str, base: &str) -> MjcfScene {
    let geom = |name: &str, x: f64| format!("<geom name='{name}' size='0.1' pos='{x} 0 0'/>");
    let xml = format!(
        "<mujoco>{option}<worldbody><body name='w'>{}</body><body name='base'>{base}{}
           <body name='b2'>{}</body>
           <body name='l1'><joint/>{}<body name='l1f'>{}
             <body name='l2'><joint axis='0 1 0'/><joint axis='1 0 0'/>{}<body name='l3'><joint axis='1 0 0'/>{}</body></body></body></body>
         </body></worldbody></mujoco>",
        geom("w", 0.0), geom("base", 0.001), geom("b2", 0.002), geom("l1", 0.003), geom("l1f", 0.004), geom("l2", 0.005), geom("l3", 0.006)
    );
    let loaded = ModelOptions::default().load_mjcf_scene_str(&xml);
    loaded.unwrap_or_else(|error| panic!("{error}")).0
}

/// The pairs that touch, each in order of the alphabet.
fn touching(scene: &MjcfScene) -> BTreeSet<String> {
    let simulator = scene.simulator();
    let u = vec![0.0; simulator.nu()];
    let report = simulator.contact_report(&scene.reference, &u);
    let name = |frame: dualbody::model::FrameId| scene.model.frames()[frame.0].name.as_str();
    let pairs = report.pairs.iter().map(|pair| {
        let mut names = pair.links.map(name);
        names.sort_unstable();
        names.join(" ")
    });
    pairs.collect()
}

#[test]
fn free_joints_may_state_that_they_have_no_limits() {
    let xml = "<mujoco><worldbody><body><joint type='free' limited='false'/><geom size='0.1'/></body></worldbody></mujoco>";
    let (_, report) = ModelOptions::default().load_mjcf_str(xml).expect("a model");
    assert!(report.ignored.is_empty(), "{report}");
}

fn pairs(list: &str) -> BTreeSet<String> {
    list.split(", ").map(str::to_owned).collect()
}

#[test]
fn bodies_touch_their_parents_if_these_are_fixed_to_the_world() {
    let common = "l1 w, l1f w, l2 w, l3 w, b2 l2, b2 l3, base l2, base l3, l1 l3, l1f l3";
    let near_base = "b2 l1, b2 l1f, base l1, base l1f";
    let near_links = "l1 l2, l1f l2, l2 l3";
    let free = "<freejoint/>";
    let of_free = "b2 w, base w";
    for (option, base, expected) in [
        ("", "", vec![common, near_base]),
        (OFF, "", vec![common, near_base, near_links]),
        ("", free, vec![common, of_free]),
        (OFF, free, vec![common, of_free, near_base, near_links]),
    ] {
        let scene = arm(option, base);
        assert_eq!(scene.contacts.neighbours_touch, option == OFF);
        assert_eq!(
            touching(&scene),
            pairs(&expected.join(", ")),
            "{option} {base}"
        );
    }
}
