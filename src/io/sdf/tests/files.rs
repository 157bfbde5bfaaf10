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

/// A model of two links with the frame `f`, whose link `tip` stands 1 above its frame.
fn finger() -> String {
    let parts = link("root", "")
        + &link("tip", "<pose>0 0 1 0 0 0</pose>")
        + "<frame name='f'><pose>0 1 0 0 0 0</pose></frame>"
        + &joint(
            "bend",
            "revolute",
            "root",
            "tip",
            "<axis><xyz expressed_in='__model__'>1 0 0</xyz></axis>",
        );
    file(&parts)
}

#[test]
fn merged_models_equal_nested_ones_under_names_without_prefix() {
    let root = Folder::new();
    root.write("finger.sdf", finger());
    let hand = |merge: bool, prefix: &str| {
        let include = format!(
            "<include merge='{merge}'><uri>finger.sdf</uri><name>n</name><placement_frame>tip</placement_frame><pose>1 0 0 0 0 {QUARTER}</pose></include>"
        );
        let text = link("palm", "")
            + &include
            + &joint("knuckle", "revolute", "palm", &format!("{prefix}root"), "")
            + &format!("<frame name='on' attached_to='{prefix}tip'/>")
            + &anchor("palm");
        let (model, report) = ModelOptions::default()
            .load_sdf_file(root.write("hand.sdf", file(&text)))
            .unwrap();
        assert!(report.ignored.is_empty(), "{report}");
        model
    };
    let (nested, merged) = (hand(false, "n::"), hand(true, ""));
    let without_prefix = |name: &str| name.replace("n::", "");
    let names: Vec<String> = (nested.frame_names().iter())
        .map(|name| without_prefix(name))
        .collect();
    assert_eq!(merged.frame_names(), names);
    assert_eq!(merged.joint_names(), ["knuckle", "bend"]);
    let q = [0.3, -0.7];
    for frame in nested.frame_names() {
        let (nested, merged) = (
            pose_at(&nested, &q, frame),
            pose_at(&merged, &q, &without_prefix(frame)),
        );
        assert_eq!(nested, merged, "{frame}");
    }
    // The tip is put at (1, 0, 0), turned; the model's frame is 1 below, and f at its y axis, which is −x here.
    assert_at(&pose(&merged, "tip"), [1., 0., 0.], [0., 1., 0.]);
    assert_at(&pose(&merged, "root"), [1., 0., -1.], [0., 1., 0.]);
    assert_at(&pose(&merged, "on"), [1., 0., 0.], [0., 1., 0.]);
    assert_at(&pose(&merged, "f"), [0., 0., -1.], [0., 1., 0.]);
}

#[test]
fn models_merged_into_merged_ones_stand_where_the_poses_add_up() {
    let root = Folder::new();
    root.write("a.sdf", file(&link("a", "<pose>0 0 1 0 0 0</pose>")));
    let merge = |uri: &str| {
        format!("<include merge='1'><uri>{uri}</uri><pose>1 0 0 0 0 0</pose></include>")
    };
    root.write(
        "b.sdf",
        file(
            &(merge("a.sdf")
                + &link("b", "<pose relative_to='a'>0 1 0 0 0 0</pose>")
                + &joint("j", "fixed", "a", "b", "")),
        ),
    );
    let path = root.write("c.sdf", file(&(merge("b.sdf") + "<static>1</static>")));
    let model = Model::from_sdf_file(path).unwrap();
    assert_at(&pose(&model, "a"), [2., 0., 1.], [1., 0., 0.]);
    assert_at(&pose(&model, "b"), [2., 1., 1.], [1., 0., 0.]);
    // The first link is the one that a merged model brings: what is attached to the model is attached to it.
    let path = root.write(
        "d.sdf",
        file(
            &(merge("b.sdf")
                + &link("own", "")
                + &joint("turn", "revolute", "a", "own", "")
                + "<frame name='f'/>"),
        ),
    );
    let model = Model::from_sdf_file(path).unwrap();
    let turned = [0., 0., 0., 1., 0., 0., 0., 1.];
    let [a, f] = ["a", "f"].map(|frame| pose_at(&model, &turned, frame));
    assert_at(&(a.inverse() * f), [-2., 0., -1.], [1., 0., 0.]);
}

