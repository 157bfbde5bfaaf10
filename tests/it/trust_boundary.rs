//! Trust boundary: files that a description from others can make the program read, and the content that it can reveal.

use std::fs;
use std::path::{Path, PathBuf};

use dualbody::contact::{ContactLaw, Contacts, Rigid, Terrain};
use dualbody::io::ImportReport;
use dualbody::model::{Geometry, samples};
use dualbody::view::{Recording, model_page};
use dualbody::{LoadError, Model, ModelOptions};

const INERTIAL: &str = "<inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>";

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

/// An SDF model of one link with these parts.
fn sdf(parts: &str) -> String {
    let inertial = "<inertial><mass>1</mass><inertia><ixx>1</ixx><iyy>1</iyy><izz>1</izz></inertia></inertial>";
    format!(
        "<sdf version='1.9'><model name='m'><link name='l'>{inertial}</link>{parts}</model></sdf>"
    )
}

/// A URDF robot of one link with these meshes to show and to touch.
fn urdf(meshes: &[String]) -> String {
    let shape = |uri: &String| {
        let mesh = format!("<geometry><mesh filename='{uri}'/></geometry>");
        format!("<visual>{mesh}</visual><collision>{mesh}</collision>")
    };
    let shapes: String = meshes.iter().map(shape).collect();
    format!("<robot name='r'><link name='l'>{INERTIAL}{shapes}</link></robot>")
}

/// Two folders for a test of this name: one for robots, and one that is not theirs.
struct Folders {
    robots: PathBuf,
    private: PathBuf,
}

impl Folders {
    fn new(test: &str) -> Self {
        let folder = Path::new(env!("CARGO_TARGET_TMPDIR"))
            .join("trust")
            .join(test);
        let _ = fs::remove_dir_all(&folder);
        let made = ["robots", "private"].map(|name| folder.join(name));
        made.iter()
            .for_each(|folder| fs::create_dir_all(folder).expect("a folder"));
        let [robots, private] = made;
        Self { robots, private }
    }

    fn robot(&self, name: &str, text: &str) -> PathBuf {
        write(&self.robots, name, text)
    }

    fn secret(&self, name: &str, text: &str) -> PathBuf {
        write(&self.private, name, text)
    }

    fn options(&self) -> ModelOptions {
        ModelOptions::default()
            .with_search_path(&self.private)
            .with_root(&self.robots)
    }
}

fn write(folder: &Path, name: &str, text: &str) -> PathBuf {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
    fs::write(&path, text).expect("a file");
    path
}

fn paths(model: &Model) -> Vec<Option<PathBuf>> {
    let visuals = model.links().iter().flat_map(|link| &link.visuals);
    let path = |geometry: &Geometry| match geometry {
        Geometry::Mesh { path, .. } => path.clone(),
        _ => None,
    };
    visuals.map(|visual| path(&visual.geometry)).collect()
}

fn reasons(report: &ImportReport) -> Vec<&str> {
    report
        .warnings
        .iter()
        .map(|note| note.reason.as_str())
        .collect()
}

#[test]
fn meshes_are_found_below_the_root_only_by_whatever_name() {
    let folders = Folders::new("meshes");
    let secret = folders.secret("pkg/secret.obj", TRIANGLE);
    folders.robot(
        "pkg/open.obj",
        &format!("mtllib ../../private/pkg/secret.obj\n{TRIANGLE}"),
    );
    let mut uris = vec![
        "pkg/open.obj".to_owned(),
        "package://pkg/open.obj".into(),
        "../private/../robots/pkg/open.obj".into(),
        secret.display().to_string(),
        format!("file://{}", secret.display()),
        "../private/pkg/secret.obj".into(),
        "package://pkg/secret.obj".into(),
        "package://pkg/../../private/pkg/secret.obj".into(),
        "model://private/pkg/secret.obj".into(),
    ];
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&secret, folders.robots.join("link.obj")).expect("a link");
        uris.push("link.obj".into());
    }
    let file = folders.robot("r.urdf", &urdf(&uris));
    let (open, _) = ModelOptions::default()
        .with_search_path(&folders.private)
        .load_urdf_file(&file)
        .expect("a robot");
    assert!(
        paths(&open).iter().all(Option::is_some),
        "{:?}",
        paths(&open)
    );

    let (model, report) = folders.options().load_urdf_file(&file).expect("a robot");
    let real = fs::canonicalize(folders.robots.join("pkg/open.obj")).expect("a file");
    let found = paths(&model);
    assert!(
        found[..3].iter().all(|path| path.as_ref() == Some(&real)),
        "{found:?}"
    );
    assert!(found[3..].iter().all(Option::is_none), "{found:?}");
    // Each is in a visual and in a collision.
    let warnings = reasons(&report);
    assert_eq!(warnings.len(), 2 * (uris.len() - 3));
    for uri in &uris[3..] {
        let expected = format!("the mesh \"{uri}\" is not found below the root folders");
        assert!(warnings.contains(&expected.as_str()), "{uri}: {warnings:?}");
    }
    // There, or not there: no difference.
    let none = secret.with_file_name("none.obj").display().to_string();
    let (_, report) = folders
        .options()
        .load_urdf_str(&urdf(std::slice::from_ref(&none)))
        .expect("a robot");
    let expected = format!("the mesh \"{none}\" is not found below the root folders");
    assert_eq!(reasons(&report), [&expected, &expected]);

    let page = model_page(&model);
    assert!(page.contains("it is not found below the folder of the mesh"));
    let contacts = Contacts::new(
        &model,
        Terrain::flat(0.0),
        ContactLaw::Rigid(Rigid::default()),
    );
    assert_eq!(
        (
            contacts.points().len(),
            contacts.shapes_without_points().len()
        ),
        (9, uris.len() - 3)
    );
    assert_eq!(contacts.mesh_remarks().len(), 1);
}

