//! Sensors of SDF files and of Gazebo's settings in URDF files: what they read against closed forms, noise and rate, what is not taken.

use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, Terrain};
use dualbody::io::{ImportReport, ImportedSensor};
use dualbody::sim::{NoisySensors, ScanAngles, Sensor, SensorNoise, Sensors};
use dualbody::{LoadError, Model, ModelOptions, Simulator, State};
use nalgebra::DVector;

use crate::common::SAME_ALGEBRA;

const NO_NOISE: SensorNoise = SensorNoise {
    offset: 0.0,
    white: 0.0,
    bias: 0.0,
    bias_walk: 0.0,
    resolution: 0.0,
    limit: f64::INFINITY,
    period: 0.0,
    delay: 0.0,
};

/// A rod of 2 kg on a hinge about y at the world, with its centre 0.5 m below, and sensors of the link and of the joint.
fn sdf(of_link: &str, of_joint: &str) -> String {
    format!(
        "<sdf version='1.9'><model name='pendulum'>
<link name='rod'><inertial><pose>0 0 -0.5 0 0 0</pose><mass>2</mass>
<inertia><ixx>0.1</ixx><ixy>0</ixy><ixz>0</ixz><iyy>0.1</iyy><iyz>0</iyz><izz>0.1</izz></inertia></inertial>
{of_link}</link>
<joint name='hinge' type='revolute'><parent>world</parent><child>rod</child><axis><xyz>0 1 0</xyz></axis>
{of_joint}</joint></model></sdf>"
    )
}

fn load(text: &str) -> (Model, ImportReport) {
    let loaded = ModelOptions::default().load_sdf_str(text);
    loaded.unwrap_or_else(|error| panic!("{error}"))
}

fn read(model: &Model, report: &ImportReport, q: f64, v: f64) -> (Vec<String>, DVector<f64>) {
    let sensors = report.known_sensors(model);
    let simulator = Simulator::new(model.clone());
    let y = sensors.read(&simulator, &State::new(&[q], &[v]), &[0.0]);
    let names = sensors.names().into_iter().map(Into::into).collect();
    (names, y)
}

fn assert_near(ours: &[f64], expected: &[f64]) {
    assert_eq!(ours.len(), expected.len());
    for (ours, expected) in ours.iter().zip(expected) {
        assert!(
            (ours - expected).abs() < SAME_ALGEBRA,
            "{ours}, expected {expected}"
        );
    }
}

/// With the angle q from the vertical: q̈ = −m g l sin q / (I + m l²).
fn angular_acceleration(q: f64) -> f64 {
    -2.0 * 9.81 * 0.5 * q.sin() / (0.1 + 2.0 * 0.25)
}

#[test]
fn an_imu_reads_the_closed_form_of_a_pendulum_in_its_own_pose() {
    // At the tip, turned by a quarter about z: its y is the x of the rod, against its x is the y of the rod.
    let imu = "<sensor name='imu' type='imu'><pose>0 0 -1 0 0 1.5707963267948966</pose></sensor>";
    let (model, report) = load(&sdf(imu, ""));
    assert!(
        report.ignored.is_empty() && report.warnings.is_empty(),
        "{report}"
    );
    assert!(model.frame("rod/imu").is_some());
    let (q, v) = (0.4_f64, 1.3);
    let (names, y) = read(&model, &report, q, v);
    assert_eq!(names[2..4], ["imu/gyro.z", "imu/accelerometer.x"]);
    // About y, a positive angle moves the tip to −x: p = −(sin q, 0, cos q), along the axes of the rod p̈ = (−a, 0, v²), and −g is (−g sin q, 0, g cos q).
    let a = angular_acceleration(q);
    let x = -a - 9.81 * q.sin();
    assert_near(&y.as_slice()[..3], &[v, 0.0, 0.0]);
    assert_near(&y.as_slice()[3..], &[0.0, -x, v * v + 9.81 * q.cos()]);
}

#[test]
fn a_force_torque_sensor_of_a_joint_reads_the_force_on_the_child() {
    let sensor = "<sensor name='ft' type='force_torque'><force_torque><frame>sensor</frame>
<measure_direction>parent_to_child</measure_direction></force_torque></sensor>";
    let (model, report) = load(&sdf("", sensor));
    assert!(
        report.ignored.is_empty() && report.warnings.is_empty(),
        "{report}"
    );
    let (q, v) = (0.3_f64, 0.7);
    let (_, y) = read(&model, &report, q, v);
    let a = angular_acceleration(q);
    let along = [
        2.0 * (-0.5 * a - 9.81 * q.sin()),
        0.0,
        2.0 * (0.5 * v * v + 9.81 * q.cos()),
    ];
    assert_near(&y.as_slice()[..3], &along);
    assert_near(&y.as_slice()[3..], &[0.0; 3]);
    // The default is the force on the parent.
    let (_, report) = load(&sdf(
        "",
        "\n<sensor name='ft' type='force_torque'><force_torque/></sensor>",
    ));
    let warning = &report.warnings[0];
    assert_eq!((warning.line, report.warnings.len()), (7, 1));
    assert!(warning.reason.contains("other sign"), "{}", warning.reason);
}

