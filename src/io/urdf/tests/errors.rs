//! One bad file for every error; the message names the file, the element and its name.

use super::*;
use crate::io::temporary::Folder;
use crate::model::Base;

/// Asserts the variant of the error of a text, and what its message contains beside the source.
macro_rules! assert_error {
    ($xml:expr, $variant:ident, [$($part:expr),*]) => {
        let error = error($xml);
        assert!(matches!(error, LoadError::$variant { .. }), "{error:?}");
        let message = error.to_string();
        for part in ["URDF text", $($part),*] {
            assert!(message.contains(part), "{part:?} is not in: {message}");
        }
    };
}

#[test]
fn text_that_is_no_description_equals_its_error() {
    for empty in ["", " \r\n\t", "\u{feff}", "\u{feff}\n"] {
        assert_error!(empty, Empty, []);
    }
    assert_error!("not xml", NotXml, [":1:1:"]);
    assert_error!("<robot>\n  <link>\n</robot>", NotXml, [":3:"]);
    assert_error!("<robot a=\"1\" a=\"2\"/>", NotXml, ["'a'", "already"]);
    assert_error!("<!-- nothing -->", NotXml, []);
    assert_error!("<sdf version=\"1.7\"/>", NotARobot, ["<sdf>", "<robot>"]);
    assert_error!("<robot name=\"r\"/>", Missing, ["<robot>", "\"r\"", "link"]);
}

#[test]
fn files_that_cannot_be_read_equal_their_errors() {
    let folder = Folder::new();
    let absent = Model::from_urdf_file(folder.path("absent.urdf")).unwrap_err();
    assert!(matches!(absent, LoadError::Io { .. }), "{absent:?}");
    assert!(absent.to_string().contains("absent.urdf"));
    let latin = folder.write("latin.urdf", b"<robot name=\"caf\xe9\"/>");
    let error = Model::from_urdf_file(latin).unwrap_err();
    assert!(
        matches!(error, LoadError::NotUtf8 { offset: 16, .. }),
        "{error:?}"
    );
    assert!(error.to_string().contains("latin.urdf"));
    let wide = folder.write("wide.urdf", b"\xff\xfe<\0r\0");
    let error = Model::from_urdf_file(wide).unwrap_err();
    assert!(
        matches!(error, LoadError::NotUtf8 { offset: 0, .. }),
        "{error:?}"
    );
}

#[test]
fn unexpanded_xacro_equals_the_advice_to_run_xacro() {
    let declared = "<robot name='r' xmlns:xacro='http://www.ros.org/wiki/xacro'>\n";
    for (text, found) in [
        (
            format!("{declared}<xacro:include filename='a'/></robot>"),
            "<xacro:include>",
        ),
        (
            format!("{declared}<link name='${{p}}arm'/></robot>"),
            "${p}arm",
        ),
        ("<robot name='r'>\n<xacro:arm/></robot>".into(), "xacro"),
        (
            "<robot name='r'>\n<link name='$(arg name)'/></robot>".into(),
            "$(arg name)",
        ),
    ] {
        assert_error!(&text, NotExpanded, [":2:", "run xacro", found]);
    }
}

#[test]
fn missing_parts_equal_errors_that_name_them() {
    assert_error!(&robot("\n<link/>"), Missing, ["<link>", "line 2", "name"]);
    assert_error!(&robot("<link name=''/>"), Missing, ["<link>", "name"]);
    for (part, missing) in [
        ("<inertial><mass value='1'/></inertial>", "<inertia>"),
        (
            "<inertial><inertia ixx='1' iyy='1' izz='1'/></inertial>",
            "<mass>",
        ),
        (
            "<inertial><mass/><inertia ixx='1' iyy='1' izz='1'/></inertial>",
            "value",
        ),
        (
            "<inertial><mass value='1'/><inertia ixx='1' iyy='1'/></inertial>",
            "izz",
        ),
        ("<visual><geometry><box/></geometry></visual>", "size"),
        (
            "<collision><geometry><sphere/></geometry></collision>",
            "radius",
        ),
        (
            "<collision><geometry><cylinder radius='1'/></geometry></collision>",
            "length",
        ),
        ("<visual><geometry><mesh/></geometry></visual>", "filename"),
    ] {
        let text = robot(&format!("<link name='arm'>{part}</link>"));
        assert_error!(&text, Missing, ["\"arm\"", missing]);
    }
    for (joint, missing) in [
        ("<joint name='j'/>", "type"),
        (
            "<joint name='j' type='fixed'><child link='arm'/></joint>",
            "<parent>",
        ),
        (
            "<joint name='j' type='fixed'><parent link='world'/></joint>",
            "<child>",
        ),
        (
            "<joint name='j' type='fixed'><parent/><child link='arm'/></joint>",
            "link",
        ),
    ] {
        assert_error!(&arm_on(joint), Missing, ["\"j\"", missing]);
    }
    for (part, missing) in [("<axis/>", "xyz"), ("<mimic/>", "joint")] {
        assert_error!(
            &arm_on(&joint("continuous", part)),
            Missing,
            ["\"j\"", missing]
        );
    }
}

