//! Names in MJCF files that refer to other elements: `MuJoCo` 4.0 refuses each text that is refused here, and takes each other one.

use dualbody::io::{ImportReport, MjcfScene, MjcfTransmission};
use dualbody::{ModelOptions, Simulator};

/// Two bodies with one of each kind of named part, on lines 1 to 5; the sections follow on line 6.
const BODIES: &str = "<mujoco><worldbody><site name='w'/>
<body name='b'><joint name='j'/><geom name='g' size='0.1'/><site name='s'/><camera name='c'/></body>
<body name='b2'><joint name='ball' type='ball'/><geom name='g2' size='0.1'/></body>
</worldbody>
<tendon><fixed name='t'><joint joint='j' coef='1'/></fixed></tendon>
";

fn load(sections: &str) -> Result<(MjcfScene, ImportReport), String> {
    let xml = format!("{BODIES}{sections}</mujoco>");
    let loaded = ModelOptions::default().load_mjcf_scene_str(&xml);
    loaded.map_err(|error| error.to_string())
}

/// The text of a section, and the kind of what it names: nothing has the name `nope`.
const UNKNOWN: [(&str, &str, &str); 40] = [
    ("sensor", "jointpos joint='nope'", "joint"),
    ("sensor", "jointlimitfrc joint='nope'", "joint"),
    ("sensor", "ballquat joint='nope'", "joint"),
    ("sensor", "gyro site='nope'", "site"),
    ("sensor", "touch site='nope'", "site"),
    ("sensor", "camprojection site='nope' camera='c'", "site"),
    ("sensor", "camprojection site='s' camera='nope'", "camera"),
    ("sensor", "tendonpos tendon='nope'", "tendon"),
    ("sensor", "actuatorfrc actuator='nope'", "actuator"),
    ("sensor", "subtreecom body='nope'", "body"),
    ("sensor", "framepos objtype='body' objname='nope'", "body"),
    ("sensor", "framepos objtype='xbody' objname='nope'", "body"),
    ("sensor", "framepos objtype='geom' objname='nope'", "geom"),
    (
        "sensor",
        "framepos objtype='camera' objname='nope'",
        "camera",
    ),
    (
        "sensor",
        "framepos objtype='site' objname='s' reftype='site' refname='nope'",
        "site",
    ),
    ("sensor", "distance geom1='g' geom2='nope'", "geom"),
    ("sensor", "distance body1='b' body2='nope'", "body"),
    ("sensor", "contact geom1='nope'", "geom"),
    (
        "sensor",
        "user objtype='body' objname='nope' dim='1'",
        "body",
    ),
    ("actuator", "motor joint='nope'", "joint"),
    ("actuator", "motor jointinparent='nope'", "joint"),
    ("actuator", "motor tendon='nope'", "tendon"),
    ("actuator", "motor site='nope'", "site"),
    ("actuator", "motor site='s' refsite='nope'", "site"),
    (
        "actuator",
        "motor cranksite='s' slidersite='nope' cranklength='1'",
        "site",
    ),
    ("actuator", "adhesion body='nope' ctrlrange='0 1'", "body"),
    ("equality", "connect body1='nope' anchor='0 0 0'", "body"),
    (
        "equality",
        "connect body1='b' body2='nope' anchor='0 0 0'",
        "body",
    ),
    ("equality", "weld site1='s' site2='nope'", "site"),
    (
        "equality",
        "weld body1='b' body2='nope' active='false'",
        "body",
    ),
    ("equality", "joint joint1='nope'", "joint"),
    ("equality", "joint joint1='j' joint2='nope'", "joint"),
    ("equality", "tendon tendon1='nope' active='false'", "tendon"),
    ("equality", "tendon tendon1='t' tendon2='nope'", "tendon"),
    ("equality", "flex flex='nope'", "flex"),
    ("contact", "exclude body1='b' body2='nope'", "body"),
    ("contact", "pair geom1='nope' geom2='g'", "geom"),
    (
        "worldbody",
        "camera mode='targetbody' target='nope'",
        "body",
    ),
    ("worldbody", "light mode='targetbody' target='nope'", "body"),
    ("worldbody", "site material='nope'", "material"),
];

