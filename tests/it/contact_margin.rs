//! Margins: contact that begins at a distance. Bodies at rest against closed forms, accelerations beside another engine's, impacts, derivatives beside differences.

use std::panic::{AssertUnwindSafe, catch_unwind};

use dualbody::collision::Surface;
use dualbody::contact::{
    CollisionOptions, ContactLaw, Contacts, Material, Materials, RelaxedRigid, Rigid, SoftContact,
    Terrain,
};
use dualbody::model::{Mass, Model, Object, World};
use dualbody::sim::{BatchSimulator, SimulatorParameterGroup as Group};
use dualbody::spatial::Transform;
use dualbody::{Integrator, ModelOptions, Simulator, State};
use nalgebra::{DVector, Vector3};

const G: f64 = 9.81;
const RADIUS: f64 = 0.1;

fn at(x: f64, y: f64, z: f64) -> Transform<f64> {
    Transform::from_translation([x, y, z].into())
}

fn laws() -> [ContactLaw; 3] {
    [
        ContactLaw::Soft(SoftContact::estimate(1.0, 1, 1e-3)),
        ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        ContactLaw::Rigid(Rigid {
            restitution: 0.5,
            ..Rigid::default()
        }),
    ]
}

/// Depth from the margin on at which a ball of 1 kg rests: K δ^(1 + p) = m g; d k d δ = (1 − d) g; none.
fn sag(law: &ContactLaw) -> f64 {
    match law {
        ContactLaw::Soft(law) => {
            (G / law.normal.stiffness).powf(1.0 / (1.0 + law.normal.stiffness_exponent))
        }
        ContactLaw::RelaxedRigid(_) => {
            // d from 0.9 to 0.95 over 1 mm, k = 1 / (0.95 · 20 ms)².
            let d = |x: f64| {
                let y = (x / 1e-3).min(1.0);
                0.9 + 0.05
                    * if y < 0.5 {
                        2.0 * y * y
                    } else {
                        1.0 - 2.0 * (1.0 - y).powi(2)
                    }
            };
            let mut depth = 1e-3;
            for _ in 0..200 {
                depth = (1.0 - d(depth)) * G * (0.95_f64 * 0.02).powi(2) / d(depth).powi(2);
            }
            depth
        }
        _ => 0.0,
    }
}

/// Balls of 1 kg at heights over a plate whose top is at z = 0, and over the ground there in its place.
fn balls(law: ContactLaw, heights: &[f64], ground: bool, options: &CollisionOptions) -> Simulator {
    let mut world = World::default();
    let plate = Object::fixed().at(at(0.0, 0.0, if ground { -9.0 } else { -0.1 }));
    world
        .add_box("plate", [9.0, 9.0, 0.2], &plate)
        .expect("a plate");
    for (k, height) in heights.iter().enumerate() {
        let ball = Object::free(Mass::Kilograms(1.0)).at(at(k as f64, 0.0, *height));
        world
            .add_sphere(&format!("ball {k}"), RADIUS, &ball)
            .expect("a ball");
    }
    let model = world.build().expect("a world");
    let contacts = Contacts::new(&model, Terrain::flat(if ground { 0.0 } else { -5.0 }), law)
        .with_collisions(&model, law, options)
        .expect("links");
    Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(1e-3)
}

fn margin(margin: f64) -> Material {
    Material {
        margin,
        ..Material::default()
    }
}

fn is_at_rest(simulator: &Simulator) -> bool {
    let state: State = simulator.neutral_state();
    simulator.step(&state, &[]).v.amax() < 1e-11
}

// A sphere rests at r + margin − sag, by all contact models: the margins of both surfaces together, or that of the pair.
#[test]
fn balls_rest_at_the_height_of_their_margins() {
    let options = CollisionOptions::default()
        .with_material("plate", margin(0.01))
        .with_material("ball 0", margin(0.025))
        .with_pair("plate", "ball 1", margin(0.1))
        .with_pair("ball 2", "plate", margin(0.0));
    for law in laws() {
        let rest = [0.035, 0.1, 0.0, 0.01].map(|margin| RADIUS + margin - sag(&law));
        for integrator in [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity] {
            let simulator = balls(law, &rest, false, &options).with_integrator(integrator);
            assert!(is_at_rest(&simulator), "{law:?}");
            let higher = rest.map(|height| height + 1e-4);
            let falls = balls(law, &higher, false, &options).with_integrator(integrator);
            assert!(!is_at_rest(&falls), "{law:?}");
        }
    }
}

