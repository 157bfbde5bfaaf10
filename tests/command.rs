//! The program `dualbody`, run as a process.

use std::fs;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const CARTPOLE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/cartpole.urdf");
const QUADRUPED: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/quadruped.urdf");
const PANDA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/panda.urdf");

fn run(arguments: &[&str]) -> Output {
    let program = env!("CARGO_BIN_EXE_dualbody");
    let mut command = Command::new(program);
    command
        .args(arguments)
        .stdin(Stdio::null())
        .env_remove("CLICOLOR_FORCE");
    command.output().expect("the program starts")
}

fn out(output: &Output) -> String {
    String::from_utf8(output.stdout.clone()).expect("text")
}

fn error(output: &Output) -> String {
    String::from_utf8(output.stderr.clone()).expect("text")
}

fn status(output: &Output) -> i32 {
    output.status.code().expect("no signal ended it")
}

/// A folder of a test, which goes when the test ends.
struct Folder(PathBuf);

impl Folder {
    fn new(name: &str) -> Self {
        let path =
            std::env::temp_dir().join(format!("dualbody-test-{}-{name}", std::process::id()));
        fs::create_dir_all(&path).expect("a folder");
        Self(path)
    }

    fn path(&self, name: &str) -> String {
        self.0.join(name).to_string_lossy().into_owned()
    }

    fn write(&self, name: &str, text: &str) -> String {
        fs::write(self.0.join(name), text).expect("a file");
        self.path(name)
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        let _ = fs::remove_dir_all(&self.0);
    }
}

/// A link on a hinge whose moments of inertia are these.
fn link_with_moments(moments: [f64; 3]) -> String {
    let [x, y, z] = moments;
    format!(
        r#"<robot name="r"><link name="world"/><link name="arm"><inertial><mass value="1"/>
        <inertia ixx="{x}" ixy="0" ixz="0" iyy="{y}" iyz="0" izz="{z}"/></inertial></link>
        <joint name="hinge" type="continuous"><parent link="world"/><child link="arm"/><axis xyz="1 0 0"/></joint></robot>"#
    )
}

#[test]
fn status_of_check_says_whether_there_is_a_flaw() {
    let folder = Folder::new("check");
    let good = run(&["check", CARTPOLE]);
    assert_eq!(
        (status(&good), out(&good).contains("inertias: no flaw")),
        (0, true)
    );
    // One moment exceeds the sum of the others.
    let bad = run(&[
        "check",
        &folder.write("bad.urdf", &link_with_moments([1.0, 1.0, 3.0])),
    ]);
    assert_eq!(
        (status(&bad), out(&bad).contains("triangle inequality")),
        (1, true)
    );
    let missing = run(&["check", &folder.path("missing.urdf")]);
    assert_eq!(
        (status(&missing), error(&missing).contains("missing.urdf")),
        (2, true)
    );
    let broken = run(&[
        "check",
        &folder.write("broken.urdf", "<robot name='r'><link"),
    ]);
    assert_eq!(status(&broken), 2);
}

#[test]
fn check_finds_a_step_that_is_too_long_for_a_spring() {
    let folder = Folder::new("stiff");
    // 1 kg on 10⁴ N/m: 16 Hz. The Runge–Kutta method is stable up to 2.83 / 100 s.
    let xml = r#"<mujoco><worldbody><body><joint name="x" type="slide" axis="1 0 0" stiffness="10000"/>
        <geom size="0.1" mass="1"/></body></worldbody></mujoco>"#;
    let file = folder.write("spring.xml", xml);
    let check = |step: &str| {
        run(&[
            "check",
            &file,
            "--integrator",
            "runge-kutta4",
            "--time-step",
            step,
        ])
    };
    let (short, long) = (check("0.001"), check("0.03"));
    assert_eq!((status(&short), status(&long)), (0, 1), "{}", error(&short));
    let text = out(&long);
    assert!(text.contains("\"x\"") && text.contains("2.8e-2"), "{text}");
}