#[test]
fn names_that_nothing_has_are_errors_of_the_line_and_the_kind() {
    for (section, element, kind) in UNKNOWN {
        let says = format!("there is no {kind} of that name");
        let error = load(&format!("<{section}>\n<{element}/></{section}>")).unwrap_err();
        let tag = element.split(' ').next().expect("a tag");
        assert!(
            error.starts_with(&format!("MJCF text:7: <{tag}>")),
            "{error}"
        );
        assert!(error.contains("\"nope\""), "{error}");
        assert!(error.contains(&says), "{error}: not {says}");
    }
}

#[test]
fn names_inside_of_elements_are_looked_for_too() {
    for (sections, kind) in [
        (
            "<tendon><fixed><joint joint='nope' coef='1'/></fixed></tendon>",
            "joint",
        ),
        (
            "<tendon><spatial><site site='s'/><site site='nope'/></spatial></tendon>",
            "site",
        ),
        (
            "<tendon><spatial><site site='s'/><geom geom='g' sidesite='nope'/><site site='s'/></spatial></tendon>",
            "site",
        ),
        (
            "<tendon><spatial material='nope'><site site='s'/><site site='w'/></spatial></tendon>",
            "material",
        ),
        (
            "<asset><material name='m' texture='nope'/></asset>",
            "texture",
        ),
        (
            "<asset><material name='m'><layer role='rgb' texture='nope'/></material></asset>",
            "texture",
        ),
        (
            "<worldbody><geom size='1' material='nope'/></worldbody>",
            "material",
        ),
        (
            "<custom><tuple name='a'><element objtype='body' objname='nope'/></tuple></custom>",
            "body",
        ),
    ] {
        let error = load(sections).unwrap_err();
        let says = format!("there is no {kind} of that name");
        assert!(error.contains(&says), "{error}: not {says}");
    }
}

#[test]
fn references_to_the_wrong_kind_and_missing_ones_are_errors() {
    for (section, says) in [
        ("<sensor><gyro/></sensor>", "has no attribute site"),
        ("<sensor><rangefinder/></sensor>", "has no attribute site"),
        (
            "<sensor><framepos objtype='site'/></sensor>",
            "has no attribute objname",
        ),
        (
            "<sensor><jointpos joint='ball'/></sensor>",
            "neither a hinge nor a slide",
        ),
        (
            "<sensor><ballquat joint='j'/></sensor>",
            "is not a ball joint",
        ),
        (
            "<actuator><motor/></actuator>",
            "has no attribute joint, tendon, site or body",
        ),
        (
            "<actuator><motor cranksite='s'/></actuator>",
            "has no attribute slidersite",
        ),
        (
            "<equality><joint joint1='ball'/></equality>",
            "neither a hinge nor a slide",
        ),
        (
            "<equality><joint joint1='j' joint2='j'/></equality>",
            "is the same as the first one",
        ),
        (
            "<equality><connect body1='b' body2='b' anchor='0 0 0'/></equality>",
            "is the same as the first one",
        ),
    ] {
        let error = load(section).unwrap_err();
        assert!(error.contains(says), "{error}: not {says}");
    }
}

/// What `MuJoCo` takes: parts that are not modelled here have names too.
#[test]
fn references_to_parts_that_are_not_modelled_are_remarks() {
    let (scene, report) = load(
        "<asset><texture name='x' type='2d' builtin='flat' width='8' height='8'/><material name='m' texture='x'/></asset>
         <worldbody><camera mode='targetbody' target='world'/><geom size='1' material='m' contype='0' conaffinity='0'/></worldbody>
         <tendon><spatial name='rope'><site site='s'/><site site='w'/></spatial></tendon>
         <actuator><motor name='pull' tendon='rope'/><adhesion name='glue' body='b' ctrlrange='0 1'/></actuator>
         <sensor><tendonpos tendon='rope'/><actuatorfrc actuator='pull'/><rangefinder camera='c'/><framepos objtype='geom' objname='g'/><clock/></sensor>
         <contact><exclude body1='b' body2='world'/><pair geom1='g' geom2='g2'/></contact>
         <custom><tuple name='a'><element objtype='body' objname='b'/></tuple></custom>",
    )
    .expect("a scene");
    assert_eq!((scene.actuation.len(), scene.sensors.len()), (2, 5));
    let text = report.to_string();
    for part in [
        "spatial",
        "motor \"pull\"",
        "adhesion",
        "tendonpos",
        "clock",
    ] {
        assert!(text.contains(part), "{part} is not in {text}");
    }
}