#[test]
fn balls_rest_over_the_ground_at_the_height_of_its_and_their_margin() {
    let table = Materials::default()
        .with_material("felt", margin(0.02))
        .with_material("wood", margin(0.01));
    for law in laws() {
        let rest = [0.03, 0.005, 0.0].map(|margin| RADIUS + margin - sag(&law));
        let simulator = balls(law, &rest, true, &CollisionOptions::default());
        let model = simulator.model().clone();
        let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
            .with_links(&model, &["ball 0", "ball 1", "ball 2"])
            .and_then(|own| own.with_materials(&model, &table, "wood", &[("ball 0", "felt")]))
            .and_then(|own| own.with_margin(&model, "ball 1", 0.005));
        let given = contacts.expect("links");
        // A margin does not change with the friction of the pair.
        let of_pair = table.between("felt", "wood").expect("materials");
        assert_eq!(of_pair.margin, 0.03);
        let on_ground = simulator.clone().with_contacts(given.clone());
        assert!(is_at_rest(&on_ground), "{law:?}");
        let depths = given.states(&model, simulator.neutral_state().q.as_slice(), &[0.0; 18]);
        for state in &depths {
            assert!((state.depth - sag(&law)).abs() < 1e-15);
        }
        // The same on a slope and on a grid of heights.
        let slope = Terrain::plane([0.0, 0.0, 0.0], [0.0, 0.3, 1.0]);
        let state = given.with_terrain(slope);
        let state = state.states(&model, &lifted(&model, 0.5), &[0.0; 18]);
        let normal = Vector3::new(0.0, 0.3, 1.0).normalize();
        let own = |height: f64, margin: f64| RADIUS + margin - (height + 0.5) * normal.z;
        assert!((state[0].depth - own(rest[0], 0.03)).abs() < 1e-15);
    }
}

/// The neutral configuration, with free bodies higher.
fn lifted(model: &Model, by: f64) -> Vec<f64> {
    let mut q = model.neutral().as_slice().to_vec();
    q.chunks_exact_mut(7).for_each(|own| own[2] += by);
    q
}

#[test]
fn a_margin_of_zero_is_none_bit_for_bit() {
    let heights = [0.0999, 0.1, 0.11];
    for law in laws() {
        for (ground, some) in [(true, 0.0), (false, 0.0)] {
            let none = CollisionOptions::default().with_material("plate", Material::default());
            let zero = none.clone().with_pair("plate", "ball 1", margin(some));
            let [a, b] = [none, zero].map(|options| {
                let simulator = balls(law, &heights, ground, &options);
                let end = simulator.rollout(&simulator.neutral_state(), 50, |_, _, _| {});
                end.last().clone()
            });
            assert_eq!((a.q, a.v), (b.q, b.v));
        }
    }
}

// A ball that falls on a margin with restitution e: bounces as one that is larger by the margin does. h(T) = r + m + e (|ḣ| T − h₀ + r + m) without gravity.
#[test]
fn impacts_happen_at_their_time_at_the_margin() {
    let plate = Material {
        restitution: 0.5,
        ..margin(0.05)
    };
    let options = CollisionOptions::default().with_material("plate", plate);
    let law = laws()[2];
    for ground in [false, true] {
        let simulator = balls(law, &[1.0], ground, &options);
        let model = simulator.model().clone().with_gravity(Vector3::zeros());
        let terrain = Terrain::flat(if ground { 0.0 } else { -5.0 });
        let mut contacts = Contacts::new(&model, terrain, law)
            .with_collisions(&model, law, &options)
            .expect("links");
        if ground {
            contacts = contacts
                .with_margin(&model, "ball 0", 0.05)
                .expect("a link");
        }
        for dt in [1e-4, 1e-3, 1e-2] {
            let simulator = Simulator::new(model.clone())
                .with_contacts(contacts.clone())
                .with_time_step(dt);
            let mut state = simulator.neutral_state();
            state.v[2] = -2.0;
            let steps = (1.0 / dt).round() as usize;
            let end = simulator.rollout(&state, steps, |_, _, _| {});
            let expected = 0.15 + 0.5 * (2.0 - 1.0 + 0.15);
            // Coordinates are relative to where the ball was put.
            let found = 1.0 + end.last().q[2];
            assert!((found - expected).abs() < 1e-6, "{dt}: {found} {expected}");
        }
    }
}

