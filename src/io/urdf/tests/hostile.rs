//! Files that are meant to break a reader, or that chance broke.

use proptest::prelude::*;

use super::*;
use crate::io::damage::{changes, damaged, on_small_stack};

const CARTPOLE: &str = include_str!("../../../../assets/cartpole.urdf");

/// A chain of `n` moving links on a fixed base.
fn chain(n: usize) -> String {
    let link = |i: usize| {
        let parent = if i == 0 {
            "world".into()
        } else {
            format!("l{}", i - 1)
        };
        format!(
            r#"<link name="l{i}">{INERTIAL}</link><joint name="j{i}" type="continuous">
               <parent link="{parent}"/><child link="l{i}"/><origin xyz="0 0 1"/></joint>"#
        )
    };
    robot(&format!(
        r#"<link name="world"/>{}"#,
        (0..n).map(link).collect::<String>()
    ))
}

#[test]
fn a_long_chain_loads_on_a_small_stack_with_all_its_links() {
    const LINKS: usize = 5_000;
    let model = on_small_stack(|| Model::from_urdf_str(&chain(LINKS)).unwrap());
    assert_eq!((model.nv(), model.links().len()), (LINKS, LINKS + 1));
}

#[test]
fn any_depth_of_nesting_ends_in_a_model_or_an_error() {
    const DEPTH: usize = 100_000;
    on_small_stack(|| {
        let (open, close) = ("<x>".repeat(DEPTH), "</x>".repeat(DEPTH));
        let nested = |place: &str| place.replace("NESTED", &format!("{open}{close}"));
        let inside = robot(
            "<link name='a'><inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1'/></inertial>NESTED</link>",
        );
        assert_eq!(
            places(&load(&nested(&inside)).1.ignored),
            [("robot/link/x", "a", 1)]
        );
        assert!(matches!(
            error(&nested("NESTED")),
            LoadError::NotARobot { .. }
        ));
        assert!(matches!(error(&open), LoadError::NotXml { .. }));
        assert!(matches!(
            error(&"<robot>".repeat(DEPTH)),
            LoadError::NotXml { .. }
        ));
    });
}

#[test]
fn entity_bombs_equal_an_error_that_names_the_line() {
    let bomb = "<?xml version='1.0'?>\n<!DOCTYPE r [<!ENTITY a 'aaaa'><!ENTITY b '&a;&a;'>]>\n<robot name='&b;'/>";
    let error = error(bomb);
    assert!(
        matches!(error, LoadError::UnsupportedXml { line: 2, .. }),
        "{error:?}"
    );
}

#[test]
fn floods_of_attributes_and_name_spaces_equal_errors_at_once() {
    let attributes: String = (0..100_000).map(|i| format!(" a{i}='0'")).collect();
    let flood = error(&format!("<robot>\n<link{attributes}/></robot>"));
    assert!(
        matches!(flood, LoadError::UnsupportedXml { line: 2, .. }),
        "{flood:?}"
    );
    let spaces: String = (0..100_000)
        .map(|i| format!("<x xmlns:a{i}='u{i}'>"))
        .collect();
    let flood = error(&format!("<robot>{spaces}"));
    assert!(
        matches!(flood, LoadError::UnsupportedXml { line: 1, .. }),
        "{flood:?}"
    );
    // Those in comments do not count.
    let commented = CARTPOLE.replace("</robot>", &format!("<!-- <a{attributes}/> --></robot>"));
    assert!(Model::from_urdf_str(&commented).is_ok());
}

#[test]
fn byte_order_mark_line_ends_and_name_spaces_change_nothing() {
    let (plain, _) = load(CARTPOLE);
    let declared = "<robot xmlns='http://www.ros.org' xmlns:xacro='http://ros.org/wiki/xacro'";
    for text in [
        format!("\u{feff}{CARTPOLE}"),
        CARTPOLE.replace('\n', "\r\n"),
        CARTPOLE.replacen("<robot", declared, 1),
    ] {
        let (model, report) = load(&text);
        assert_eq!(format!("{model:?}"), format!("{plain:?}"));
        assert_eq!(report.ignored, []);
    }
}

/// Pieces that mean something, to be put anywhere.
const SNIPPETS: &[&str] = &[
    "<",
    ">",
    "/>",
    "\"",
    "&",
    "&#0;",
    "&lt;",
    "nan",
    "-inf",
    "1e999",
    "]]>",
    "<!--",
    "<!DOCTYPE",
    "xmlns:a=\"b\" ",
    "</link>",
    "<limit/>",
    "<mimic joint=\"pivot\"/>",
    "\u{0}",
    "\u{feff}",
    "é",
    "<visual><geometry><mesh filename=\"package://a/b\"/></geometry></visual>",
];

/// Words that mean something, to be exchanged.
const WORDS: &[&str] = &[
    "\"world\"",
    "\"rail\"",
    "\"cart\"",
    "\"pole\"",
    "\"linear\"",
    "\"pivot\"",
    "\"prismatic\"",
    "\"continuous\"",
    "\"fixed\"",
    "\"floating\"",
    "\"planar\"",
];

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(800) })]

    #[test]
    fn any_damage_ends_in_a_model_or_an_error(changes in changes(SNIPPETS, WORDS)) {
        let text = damaged(CARTPOLE, changes);
        match ModelOptions::default().load_urdf_str(&text) {
            Ok((model, report)) => {
                prop_assert!(model.links().len() <= text.len());
                prop_assert!(report.to_string().starts_with("URDF text"));
            }
            Err(error) => prop_assert!(error.to_string().contains("URDF text")),
        }
    }
}
