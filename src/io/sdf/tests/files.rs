//! Files that include files.

use super::*;
use crate::io::temporary::Folder;

fn file(parts: &str) -> String {
    robot_of("1.8", parts)
}

#[test]
fn included_models_stand_where_the_file_puts_them() {
    let root = Folder::new();
    root.write(
        "models/finger/model.sdf",
        file(&(link("tip", "<pose>0 0 1 0 0 0</pose>") + "<plugin name='x'/>")),
    );
    let include = |name: &str, uri: &str, y: f64| {
        format!("<include><uri>{uri}</uri><name>{name}</name><pose>0 {y} 0 0 0 0</pose></include>")
    };
    let text = link("palm", "")
        + &include("left", "model://finger", 1.0)
        + &include("right", "../models/finger", -1.0)
        + &joint("l", "revolute", "palm", "left::tip", "")
        + &joint("r", "revolute", "palm", "right::tip", "")
        + &anchor("palm");
    let path = root.write("hand/hand.sdf", file(&text));
    let options = ModelOptions::default().with_search_path(root.path("models"));
    let (model, report) = options.load_sdf_file(&path).unwrap();
    assert_eq!(model.nv(), 2);
    assert_at(&pose(&model, "left::tip"), [0., 1., 1.], [1., 0., 0.]);
    assert_at(&pose(&model, "right::tip"), [0., -1., 1.], [1., 0., 0.]);
    let note = report.ignored[0].to_string();
    assert!(
        note.contains("plugin") && note.contains("model.sdf)"),
        "{note}"
    );
}

#[test]
fn placement_and_stillness_of_an_include_replace_those_of_the_model() {
    let root = Folder::new();
    root.write("m.sdf", file(&link("tip", "<pose>0 0 1 0 0 0</pose>")));
    let include = "<include><uri>m.sdf</uri><name>n</name><static>1</static><placement_frame>tip</placement_frame><pose>3 0 0 0 0 0</pose></include>";
    let path = root.write("r.sdf", file(include));
    let model = Model::from_sdf_file(path).unwrap();
    assert_eq!(model.nv(), 0);
    assert_at(&pose(&model, "n::tip"), [3., 0., 0.], [1., 0., 0.]);
}

#[test]
fn a_world_that_includes_its_robot_loads_it() {
    let root = Folder::new();
    root.write("ball/model.sdf", file(&link("ball", "")));
    let world = "<sdf version='1.6'><world name='w'><include><uri>model://ball</uri></include><light name='sun'/></world></sdf>";
    let path = root.write("w.world", world);
    let model = Model::from_sdf_file(path).unwrap();
    assert_eq!(
        (model.name(), model.nv(), model.gravity().z),
        ("r", 6, -9.8)
    );
}

#[test]
fn files_that_include_themselves_or_too_much_equal_errors() {
    let root = Folder::new();
    let include =
        |uri: &str, name: &str| format!("<include><uri>{uri}</uri><name>{name}</name></include>");
    let path = root.write("a.sdf", file(&include("b.sdf", "b")));
    root.write("b.sdf", file(&include("a.sdf", "a")));
    let error = Model::from_sdf_file(path).unwrap_err();
    assert!(error.to_string().contains("includes itself"), "{error}");
    // Twice the next file, twenty files deep: a million models.
    for i in 0..20 {
        let next = format!("n{}.sdf", i + 1);
        root.write(
            &format!("n{i}.sdf"),
            file(&(include(&next, "x") + &include(&next, "y"))),
        );
    }
    root.write("n20.sdf", file(&link("l", "")));
    let error = Model::from_sdf_file(root.path("n0.sdf")).unwrap_err();
    assert!(error.to_string().contains("too many files"), "{error}");
    let missing = Model::from_sdf_file(root.path("none.sdf")).unwrap_err();
    assert!(matches!(missing, LoadError::Io { .. }));
}