#[test]
fn a_lidar_of_one_ray_reads_the_distance_of_a_wall() {
    let lidar = "<sensor name='eye' type='gpu_lidar'><pose>0 0 -0.2 0 0 0</pose><update_rate>20</update_rate>
<lidar><scan><horizontal><samples>1</samples><min_angle>0.5</min_angle><max_angle>0.5</max_angle></horizontal></scan>
<range><min>0</min><max>9</max><resolution>0.01</resolution></range></lidar></sensor>";
    let text = before_a_wall(lidar);
    let loaded = ModelOptions::default()
        .with_all_models()
        .load_sdf_str(&text);
    let (model, report) = loaded.unwrap_or_else(|error| panic!("{error}"));
    let y = read(&model, &report, 0.0, 0.0).1;
    assert_near(y.as_slice(), &[2.5 / 0.5_f64.cos()]);
    let noise = report.sensors[0].noise;
    assert_eq!((noise.period, noise.resolution), (0.05, 0.01));
    // Beyond the range
    let text = text.replace("<pose>3 0 0", "<pose>30 0 0");
    let loaded = ModelOptions::default()
        .with_all_models()
        .load_sdf_str(&text);
    let (model, report) = loaded.expect("a world");
    assert_eq!(read(&model, &report, 0.0, 0.0).1[0], 9.0);
}

/// A world of the pendulum and a wall, whose face is 2.5 m ahead.
fn before_a_wall(of_link: &str) -> String {
    let wall = "</model><model name='wall'><static>true</static><link name='wall'><pose>3 0 0 0 0 0</pose><collision name='c'>
<geometry><box><size>1 50 50</size></box></geometry></collision></link></model></world>";
    let text = sdf(of_link, "").replace("</model>", wall);
    text.replace(
        "<model name='pendulum'>",
        "<world name='w'><model name='pendulum'>",
    )
}

#[test]
fn a_lidar_of_several_rays_reads_the_distance_along_each() {
    let lidar = "<sensor name='scan' type='lidar'><pose>0 0 -0.2 0 0 0</pose><lidar><scan>
<horizontal><samples>5</samples><resolution>2</resolution><min_angle>-0.9</min_angle><max_angle>0.9</max_angle></horizontal>
<vertical><samples>2</samples><min_angle>-0.1</min_angle><max_angle>0.3</max_angle></vertical></scan>
<range><max>3.5</max></range></lidar></sensor>";
    let loaded = ModelOptions::default()
        .with_all_models()
        .load_sdf_str(&before_a_wall(lidar));
    let (model, report) = loaded.unwrap_or_else(|error| panic!("{error}"));
    let sensors = report.known_sensors(&model);
    let (names, y) = read(&model, &report, 0.0, 0.0);
    assert_eq!(
        (names.len(), &names[0][..], &names[19][..]),
        (20, "scan.0", "scan.19")
    );
    assert_eq!(sensors.units()[7], "m");
    let mut expected = Vec::new();
    for up in [-0.1_f64, 0.3] {
        for k in 0..10 {
            let turned = -0.9 + 0.2 * f64::from(k);
            expected.push((2.5 / (up.cos() * turned.cos())).min(3.5));
        }
    }
    assert_near(y.as_slice(), &expected);
    assert!(expected[0] == 3.5 && expected[4] < 2.6);
    let simulator = Simulator::new(model);
    let slopes = sensors.linearize(&simulator, &State::new(&[0.02], &[0.0]), &[0.0]);
    let read = |q: f64| sensors.read(&simulator, &State::new(&[q], &[0.0]), &[0.0]);
    let difference = (read(0.02 + 1e-6) - read(0.02 - 1e-6)) / 2e-6;
    for k in 0..20 {
        let error = slopes.c[(k, 0)] - difference[k];
        assert!(error.abs() < 1e-7, "ray {k}: {error:e}");
    }
}

