//! Tests that tables and JSON lose nothing, mix up nothing, and let nothing wrong through.

use nalgebra::Vector3;

use super::super::{Camera, Recording, model_page};
use super::{bits, everything, models};
use crate::contact::{ContactLaw, Contacts, SoftContact, Terrain};
use crate::io::temporary::Folder;
use crate::joint::JointKind;
use crate::model::{Base, JointSpec, LinkSpec, Mass, Model, ModelBuilder, samples};
use crate::sim::{BatchSimulator, Rollout};
use crate::spatial::Transform;
use crate::{Simulator, State};

/// A recording as it comes back from a table.
fn through_csv(recording: &Recording) -> Recording {
    let path = Folder::new();
    let path = path.write("motion.csv", recording.to_csv());
    Recording::read_csv(path, &models(recording)).unwrap()
}

/// A recording as it comes back from JSON.
fn through_json(recording: &Recording) -> Recording {
    let path = Folder::new();
    let path = path.write("motion.json", recording.to_json());
    Recording::read_json(path, &models(recording)).unwrap()
}

/// A ball that floats, of a name.
fn ball(name: &str) -> Model {
    let mut builder = ModelBuilder::new(name).with_base(Base::Floating);
    builder.add_link(LinkSpec::solid_sphere("ball", 0.1, Mass::Kilograms(1.0)));
    builder.build().unwrap()
}

fn names(recording: &Recording) -> Vec<&str> {
    let series = recording.series().iter();
    series.map(|series| series.name.as_str()).collect()
}

#[test]
fn recordings_without_moments_read_back_equal_for_robots_of_all_sizes() {
    for model in [
        samples::pendulum(),
        samples::cartpole(),
        samples::random_tree(9, 4),
    ] {
        let recording = Recording::new(&model);
        for again in [through_csv(&recording), through_json(&recording)] {
            assert!(again.len() == 0);
            assert_eq!(again.to_json(), recording.to_json());
            assert_eq!(again.to_csv(), recording.to_csv());
        }
    }
}

/// The first line of a table.
fn header(recording: &Recording) -> String {
    let table = recording.to_csv();
    table.lines().next().unwrap().to_owned()
}

#[test]
fn inputs_of_a_table_have_the_names_of_what_they_act_on_and_read_back() {
    let models = ["a", "a/u.b"].map(ball);
    let mut recording = Recording::of_robots(&models.each_ref());
    let states = models.each_ref().map(State::neutral);
    recording.push_all(0.0, &[(&states[0], &[1.0, 2.0][..]), (&states[1], &[3.0])]);
    let named = ["x", "y,z", "x"].map(str::to_owned);
    recording.robot_mut(0).name_inputs(named[..2].to_vec());
    recording.robot_mut(1).name_inputs(named[2..].to_vec());
    let head = header(&recording);
    for column in [",a/u.x,", ",a/u.y_z,", ",a/u.b/u.x"] {
        assert!(head.contains(column), "{column} is not in {head}");
    }
    let again = through_csv(&recording);
    assert_eq!(again.robots()[0].inputs, ["x", "y_z"]);
    assert_eq!(
        (again.robots()[0].u(0), again.robots()[1].u(0)),
        (&[1.0, 2.0][..], &[3.0][..])
    );
    assert_eq!((bits(&again), header(&again)), (bits(&recording), head));
    // Not a name for each input: they are numbered.
    recording.robot_mut(0).name_inputs(Vec::new());
    assert!(header(&recording).contains(",a/u0,a/u1,"));
    assert_eq!(bits(&through_csv(&recording)), bits(&recording));
}

#[cfg(feature = "plot")]
#[test]
fn inputs_are_plotted_by_name_and_by_number() {
    let simulator = Simulator::new(samples::cartpole());
    let rollout = simulator.rollout(&State::new(&[0.0; 2], &[0.0; 2]), 3, |_, _, _| {});
    let recording = Recording::from_rollout(simulator.model(), &rollout);
    let plot = recording.plot(&["u.linear", "u1"]).unwrap().to_svg();
    assert!(plot.contains("u.linear") && plot.contains("u1, pivot"));
    assert!(recording.plot(&["u2"]).is_err());
}