#[test]
fn massless_robots_are_flawed_and_do_not_panic() {
    let folder = Folder::new("massless");
    let xml = r#"<robot name="vane"><link name="world"/><link name="vane"/><joint name="pivot" type="continuous">
        <parent link="world"/><child link="vane"/></joint></robot>"#;
    let file = folder.write("vane.urdf", xml);
    let check = run(&["check", &file]);
    assert_eq!((status(&check), out(&check).contains("pivot")), (1, true));
    for command in ["simulate", "bench"] {
        let output = run(&[command, &file]);
        assert_eq!(status(&output), 2, "{}", error(&output));
        assert!(error(&output).contains("pivot") && !error(&output).contains("panicked"));
    }
}

#[test]
fn info_as_json_equals_the_file() {
    let output = run(&["info", PANDA, "--json", "--base", "fixed"]);
    let info: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert_eq!((&info["base"], status(&output)), (&"fixed".into(), 0));
    let joints = info["joints"].as_array().expect("a list");
    let first = joints
        .iter()
        .find(|joint| joint["name"] == "panda_joint1")
        .expect("the first joint");
    assert_eq!(
        (first["upper"].as_f64(), first["effort"].as_f64()),
        (Some(2.8973), Some(87.0))
    );
    let output = run(&["info", QUADRUPED, "--json"]);
    let info: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let masses = info["links"]
        .as_array()
        .expect("a list")
        .iter()
        .filter_map(|link| link["mass"].as_f64());
    assert!((masses.sum::<f64>() - info["total_mass"].as_f64().expect("a number")).abs() < 1e-12);
    assert!(out(&run(&["info", PANDA])).contains("panda_joint1"));
}

/// A scene with a part of each kind.
const SCENE: &str = r#"<mujoco><worldbody><geom name="floor" type="plane" size="1 1 1"/>
    <body name="arm" pos="0 0 1"><joint name="hinge" axis="0 1 0"/><geom name="rod" type="capsule" fromto="0 0 0 0.3 0 0" size="0.02" friction="0.7"/>
    <site name="tip" pos="0.3 0 0"/><body name="hand" pos="0.3 0 0"><joint name="wrist"/><geom type="ellipsoid" size="0.1 0.05 0.02" condim="4"/></body></body>
    <body name="box" pos="1 0 1"><freejoint name="free"/><geom size="0.1"/></body></worldbody>
    <tendon><fixed name="belt"><joint joint="hinge" coef="1"/><joint joint="wrist" coef="-1"/></fixed></tendon>
    <actuator><position name="drive" joint="hinge" kp="10" ctrlrange="-1 2"/><motor name="pull" tendon="belt"/></actuator>
    <equality><weld body1="hand" body2="box"/><joint joint1="hinge" joint2="wrist"/></equality>
    <sensor><gyro name="rates" site="tip"/></sensor>
    <contact><exclude body1="arm" body2="box"/></contact>
    <keyframe><key name="home" time="2"/></keyframe></mujoco>"#;

#[test]
fn info_names_the_parts_of_a_scene() {
    let folder = Folder::new("info");
    let file = folder.write("scene.xml", SCENE);
    let output = run(&["info", &file, "--json"]);
    let info: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    for (pointer, expected) in [
        ("/actuators/0/name", "drive".into()),
        (
            "/actuators/0/acts_on",
            serde_json::json!(["joint", "hinge"]),
        ),
        ("/actuators/0/upper", 2.0.into()),
        (
            "/actuators/1/acts_on",
            serde_json::json!(["tendon", "belt"]),
        ),
        ("/sensors/0/name", "rates".into()),
        ("/sensors/0/object", "tip".into()),
        ("/keyframes/0/name", "home".into()),
        ("/keyframes/0/time", 2.0.into()),
        ("/equalities/0/kind", "weld".into()),
        ("/equalities/0/ties", serde_json::json!(["hand", "box"])),
        ("/equalities/1/ties", serde_json::json!(["hinge", "wrist"])),
        ("/contact/ground", "plane".into()),
        ("/contact/geoms/0/name", "rod".into()),
        ("/contact/geoms/0/friction/0", 0.7.into()),
        ("/contact/geoms/1/link", "hand".into()),
        ("/contact/geoms/1/condim", 4.into()),
        ("/contact/excluded/0", serde_json::json!(["arm", "box"])),
    ] {
        assert_eq!(info.pointer(pointer), Some(&expected), "{pointer}");
    }
    let text = out(&run(&["info", &file]));
    for line in [
        "drive     position  joint hinge  -1 to 2",
        "rates   gyro  tip",
        "home      2 s",
        "weld      hand, box",
        "ground: plane",
    ] {
        assert!(text.contains(line), "no {line:?} in\n{text}");
    }
    // A URDF has none of these.
    let output = run(&["info", PANDA, "--json"]);
    let info: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    assert!(info.get("actuators").is_none() && info["sensors"] == serde_json::json!([]));
}