/// Accelerations of two bodies of an MJCF scene along z, and the number of contact points with forces.
fn accelerations(
    floor: &str,
    [lower, upper]: [&str; 2],
    more: &str,
    [h, k]: [f64; 2],
    kind: &str,
) -> ([f64; 2], usize) {
    let xml = format!(
        "<mujoco><option timestep='0.002' cone='elliptic'/><worldbody><geom name='floor' type='plane' size='1 1 1' {floor}/>
         <body pos='0 0 {h}'><freejoint/><geom name='lower' {kind} {lower}/></body>
         <body pos='0 0 {k}'><freejoint/><geom name='upper' {kind} {upper}/></body></worldbody>{more}</mujoco>"
    );
    let (scene, report) = ModelOptions::default()
        .load_mjcf_scene_str(&xml)
        .expect("a scene");
    assert!(!report.to_string().contains("margin"), "{report}");
    let simulator = scene.simulator();
    let next = simulator.step(&scene.reference, &[]);
    let report = simulator.contact_report(&scene.reference, &[]);
    let pairs = report.pairs.iter().map(|own| own.force);
    let forces = report.forces.iter().copied().chain(pairs);
    let touching = forces.filter(|force| force.norm() > 0.0).count();
    ([next.v[2] / 0.002, next.v[8] / 0.002], touching)
}

// By MuJoCo 4.0 with its solver's tolerance at zero: margins are summed, whatever the priority; a pair has its own; gap has no effect.
#[test]
fn accelerations_of_balls_within_their_margins_equal_those_of_mujoco() {
    let pairs = "<contact><pair geom1='lower' geom2='upper' margin='0.04' gap='0.01'/><pair geom1='floor' geom2='lower' margin='0.005'/></contact>";
    let (a, b, c) = ("margin='0.01'", "margin='0.02'", "margin='0.01'");
    for (floor, geoms, more, heights, expected, count) in [
        (a, [b, ""], "", [0.12, 0.5], [24.509500000000017, -9.81], 1),
        (
            "margin='0.01' gap='0.05'",
            ["margin='0.02' gap='0.3'", ""],
            "",
            [0.12, 0.5],
            [24.509500000000017, -9.81],
            1,
        ),
        (
            "",
            [b, "margin='0.01' priority='1'"],
            "",
            [0.3, 0.525],
            [-16.05999999999997, -3.5600000000000316],
            1,
        ),
        (
            a,
            [b, c],
            pairs,
            [0.102, 0.33],
            [4.914806378132147, 32.0838724373576],
            2,
        ),
        (
            a,
            [b, c],
            "",
            [0.115, 0.34],
            [34.4136674259681, 42.106651480637744],
            2,
        ),
    ] {
        let (found, touching) = accelerations(floor, geoms, more, heights, "size='0.1'");
        assert_eq!(touching, count, "{floor} {geoms:?} {more}");
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() < 1e-8 * 50.0,
                "{geoms:?} {more}: {found} {expected}"
            );
        }
    }
    let boxes = accelerations(
        a,
        ["margin='0.002'", ""],
        "",
        [0.11, 0.7],
        "type='box' size='0.2 0.15 0.1'",
    );
    assert_eq!(boxes.1, 4);
}

#[test]
fn a_negative_margin_of_an_mjcf_file_names_its_element() {
    for (geom, pair) in [
        ("margin='-0.01'", ""),
        ("", "margin='-0.5'"),
        ("margin='nan'", ""),
    ] {
        let xml = format!(
            "<mujoco><worldbody><geom name='floor' type='plane' size='1 1 1'/>\n<body><freejoint/><geom name='a' size='0.1' {geom}/></body></worldbody>
             <contact><pair geom1='a' geom2='floor' {pair}/></contact></mujoco>"
        );
        let error = ModelOptions::default().load_mjcf_scene_str(&xml);
        let error = error.map(|_| ()).expect_err("a margin").to_string();
        let element = if pair.is_empty() { "geom" } else { "pair" };
        for part in ["margin", element] {
            assert!(error.contains(part), "{error}");
        }
    }
}