/// Eight megabytes took minutes when each line read all before it.
#[test]
fn quote_that_is_never_closed_is_an_error_in_linear_time() {
    let (folder, model) = (Folder::new(), samples::cartpole());
    let text = format!("time,\"q.linear\n{}", "0,0,0,0,0\n".repeat(800_000));
    let path = folder.write("open.csv", text);
    let clock = std::time::Instant::now();
    let error = Recording::read_csv(path, &[&model]).unwrap_err();
    assert!(
        error.to_string().contains("no column \"q.linear\""),
        "{error}"
    );
    assert!(clock.elapsed().as_secs() < 20, "{:?}", clock.elapsed());
}

#[test]
fn quote_that_is_open_in_a_row_is_an_error_that_says_so() {
    let (folder, model) = (Folder::new(), samples::pendulum());
    let path = folder.write("open.csv", "time,q.pivot,v.pivot\n0,\"1,2\n");
    let error = Recording::read_csv(path, &[&model]).unwrap_err();
    assert!(
        error.to_string().ends_with(":2: a quote is not closed"),
        "{error}"
    );
}

#[test]
fn series_of_any_name_read_back_as_series() {
    let mut recording = Recording::new(&samples::cartpole());
    for k in 0..3 {
        let x = f64::from(k);
        recording.push(x, &State::new(&[x, 0.0], &[0.0; 2]), &[x, -x]);
    }
    let hostile = [
        "u2",
        "u",
        "u.pivot",
        "u2x",
        "contact0",
        "time",
        "q.linear",
        "v.pivot",
        "f.pole.x",
        "series.u2",
        "",
        "a\r\nb",
        "\r",
        "a\nb",
        "x,\"y\"",
        "=1+1",
        "+1",
        "-1",
        "@a",
        "\ta",
        "u2",
        " ",
    ];
    for (k, name) in hostile.into_iter().enumerate() {
        recording.add_series(name, [k as f64, f64::NAN, -0.5]);
    }
    for again in [through_csv(&recording), through_json(&recording)] {
        assert_eq!(again.robots()[0].nu(), 2);
        assert_eq!(names(&again), names(&recording));
        assert_eq!(bits(&again), bits(&recording));
    }
}

#[test]
fn robots_of_colliding_names_have_tracks_of_different_names_and_read_back() {
    let models = ["a", "a 1", "a", "a", "a 4"].map(ball);
    let mut recording = Recording::of_robots(&models.each_ref());
    let tracks = recording.robots().iter().map(|track| track.name());
    assert_eq!(
        tracks.collect::<Vec<_>>(),
        ["a 2", "a 1", "a 3", "a 5", "a 4"]
    );
    let states = models.each_ref().map(State::neutral);
    let moments: Vec<_> = (0..5).map(|i| (&states[i], [i as f64; 1])).collect();
    let moments: Vec<_> = moments.iter().map(|(state, u)| (*state, &u[..])).collect();
    recording.push_all(0.0, &moments);
    for again in [through_csv(&recording), through_json(&recording)] {
        assert_eq!(bits(&again), bits(&recording));
    }
}

#[test]
fn joints_whose_columns_share_a_name_read_back_in_their_order() {
    let link = |name: &str| LinkSpec::solid_sphere(name, 0.1, Mass::Kilograms(1.0));
    let joint = |name: &str, parent: &str, child: &str| {
        JointSpec::new(name, JointKind::Prismatic, parent, child)
    };
    let mut builder = ModelBuilder::new("two");
    builder
        .add_link(LinkSpec::new("world"))
        .add_link(link("one"))
        .add_link(link("other"));
    builder
        .add_joint(joint("a,b", "world", "one"))
        .add_joint(joint("a_b", "one", "other"));
    let model = builder.build().unwrap();
    let mut recording = Recording::new(&model);
    recording.push(0.0, &State::new(&[1.0, 2.0], &[3.0, 4.0]), &[]);
    for again in [through_csv(&recording), through_json(&recording)] {
        assert_eq!(bits(&again), bits(&recording));
    }
}