/// Flexible bodies make others, whose names this library does not know.
#[test]
fn files_with_flexible_bodies_load_without_what_refers_to_them() {
    let (scene, report) = load(
        "<worldbody><flexcomp name='cloth' type='grid' count='4 4 1' spacing='0.1 0.1 0.1' dim='2'/></worldbody>
         <contact><exclude body1='b' body2='cloth_0'/></contact>
         <equality><flex flex='cloth'/></equality>
         <sensor><framepos objtype='body' objname='cloth_0'/></sensor>",
    )
    .expect("a scene");
    assert!(scene.constraints.is_empty() && scene.contacts.excluded.is_empty());
    let says = "is not modelled: ";
    assert!(report.to_string().contains(says), "{report}");
}

/// Numbers of the elements, and their order, as `MuJoCo` has them.
#[test]
fn what_refers_to_replicas_is_replicated() {
    let xml = "<mujoco><worldbody><site name='w'/><body name='o'><joint name='oj'/><geom name='og' size='0.1'/></body>
      <replicate count='2' sep='-'><body name='b'><joint name='j'/><geom name='g' size='0.1'/>
        <replicate count='3' sep='+'><body name='c'><joint name='k'/><geom size='0.1'/><site name='s'/></body></replicate></body></replicate></worldbody>
      <tendon><fixed name='t'><joint joint='j' coef='1'/><joint joint='oj' coef='1'/></fixed></tendon>
      <actuator><motor name='b' joint='oj'/><motor name='a' joint='k'/><motor name='c' joint='j'/><motor name='d' tendon='t'/></actuator>
      <sensor><gyro name='gy' site='s'/><actuatorfrc name='af' actuator='c'/></sensor>
      <contact><exclude body1='b' body2='o'/><exclude body1='c' body2='world'/><pair geom1='g' geom2='og'/></contact>
      <equality><joint joint1='k'/><joint joint1='j' joint2='oj'/><weld body1='b' body2='world'/></equality></mujoco>";
    let (scene, report) = ModelOptions::default()
        .load_mjcf_scene_str(xml)
        .expect("a scene");
    let names: Vec<&str> = scene.actuation.iter().map(|own| &*own.name).collect();
    let expected = [
        "b", "c-0", "d-0", "a+0-0", "a+1-0", "a+2-0", "c-1", "d-1", "a+0-1", "a+1-1", "a+2-1",
    ];
    assert_eq!(names, expected);
    let third = MjcfTransmission::Joint("k+0-0".into());
    assert_eq!(scene.actuation[3].transmission, third);
    let tendons: Vec<_> = scene.tendons.iter().map(|own| &*own.name).collect();
    assert_eq!(tendons, ["t-0", "t-1"]);
    let joints = [("j-1".to_owned(), 1.0), ("oj".to_owned(), 1.0)];
    assert_eq!(scene.tendons[1].joints, joints);
    assert_eq!(scene.sensors.len(), 2 * 3 + 2);
    assert_eq!(scene.contacts.pairs.len(), 2);
    let excluded = &scene.contacts.excluded;
    assert_eq!(excluded.len(), 2 + 6);
    assert!(excluded.contains(&["b-0".into(), "o".into()]));
    assert!(excluded.contains(&["c+2-1".into(), "world".into()]));
    // A joint of a replica and another one: as there, this equality is dropped, with a remark.
    assert_eq!(scene.constraints.len(), 6 + 2);
    assert!(
        report.to_string().contains("not used, as in MuJoCo"),
        "{report}"
    );
}

#[test]
fn welds_to_a_site_of_the_world_hold_a_floating_body() {
    let xml = "<mujoco><worldbody><site name='w' pos='0 0 2'/><body name='b' pos='0 0 2'><freejoint/><geom size='0.1'/><site name='s'/></body></worldbody>
      <equality><weld site1='w' site2='s'/></equality></mujoco>";
    let simulator = Simulator::from_mjcf_str(xml).expect("a scene");
    let start = simulator.neutral_state();
    let mut state = start;
    state.q[2] = 2.0;
    let end = simulator.rollout(&state, 200, |_, _, _| {});
    let fallen = 2.0 - end.last().q[2];
    assert!(fallen.abs() < 0.01, "{fallen}");
}