#[test]
fn margins_that_are_negative_or_not_numbers_are_refused_by_name() {
    let model = balls(laws()[1], &[0.2], true, &CollisionOptions::default());
    let model = model.model().clone();
    let message = |make: &dyn Fn()| {
        let panic = catch_unwind(AssertUnwindSafe(make)).expect_err("a panic");
        let text = panic.downcast_ref::<String>();
        text.cloned().unwrap_or_default()
    };
    for bad in [-1e-3, f64::NAN, f64::INFINITY] {
        let table = || drop(Materials::default().with_material("odd", margin(bad)));
        let found = message(&table);
        assert!(found.contains("margin"), "{found}");
        let law = laws()[1];
        let ground = || {
            let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
            drop(contacts.with_margin(&model, "ball 0", bad));
        };
        let found = message(&ground);
        assert!(
            found.contains("\"ball 0\"") && found.contains("margin"),
            "{found}"
        );
        let pairs = || {
            let options = CollisionOptions::default().with_material("ball 0", margin(bad));
            let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
            drop(contacts.with_collisions(&model, law, &options));
        };
        let found = message(&pairs);
        assert!(found.contains("margin"), "{found}");
    }
    let contacts = Contacts::new(&model, Terrain::flat(0.0), laws()[1]);
    let error = contacts.with_margin(&model, "nobody", 0.1);
    assert_eq!(error.expect_err("no link").name, "nobody");
}

/// The difference of two steps in the tangent space.
fn difference(simulator: &Simulator, from: &State, to: &State) -> DVector<f64> {
    let dq = simulator
        .model()
        .difference(from.q.as_slice(), to.q.as_slice());
    let rest = [&to.v - &from.v, &to.contact - &from.contact];
    let all = dq.iter().chain(rest.iter().flatten()).copied();
    DVector::from_vec(all.collect())
}

/// Gradients of a step in parameters of contact beside central differences, and in the state beside A; the number of margins among them that matter.
fn check_derivatives(simulator: &Simulator) -> usize {
    let mut state = simulator.neutral_state();
    for (k, v) in state.v.iter_mut().enumerate() {
        *v = 0.02 * (k as f64 + 1.0).sin() - if k % 6 == 2 { 0.1 } else { 0.0 };
    }
    let n = 2 * state.v.len() + state.contact.len();
    let weights = DVector::from_fn(n, |k, _| (k as f64 + 0.5).sin());
    let gradient = simulator.vjp(&state, &[], weights.as_slice());
    // Differences in the tangent space at the next state.
    let next = simulator.step(&state, &[]);
    let a = simulator.linearize(&state, &[]).a;
    let error = (a.tr_mul(&weights) - &gradient.state).amax() / a.amax();
    assert!(error < 1e-9, "adjoint differs by {error:e}");
    for k in 0..state.v.len() {
        let [after, before] = [1e-6, -1e-6].map(|h| {
            let mut dv = vec![0.0; state.v.len()];
            dv[k] = h;
            let mut moved = state.clone();
            moved.q = simulator.model().integrate(state.q.as_slice(), &dv);
            difference(simulator, &next, &simulator.step(&moved, &[]))
        });
        let expected = (after - before) / 2e-6;
        let error = (a.column(k) - &expected).amax() / a.amax();
        assert!(error < 3e-6, "coordinate {k}: {error:e}");
    }
    let (layout, parameters) = (simulator.parameter_layout(), simulator.parameters());
    let mut margins = 0;
    for (group, range) in layout.groups() {
        let is_own = matches!(
            group,
            Group::PairLaw
                | Group::CollisionShape(_)
                | Group::PairMaterial(_)
                | Group::ContactLaw(_)
        );
        for k in range.clone().filter(|k| is_own && parameters[*k] != 0.0) {
            let by = 1e-6 * parameters[k];
            let [after, before] = [by, -by].map(|by| {
                let mut moved = parameters.clone();
                moved[k] += by;
                let moved = simulator.with_parameters(moved.as_slice());
                difference(simulator, &next, &moved.step(&state, &[]))
            });
            let expected = (after - before).dot(&weights) / (2.0 * by);
            let own = gradient.parameters[k];
            let scale = expected.abs().max(1.0).max(1.0 / parameters[k]);
            assert!(
                (own - expected).abs() < 2e-6 * scale,
                "{} of {group:?}: {own} {expected}",
                layout.names()[k]
            );
            let is_margin = layout.names()[k].contains("margin");
            margins += usize::from(is_margin && expected.abs() > 1e-3);
        }
    }
    margins
}