#[test]
fn forces_read_back_from_a_table_in_their_order() {
    let mut recording = Recording::new(&samples::cartpole());
    recording.push(0.0, &State::new(&[0.0; 2], &[0.0; 2]), &[]);
    let track = recording.robot_mut(0);
    for (k, frame) in ["pole", "cart", "pole"].into_iter().enumerate() {
        track
            .add_force(frame, [Vector3::new(k as f64, 0.0, 1.0)])
            .unwrap();
    }
    let again = through_csv(&recording);
    assert_eq!(again.to_csv(), recording.to_csv());
    assert_eq!(again.robots()[0].forces().len(), 3);
    assert!(again.series().is_empty());
}

#[test]
fn cells_of_a_header_are_no_formulas() {
    let names = ["=cmd|'/C calc'!A0", "@x", "robot.=a", "+1", "-1"];
    let models = names.map(ball);
    let mut recording = Recording::of_robots(&models.each_ref());
    recording.add_series("=HYPERLINK(\"http://x\")", []);
    recording.add_series("\t=1", []);
    let csv = recording.to_csv();
    let header = csv.lines().next().unwrap();
    for cell in header.split(',') {
        let start = cell.trim_start_matches('"').chars().next();
        assert!(!start.is_some_and(|c| "=+-@\t\r".contains(c)), "{cell}");
    }
    assert_eq!(through_csv(&recording).to_csv(), csv);
}

/// A ball that slides and rolls on soft ground: its bristles bend.
fn sliding() -> (Simulator, Rollout) {
    let file = concat!(env!("CARGO_MANIFEST_DIR"), "/assets/sphere.urdf");
    let model = Model::from_urdf_file(file).unwrap();
    let law = ContactLaw::Soft(SoftContact::estimate(model.total_mass(), 1, 1e-3));
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let simulator = Simulator::new(model).with_contacts(contacts);
    let mut start: State = simulator.neutral_state();
    start.q[2] = 0.0995;
    start.v[0] = 1.0 / 3.0;
    let rollout = simulator.rollout(&start, 200, |_, _, _| {});
    (simulator, rollout)
}

#[test]
fn soft_contact_resumed_from_files_equals_the_rollout_bit_for_bit() {
    let (simulator, rollout) = sliding();
    let recording = Recording::from_rollout(simulator.model(), &rollout);
    assert!(rollout.states[100].contact.amax() > 0.0);
    let (mut written, model) = (Vec::new(), simulator.model());
    rollout.write_csv(model, &mut written).unwrap();
    assert_eq!(recording.to_csv().as_bytes(), written);
    for again in [through_csv(&recording), through_json(&recording)] {
        assert_eq!(bits(&again), bits(&recording));
        let resumed = simulator.rollout(&again.robots()[0].state(100), 100, |_, _, _| {});
        assert_eq!(*resumed.last(), *rollout.last());
        assert_eq!(again.robots()[0].nu(), 0);
    }
    let mut pushed = Recording::new(model);
    for (time, state) in rollout.times().zip(&rollout.states) {
        pushed.push(time, state, &[]);
    }
    assert_eq!(bits(&pushed), bits(&recording));
}

#[test]
fn contact_of_a_batch_is_recorded() {
    let (simulator, rollout) = sliding();
    let mut batch = BatchSimulator::new(simulator.clone(), 2);
    let starts = vec![rollout.states[0].clone(); 2];
    let all = batch.rollout(&starts, 50, |_, _, _| {});
    let recording = Recording::from_batch(&batch, &all, &[1]);
    assert_eq!(recording.robots()[0].state(50), rollout.states[50]);
}

#[test]
#[should_panic(expected = "the rollout is one of another robot than \"double_pendulum\"")]
fn rollout_of_another_robot_of_the_same_size_is_refused() {
    let simulator = Simulator::new(samples::cartpole());
    let rollout = simulator.rollout(&State::new(&[0.0; 2], &[0.0; 2]), 1, |_, _, _| {});
    Recording::from_rollout(&samples::double_pendulum(), &rollout);
}