#[test]
#[should_panic(expected = "a scan has 0 rays")]
fn a_scan_without_rays_is_refused() {
    let (model, _) = load(&sdf("", ""));
    let frame = model.frame("rod").expect("a link");
    let none = ScanAngles {
        count: 0,
        ..ScanAngles::ONE
    };
    let lidar = Sensor::Lidar {
        frame,
        horizontal: ScanAngles::ONE,
        vertical: none,
        range: 1.0,
    };
    let _ = Sensors::new(&model, [("scan", lidar)]);
}

#[test]
fn more_rays_than_any_lidar_has_are_reported() {
    for samples in ["1e9", "1e300", "5000000000"] {
        let sensor = format!(
            "\n<sensor name='s' type='lidar'><lidar><scan><horizontal><samples>{samples}</samples></horizontal></scan></lidar></sensor>"
        );
        let (_, report) = load(&sdf(&sensor, ""));
        assert!(report.sensors[0].sensor.is_none());
        assert!(report.to_string().contains("rays, more than"), "{report}");
    }
}

#[test]
fn a_contact_sensor_reads_the_weight_of_a_resting_ball() {
    let text = "<sdf version='1.9'><model name='ball'><link name='ball'>
<inertial><mass>3</mass><inertia><ixx>0.01</ixx><iyy>0.01</iyy><izz>0.01</izz><ixy>0</ixy><ixz>0</ixz><iyz>0</iyz></inertia></inertial>
<collision name='c'><geometry><sphere><radius>0.1</radius></sphere></geometry></collision>
<sensor name='bumper' type='contact'/><sensor name='height' type='altimeter'/></link></model></sdf>";
    let (model, report) = load(text);
    let sensors = report.known_sensors(&model);
    let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let simulator = Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(2e-3);
    let mut state = simulator.neutral_state();
    state.q[2] = 0.1;
    let u = vec![0.0; simulator.nu()];
    for _ in 0..2000 {
        state = simulator.step(&state, &u);
    }
    let y = sensors.read(&simulator, &state, &u);
    let of = |name: &str| &y.as_slice()[sensors.range(name).expect("a sensor")];
    assert!(
        (of("bumper")[2] - 3.0 * 9.81).abs() < 1e-6,
        "{}",
        of("bumper")[2]
    );
    assert_eq!(of("height/position")[2], state.q[2]);
}

#[test]
fn noise_and_rate_of_an_sdf_are_those_of_the_sensors() {
    let axis = |stddev: f64| {
        format!(
            "<noise type='gaussian'><mean>0.25</mean><stddev>{stddev}</stddev><bias_mean>0.5</bias_mean><bias_stddev>0.125</bias_stddev></noise>"
        )
    };
    let [rate, other] = [axis(0.01), axis(0.02)];
    let imu = format!(
        "<sensor name='imu' type='imu'><update_rate>250</update_rate><topic>t</topic><imu>
<angular_velocity><x>{rate}</x><y>{rate}</y><z>{rate}</z></angular_velocity>
<linear_acceleration><x>{rate}</x><y>{other}</y><z>{rate}</z></linear_acceleration></imu></sensor>"
    );
    let (model, report) = load(&sdf(&imu, ""));
    let expected = SensorNoise {
        offset: 0.75,
        white: 0.01,
        bias: 0.125,
        period: 0.004,
        ..NO_NOISE
    };
    let noises: Vec<SensorNoise> = report.sensors.iter().map(|own| own.noise).collect();
    assert_eq!(noises, [expected; 2]);
    let lines = |notes: &[dualbody::io::ImportNote]| -> Vec<u32> {
        notes.iter().map(|note| note.line).collect()
    };
    assert_eq!(lines(&report.ignored), [4], "the topic: {report}");
    assert_eq!(lines(&report.warnings), [6], "axes that differ: {report}");
    // The offset is in what is read.
    let sensors = report.known_sensors(&model);
    let offset = SensorNoise {
        offset: 0.75,
        ..NO_NOISE
    };
    let noisy = NoisySensors::new(&sensors, 1e-3, 5).with_noise("imu/gyro", offset);
    let (mut noisy, mut out) = (noisy.expect("a sensor"), [0.0; 6]);
    noisy.sample_into(&[1.0; 6], &mut out);
    assert_eq!(out, [1.75, 1.75, 1.75, 1.0, 1.0, 1.0]);
    // Before version 1.5 it stood elsewhere.
    let old = "<sensor name='imu' type='imu'><imu><noise><type>gaussian</type><rate><stddev>0.5</stddev></rate>
<accel><stddev>2</stddev><dynamic_bias_stddev>3</dynamic_bias_stddev></accel></noise></imu></sensor>";
    let (_, report) = load(&sdf(old, ""));
    let [rate, accel] = [0, 1].map(|k| report.sensors[k].noise);
    assert_eq!((rate.white, accel.white, accel.bias_walk), (0.5, 2.0, 3.0));
}