#[test]
fn descriptions_and_includes_are_read_below_the_roots_only() {
    let folders = Folders::new("includes");
    let secret = folders.secret("model.sdf", &sdf(""));
    folders.robot("part/model.sdf", &sdf(""));
    folders.robot(
        "config/model.config",
        "<model><sdf version='1.9'>../../private/model.sdf</sdf></model>",
    );
    let robot = |uri: &str| {
        let include = format!("<include><uri>{uri}</uri><name>n</name></include>");
        folders.robot("r.sdf", &sdf(&format!("<static>1</static>{include}")))
    };
    let options = folders.options();
    for uri in [
        "part",
        "part/model.sdf",
        "model://part",
        "model://part/model.sdf",
    ] {
        assert!(options.load_sdf_file(robot(uri)).is_ok(), "{uri}");
    }
    let private = folders.private.display();
    for uri in [
        "../private",
        "../private/model.sdf",
        &format!("{private}"),
        &format!("file://{private}/model.sdf"),
        "model://private",
        "config",
    ] {
        let file = robot(uri);
        assert!(
            ModelOptions::default().load_sdf_file(&file).is_ok(),
            "{uri}"
        );
        let error = options.load_sdf_file(&file).unwrap_err().to_string();
        assert!(error.contains("below the root folders"), "{uri}: {error}");
        assert!(
            options
                .clone()
                .with_root(&folders.private)
                .load_sdf_file(&file)
                .is_ok(),
            "{uri}"
        );
    }
    let error = options.load_sdf_file(&secret).unwrap_err();
    assert!(matches!(error, LoadError::Io { .. }), "{error}");
    let missing = options
        .load_sdf_file(secret.with_file_name("none.sdf"))
        .unwrap_err();
    assert_eq!(
        error.to_string().replace("model.sdf", ""),
        missing.to_string().replace("none.sdf", "")
    );
}

/// No description of any file but SDF: neither its root element, nor values, nor where it stops to be XML.
#[test]
fn included_files_that_are_no_sdf_are_not_quoted() {
    let folders = Folders::new("quotes");
    let robot = folders.robot("r.sdf", &sdf("<include><uri>secret</uri></include>"));
    let config = folders.robot("c.sdf", &sdf("<include><uri>folder</uri></include>"));
    for (secret, reason) in [
        ("<password>hunter2</password>", "the file is not SDF"),
        (
            "<?xml version='1.0'?><!-- <sdf> --><password>hunter2</password>",
            "the file is not SDF",
        ),
        ("password = hunter2", "the file is not SDF"),
        ("<hunter2", "the file is not SDF"),
        ("", "the file is not SDF"),
        (
            "<sdf version='hunter2'/>",
            "the file states no version of the SDF",
        ),
        ("<sdf/>", "the file states no version of the SDF"),
    ] {
        folders.robot("secret", secret);
        folders.robot("folder/model.config", secret);
        let error = Model::from_sdf_file(&robot).unwrap_err();
        assert!(
            matches!(&error, LoadError::Include { uri, .. } if uri == "secret"),
            "{error:?}"
        );
        let message = error.to_string();
        assert!(message.ends_with(reason), "{message}");
        let of_config = Model::from_sdf_file(&config).unwrap_err().to_string();
        for message in [message, of_config] {
            let words = ["hunter2", "password"];
            assert!(
                !words.iter().any(|word| message.contains(word)),
                "{message}"
            );
        }
    }
    // Errors in an SDF file are quoted in full.
    folders.robot(
        "secret",
        "<sdf version='1.9'><model name='a'><link name='a'/><link name='a'/></model></sdf>",
    );
    let error = Model::from_sdf_file(&robot).unwrap_err();
    assert!(matches!(error, LoadError::DuplicateName { .. }), "{error}");
}

