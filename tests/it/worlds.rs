//! Worlds of several robots and objects: each member moves as it does alone, independent of the other members.

use std::ops::Range;

use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, Rigid, Terrain};
use dualbody::control::Lqr;
use dualbody::dynamics::{frame_pose, mass_matrix};
use dualbody::error::{EditError, InvalidState};
use dualbody::model::{
    Base, JointSpec, LinkSpec, Mass, ModelBuilder, Object, UpAxis, World, samples,
};
use dualbody::sim::{BatchSimulator, Engine, EngineCoordinates};
use dualbody::spatial::{Motion, Quaternion, Representation, Transform};
use dualbody::view::Recording;
use dualbody::{Integrator, Model, ModelOptions, Simulator, State};
use nalgebra::{DMatrix, DVector, Vector3};
use rand::RngExt;

use crate::common::{
    OTHER_ALGORITHM, ROUNDING, SAME_ALGEBRA, asset, floating_robot, generator, random_point,
};

const DT: f64 = 0.005;

fn at(x: f64, y: f64, z: f64) -> Transform<f64> {
    Transform::from_translation(Vector3::new(x, y, z))
}

fn turned() -> Transform<f64> {
    let rotation = Quaternion::exp(&Vector3::new(0.2, -0.4, 0.9)).to_matrix();
    Transform::new(rotation, Vector3::new(-1.0, 2.0, 0.5))
}

/// The members of [`cell`] by prefix: a floating robot, an arm, and a robot with every kind of joint.
fn members() -> Vec<(&'static str, Model)> {
    vec![
        ("a/", floating_robot()),
        ("b/", samples::arm()),
        ("c/", samples::random_tree(9, 1)),
    ]
}

/// Members at the origin, so that they are in the world as they are alone.
fn cell() -> Model {
    let mut world = World::new("cell");
    for (prefix, model) in members() {
        world.add(&model, prefix, &Transform::identity()).unwrap();
    }
    world.build().unwrap()
}

/// Coordinates in q and v of the joints whose names begin with a prefix.
fn coordinates(world: &Model, prefix: &str) -> [Range<usize>; 2] {
    let names = world.joint_names();
    let own = names.iter().filter(|name| name.starts_with(prefix));
    let ids: Vec<_> = own.map(|name| world.joint(name).unwrap()).collect();
    let span = |ranges: Vec<Range<usize>>| {
        let start = ranges.iter().map(|range| range.start).min().unwrap();
        start..ranges.iter().map(|range| range.end).max().unwrap()
    };
    [
        span(ids.iter().map(|&id| world.joint_q(id)).collect()),
        span(ids.iter().map(|&id| world.joint_v(id)).collect()),
    ]
}

fn part(world: &Model, prefix: &str, state: &State) -> State {
    let [q, v] = coordinates(world, prefix);
    State::new(&state.q.as_slice()[q], &state.v.as_slice()[v])
}

fn simulator(model: Model, integrator: Integrator) -> Simulator {
    Simulator::new(model)
        .with_time_step(DT)
        .with_integrator(integrator)
}

/// A random state, and inputs of a simulator by the names of their coordinates.
fn start(model: &Model, seed: u64) -> (State, DVector<f64>) {
    let point = random_point(model, seed);
    let state = State::new(point.q.as_slice(), point.v.as_slice());
    (state, point.w)
}

/// The part of a force on all coordinates that a simulator has inputs for.
fn input(simulator: &Simulator, force: &[f64]) -> Vec<f64> {
    simulator.actuated().iter().map(|&v| force[v]).collect()
}