#[test]
fn sensors_of_gazebo_in_a_urdf_are_those_of_the_sdf() {
    let inertial = "<inertial><mass value='1'/><inertia ixx='1' ixy='0' ixz='0' iyy='1' iyz='0' izz='1'/></inertial>";
    let text = format!(
        "<robot name='r'><link name='base'>{inertial}</link><link name='arm'>{inertial}</link>
<joint name='j' type='continuous'><parent link='base'/><child link='arm'/><axis xyz='0 0 1'/></joint>
<gazebo reference='arm'><sensor name='imu' type='imu'><pose>0.5 0 0 0 0 0</pose></sensor></gazebo>
<gazebo reference='j'><sensor name='ft' type='force_torque'/></gazebo>
<gazebo reference='base'>
<sensor name='eyes' type='depth'/>
<sensor name='scan' type='ray'><ray><scan><horizontal><samples>640</samples></horizontal></scan></ray></sensor></gazebo>
<gazebo reference='nowhere'><sensor name='lost' type='imu'/></gazebo></robot>"
    );
    let loaded = ModelOptions::default().load_urdf_str(&text);
    let (model, report) = loaded.unwrap_or_else(|error| panic!("{error}"));
    let [arm, imu] = ["arm", "arm/imu"].map(|name| model.frame(name).expect("a frame"));
    let found = |own: &ImportedSensor| (own.name.clone(), own.sensor);
    let all: Vec<_> = report.sensors.iter().map(found).collect();
    assert_eq!(all[0], ("imu/gyro".into(), Some(Sensor::Gyro(imu))));
    assert_eq!(
        all[1],
        ("imu/accelerometer".into(), Some(Sensor::Accelerometer(imu)))
    );
    assert_eq!(all[2], ("ft".into(), Some(Sensor::Wrench(arm))));
    assert_eq!(all[3], ("eyes".into(), None));
    let scan = Sensor::Lidar {
        frame: model.frame("base").expect("a frame"),
        horizontal: ScanAngles {
            count: 640,
            ..ScanAngles::ONE
        },
        vertical: ScanAngles::ONE,
        range: 1e3,
    };
    assert_eq!(all[4], ("scan".into(), Some(scan)));
    assert_eq!(all[5], ("lost".into(), None));
    let table = report.to_string();
    for part in [
        "line 6: ",
        "\"depth\" are not modelled",
        "line 8: ",
        "\"nowhere\"",
    ] {
        assert!(table.contains(part), "{part} in {table}");
    }
    assert_eq!(report.known_sensors(&model).len(), 12 + 640);
}

#[test]
fn broken_sensors_name_line_and_value() {
    let error = |sensor: &str| -> LoadError {
        let loaded = ModelOptions::default().load_sdf_str(&sdf(sensor, ""));
        loaded.expect_err("an error")
    };
    for (sensor, part) in [
        (
            "\n<sensor name='s' type='imu'><update_rate>-3</update_rate></sensor>",
            "-3",
        ),
        (
            "\n<sensor name='s' type='imu'><update_rate>fast</update_rate></sensor>",
            "fast",
        ),
        (
            "\n<sensor name='s' type='imu'><update_rate>1e-320</update_rate></sensor>",
            "period is finite",
        ),
        (
            "\n<sensor name='s' type='lidar'><lidar><range><max>0</max></range></lidar></sensor>",
            "\"0\"",
        ),
        (
            "\n<sensor name='s' type='lidar'><lidar><noise><stddev>nan</stddev></noise></lidar></sensor>",
            "stddev",
        ),
        (
            "\n<sensor name='s' type='imu'><pose relative_to='nobody'>1 0 0 0 0 0</pose></sensor>",
            "nobody",
        ),
    ] {
        let text = error(sensor).to_string();
        assert!(
            text.contains(part) && text.contains(":5"),
            "{part} and the line in {text}"
        );
    }
}

/// A hostile file: many sensors of one name, each with a frame.
#[test]
fn sensors_of_one_name_have_frames_of_their_own() {
    let one = "<sensor name='imu' type='imu'><pose>0 0 1 0 0 0</pose></sensor>";
    let (model, report) = load(&sdf(&one.repeat(3), ""));
    let sensors = report.known_sensors(&model);
    assert_eq!(sensors.len(), 18);
    assert!(
        ["rod/imu", "rod/imu_", "rod/imu__"]
            .iter()
            .all(|name| model.frame(name).is_some())
    );
    assert_eq!(sensors.names()[6], "imu 2.x");
}
