//! Files that are meant to break a reader, or that chance broke.

use proptest::prelude::*;

use super::*;
use crate::io::damage::{changes, damaged, on_small_stack};

/// One of everything.
const EVERYTHING: &str = r#"<sdf version="1.11"><world name="w"><gravity>0 0 -9.81</gravity><frame name="g"><pose>1 0 0 0 0 0</pose></frame>
<model name="r" canonical_link="a"><pose relative_to="g">0 0 1 0 0 0</pose>
<link name="a"><inertial><pose>0 0 1 0 0 0</pose><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>
<visual name="v"><geometry><box><size>1 1 1</size></box></geometry></visual></link>
<frame name="f" attached_to="m::b"><pose degrees="true">0 0 1 0 90 0</pose></frame>
<model name="m" placement_frame="b"><link name="b"><pose relative_to="k">0 1 0 0 0 0</pose></link><link name="c"/>
<joint name="k" type="universal"><pose relative_to="c">1 0 0 0 0 0</pose><parent>b</parent><child>c</child>
<axis><xyz expressed_in="__model__">1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2></joint></model>
<joint name="j" type="revolute"><parent>a</parent><child>m::b</child><axis><xyz>0 0 1</xyz><limit><lower>-1</lower></limit>
<mimic joint="l"><multiplier>2</multiplier></mimic></axis></joint>
<joint name="l" type="prismatic"><parent>world</parent><child>a</child></joint></model>
<model name="s"><link name="e"/></model><joint name="n" type="fixed"><parent>r::m::c</parent><child>s</child></joint></world></sdf>"#;

#[test]
fn long_chains_of_links_frames_and_poses_load_on_a_small_stack() {
    const LINKS: usize = 5_000;
    let nth = |i: usize| {
        let parent = if i == 0 {
            "world".into()
        } else {
            format!("l{}", i - 1)
        };
        let pose = if i == 0 {
            String::new()
        } else {
            format!("<pose relative_to='f{}'>0 0 1 0 0 0</pose>", i - 1)
        };
        link(&format!("l{i}"), &pose)
            + &joint(&format!("j{i}"), "revolute", &parent, &format!("l{i}"), "")
            + &format!("<frame name='f{i}' attached_to='l{i}'/>")
    };
    // The last first, so that no pose is known when it is asked for.
    let text = robot(&(0..LINKS).rev().map(nth).collect::<String>());
    let model = on_small_stack(move || Model::from_sdf_str(&text).unwrap());
    assert_eq!((model.nv(), model.links().len()), (LINKS, LINKS + 1));
    assert_eq!(pose(&model, "f4999").translation.z, 4999.0);
}

#[test]
fn any_depth_of_nesting_ends_in_a_model_or_an_error() {
    const DEPTH: usize = 100_000;
    on_small_stack(|| {
        let nested = |tag: &str| {
            format!("<{tag} name='m'>").repeat(DEPTH) + &format!("</{tag}>").repeat(DEPTH)
        };
        assert_eq!(
            load(&robot(&(link("a", "") + &nested("x"))))
                .1
                .ignored
                .len(),
            1
        );
        assert!(matches!(
            error(&robot(&nested("model"))),
            LoadError::Unsupported { .. }
        ));
        // As deep as is allowed, with the link at the bottom.
        let deep = "<model name='m'>".repeat(49) + &link("a", "") + &"</model>".repeat(49);
        assert_eq!(load(&robot(&deep)).0.nv(), 6);
    });
}

/// Words that mean something, to be exchanged.
const WORDS: &[&str] = &[
    "\"a\"",
    "\"b\"",
    "\"r\"",
    "\"m\"",
    "\"f\"",
    "\"k\"",
    ">a<",
    ">m::b<",
    ">world<",
    ">b<",
    ">c<",
    "\"m::b\"",
    "\"__model__\"",
    "\"c\"",
    "revolute",
    "universal",
];

/// Pieces that mean something, to be put anywhere.
const SNIPPETS: &[&str] = &[
    "<",
    ">",
    "/>",
    "\"",
    "&#0;",
    "nan",
    "-inf",
    "1e999",
    "<!--",
    "</link>",
    "</model>",
    "<pose/>",
    "<axis/>",
    "<static>1</static>",
    "<link name=\"n\"/>",
    "::",
    "__model__",
    "\u{0}",
    "é",
    "<include><uri>model://x</uri></include>",
    "<include merge=\"1\"><uri>x</uri></include>",
];

#[test]
fn the_file_to_damage_loads() {
    let (model, _) = load(EVERYTHING);
    assert_eq!(model.joint_names(), ["l", "j", "m::k"]);
    // Placed at its link b, the nested model turns b about c's hinges: b stands at (0, 0, 0) of r, which is at (1, 0, 1).
    assert_at(&pose(&model, "m::b"), [1., 0., 1.], [1., 0., 0.]);
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(800) })]

    #[test]
    fn any_damage_ends_in_a_model_or_an_error(changes in changes(SNIPPETS, WORDS)) {
        let text = damaged(EVERYTHING, changes);
        match ModelOptions::default().load_sdf_str(&text) {
            Ok((model, report)) => {
                prop_assert!(model.links().len() <= text.len());
                prop_assert!(report.to_string().starts_with("SDF text"));
            }
            Err(error) => prop_assert!(error.to_string().contains("SDF text")),
        }
    }
}
