//! Files that are meant to break a reader, or that chance broke.

use proptest::prelude::*;

use super::*;

const CARTPOLE: &str = include_str!("../../../../assets/cartpole.urdf");

/// The stack of a thread that Rust starts, less than that of the main thread.
const SMALL_STACK: usize = 2 << 20;

fn on_small_stack<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> T {
    let thread = std::thread::Builder::new().stack_size(SMALL_STACK);
    thread.spawn(work).unwrap().join().unwrap()
}

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

/// A change of a text, at places given as parts of its length.
#[derive(Clone, Debug)]
enum Change {
    Delete(f64, usize),
    Duplicate(f64, usize, f64),
    Overwrite(f64, Vec<u8>),
    Insert(f64, &'static str),
}

fn change() -> impl Strategy<Value = Change> {
    let snippets = prop::sample::select(vec![
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
    ]);
    prop_oneof![
        (0.0..1.0, 1..200_usize).prop_map(|(at, n)| Change::Delete(at, n)),
        (0.0..1.0, 1..400_usize, 0.0..1.0).prop_map(|(at, n, to)| Change::Duplicate(at, n, to)),
        (0.0..1.0, prop::collection::vec(any::<u8>(), 1..8))
            .prop_map(|(at, bytes)| Change::Overwrite(at, bytes)),
        (0.0..1.0, snippets).prop_map(|(at, snippet)| Change::Insert(at, snippet)),
    ]
}

fn apply(text: &mut Vec<u8>, change: Change) {
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "a place in a short text"
    )]
    let place = |text: &[u8], part: f64| (part * text.len() as f64) as usize;
    let span = |text: &[u8], at: usize, n: usize| at..(at + n).min(text.len());
    match change {
        Change::Delete(at, n) => {
            let at = place(text, at);
            text.drain(span(text, at, n));
        }
        Change::Duplicate(at, n, to) => {
            let (at, to) = (place(text, at), place(text, to));
            let copy = text[span(text, at, n)].to_vec();
            text.splice(to..to, copy);
        }
        Change::Overwrite(at, bytes) => {
            let at = place(text, at);
            text.splice(span(text, at, bytes.len()), bytes);
        }
        Change::Insert(at, snippet) => {
            let at = place(text, at);
            text.splice(at..at, snippet.bytes());
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(800) })]

    #[test]
    fn any_damage_ends_in_a_model_or_an_error(changes in prop::collection::vec(change(), 1..5)) {
        let mut text = CARTPOLE.as_bytes().to_vec();
        for change in changes {
            apply(&mut text, change);
        }
        let text = String::from_utf8_lossy(&text);
        match ModelOptions::default().load_urdf_str(&text) {
            Ok((model, report)) => {
                prop_assert!(model.links().len() <= text.len());
                prop_assert!(report.to_string().starts_with("URDF text"));
            }
            Err(error) => prop_assert!(error.to_string().contains("URDF text")),
        }
    }
}