#[test]
fn merging_what_cannot_be_merged_equals_an_error_or_a_remark() {
    let root = Folder::new();
    root.write(
        "finger.sdf",
        finger().replace("<frame", "<static>1</static><frame"),
    );
    let load = |text: String| ModelOptions::default().load_sdf_file(root.write("r.sdf", text));
    let merge = "<include merge='true'><uri>finger.sdf</uri><static>0</static></include>";
    let error = load(file(&(link("tip", "") + merge))).unwrap_err();
    assert!(
        matches!(&error, LoadError::DuplicateName { name, at, .. } if name == "tip" && at.file.ends_with("finger.sdf") && at.line > 0),
        "{error:?}"
    );
    let error = load(format!(
        "<sdf version='1.9'><world name='w'>{merge}</world></sdf>"
    ))
    .unwrap_err();
    assert!(
        error
            .to_string()
            .contains("<world/include> \"w\": models are merged into models"),
        "{error}"
    );
    let error = load(file(
        "<include merge='perhaps'><uri>finger.sdf</uri></include>",
    ))
    .unwrap_err();
    assert!(matches!(error, LoadError::Malformed { .. }), "{error:?}");
    let (model, report) = load(file(merge)).unwrap();
    assert_eq!(model.nv(), 7);
    let lines = places(&report.ignored);
    assert_eq!(
        lines,
        [
            ("sdf/model/include/static", "r", 1),
            ("sdf/model/static", "r", 1)
        ]
    );
}

#[test]
fn folders_of_models_mean_the_file_that_their_configuration_names() {
    let root = Folder::new();
    let config = "<?xml version='1.0'?><model><name>ball</name>
        <sdf version='1.4'>old.sdf</sdf><sdf version='1.9'>new.sdf</sdf><sdf version='2.0'>future.sdf</sdf><sdf>plain.sdf</sdf></model>";
    root.write("models/ball/model.config", config);
    let ball = |z: f64| file(&link("ball", &format!("<pose>0 0 {z} 0 0 0</pose>")));
    root.write("models/ball/new.sdf", ball(9.0));
    root.write("models/ball/old.sdf", ball(4.0));
    root.write("models/ball/model.sdf", ball(1.0));
    let include =
        |uri: &str| format!("<static>1</static><include><uri>{uri}</uri><name>n</name></include>");
    let load = |uri: &str, search_path: &str| {
        let path = root.write("robot/r.sdf", file(&include(uri)));
        let options = ModelOptions::default().with_search_path(root.path(search_path));
        options.load_sdf_file(path)
    };
    for (uri, search_path) in [
        ("model://ball", "models"),
        ("model://ball/", "models"),
        ("model://ball", "models/ball"),
        ("model://models/ball", "models"),
        ("../models/ball", "none"),
        ("model://ball/new.sdf", "models"),
    ] {
        let (model, _) = load(uri, search_path).unwrap();
        assert_at(&pose(&model, "n::ball"), [0., 0., 9.], [1., 0., 0.]);
    }
    let folder = format!("file://{}", root.path("models/ball").display());
    assert!(load(&folder, "none").is_ok());
    // A folder that is given is not the model of every name.
    assert!(matches!(
        load("model://cube", "models/ball"),
        Err(LoadError::Include { .. })
    ));
    for (config, expected) in [
        (
            "<model/>",
            "model.config:1: <model> \"on line 1\" has no child element <sdf>",
        ),
        (
            "<model><sdf version='1.9'>none.sdf</sdf></model>",
            "file = \"none.sdf\": there is no such file",
        ),
        ("<sdf/>", "does not describe a model"),
        ("", "does not describe a model"),
    ] {
        root.write("models/ball/model.config", config);
        let error = load("model://ball", "models").unwrap_err().to_string();
        assert!(
            error.contains("model.config") && error.contains(expected),
            "{error}"
        );
    }
    std::fs::remove_file(root.path("models/ball/model.config")).unwrap();
    let (model, _) = load("model://ball", "models").unwrap();
    assert_at(&pose(&model, "n::ball"), [0., 0., 1.], [1., 0., 0.]);
}