#[test]
fn view_writes_the_page_of_the_robot() {
    let folder = Folder::new("view");
    let page = folder.path("page.html");
    let output = run(&["view", CARTPOLE, "--no-open", "--output", &page]);
    assert_eq!((status(&output), out(&output).trim()), (0, &*page));
    let text = fs::read_to_string(&page).expect("a page");
    assert!(text.starts_with("<!doctype html>") && text.contains("pivot"));
}

#[test]
fn simulated_fall_equals_that_of_a_free_body() {
    let folder = Folder::new("fall");
    let xml = r#"<robot name="ball"><link name="ball"><inertial><mass value="2"/>
        <inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial></link></robot>"#;
    let (file, csv, json, page) = (
        folder.write("ball.urdf", xml),
        folder.path("a.csv"),
        folder.path("a.json"),
        folder.path("a.html"),
    );
    let words = [
        "simulate",
        &file,
        "-d",
        "1",
        "--time-step",
        "0.01",
        "--start",
        "base=0,0,5",
        "--velocity",
        "base=0,0,3,0,0,0",
    ];
    let files = [
        "--terrain",
        "none",
        "--csv",
        &csv,
        "--json",
        &json,
        "--page",
        &page,
    ];
    let output = run(&[&words[..], &files].concat());
    assert_eq!(status(&output), 0, "{}", error(&output));
    let table = fs::read_to_string(&csv).expect("a table");
    let last = table.lines().last().expect("a line");
    let z: f64 = last
        .split(',')
        .nth(3)
        .expect("z")
        .parse()
        .expect("a number");
    // Semi-implicit Euler: z = z₀ + v₀ t − ½ g t (t + Δt).
    assert!((z - (5.0 + 3.0 - 0.5 * 9.81 * 1.01)).abs() < 1e-9, "{last}");
    assert_eq!(table.lines().count(), 102);
    serde_json::from_str::<serde_json::Value>(&fs::read_to_string(json).expect("JSON"))
        .expect("JSON");
    assert!(fs::read_to_string(page).expect("a page").contains("ball"));
}

#[test]
fn pictures_of_a_simulation_have_the_size_that_is_asked_for() {
    let folder = Folder::new("pictures");
    let (gif, png) = (folder.path("a.gif"), folder.path("a.png"));
    let words = [
        "simulate",
        CARTPOLE,
        "-d",
        "0.2",
        "--time-step",
        "0.01",
        "--size",
        "80x60",
    ];
    let output = run(&[&words[..], &["--gif", &gif, "--png", &png]].concat());
    assert_eq!(status(&output), 0, "{}", error(&output));
    let (gif, png) = (fs::read(gif).expect("a GIF"), fs::read(png).expect("a PNG"));
    assert_eq!(
        (&gif[..6], &gif[6..10]),
        (&b"GIF89a"[..], &[80, 0, 60, 0][..])
    );
    assert_eq!(
        (&png[1..4], &png[16..24]),
        (&b"PNG"[..], &[0, 0, 0, 80, 0, 0, 0, 60][..])
    );
    assert_eq!(status(&run(&["simulate", CARTPOLE, "--size", "0x60"])), 2);
}

#[test]
fn a_duration_without_a_step_is_an_error_and_long_times_are_short_texts() {
    let refused = run(&["simulate", CARTPOLE, "-d", "1", "--time-step", "10"]);
    assert_eq!(status(&refused), 2);
    let message = error(&refused);
    assert!(
        message.contains("a duration of 1 s has no step of 10 s"),
        "{message}"
    );
    let checked = out(&run(&["check", CARTPOLE, "--time-step", "1e300"]));
    assert!(
        checked.contains("steps of 1e300 s, semi-implicit Euler"),
        "{checked}"
    );
}