/// Writing MJCF reads meshes, to see whether `MuJoCo` takes them: those that the model may name, and no others.
#[test]
fn mjcf_reads_and_names_meshes_below_the_root_only() {
    let folders = Folders::new("mjcf");
    let corners = ["0 0 0", "2 0 0", "0 3 0", "0 0 4"];
    let facet = |of: [usize; 3]| {
        let lines = of.map(|k| format!("vertex {}\n", corners[k]));
        format!(
            "facet normal 0 0 0\nouter loop\n{}endloop\nendfacet\n",
            lines.concat()
        )
    };
    let facets = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]].map(facet);
    let text = format!("solid x\n{}endsolid\n", facets.concat());
    let secret = folders.secret("secret.stl", &text.replace("2 0 0", "7.25 0 0"));
    folders.robot("open.stl", &text);
    let mut uris = vec!["open.stl".to_owned(), secret.display().to_string()];
    uris.push("../private/secret.stl".into());
    #[cfg(unix)]
    {
        std::os::unix::fs::symlink(&secret, folders.robots.join("link.stl")).expect("a link");
        uris.push("link.stl".into());
    }
    let file = folders.robot("r.urdf", &urdf(&uris));
    let (model, _) = folders.options().load_urdf_file(&file).expect("a robot");
    let mjcf = model.to_mjcf().expect("a file");
    // The triangles of the one that is allowed, and of the others only their names in the description.
    assert!(
        mjcf.contains("vertex=\"0 0 0 ") && !mjcf.contains("7.25"),
        "{mjcf}"
    );
    assert_eq!(mjcf.matches("<mesh ").count(), 1, "{mjcf}");
    // Without the root all are read.
    let mjcf = Model::from_urdf_file(&file).expect("a robot").to_mjcf();
    assert!(mjcf.expect("a file").contains("7.25"));
}

/// Each of these waited for ever, or read until the memory was full.
#[cfg(unix)]
#[test]
fn pipes_and_devices_are_refused_wherever_something_is_read() {
    let folders = Folders::new("devices");
    let pipe = folders.robots.join("pipe");
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    assert!(made.expect("a pipe").success());
    for path in [pipe.as_path(), Path::new("/dev/zero")] {
        let reason = |error: &dyn std::error::Error| {
            assert!(
                error.to_string().contains("is not a regular file"),
                "{error}"
            );
        };
        reason(&Model::from_urdf_file(path).unwrap_err());
        reason(&Model::from_sdf_file(path).unwrap_err());
        let arm = samples::arm();
        reason(&Recording::read_csv(path, &[&arm]).unwrap_err());
        reason(&Recording::read_json(path, &[&arm]).unwrap_err());
        let uri = path.display();
        let text = sdf(&format!("<include><uri>{uri}</uri></include>"));
        let error = Model::from_sdf_str(&text).unwrap_err();
        assert!(matches!(error, LoadError::Include { .. }), "{error}");
        let (_, report) = ModelOptions::default()
            .load_urdf_str(&urdf(&[uri.to_string()]))
            .expect("a robot");
        assert_eq!(reasons(&report).len(), 2);
    }
    // It calls itself a regular file of no bytes.
    let kernel = Path::new("/proc/kmsg");
    if kernel.is_file() {
        let mesh = folders.robots.join("kernel.stl");
        std::os::unix::fs::symlink(kernel, &mesh).expect("a link");
        let robot = Model::from_urdf_str(&urdf(&[mesh.display().to_string()]));
        let mjcf = robot.expect("a robot").to_mjcf().expect("a file");
        assert!(!mjcf.contains("<mesh "), "{mjcf}");
        let text = sdf("<include><uri>/proc/kmsg</uri></include>");
        let error = Model::from_sdf_str(&text).unwrap_err().to_string();
        assert!(error.ends_with("the file is not SDF"), "{error}");
        assert!(matches!(
            Model::from_urdf_file(kernel),
            Err(LoadError::Empty { .. })
        ));
    }
}

#[test]
fn larger_descriptions_than_any_robots_are_refused_unread() {
    let folders = Folders::new("size");
    let path = folders.robot("large.urdf", "");
    let file = fs::File::create(&path).expect("a file");
    file.set_len((64 << 20) + 1).expect("a sparse file");
    let error = Model::from_urdf_file(&path).unwrap_err().to_string();
    assert!(
        error.ends_with("has 67108865 bytes, more than 67108864"),
        "{error}"
    );
    // Nor together: a file of half that size, again and again.
    let part = sdf(&format!("<!-- {} -->", " ".repeat(33 << 20)));
    folders.robot("part.sdf", &part);
    let includes = |n: usize| {
        let one = |i: usize| format!("<include><uri>part.sdf</uri><name>n{i}</name></include>");
        let all: String = (0..n).map(one).collect();
        let path = folders.robot("r.sdf", &sdf(&format!("<static>1</static>{all}")));
        Model::from_sdf_file(path)
    };
    assert!(includes(1).is_ok());
    let error = includes(2).unwrap_err().to_string();
    assert!(
        error.contains("the included files have more than 67108864 bytes"),
        "{error}"
    );
}