#[test]
fn values_that_cannot_be_understood_equal_errors_that_quote_them() {
    for (part, attribute, value) in [
        ("<origin xyz='1 2 x 3'/>", "xyz", "1 2 x 3"),
        ("<origin rpy='0 0'/>", "rpy", "0 0"),
        ("<axis xyz='1 0 0 0'/>", "xyz", "1 0 0 0"),
        ("<axis xyz='1,0,0'/>", "xyz", "1,0,0"),
        ("<limit lower='-90deg' upper='1'/>", "lower", "-90deg"),
        ("<limit effort=''/>", "effort", ""),
        ("<dynamics damping='a'/>", "damping", "a"),
        ("<mimic joint='j' multiplier='1 1'/>", "multiplier", "1 1"),
    ] {
        let text = arm_on(&joint("revolute", part));
        let quoted = format!("{attribute} = \"{value}\"");
        assert_error!(&text, Malformed, ["\"j\"", &quoted]);
    }
    // The line, and what the element belongs to.
    let text = arm_on(&joint("revolute", "\n<origin rpy='0 0'/>"));
    assert_error!(&text, Malformed, [":2:", "<joint/origin> \"j\""]);
    let text = arm_on(&joint("revolute", "\n<limit lower='1' upper='-1'/>"));
    assert_error!(&text, InvalidLimits, [":1:", "\"j\""]);
    for (part, quoted) in [
        ("<dynamics damping='-1'/>", "damping = \"-1\": is negative"),
        (
            "<dynamics friction='-1'/>",
            "friction = \"-1\": is negative",
        ),
    ] {
        let text = arm_on(&joint("continuous", part));
        assert_error!(&text, Malformed, ["<joint>", "\"j\"", quoted]);
    }
    let helical = arm_on(&joint("helical", ""));
    assert_error!(
        &helical,
        Malformed,
        ["<joint>", "\"j\"", "helical", "revolute"]
    );
    for quaternion in ["rpy='0 0 0' quat_xyzw='0 0 0 1'", "quat_xyzw='0 0 0 0'"] {
        let text = arm_on(&joint("fixed", &format!("<origin {quaternion}/>")));
        let text = text.replacen("<robot", "<robot version='1.1'", 1);
        assert_error!(&text, Malformed, ["<joint/origin>", "\"j\"", "quat_xyzw"]);
    }
}

#[test]
fn numbers_that_are_not_finite_equal_errors_that_name_the_quantity() {
    for (part, element, quantity) in [
        ("<origin xyz='0 nan 0'/>", "<joint/origin>", "xyz"),
        ("<origin rpy='0 0 1e999'/>", "<joint/origin>", "rpy"),
        ("<axis xyz='inf 0 0'/>", "<joint/axis>", "xyz"),
        ("<limit upper='nan'/>", "<joint/limit>", "upper"),
        ("<limit lower='inf'/>", "<joint/limit>", "lower"),
        ("<limit effort='-inf'/>", "<joint/limit>", "effort"),
        ("<dynamics friction='inf'/>", "<joint/dynamics>", "friction"),
        ("<mimic joint='j' offset='nan'/>", "<joint/mimic>", "offset"),
    ] {
        let text = arm_on(&joint("revolute", part));
        assert_error!(&text, NonFinite, [element, "\"j\"", quantity]);
    }
    let text = arm_on(&joint("fixed", ""));
    let heavy = text.replace("mass value=\"1\"", "mass value=\"inf\"");
    assert_error!(
        &heavy,
        NonFinite,
        ["<link/inertial/mass>", "\"arm\"", "value"]
    );
    // Finite numbers whose inertia about the origin is not.
    let far = text.replace("<inertial>", "<inertial><origin xyz='1e200 0 0'/>");
    assert_error!(&far, NonFinite, ["<link>", "\"arm\"", "inertia"]);
}

