//! Pairs of links that collide, by SRDF and SDF files.

use dualbody::contact::{CollisionOptions, LinkShapes};
use dualbody::{LoadError, Model, ModelOptions};

const ROBOT: &str = r#"<robot name="r"><link name="world"/>
<link name="a"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="b"><collision><geometry><sphere radius="0.1"/></geometry></collision></link>
<link name="c"/>
<joint name="wa" type="floating"><parent link="world"/><child link="a"/></joint>
<joint name="wb" type="floating"><parent link="world"/><child link="b"/></joint>
<joint name="wc" type="floating"><parent link="world"/><child link="c"/></joint></robot>"#;

#[test]
fn pairs_of_an_srdf_are_excluded_and_the_rest_is_reported() {
    let model = Model::from_urdf_str(ROBOT).expect("a robot");
    let srdf = r#"<?xml version="1.0"?>
<robot name="r">
  <group name="all"><link name="a"/></group>
  <disable_collisions link1="b" link2="a" reason="Never"/>
  <disable_collisions link1="a" link2="c" reason="Adjacent"/>
</robot>"#;
    let options = CollisionOptions::default();
    let (options, rest) = options.with_srdf_str(&model, "", srdf).expect("an SRDF");
    assert_eq!(options.excluded, [["b", "a"], ["a", "c"]]);
    let rest: Vec<_> = rest
        .iter()
        .map(|note| (note.path.as_str(), note.line))
        .collect();
    assert_eq!(rest, [("robot/group", 3)]);
    let mut shapes = LinkShapes::new(&model);
    assert!(shapes.may_touch(0, 1));
    shapes
        .exclude(&model, &[["b", "a"], ["a", "c"]])
        .expect("links, of which one has no shape");
    assert!(!shapes.may_touch(0, 1));
}

#[test]
fn broken_srdf_files_are_errors_that_name_line_and_link() {
    let model = Model::from_urdf_str(ROBOT).expect("a robot");
    let read = |prefix: &str, text: &str| {
        let options = CollisionOptions::default();
        options.with_srdf_str(&model, prefix, text).map(|_| ())
    };
    for (prefix, text, said) in [
        (
            "",
            "<robot name='r'>\n<disable_collisions link1='a' link2='d'/></robot>",
            ":2: <disable_collisions>",
        ),
        (
            "",
            "<robot name='r'>\n<disable_collisions link1='a' link2='d'/></robot>",
            "\"d\"",
        ),
        (
            "left/",
            "<robot><disable_collisions link1='a' link2='b'/></robot>",
            "\"left/a\"",
        ),
        (
            "",
            "<robot>\n\n<disable_collisions link1='a'/></robot>",
            "link2",
        ),
        ("", "<model/>", "<robot>"),
        ("", "<robot><disable", "well-formed"),
        ("", "", "empty"),
    ] {
        let error = read(prefix, text).expect_err(text).to_string();
        assert!(error.contains(said), "{error}");
    }
    let missing = CollisionOptions::default().with_srdf_file(&model, "", "/nowhere/r.srdf");
    assert!(matches!(missing, Err(LoadError::Io { .. })));
}

fn sdf(first: &str, second: &str, third: &str) -> String {
    let link = |name: &str, mask: &str| {
        format!(
            "<link name='{name}'><inertial><mass>1</mass></inertial><collision name='c'><geometry><sphere><radius>0.1</radius></sphere></geometry>\n\
             {mask}</collision></link>"
        )
    };
    format!(
        "<sdf version='1.9'><model name='m'>{}{}{}\
         <joint name='ab' type='prismatic'><parent>a</parent><child>b</child><axis><xyz>1 0 0</xyz></axis></joint>\
         <joint name='bc' type='prismatic'><parent>b</parent><child>c</child><axis><xyz>1 0 0</xyz></axis></joint>\
         </model></sdf>",
        link("a", first),
        link("b", second),
        link("c", third)
    )
}

fn mask(bits: &str) -> String {
    format!("<surface><contact><collide_bitmask>{bits}</collide_bitmask></contact></surface>")
}

// Two shapes of an SDF collide where their bitmasks have a bit in common; one without a bitmask has all.
#[test]
fn bitmasks_of_an_sdf_say_which_links_collide() {
    for (first, third, touch) in [
        (mask("0x01"), mask("2"), false),
        (mask("0x03"), mask("0x02"), true),
        (mask("4"), String::new(), true),
        (mask("0"), String::new(), false),
        (String::new(), String::new(), true),
    ] {
        let text = sdf(&first, "", &third);
        let (model, _) = ModelOptions::default().load_sdf_str(&text).expect("an SDF");
        let shapes = LinkShapes::new(&model);
        assert_eq!(shapes.may_touch(0, 2), touch, "{first} {third}");
        // Editing keeps them.
        let again = model.to_builder().build().expect("a model");
        assert_eq!(LinkShapes::new(&again).may_touch(0, 2), touch);
    }
}

#[test]
fn bitmasks_that_are_none_are_errors_and_other_settings_are_reported() {
    for bits in ["0x10000", "-1", "one", ""] {
        let text = sdf(&mask(bits), "", "");
        let error = ModelOptions::default().load_sdf_str(&text).expect_err(bits);
        let error = error.to_string();
        assert!(
            error.contains("collide_bitmask") && error.contains(":2:"),
            "{error}"
        );
    }
    let both = "<surface><contact><collide_bitmask>1</collide_bitmask><ode/></contact><friction/></surface>";
    let (_, report) = ModelOptions::default()
        .load_sdf_str(&sdf(both, "", ""))
        .expect("an SDF");
    let ignored: Vec<&str> = report
        .ignored
        .iter()
        .map(|note| note.path.as_str())
        .collect();
    let surface = "sdf/model/link/collision/surface";
    assert_eq!(
        ignored,
        [
            format!("{surface}/friction"),
            format!("{surface}/contact/ode")
        ]
    );
}