#[test]
#[should_panic(expected = "the rollout is not one of this batch")]
fn rollout_of_another_batch_is_refused() {
    let of = |model: Model| BatchSimulator::new(Simulator::new(model), 1);
    let mut batch = of(samples::cartpole());
    let rollout = batch.rollout(&[State::new(&[0.0; 2], &[0.0; 2])], 1, |_, _, _| {});
    Recording::from_batch(&of(samples::double_pendulum()), &rollout, &[0]);
}

#[test]
#[should_panic(expected = "has a number that is not finite")]
fn place_that_is_not_finite_is_refused() {
    let nowhere = Transform::from_translation(Vector3::new(0.0, f64::NAN, 0.0));
    Recording::new(&samples::pendulum())
        .robot_mut(0)
        .place(nowhere);
}

#[test]
#[should_panic(expected = "has a number that is not finite")]
fn camera_that_is_not_finite_is_refused() {
    let camera = Camera {
        look_at: [0.0; 3],
        distance: f64::INFINITY,
        azimuth: 0.0,
        elevation: 0.0,
    };
    let _ = Recording::new(&samples::pendulum()).with_camera(camera);
}

#[test]
fn messages_about_files_show_no_control_characters_and_are_short() {
    let (folder, model) = (Folder::new(), samples::pendulum());
    let cell = format!(
        "time,q.pivot,v.pivot\n0,\u{1b}[2J\0{},0\n",
        "x".repeat(100_000)
    );
    let csv = Recording::read_csv(folder.write("a.csv", cell), &[&model]).unwrap_err();
    let json = Recording::new(&model)
        .to_json()
        .replace("q.pivot", "\\u001b\\u0000");
    let json = Recording::read_json(folder.write("a.json", json), &[&model]).unwrap_err();
    for message in [csv.to_string(), json.to_string()] {
        assert!(
            message.len() < 2000 && message.contains("\\u{1b}"),
            "{message}"
        );
        assert!(!message.contains(char::is_control), "{message:?}");
    }
}

#[test]
fn table_without_robots_is_an_error_as_json_without_robots_is() {
    let folder = Folder::new();
    let csv = Recording::read_csv(folder.write("a.csv", "time\n"), &[]).unwrap_err();
    let json = everything().to_json();
    let json = Recording::read_json(folder.write("a.json", json), &[]).unwrap_err();
    assert!(csv.to_string().ends_with("no robot was given"), "{csv}");
    assert!(
        json.to_string().ends_with("2 robots, 0 were given"),
        "{json}"
    );
}

#[test]
fn inputs_are_called_by_their_joints_in_plots_and_files() {
    let simulator = Simulator::new(samples::cartpole());
    let simulator = simulator.with_actuated_joints(&["pivot"]).unwrap();
    let start = State::new(&[0.0; 2], &[0.0; 2]);
    let rollout = simulator.rollout(&start, 3, |_, _, _| {});
    let recording = Recording::from_rollout(simulator.model(), &rollout);
    assert_eq!(recording.robots()[0].inputs, ["pivot"]);
    assert_eq!(through_json(&recording).robots()[0].inputs, ["pivot"]);
    assert_eq!(through_csv(&recording).robots()[0].inputs, ["pivot"]);
    let page = recording.to_html();
    let input = page.find("\"title\":\"Input\"").unwrap();
    assert!(
        page[input..]
            .starts_with("\"title\":\"Input\",\"unit\":\"N, N·m\",\"lines\":[{\"name\":\"pivot\"")
    );
    // Inputs of pushed moments have no names until they get some.
    let mut pushed = Recording::new(simulator.model());
    pushed.push(0.0, &start, &[1.0]);
    assert!(pushed.to_html().contains("\"name\":\"u0\""));
    pushed.robot_mut(0).name_inputs(simulator.input_names());
    assert!(!pushed.to_html().contains("\"name\":\"u0\""));
    assert!(model_page(simulator.model()).len() > 1000);
}