#[test]
fn impossible_parts_equal_errors_that_name_them() {
    let negative = arm_on(&joint("fixed", "")).replace("mass value=\"1\"", "mass value=\"-1\"");
    assert_error!(&negative, NegativeMass, ["\"arm\"", "-1"]);
    let massless = arm_on(&joint("continuous", "")).replace(INERTIAL, "");
    let options = ModelOptions::default().with_massless_links(crate::io::MasslessLinks::Refused);
    let error = options.load_urdf_str(&massless).unwrap_err();
    assert!(matches!(error, LoadError::MissingInertia { .. }), "{error}");
    assert!(
        error.to_string().contains("joint \"j\" (link \"arm\""),
        "{error}"
    );
    let mesh = "<visual><geometry><mesh filename='a.stl' scale='1 0 1'/></geometry></visual>";
    let flat = robot(&format!("<link name='arm'>{mesh}</link>"));
    assert_error!(&flat, Malformed, ["\"arm\"", "scale = \"0\"", "flat"]);
    let flat = arm_on(&joint("planar", "<axis xyz='0 0 0'/>"));
    assert_error!(&flat, ZeroAxis, ["\"j\""]);
    for limit in ["lower='1' upper='-1'", "velocity='-1'", "effort='-2'"] {
        let text = arm_on(&joint("revolute", &format!("<limit {limit}/>")));
        assert_error!(&text, InvalidLimits, ["\"j\""]);
    }
    for leader in ["j", "absent"] {
        let text = arm_on(&joint("continuous", &format!("<mimic joint='{leader}'/>")));
        assert_error!(&text, InvalidMimic, ["\"j\"", leader]);
    }
}

#[test]
fn graphs_that_are_no_trees_equal_errors_that_name_the_joint() {
    let links = |names: &[&str]| -> String {
        let link = |name: &&str| format!("<link name='{name}'>{INERTIAL}</link>");
        names.iter().map(link).collect()
    };
    let edge = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name='{name}' type='continuous'><parent link='{parent}'/><child link='{child}'/></joint>"
        )
    };
    let build = |names: &[&str], edges: &[String]| robot(&(links(names) + &edges.concat()));

    let twice = build(&["a", "a"], &[]);
    assert_error!(&twice, DuplicateName, ["link", "\"a\""]);
    let twice = build(
        &["a", "b", "c"],
        &[edge("j", "a", "b"), edge("j", "a", "c")],
    );
    assert_error!(&twice, DuplicateName, ["joint", "\"j\""]);
    let lost = build(&["a"], &[edge("j", "b", "a")]);
    assert_error!(&lost, UnknownParent, ["joint", "\"j\"", "\"b\""]);
    let lost = build(&["a"], &[edge("j", "a", "b")]);
    assert_error!(&lost, UnknownChild, ["\"j\"", "\"b\""]);
    for (edges, loop_) in [
        (vec![edge("j", "a", "a")], "link \"a\" back to it: j;"),
        (
            vec![edge("j", "a", "b"), edge("j2", "b", "a")],
            "link \"b\" back to it: j2, j;",
        ),
        (
            vec![
                edge("j", "c", "a"),
                edge("i", "a", "b"),
                edge("k", "b", "c"),
            ],
            "link \"a\" back to it: i, k, j;",
        ),
    ] {
        let text = build(&["a", "b", "c"], &edges);
        assert_error!(&text, Loop, [loop_, "Constraint"]);
    }
    let twice = build(
        &["a", "b", "c"],
        &[edge("i", "c", "a"), "\n".into(), edge("j", "b", "a")],
    );
    assert_error!(&twice, SeveralParents, [":2:", "\"i\"", "\"j\"", "\"a\""]);
    assert_error!(&build(&["a", "b"], &[]), SeveralRoots, ["a, b"]);
}

#[test]
fn a_world_with_a_moving_child_cannot_float() {
    let text = arm_on(&joint("continuous", ""));
    let options = ModelOptions::default().with_base(Base::Floating);
    let error = options.load_urdf_str(&text).unwrap_err();
    assert!(
        matches!(error, LoadError::UnsupportedBase { .. }),
        "{error:?}"
    );
    let message = error.to_string();
    for part in ["URDF text:1:", "\"world\"", "fixed base", "rename the link"] {
        assert!(message.contains(part), "{part} is not in: {message}");
    }
    // Both ways out.
    let renamed = text.replace("\"world\"", "\"frame\"");
    let renamed = options.load_urdf_str(&renamed).unwrap().0;
    let fixed = ModelOptions::default().with_base(Base::Fixed);
    let fixed = fixed.load_urdf_str(&text).unwrap().0;
    assert_eq!((fixed.nv(), renamed.nv()), (1, 7));
}
