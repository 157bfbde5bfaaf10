//! One bad file per error.

use super::*;

macro_rules! assert_error {
    ($text:expr, $pattern:pat, $($part:expr),*) => {
        let text = $text;
        let error = error(&text);
        assert!(matches!(error, $pattern), "{error:?}\n{text}");
        let message = error.to_string();
        for part in ["SDF text", $($part),*] {
            assert!(message.contains(part), "{part} is not in: {message}");
        }
    };
}

#[test]
fn bad_files_equal_errors_that_name_the_place() {
    use LoadError as E;
    let a = || link("a", "");
    let j = |kind: &str, parts: &str| robot(&(a() + &joint("j", kind, "world", "a", parts)));
    assert_error!(" ".to_owned(), E::Empty { .. }, "empty");
    assert_error!(
        "<robot/>".to_owned(),
        E::NotARobot { .. },
        "<robot>",
        "expected <sdf>"
    );
    assert_error!("<sdf".to_owned(), E::NotXml { .. }, ":1:");
    assert_error!("<sdf/>".to_owned(), E::Missing { .. }, "version");
    assert_error!(
        "<sdf version='x'/>".to_owned(),
        E::Malformed { .. },
        "version",
        "x"
    );
    assert_error!(
        "<sdf version='1.9'/>".to_owned(),
        E::ModelChoice { .. },
        "no model"
    );
    assert_error!(
        "<sdf version='1.9'><model/></sdf>".to_owned(),
        E::Missing { .. },
        "attribute name"
    );
    assert_error!(robot(""), E::Missing { .. }, "link");
    assert_error!(
        robot("<link/>"),
        E::Missing { .. },
        "link",
        "attribute name"
    );
    assert_error!(
        robot(&(a() + &a())),
        E::DuplicateName { .. },
        "link",
        "\"a\""
    );
    assert_error!(
        robot(&(a() + "<frame name='a'/>")),
        E::DuplicateName { .. },
        "frame",
        "\"a\""
    );
    assert_error!(
        robot("<link name='world'/>"),
        E::Malformed { .. },
        "reserved"
    );
    assert_error!(
        robot(&link("a", "<pose>1 2 3</pose>")),
        E::Malformed { .. },
        "pose",
        "expected 6"
    );
    assert_error!(
        robot(&link("a", "<pose>1 2 nan 0 0 0</pose>")),
        E::NonFinite { .. },
        "pose",
        "\"a\""
    );
    assert_error!(
        robot(&link(
            "a",
            "<pose rotation_format='quat_xyzw'>1 2 3 0 0 0 0</pose>"
        )),
        E::Malformed { .. },
        "norm"
    );
    assert_error!(
        robot(&link("a", "<pose rotation_format='x'>1 2 3 0 0 0</pose>")),
        E::Malformed { .. },
        "rotation_format"
    );
    assert_error!(
        robot(&link(
            "a",
            "<pose rotation_format='quat_xyzw' degrees='true'>1 2 3 0 0 0 1</pose>"
        )),
        E::Malformed { .. },
        "degrees"
    );
    assert_error!(
        robot(&link("a", "<pose relative_to='b'/>")),
        E::UnknownFrame { .. },
        "link",
        "\"a\"",
        "\"b\""
    );
    assert_error!(
        robot(&link("a", "<pose relative_to='world'/>")),
        E::UnknownFrame { .. },
        "\"world\""
    );
    assert_error!(
        robot(&link("a", "<pose relative_to='a'/>")),
        E::FrameCycle { .. },
        "\"a\""
    );
    let cycle = link("a", "<pose relative_to='b'/>")
        + &link("b", "<pose relative_to='c'/>")
        + &link("c", "<pose relative_to='a'/>");
    assert_error!(robot(&cycle), E::FrameCycle { .. }, "itself");
    let cycle = a()
        + "<frame name='f' attached_to='g'><pose relative_to='a'/></frame><frame name='g' attached_to='f'><pose relative_to='a'/></frame>";
    assert_error!(robot(&cycle), E::FrameCycle { .. }, "frame");
    assert_error!(
        robot(&a().replace("<mass>1", "<mass>x")),
        E::Malformed { .. },
        "inertial",
        "mass",
        "\"a\""
    );
    assert_error!(
        robot(&a().replace("<mass>1", "<mass>-1")),
        E::NegativeMass { .. },
        "\"a\""
    );
    assert_error!(
        robot(&a().replace("<ixx>1", "<ixx>inf")),
        E::NonFinite { .. },
        "ixx"
    );
    assert_error!(j("", ""), E::Missing { .. }, "\"j\"", "type");
    assert_error!(
        j("hinge", ""),
        E::Malformed { .. },
        "\"j\"",
        "hinge",
        "revolute"
    );
    assert_error!(
        j("screw", "<thread_pitch>0</thread_pitch>"),
        E::Malformed { .. },
        "\"j\"",
        "thread_pitch",
        "no thread"
    );
    assert_error!(j("gearbox", ""), E::Unsupported { .. }, "\"j\"", "gearbox");
    assert_error!(
        j("revolute", "<axis><xyz>0 0 0</xyz></axis>"),
        E::ZeroAxis { .. },
        "\"j\""
    );
    assert_error!(
        j("revolute", "<axis><xyz expressed_in='b'>0 0 1</xyz></axis>"),
        E::UnknownFrame { .. },
        "\"b\""
    );
    assert_error!(
        j("revolute", "<axis><limit><lower>nan</lower></limit></axis>"),
        E::NonFinite { .. },
        "lower"
    );
    assert_error!(
        j(
            "revolute",
            "<axis><limit><lower>2</lower><upper>1</upper></limit></axis>"
        ),
        E::InvalidLimits { .. },
        "\"j\""
    );
    assert_error!(
        j("revolute", "<axis><mimic joint='k'/></axis>"),
        E::UnknownFrame { .. },
        "\"k\""
    );
    assert_error!(
        j("revolute", "<axis><mimic joint='j'/></axis>"),
        E::InvalidMimic { .. },
        "itself"
    );
    assert_error!(
        robot(&(a() + &joint("j", "fixed", "b", "a", ""))),
        E::UnknownParent { .. },
        "\"b\""
    );
    assert_error!(
        robot(&(a() + &joint("j", "fixed", "a", "b", ""))),
        E::UnknownFrame { .. },
        "\"b\""
    );
    assert_error!(
        robot(&(a() + &joint("j", "fixed", "a", "a", ""))),
        E::Loop { .. },
        "to it: j"
    );
    let triangle = a()
        + &link("b", "")
        + &joint("j", "revolute", "a", "b", "")
        + &joint("k", "revolute", "a", "b", "");
    assert_error!(
        robot(&triangle),
        E::Loop { .. },
        "to it: k, j",
        "Constraint"
    );
    assert_error!(
        robot(&(a() + &link("b", ""))),
        E::SeveralRoots { .. },
        "a, b"
    );
    assert_error!(
        robot(&(a() + &link("b", "") + &anchor("b"))),
        E::SeveralRoots { .. },
        "world, a"
    );
    assert_error!(robot("<include/>"), E::Missing { .. }, "uri");
    assert_error!(
        robot("<include><uri>model://none</uri></include>"),
        E::Include { .. },
        "model://none",
        "no such file"
    );
    assert_error!(
        robot("<static>maybe</static>"),
        E::Malformed { .. },
        "maybe"
    );
    assert_error!(robot("<link name='${n}'/>"), E::NotExpanded { .. }, "${n}");
    let deep = "<model name='m'>".repeat(60) + &"</model>".repeat(60);
    assert_error!(robot(&deep), E::Unsupported { .. }, "deep");
}

#[test]
fn choice_of_a_model_equals_the_one_that_is_named_or_an_error_with_the_names() {
    let model = |name: &str| format!("<model name='{name}'>{}</model>", link("a", ""));
    let world = format!(
        "<sdf version='1.9'><world name='w'>{}{}<include><uri>model://ball</uri></include></world></sdf>",
        model("left"),
        model("right")
    );
    assert_error!(
        &world,
        LoadError::ModelChoice { .. },
        "left, right, ball",
        "the option model_name"
    );
    let load = |name: &str| {
        ModelOptions::default()
            .with_model_name(name)
            .load_sdf_str(&world)
    };
    let (chosen, report) = load("right").unwrap();
    assert_eq!((chosen.name(), report.ignored.len()), ("right", 2));
    let message = load("middle").unwrap_err().to_string();
    assert!(
        message.contains("no model \"middle\"") && message.contains("left, right, ball"),
        "{message}"
    );
    assert!(matches!(load("ball"), Err(LoadError::Include { .. })));
}