fn difference(a: &State, b: &State) -> f64 {
    let numbers = a.numbers().zip(b.numbers());
    numbers.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

const INTEGRATORS: [Integrator; 4] = [
    Integrator::SemiImplicitEuler,
    Integrator::ImplicitVelocity,
    Integrator::RungeKutta4,
    Integrator::ImplicitMidpoint,
];

#[test]
fn members_of_a_world_move_as_each_alone() {
    let world = cell();
    let (start, force) = start(&world, 5);
    for integrator in INTEGRATORS {
        let all = simulator(world.clone(), integrator);
        let u = input(&all, force.as_slice());
        let together = all.rollout(&start, 40, |_, _, out| out.copy_from_slice(&u));
        for (prefix, model) in members() {
            let alone = simulator(model, integrator);
            let [_, v] = coordinates(&world, prefix);
            let u = input(&alone, &force.as_slice()[v]);
            let first = part(&world, prefix, &start);
            let apart = alone.rollout(&first, 40, |_, _, out| out.copy_from_slice(&u));
            for (k, expected) in apart.states.iter().enumerate() {
                let error = difference(&part(&world, prefix, &together.states[k]), expected);
                let bound = match integrator {
                    // Both stop a search at a tolerance of all coordinates together.
                    Integrator::ImplicitMidpoint => OTHER_ALGORITHM,
                    _ => 0.0,
                };
                assert!(error <= bound, "{integrator:?} {prefix} {k}: {error:e}");
            }
        }
    }
}

/// A matrix of tangents (δq, δv) or inputs of a member: its rows and columns.
fn block(matrix: &DMatrix<f64>, rows: &[usize], columns: &[usize]) -> DMatrix<f64> {
    DMatrix::from_fn(rows.len(), columns.len(), |i, j| {
        matrix[(rows[i], columns[j])]
    })
}

#[test]
fn jacobians_and_mass_matrix_of_a_world_have_the_blocks_of_its_members_and_zeros() {
    let world = cell();
    let (start, force) = start(&world, 6);
    let nv = world.nv();
    let M = mass_matrix(&world, start.q.as_slice());
    for integrator in INTEGRATORS {
        let all = simulator(world.clone(), integrator);
        let u = input(&all, force.as_slice());
        let mut step = all.linearize(&start, &u);
        let mut M = M.clone();
        for (prefix, model) in members() {
            let [_, v] = coordinates(&world, prefix);
            let alone = simulator(model, integrator);
            let own = part(&world, prefix, &start);
            let expected = alone.linearize(&own, &input(&alone, &force.as_slice()[v.clone()]));
            let tangent: Vec<usize> = v.clone().chain(v.start + nv..v.end + nv).collect();
            let inputs = all.actuated().iter().enumerate();
            let inputs: Vec<usize> = inputs
                .filter(|(_, at)| v.contains(at))
                .map(|(k, _)| k)
                .collect();
            let a = block(&step.a, &tangent, &tangent) - &expected.a;
            let b = block(&step.b, &tangent, &inputs) - &expected.b;
            let v: Vec<usize> = v.collect();
            let mass = block(&M, &v, &v) - mass_matrix(alone.model(), own.q.as_slice());
            let error = a.amax().max(b.amax()).max(mass.amax());
            assert!(
                error < OTHER_ALGORITHM,
                "{integrator:?} {prefix}: {error:e}"
            );
            // The remaining entries couple members.
            for &i in &tangent {
                tangent.iter().for_each(|&j| step.a[(i, j)] = 0.0);
                inputs.iter().for_each(|&j| step.b[(i, j)] = 0.0);
            }
            for &i in &v {
                v.iter().for_each(|&j| M[(i, j)] = 0.0);
            }
        }
        assert_eq!(M.amax(), 0.0);
        let coupling = step.a.amax().max(step.b.amax());
        assert_eq!(coupling, 0.0, "{integrator:?}");
    }
}

#[test]
fn vector_jacobian_product_of_a_world_equals_those_of_its_members() {
    let world = cell();
    let (start, force) = start(&world, 7);
    let all = simulator(world.clone(), Integrator::SemiImplicitEuler);
    let mut rng = generator(8);
    let mut weights = vec![0.0; 2 * world.nv()];
    weights
        .iter_mut()
        .for_each(|x| *x = rng.random_range(-1.0..1.0));
    let whole = all.vjp(&start, &input(&all, force.as_slice()), &weights);
    let nv = world.nv();
    for (prefix, model) in members() {
        let [_, v] = coordinates(&world, prefix);
        let alone = simulator(model, Integrator::SemiImplicitEuler);
        let own: Vec<f64> = v
            .clone()
            .chain(v.start + nv..v.end + nv)
            .map(|k| weights[k])
            .collect();
        let u = input(&alone, &force.as_slice()[v.clone()]);
        let expected = alone.vjp(&part(&world, prefix, &start), &u, &own);
        let tangent = v.clone().chain(v.start + nv..v.end + nv);
        for (k, at) in tangent.enumerate() {
            let error = (whole.state[at] - expected.state[k]).abs();
            assert!(error < OTHER_ALGORITHM, "{prefix} {k}: {error:e}");
        }
    }
}

#[test]
fn batch_of_worlds_has_the_bits_of_single_ones() {
    let all = simulator(cell(), Integrator::SemiImplicitEuler);
    let states: Vec<State> = (0..5).map(|k| start(all.model(), 20 + k).0).collect();
    let u = vec![0.1; all.nu()];
    let inputs = u.repeat(states.len());
    let batch = BatchSimulator::new(all.clone(), states.len());
    let jacobians = batch.linearize(&states, &inputs);
    for (state, together) in states.iter().zip(jacobians) {
        assert_eq!(together, all.linearize(state, &u));
    }
}

#[test]
fn order_of_adding_has_no_effect() {
    let build = |order: &[usize]| {
        let mut world = World::new("cell");
        for &k in order {
            let steel = Object::free(Mass::Density(7800.0)).at(at(0.0, 0.0, 1.0));
            let added = match k {
                0 => world.add(&samples::arm(), "right/", &turned()),
                1 => world.add(&floating_robot(), "left/", &at(0.0, 3.0, 0.0)),
                2 => world.add_on(&samples::pendulum(), "bob/", "right/tool", &turned()),
                _ => world.add_box("cube", [0.1, 0.2, 0.3], &steel),
            };
            added.unwrap();
        }
        world.build().unwrap()
    };
    let first = build(&[0, 1, 2, 3]);
    let (start, force) = start(&first, 3);
    let step = |model: &Model| {
        let simulator = simulator(model.clone(), Integrator::SemiImplicitEuler);
        simulator.step(&start, &input(&simulator, force.as_slice()))
    };
    for order in [[3, 2, 1, 0], [2, 0, 3, 1]] {
        let other = build(&order);
        assert_eq!(other.joint_names(), first.joint_names());
        assert_eq!(other.bodies(), first.bodies());
        assert_eq!(step(&other), step(&first));
    }
    assert_eq!(first.joint_names()[0], "cube");
    assert_eq!(first.joint_names()[1], "left/floating_base");
}

#[test]
fn members_stand_where_they_were_added() {
    let mut world = World::default();
    world.add(&samples::arm(), "arm/", &turned()).unwrap();
    world
        .add_on(&floating_robot(), "held/", "arm/tool", &at(0.0, 0.0, 0.1))
        .unwrap();
    world
        .add(&floating_robot(), "free/", &at(1.0, 2.0, 3.0))
        .unwrap();
    let lid = Object::fixed_to("arm/tool", Mass::Kilograms(0.5)).at(at(0.0, 0.1, 0.0));
    world.add_cylinder("lid", 0.1, 0.02, &lid).unwrap();
    let model = world.build().unwrap();
    let neutral = model.neutral();
    let pose = |link: &str| frame_pose(&model, neutral.as_slice(), model.frame(link).unwrap());
    let arm = samples::arm();
    let tool = frame_pose(&arm, arm.neutral().as_slice(), arm.frame("tool").unwrap());
    for (link, expected) in [
        ("arm/tool", turned() * tool),
        ("held/torso", turned() * tool * at(0.0, 0.0, 0.1)),
        ("free/torso", at(1.0, 2.0, 3.0)),
        ("lid", turned() * tool * at(0.0, 0.1, 0.0)),
    ] {
        let error = (pose(link).translation - expected.translation).amax()
            + (pose(link).rotation - expected.rotation).amax();
        assert!(error < 10.0 * ROUNDING, "{link}: {error:e}");
    }
    let robot = floating_robot();
    assert_eq!(model.nv(), arm.nv() + 2 * robot.nv() - 6);
    let mass = arm.total_mass() + 2.0 * robot.total_mass() + 0.5;
    assert!((model.total_mass() - mass).abs() < 100.0 * ROUNDING);
}

// A floating body above a fixed joint on a link `world` keeps that placement, and the link `world` stays.
#[test]
fn robot_that_floats_below_a_link_world_moves_as_alone() {
    let mut builder = ModelBuilder::new("robot").with_base(Base::Floating);
    builder.add_link(LinkSpec::new("world"));
    builder.add_link(LinkSpec::new("hull").with_mass(1.0, [0.1, 0.0, 0.2], [0.1, 0.2, 0.25]));
    let weld = JointSpec::new("weld", dualbody::joint::JointKind::Fixed, "world", "hull");
    builder.add_joint(weld.with_placement(turned()));
    let alone = builder.build().unwrap().with_damping(4, 0.3);
    let mut world = World::default();
    world.add(&alone, "r/", &at(0.0, 0.0, 0.0)).unwrap();
    let model = world.build().unwrap();
    let (start, _) = start(&alone, 4);
    let [ours, theirs] = [&model, &alone].map(|model| {
        let simulator = simulator(model.clone(), Integrator::SemiImplicitEuler);
        assert_eq!(simulator.nu(), 0);
        simulator.step(&start, &[])
    });
    assert!(difference(&ours, &theirs) < ROUNDING, "{ours:?} {theirs:?}");
    assert_eq!(model.damping(), alone.damping());
    let pose = frame_pose(&model, start.q.as_slice(), model.frame("r/world").unwrap());
    assert_eq!(pose, Transform::identity());
}

#[test]
fn free_bodies_are_set_and_asked_by_name() {
    let mut world = World::default();
    world
        .add_sphere(
            "ball",
            0.1,
            &Object::free(Mass::Kilograms(2.0)).at(turned()),
        )
        .unwrap();
    world.add(&floating_robot(), "robot/", &turned()).unwrap();
    let model = world.build().unwrap();
    let mut state = State::neutral(&model);
    let (pose, twist) = (
        at(1.0, 0.0, 3.0) * turned(),
        Motion::from_array([1., 2., 3., 4., 5., 6.]),
    );
    for name in ["ball", "robot/floating_base"] {
        state.set_free_pose(&model, name, &pose).unwrap();
        state
            .set_free_velocity(&model, name, &twist, Representation::Mixed)
            .unwrap();
        let own = state.free_pose(&model, name).unwrap();
        let velocity = state
            .free_velocity(&model, name, Representation::Mixed)
            .unwrap();
        let error = (own.translation - pose.translation).amax()
            + (own.rotation - pose.rotation).amax()
            + (DVector::from_column_slice(&velocity.to_array())
                - DVector::from_column_slice(&twist.to_array()))
            .amax();
        assert!(error < 100.0 * ROUNDING, "{name}: {error:e}");
    }
    let link = model.frame("robot/torso").unwrap();
    let shown = frame_pose(&model, state.q.as_slice(), link);
    assert!((shown.translation - pose.translation).amax() < 10.0 * ROUNDING);
    let error = state.free_pose(&model, "robot/hinge_joint").unwrap_err();
    let error = error.to_string();
    let parts = [
        "no floating joint on the world \"robot/hinge_joint\"",
        "ball",
        "robot/floating_base",
    ];
    assert!(parts.iter().all(|part| error.contains(part)), "{error}");
}

// Thrown from 1 m: z = 1 − g t² / 2, and the arm falls beside it as it would alone.
#[test]
fn state_is_carried_by_name_to_a_world_with_other_members() {
    let mut world = World::default();
    let ball = Object::free(Mass::Kilograms(1.0)).at(at(0.0, 0.0, 1.0));
    world.add_sphere("ball", 0.1, &ball).unwrap();
    world.add(&samples::arm(), "arm/", &turned()).unwrap();
    let before = simulator(world.build().unwrap(), Integrator::RungeKutta4);
    let (start, _) = start(before.model(), 9);
    let moved = before.rollout(&start, 20, |_, _, u| u.fill(0.0));
    // The ball is added anew elsewhere, the arm stays, a cube comes, all under other coordinates.
    world.remove("ball").unwrap();
    let elsewhere = ball.at(turned());
    world.add_sphere("ball", 0.1, &elsewhere).unwrap();
    let cube = Object::free(Mass::Kilograms(3.0)).at(at(5.0, 5.0, 5.0));
    world.add_box("aaa", [0.2; 3], &cube).unwrap();
    let after = simulator(world.build().unwrap(), Integrator::RungeKutta4);
    let state = after.carried_state(&before, moved.last()).unwrap();
    state.check(after.model()).unwrap();
    for (link, bound) in [("arm/tool", 0.0), ("ball", 10.0 * ROUNDING)] {
        let pose = |simulator: &Simulator, state: &State| {
            let frame = simulator.model().frame(link).unwrap();
            frame_pose(simulator.model(), state.q.as_slice(), frame)
        };
        let (ours, theirs) = (pose(&after, &state), pose(&before, moved.last()));
        let error = (ours.translation - theirs.translation).amax()
            + (ours.rotation - theirs.rotation).amax();
        assert!(error <= bound, "{link}: {error:e}");
    }
    let cube = state.free_pose(after.model(), "aaa").unwrap();
    assert_eq!(cube, at(5.0, 5.0, 5.0));
    let [_, v] = coordinates(after.model(), "aaa");
    assert!(state.v.as_slice()[v].iter().all(|&x| x == 0.0));
    // And back again: the cube goes.
    let back = before.carried_state(&after, &state).unwrap();
    // Both signs of a quaternion are one rotation.
    let off = back.deviation(before.model(), moved.last());
    assert!(off.amax() < 100.0 * ROUNDING, "{:e}", off.amax());

    let mut other = samples::cartpole().to_builder();
    other.add_link(LinkSpec::new("x").with_mass(1.0, [0.0; 3], [1.0; 3]));
    let [hinge, slide] = [
        dualbody::joint::JointKind::Revolute,
        dualbody::joint::JointKind::Prismatic,
    ]
    .map(|kind| {
        let mut builder = other.clone();
        builder.add_joint(JointSpec::new("j", kind, "world", "x"));
        builder.build().unwrap()
    });
    let error = State::neutral(&hinge).carried(&hinge, &slide).unwrap_err();
    assert!(matches!(error, InvalidState::OtherJoint { .. }));
    assert_eq!(
        error.to_string(),
        "joint \"j\" is prismatic and was revolute"
    );
    let nan = State::new(&[f64::NAN, 0.0, 0.0], &[0.0; 3]);
    assert!(nan.carried(&hinge, &hinge).is_err());
}

fn error(change: impl FnOnce(&mut World) -> Result<(), EditError>) -> String {
    let mut world = World::new("lab");
    let arm = samples::arm();
    world.add(&arm, "a/", &Transform::identity()).unwrap();
    match change(&mut world).and_then(|()| world.build().map(drop)) {
        Ok(()) => panic!("no error"),
        Err(error) => error.to_string(),
    }
}

#[test]
fn what_is_no_world_is_refused_by_name() {
    let arm = &samples::arm();
    let here = &Transform::identity();
    let nan = &at(0.0, f64::NAN, 0.0);
    let free = &Object::free(Mass::Kilograms(1.0));
    let mirror = &Transform::new(
        nalgebra::Matrix3::from_diagonal(&Vector3::new(1.0, 1.0, -1.0)),
        Vector3::zeros(),
    );
    let cases: Vec<(String, &[&str])> = vec![
        (
            error(|w| w.add(arm, "a/", here).map(drop)),
            &["two members", "\"a/\""],
        ),
        (error(|w| w.add(arm, "", here).map(drop)), &["\"world\""]),
        (
            error(|w| w.add(arm, "b/", nan).map(drop)),
            &["<member> \"b/\"", "position"],
        ),
        (
            error(|w| w.add(arm, "b/", mirror).map(drop)),
            &["<member> \"b/\"", "not a rotation"],
        ),
        (
            error(|w| w.add(arm, "b/", &at(1e300, 0.0, 0.0)).map(drop)),
            &["<member> \"b/\"", "position 1e300"],
        ),
        (
            error(|w| w.add_on(arm, "b/", "a/tol", here).map(drop)),
            &["no frame \"a/tol\"", "a/tool"],
        ),
        (
            error(|w| {
                w.add_on(arm, "b/", "c/tool", here)?;
                w.add_on(arm, "c/", "b/tool", here).map(drop)
            }),
            &["loop", "attachment"],
        ),
        (
            error(|w| Ok(w.remove("b/").map(drop)?)),
            &["no member \"b/\"", "a/"],
        ),
        (
            error(|w| w.add_sphere("a/tool", 0.1, free).map(drop)),
            &["\"a/tool\""],
        ),
        (
            error(|w| w.add_sphere("world", 0.1, free).map(drop)),
            &["two links", "\"world\""],
        ),
        (
            error(|w| w.add_sphere("", 0.1, free).map(drop)),
            &["has no name"],
        ),
        (
            error(|w| w.add_sphere("ball", f64::NAN, free).map(drop)),
            &["\"ball\"", "size"],
        ),
        (
            error(|w| w.add_box("cube", [1.0, -1.0, 1.0], free).map(drop)),
            &["\"cube\"", "-1"],
        ),
        (
            error(|w| {
                w.add_box("cube", [1.0; 3], &Object::free(Mass::Kilograms(0.0)))
                    .map(drop)
            }),
            &["mass of \"cube\"", "not positive"],
        ),
        (
            error(|w| {
                let color = free.clone().with_color([0.0, f64::NAN, 0.0, 1.0]);
                w.add_box("cube", [1.0; 3], &color).map(drop)
            }),
            &["\"cube\"", "colour"],
        ),
        (
            error(|w| w.add_mesh("cup", "no/such.stl", [1.0; 3], free).map(drop)),
            &["\"cup\"", "no/such.stl"],
        ),
        (
            error(|w| {
                let mesh = dualbody::model::Geometry::Mesh {
                    uri: "x.stl".into(),
                    path: None,
                    scale: [1.0, 0.0, 1.0],
                    up_axis: UpAxis::default(),
                };
                let mut none = dualbody_solids();
                w.add_shape("cup", mesh, free, &mut none).map(drop)
            }),
            &["\"cup\"", "scale"],
        ),
    ];
    for (error, parts) in &cases {
        assert!(
            parts.iter().all(|part| error.contains(part)),
            "{parts:?}: {error}"
        );
    }
    let gravity = World::default().with_gravity([0.0, f64::INFINITY, 0.0]);
    assert!(gravity.build().unwrap_err().to_string().contains("gravity"));
    assert_eq!(World::default().build().unwrap().nv(), 0);
}

/// Solids of meshes that are never found.
fn dualbody_solids() -> impl dualbody::model::MeshSolids {
    struct Nothing;
    impl dualbody::model::MeshSolids for Nothing {
        fn solid(
            &mut self,
            _: &dualbody::model::Geometry,
        ) -> Result<dualbody::spatial::Inertia<f64>, String> {
            Err("is not there".into())
        }
    }
    Nothing
}

#[test]
fn a_mesh_has_the_inertia_of_its_solid() {
    // A tetrahedron at the origin with edges of 1 along the axes: volume 1/6, centre of mass at ¼.
    let facets = [
        [[0, 0, 0], [0, 1, 0], [1, 0, 0]],
        [[0, 0, 0], [1, 0, 0], [0, 0, 1]],
        [[0, 0, 0], [0, 0, 1], [0, 1, 0]],
        [[1, 0, 0], [0, 1, 0], [0, 0, 1]],
    ];
    let mut text = "solid t\n".to_owned();
    for facet in facets {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in facet {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    text += "endsolid t\n";
    let path = std::env::temp_dir().join(format!("tetrahedron_{}.stl", std::process::id()));
    std::fs::write(&path, text).unwrap();
    let body = |mass: Mass| {
        let mut world = World::default();
        world
            .add_mesh("t", &path, [2.0, 1.0, 1.0], &Object::free(mass))
            .unwrap();
        world.build().unwrap().bodies()[0].inertia
    };
    let (dense, given) = (body(Mass::Density(6.0)), body(Mass::Kilograms(4.0)));
    std::fs::remove_file(&path).unwrap();
    assert!((dense.mass - 2.0).abs() < ROUNDING);
    assert!((given.mass - 4.0).abs() < ROUNDING);
    for inertia in [dense, given] {
        assert!((inertia.com() - Vector3::new(0.5, 0.25, 0.25)).amax() < ROUNDING);
    }
}

const WORLD: &str = r#"<sdf version="1.10"><world name="lab"><gravity>0 0 -1.6</gravity>
    <frame name="shelf"><pose>0 0 2 0 0 0</pose></frame>
    <model name="table"><static>true</static><pose>0 0 0.7 0 0 0</pose><link name="top"><inertial><mass>9</mass></inertial>
      <collision name="c"><geometry><box><size>1 1 0.1</size></box></geometry></collision></link></model>
    <model name="arm"><pose>1 0 0 0 0 0</pose><link name="base"/><link name="rod"><inertial><pose>0 0 -0.5 0 0 0</pose><mass>2</mass></inertial></link>
      <joint name="hold" type="fixed"><parent>world</parent><child>base</child></joint>
      <joint name="swing" type="revolute"><parent>base</parent><child>rod</child><axis><xyz>0 1 0</xyz></axis></joint></model>
    <model name="ball"><pose relative_to="shelf">0 0.5 0 0 0 0</pose><link name="l"><inertial><mass>3</mass></inertial></link></model>
  </world></sdf>"#;

#[test]
fn sdf_world_is_read_with_all_its_models() {
    let all = ModelOptions::default().with_all_models();
    let (world, report) = all.load_sdf_str(WORLD).unwrap();
    assert_eq!(world.name(), "lab");
    assert_eq!(
        world.joint_names(),
        ["ball::floating_base", "arm::swing"],
        "{report}"
    );
    assert_eq!(
        world.link_names(),
        ["world", "ball::l", "table::top", "arm::base", "arm::rod"]
    );
    let state = State::neutral(&world);
    let pose = |link: &str| {
        let pose = frame_pose(&world, state.q.as_slice(), world.frame(link).unwrap());
        pose.translation
    };
    assert_eq!(pose("table::top"), Vector3::new(0.0, 0.0, 0.7));
    assert_eq!(pose("arm::rod"), Vector3::new(1.0, 0.0, 0.0));
    assert_eq!(pose("ball::l"), Vector3::new(0.0, 0.5, 2.0));
    assert_eq!(pose("shelf"), Vector3::new(0.0, 0.0, 2.0));
    let simulator = simulator(world, Integrator::SemiImplicitEuler);
    assert_eq!(simulator.nu(), 1);
    let fallen = simulator.rollout(&state, 100, |_, _, _| {});
    let ball = fallen
        .last()
        .free_pose(simulator.model(), "ball::floating_base");
    // Semi-implicit Euler falls by g dt² n (n + 1) / 2.
    let expected = 2.0 - 1.6 * DT * DT * 100.0 * 101.0 / 2.0;
    assert!((ball.unwrap().translation.z - expected).abs() < SAME_ALGEBRA);

    let held = all.with_base(Base::Fixed).load_sdf_str(WORLD).unwrap().0;
    assert_eq!(held.joint_names(), ["arm::swing"]);
    // A world is a member like any robot.
    let mut both = World::default();
    both.add(simulator.model(), "near/", &Transform::identity())
        .unwrap();
    both.add(simulator.model(), "far/", &at(9.0, 0.0, 0.0))
        .unwrap();
    let both = both.build().unwrap();
    let far = State::neutral(&both)
        .free_pose(&both, "far/ball::floating_base")
        .unwrap();
    assert_eq!(far.translation, Vector3::new(9.0, 0.5, 2.0));
}

#[test]
fn groups_of_links_of_an_sdf_world_float_each_and_loops_are_refused() {
    let link = |name: &str| format!("<link name='{name}'/>");
    let joint = |name: &str, parent: &str, child: &str| {
        format!(
            "<joint name='{name}' type='revolute'><parent>{parent}</parent><child>{child}</child><axis><xyz>0 0 1</xyz></axis></joint>"
        )
    };
    let world = |parts: String| {
        let text = format!("<sdf version='1.10'><world name='w'>{parts}</world></sdf>");
        ModelOptions::default()
            .with_all_models()
            .load_sdf_str(&text)
    };
    // Two models that a joint joins, and one whose two links nothing connects.
    let parts = format!(
        "<model name='a'>{}</model><model name='b'>{}</model>{}<model name='c'>{}{}</model>",
        link("l"),
        link("l"),
        joint("j", "b::l", "a::l"),
        link("m"),
        link("n"),
    );
    let (model, _) = world(parts).unwrap();
    assert_eq!(
        model.joint_names(),
        [
            "b::floating_base",
            "j",
            "c::floating_base",
            "c::n::floating_base"
        ]
    );
    let ring = format!(
        "<model name='a'>{}{}{}{}</model>",
        link("l"),
        link("m"),
        joint("j", "l", "m"),
        joint("k", "m", "l"),
    );
    let error = world(ring).unwrap_err().to_string();
    assert!(error.contains("loop"), "{error}");
    let twice = format!(
        "<model name='a'>{}</model><model name='a'>{}</model>",
        link("l"),
        link("l")
    );
    let error = world(twice).unwrap_err().to_string();
    assert!(error.contains("\"a\""), "{error}");
    assert!(world(String::new()).is_err());
}

#[test]
fn hundreds_of_free_bodies_fall_as_one() {
    let mut world = World::default();
    for k in 0..300 {
        let marble = Object::free(Mass::Kilograms(0.01)).at(at(k as f64, 0.0, 1.0));
        world.add_sphere(&format!("m{k}"), 0.01, &marble).unwrap();
    }
    let model = world.build().unwrap();
    assert_eq!(model.nv(), 1_800);
    let state = State::neutral(&model);
    let fallen = simulator(model.clone(), Integrator::SemiImplicitEuler).step(&state, &[]);
    let last: Transform<f64> = fallen.free_pose(&model, "m299").unwrap();
    assert!((last.translation.z - 1.0 + 9.81 * DT * DT).abs() < SAME_ALGEBRA);
    assert_eq!(last.translation.x, 299.0);
}

#[test]
fn recording_and_page_hold_every_member() {
    let mut world = World::new("cell");
    world
        .add(&samples::arm(), "bare/", &at(0.0, 1.0, 0.0))
        .unwrap();
    world.add(&asset("ur5.urdf"), "ur5/", &turned()).unwrap();
    let red = Object::free(Mass::Kilograms(0.2))
        .at(at(0.3, 0.0, 1.0))
        .with_color([1.0, 0.0, 0.0, 1.0]);
    world.add_box("brick", [0.123, 0.2, 0.3], &red).unwrap();
    world
        .add_cylinder("post", 0.0456, 2.0, &Object::fixed())
        .unwrap();
    let model = world.build().unwrap();
    let simulator = simulator(model, Integrator::SemiImplicitEuler);
    let rollout = simulator.rollout(&simulator.neutral_state(), 3, |_, _, u| u.fill(0.0));
    let recording = Recording::from_rollout(simulator.model(), &rollout);
    let page = recording.to_html();
    for part in ["bare/tool", "ur5/", "brick", "post", "0.123", "0.0456"] {
        assert!(page.contains(part), "{part}");
    }
    // The member without shapes is drawn as a skeleton, of capsules, beside those that have some.
    assert!(page.contains("\"capsule\""));
    let table = recording.to_csv();
    for part in ["bare/", "brick"] {
        assert!(table.lines().next().unwrap().contains(part), "{part}");
    }
}

// The free joints of MuJoCo have the pose in the world; here it is relative to where the body was added.
#[test]
fn coordinates_of_other_engines_of_a_free_body_are_those_of_the_world() {
    let mut world = World::default();
    let ball = Object::free(Mass::Kilograms(1.0)).at(turned());
    world.add_sphere("ball", 0.1, &ball).unwrap();
    world.add(&samples::arm(), "arm/", &turned()).unwrap();
    let model = world.build().unwrap();
    let (state, _) = start(&model, 12);
    let pose = state.free_pose(&model, "ball").unwrap();
    let twist = state
        .free_velocity(&model, "ball", Representation::Mixed)
        .unwrap();
    let (q, v) = EngineCoordinates::new(&model, Engine::MuJoCo).state_to(&state);
    let ball = model.joint_q(model.joint("ball").unwrap()).start;
    assert!((q.fixed_rows::<3>(ball) - pose.translation).amax() < 10.0 * ROUNDING);
    let first = model.joint_v(model.joint("ball").unwrap()).start;
    assert!((v.fixed_rows::<3>(first) - twist.linear).amax() < 10.0 * ROUNDING);
    for engine in [Engine::MuJoCo, Engine::Pinocchio, Engine::JaxSim] {
        let theirs = EngineCoordinates::new(&model, engine);
        let (q, v) = theirs.state_to(&state);
        let back = theirs.state_from(q.as_slice(), v.as_slice());
        let rotation = |state: &State| state.free_pose(&model, "ball").unwrap().rotation;
        assert!((rotation(&back) - rotation(&state)).amax() < 100.0 * ROUNDING);
        assert!((&back.v - &state.v).amax() < 100.0 * ROUNDING, "{engine:?}");
    }
}

#[test]
fn lqr_of_one_arm_holds_in_a_world() {
    let alone = simulator(samples::double_pendulum(), Integrator::SemiImplicitEuler);
    let mut world = World::default();
    for prefix in ["a/", "b/"] {
        world
            .add(alone.model(), prefix, &Transform::identity())
            .unwrap();
    }
    let both = simulator(world.build().unwrap(), Integrator::SemiImplicitEuler);
    let gain = |simulator: &Simulator| {
        let step = simulator.linearize(&simulator.neutral_state(), &vec![0.0; simulator.nu()]);
        let (n, m) = (step.a.nrows(), step.b.ncols());
        let (q, r) = (DMatrix::identity(n, n), DMatrix::identity(m, m));
        let lqr = Lqr::discrete(&step.a, &step.b, &q, &r);
        lqr.spectral_radius()
    };
    assert!((gain(&both) - gain(&alone)).abs() < OTHER_ALGORITHM);
}

// Rows of robots that do not touch each other are islands: each robot moves to the bits of one alone, and so are A and B.
#[test]
fn robots_on_the_ground_move_as_each_alone() {
    let quadruped = Model::from_urdf_file("assets/quadruped.urdf").expect("an asset");
    let standing = |n: usize, law: ContactLaw| {
        let mut world = World::default();
        for k in 0..n {
            let at = Transform::from_translation([2.0 * k as f64, 0.0, 0.0].into());
            world
                .add(&quadruped, &format!("{k}/"), &at)
                .expect("a member");
        }
        let model = world.build().expect("a world");
        let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
        let simulator = Simulator::new(model)
            .with_contacts(contacts)
            .with_time_step(2e-3);
        let mut state = simulator.neutral_state();
        let heights = state.q.iter_mut().skip(2).step_by(19);
        heights.for_each(|z| *z = 0.45);
        let u = vec![0.0; simulator.nu()];
        for _ in 0..200 {
            state = simulator.step(&state, &u);
        }
        (simulator, state)
    };
    for law in [
        ContactLaw::Rigid(Rigid::default()),
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
    ] {
        let ((one, alone), (three, state)) = (standing(1, law), standing(3, law));
        assert!(
            one.contact_report(&alone, &[0.0; 12])
                .forces
                .iter()
                .any(|f| f.norm() > 1.0)
        );
        let lone = one.linearize(&alone, &[0.0; 12]);
        let all = three.linearize(&state, &[0.0; 36]);
        for k in 0..3 {
            let v = (state.v.rows(18 * k, 18) - &alone.v).amax();
            assert!(v < 1e-11, "{k}: {v:e}");
            for (row, column) in [(0, 0), (0, 54), (54, 0), (54, 54)] {
                let own = all.a.view((row + 18 * k, column + 18 * k), (18, 18));
                let expected = lone.a.view((row / 3, column / 3), (18, 18));
                let error = (own - expected).amax();
                assert!(
                    error < 1e-9 * lone.a.amax(),
                    "{k} {row} {column}: {error:e}"
                );
            }
        }
        // Through all of it, also in friction.
        let adjoint: Vec<f64> = (0..108).map(|k| (f64::from(k) * 0.7).sin()).collect();
        let found = three.vjp(&state, &[0.0; 36], &adjoint);
        let expected = all.a.transpose() * DVector::from(adjoint);
        assert!((&found.state - &expected).amax() < 1e-10 * expected.amax());
    }
}