#[test]
fn held_quadruped_stands_and_a_loose_one_does_not() {
    let folder = Folder::new("stand");
    let height = |more: &[&str]| {
        let csv = folder.path("stand.csv");
        let pose = ["FR", "FL", "RR", "RL"]
            .map(|leg| {
                [
                    format!("{leg}_thigh_joint=0.8"),
                    format!("{leg}_calf_joint=-1.6"),
                ]
            })
            .concat();
        let mut words = vec![
            "simulate",
            QUADRUPED,
            "-d",
            "1",
            "--time-step",
            "0.002",
            "--csv",
            &csv,
        ];
        pose.iter()
            .for_each(|joint| words.extend(["--start", joint]));
        let output = run(&[&words, more].concat());
        assert_eq!(status(&output), 0, "{}", error(&output));
        let table = fs::read_to_string(&csv).expect("a table");
        let z = |line: &str| {
            line.split(',')
                .nth(3)
                .expect("z")
                .parse::<f64>()
                .expect("a number")
        };
        let mut lines = table.lines().skip(1);
        let first = z(lines.next().expect("a start"));
        z(lines.last().expect("an end")) / first
    };
    assert!(height(&["--hold"]) > 0.85);
    assert!(height(&[]) < 0.6);
}

// Files of walkers ask for this method.
#[test]
fn method_of_runge_and_kutta_simulates_regularised_contact() {
    let arguments = [
        "simulate",
        QUADRUPED,
        "--integrator",
        "runge-kutta4",
        "--duration",
        "0.01",
    ];
    let run = run(&arguments);
    assert_eq!(status(&run), 0, "{}", error(&run));
}

#[test]
fn simulate_counts_the_parts_of_a_file_that_are_not_used() {
    let folder = Folder::new("unused");
    let xml = r#"<mujoco><worldbody><body><joint name="x"/><geom size="0.1"/></body></worldbody><sensor><clock/></sensor></mujoco>"#;
    let file = folder.write("clock.xml", xml);
    let noted = run(&["simulate", &file, "--duration", "0.01"]);
    let says = "1 part of the file not used";
    assert!(error(&noted).contains(says), "{}", error(&noted));
    assert_eq!(status(&noted), 0);
    let quiet = run(&["simulate", &file, "--duration", "0.01", "--quiet"]);
    assert_eq!(error(&quiet), "");
}

#[test]
fn options_that_do_not_fit_are_named() {
    for (arguments, words) in [
        (
            &["simulate", QUADRUPED, "--integrator", "implicit-midpoint"][..],
            "contact",
        ),
        (
            &[
                "simulate",
                QUADRUPED,
                "--integrator",
                "runge-kutta4",
                "--law",
                "rigid",
            ],
            "contact",
        ),
        (&["simulate", CARTPOLE, "--start", "nobody=1"], "nobody"),
        (
            &["simulate", CARTPOLE, "--start", "pivot=1,2"],
            "2 numbers for \"pivot\", expected 1",
        ),
        (
            &["simulate", CARTPOLE, "--start", "pivot=nan"],
            "not finite",
        ),
        (
            &["simulate", QUADRUPED, "--start", "base=0,0,1,0,0,0,0"],
            "quaternion",
        ),
        (&["simulate", CARTPOLE, "--time-step", "-1"], "not positive"),
        (&["simulate", CARTPOLE, "--duration", "1e300"], "steps"),
        (&["simulate", CARTPOLE, "--keyframe", "home"], "home"),
        (&["simulate", CARTPOLE, "--terrain", "wavy"], "flat"),
        (&["convert", CARTPOLE, "robot.doc"], "--to"),
        (&["convert", CARTPOLE, "robot.sdf"], "SDF"),
        (&["check", "/dev/null"], "regular"),
        (&["dance"], "dance"),
    ] {
        let output = run(arguments);
        assert_eq!(status(&output), 2, "{arguments:?}");
        let text = error(&output);
        assert!(
            text.contains(words) && !text.contains("panicked"),
            "{arguments:?}: {text}"
        );
    }
}