// Of the ground's points, of shapes of two links, of a pair.
#[test]
fn derivatives_in_margins_and_states_equal_differences() {
    let options = CollisionOptions::default()
        .with_material("plate", margin(0.01))
        .with_material("ball 0", margin(0.025))
        .with_pair("plate", "ball 1", margin(0.1));
    for (k, law) in laws().into_iter().enumerate() {
        let integrators: &[Integrator] = match k {
            0 => &[Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity],
            _ => &[Integrator::SemiImplicitEuler],
        };
        for &integrator in integrators {
            let own = |margin: f64| RADIUS + margin - 1.5e-3;
            let simulator = balls(law, &[own(0.035), own(0.1)], false, &options);
            let found = check_derivatives(&simulator.with_integrator(integrator));
            assert_eq!(found, 3, "{law:?}");
            let heights = [own(0.02), own(0.0)];
            let simulator = balls(law, &heights, true, &CollisionOptions::default());
            let model = simulator.model().clone();
            let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
            let contacts = contacts
                .with_margin(&model, "ball 0", 0.02)
                .expect("a link");
            let simulator = simulator.with_contacts(contacts);
            let found = check_derivatives(&simulator.with_integrator(integrator));
            assert_eq!(found, 1, "{law:?}");
        }
    }
}

// Lanes and triangles: a batch is its states one by one, a ball rests over a mesh as over a plate.
#[test]
fn batches_and_surfaces_have_margins() {
    let options = CollisionOptions::default()
        .with_material("plate", margin(0.01))
        .with_material("ball 0", margin(0.025));
    for law in laws() {
        let simulator = balls(law, &[0.2, 0.112], false, &options);
        let states: Vec<State> = (0..9)
            .map(|k| {
                let mut state = simulator.neutral_state();
                state.q[2] = 1e-3 * f64::from(k) - 0.068;
                state.v[0] = 0.1 * f64::from(k);
                state
            })
            .collect();
        let mut batch = BatchSimulator::new(simulator.clone(), states.len());
        let ends = batch.rollout(&states, 20, |_, _, _| {});
        for (k, state) in states.iter().enumerate() {
            let single = simulator.rollout(state, 20, |_, _, _| {});
            let error = (&single.last().v - &ends.last(k).v).amax();
            assert!(error < 1e-12, "{law:?}: {error:e}");
        }
        let corners = [[-5.0, -5.0], [5.0, -5.0], [5.0, 5.0], [-5.0, 5.0]];
        // The frame of its link is 9 m lower.
        let corners = corners.map(|[x, y]| Vector3::new(x, y, 9.0)).to_vec();
        let mesh = Surface::new(corners, vec![[0, 1, 2], [0, 2, 3]]).expect("a mesh");
        let mut world = World::default();
        let plate = Object::fixed().at(at(0.0, 0.0, -9.0));
        world.add_box("plate", [0.1; 3], &plate).expect("a plate");
        let height = RADIUS + 0.035 - sag(&law);
        let ball = Object::free(Mass::Kilograms(1.0)).at(at(1.0, 0.3, height));
        world.add_sphere("ball 0", RADIUS, &ball).expect("a ball");
        let model = world.build().expect("a world");
        let options = options.clone().with_surface("plate", mesh);
        let contacts = Contacts::new(&model, Terrain::flat(-50.0), law)
            .with_collisions(&model, law, &options)
            .expect("links");
        let simulator = Simulator::new(model).with_contacts(contacts);
        assert!(is_at_rest(&simulator.with_time_step(1e-3)), "{law:?}");
    }
}