#[test]
fn converted_robots_have_the_same_numbers_and_losses_are_named() {
    let folder = Folder::new("convert");
    let (mjcf, urdf) = (folder.path("cartpole.xml"), folder.path("again.urdf"));
    assert_eq!(status(&run(&["convert", CARTPOLE, &mjcf])), 0);
    let back = run(&["convert", &mjcf, &urdf]);
    assert_eq!(status(&back), 0, "{}", error(&back));
    let info = |file: &str| {
        serde_json::from_slice::<serde_json::Value>(&run(&["info", file, "--json"]).stdout)
            .expect("JSON")
    };
    let (one, other) = (info(CARTPOLE), info(&urdf));
    assert_eq!(
        (&one["nv"], &one["total_mass"]),
        (&other["nv"], &other["total_mass"])
    );
    // A URDF has no place for springs.
    let xml = r#"<mujoco><worldbody><body><joint name="x" type="slide" stiffness="3"/><geom size="0.1"/></body></worldbody></mujoco>"#;
    let lossy = run(&[
        "convert",
        &folder.write("spring.xml", xml),
        &folder.path("spring.urdf"),
    ]);
    assert!(out(&lossy).contains("spring 3"), "{}", out(&lossy));
    // Neither format is written with servos and sensors.
    let scene = xml.replace(
        "</mujoco>",
        r#"<actuator><position joint="x" kp="9"/></actuator><sensor><jointpos joint="x"/></sensor></mujoco>"#,
    );
    let lossy = run(&[
        "convert",
        &folder.write("servo.xml", &scene),
        &folder.path("servo.mjcf"),
    ]);
    for lost in [
        "actuators of the MJCF file: 1",
        "sensors of the MJCF file: 1",
    ] {
        assert!(out(&lossy).contains(lost), "{}", out(&lossy));
    }
    let printed = run(&["convert", CARTPOLE, "-", "--to", "mjcf"]);
    assert!(out(&printed).contains("<mujoco"));
}

#[test]
fn bench_reports_each_function() {
    let output = run(&["bench", CARTPOLE, "--seconds", "0.01", "--json"]);
    let timings: serde_json::Value = serde_json::from_slice(&output.stdout).expect("JSON");
    let timings = timings.as_array().expect("a list");
    assert!(
        timings.len() == 5
            && timings
                .iter()
                .all(|own| own["seconds"].as_f64().is_some_and(|s| s > 0.0))
    );
}

#[test]
fn live_prints_the_address_of_its_page() {
    let mut program = Command::new(env!("CARGO_BIN_EXE_dualbody"))
        .args(["live", CARTPOLE, "--no-open"])
        .stdout(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut line = String::new();
    let mut out = BufReader::new(program.stdout.take().expect("its output"));
    out.read_line(&mut line).expect("a line");
    program
        .kill()
        .and_then(|()| program.wait())
        .expect("it ends");
    assert!(line.starts_with("http://127.0.0.1:"), "{line}");
    assert_eq!(status(&run(&["live", "no_such_file.urdf"])), 2);
}

#[test]
fn completions_name_the_subcommands() {
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let text = out(&run(&["completions", shell]));
        assert!(
            text.contains("simulate") && text.contains("convert"),
            "{shell}"
        );
    }
}

#[test]
fn colour_is_for_terminals_only() {
    assert!(!out(&run(&["check", CARTPOLE])).contains('\x1b'));
    let forced = Command::new(env!("CARGO_BIN_EXE_dualbody"))
        .args(["check", CARTPOLE])
        .env("CLICOLOR_FORCE", "1")
        .output();
    assert!(out(&forced.expect("the program starts")).contains("\x1b["));
}

#[test]
fn a_reader_that_leaves_early_is_no_error() {
    let mut child = Command::new(env!("CARGO_BIN_EXE_dualbody"))
        .args(["completions", "bash"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    assert_eq!((status(&output), error(&output).as_str()), (0, ""));
}

#[test]
fn files_below_a_folder_only_are_opened_where_that_is_asked_for() {
    let folder = Folder::new("root");
    let inside = folder.write(
        "cartpole.urdf",
        &fs::read_to_string(CARTPOLE).expect("the robot"),
    );
    assert!(Path::new(&inside).is_absolute());
    assert_eq!(
        status(&run(&["info", &inside, "--root", &folder.path("")])),
        0
    );
    assert_eq!(
        status(&run(&["info", CARTPOLE, "--root", &folder.path("")])),
        2
    );
}
