//! Compliance of materials: closed forms of bodies at rest, other engines' heights, derivatives beside differences; and columns of boxes that yield.

use dualbody::contact::{
    CollisionOptions, Compliance, ContactLaw, Contacts, Impedance, Material, Materials, Reference,
    RelaxedRigid, Rigid, SoftContact, Terrain,
};
use dualbody::model::{Mass, Object, World};
use dualbody::sim::SimulatorParameterGroup as Group;
use dualbody::spatial::Transform;
use dualbody::{Integrator, ModelOptions, Simulator, State};
use nalgebra::{DMatrix, DVector};

const G: f64 = 9.81;
const RADIUS: f64 = 0.1;

fn at(x: f64, y: f64, z: f64) -> Transform<f64> {
    Transform::from_translation([x, y, z].into())
}

fn with(compliance: Compliance) -> Material {
    Material {
        compliance: Some(compliance),
        ..Material::default()
    }
}

fn soft(stiffness: f64, damping: f64) -> Compliance {
    Compliance::Soft { stiffness, damping }
}

/// By a time constant and a damping ratio, and an impedance that is constant from 10 µm on.
fn regularised(time_constant: f64, damping_ratio: f64, largest: f64) -> Compliance {
    Compliance::Regularised {
        reference: Reference::TimeConstant {
            time_constant,
            damping_ratio,
        },
        impedance: Impedance {
            largest,
            width: 1e-5,
            ..Impedance::default()
        },
    }
}

/// A plate, and balls of 1 kg on it at given depths.
fn on_a_plate(law: ContactLaw, depths: &[f64], options: &CollisionOptions) -> Simulator {
    let mut world = World::default();
    let plate = Object::fixed().at(at(0.0, 0.0, -0.1));
    world
        .add_box("plate", [9.0, 9.0, 0.2], &plate)
        .expect("a plate");
    for (k, depth) in depths.iter().enumerate() {
        let place = at(k as f64, 0.0, RADIUS - depth);
        let ball = Object::free(Mass::Kilograms(1.0)).at(place);
        world
            .add_sphere(&format!("ball {k}"), RADIUS, &ball)
            .expect("a ball");
    }
    let model = world.build().expect("a world");
    let contacts = Contacts::new(&model, Terrain::flat(-5.0), law)
        .with_selection(|_| false)
        .with_collisions(&model, law, options)
        .expect("links");
    Simulator::new(model)
        .with_contacts(contacts)
        .with_time_step(2e-3)
}

/// The largest velocity after a step from rest.
fn speed(simulator: &Simulator) -> f64 {
    simulator.step(&simulator.neutral_state(), &[]).v.amax()
}

// K δ^(1 + p) = m g, with the harmonic mean of both K; with the one that is given; with that of the pair.
#[test]
fn a_ball_rests_on_two_soft_materials_at_the_depth_of_both() {
    let law = SoftContact::estimate(1.0, 1, 1e-3);
    let (p, own) = (law.normal.stiffness_exponent, law.normal.stiffness);
    let options = CollisionOptions::default()
        .with_material("plate", with(soft(3.0 * own, 1e4)))
        .with_material("ball 0", with(soft(own, 2e4)))
        .with_material("ball 1", Material::default())
        .with_pair("plate", "ball 3", with(soft(7.0 * own, 1e4)))
        .with_pair("ball 4", "plate", Material::default());
    let stiffness = [1.5, 3.0, 3.0, 7.0, 1.0].map(|factor| factor * own);
    let depths = stiffness.map(|k| (G / k).powf(1.0 / (1.0 + p)));
    for integrator in [Integrator::ImplicitVelocity, Integrator::SemiImplicitEuler] {
        let simulator = on_a_plate(ContactLaw::Soft(law), &depths, &options);
        let speed = speed(&simulator.with_integrator(integrator));
        assert!(speed < 1e-12, "{integrator:?}: {speed:e}");
    }
}

// A point at rest has R f = k d δ with R = (1 − d) / d / m, so δ = g (1 − d) / (k d²), k = 1 / (d T ζ)²: δ = g (1 − d) (T ζ)².
#[test]
fn a_ball_rests_on_two_regularised_materials_at_the_depth_of_both() {
    let direct = Compliance::Regularised {
        reference: Reference::Direct {
            stiffness: 2e3,
            damping: 80.0,
        },
        impedance: Impedance {
            largest: 0.92,
            width: 1e-5,
            ..Impedance::default()
        },
    };
    let options = CollisionOptions::default()
        .with_material("plate", with(regularised(0.04, 0.8, 0.9)))
        .with_material("ball 0", with(regularised(0.02, 1.2, 0.98)))
        .with_material("ball 1", Material::default())
        .with_material("ball 2", with(direct))
        .with_pair("ball 3", "plate", with(regularised(0.05, 1.0, 0.95)));
    let rest = |time: f64, ratio: f64, d: f64| G * (1.0 - d) * (time * ratio).powi(2);
    let depths = [
        rest(0.03, 1.0, 0.94),
        rest(0.04, 0.8, 0.9),
        // k = 2000 / d², so δ = g (1 − d) / 2000, at the mean of both impedances.
        G * 0.09 / 2e3,
        rest(0.05, 1.0, 0.95),
    ];
    let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let speed = speed(&on_a_plate(law, &depths, &options));
    assert!(speed < 1e-12, "{speed:e}");
}

#[test]
fn the_ground_has_compliance_by_its_table() {
    let law = SoftContact::estimate(1.0, 1, 1e-3);
    let own = law.normal.stiffness;
    let table = Materials::default()
        .with_material("foam", with(soft(own, 2e4)))
        .with_material("wood", with(soft(4.0 * own, 1e4)));
    let depth = (G / (1.6 * own)).powf(1.0 / (1.0 + law.normal.stiffness_exponent));
    let mut world = World::default();
    let ball = Object::free(Mass::Kilograms(1.0)).at(at(0.0, 0.0, RADIUS - depth));
    world.add_sphere("ball", RADIUS, &ball).expect("a ball");
    let model = world.build().expect("a world");
    let contacts = Contacts::new(&model, Terrain::flat(0.0), ContactLaw::Soft(law))
        .with_materials(&model, &table, "wood", &[("ball", "foam")])
        .expect("links");
    let speed = speed(&Simulator::new(model).with_contacts(contacts));
    assert!(speed < 1e-12, "{speed:e}");
}

#[test]
#[should_panic(expected = "a material has a compliance, which rigid contact does not have")]
fn compliance_of_another_contact_model_is_refused() {
    let options = CollisionOptions::default().with_material("plate", with(soft(1e3, 1.0)));
    let _ = on_a_plate(ContactLaw::Rigid(Rigid::default()), &[0.0], &options);
}

#[test]
#[should_panic(expected = "all materials of a table have compliances for one contact model")]
fn a_table_of_two_contact_models_is_refused() {
    let _ = Materials::default()
        .with_material("foam", with(soft(1e3, 1.0)))
        .with_material("wood", with(regularised(0.02, 1.0, 0.95)));
}

#[test]
#[should_panic(expected = "the stiffness of a material is 0: not positive and finite")]
fn a_surface_without_stiffness_is_refused() {
    let _ = Materials::default().with_material("air", with(soft(0.0, 1.0)));
}

#[test]
fn an_unknown_link_of_a_pair_is_named() {
    let model = World::default().build().expect("a world");
    let law = ContactLaw::Rigid(Rigid::default());
    let options = CollisionOptions::default().with_pair("a", "b", Material::default());
    let contacts = Contacts::new(&model, Terrain::flat(0.0), law);
    let error = contacts.with_collisions(&model, law, &options);
    assert_eq!(error.expect_err("no links").name, "a");
}

/// The difference of two steps in the tangent space.
fn difference(simulator: &Simulator, from: &State, to: &State) -> DVector<f64> {
    let dq = simulator
        .model()
        .difference(from.q.as_slice(), to.q.as_slice());
    let all: Vec<f64> = dq.iter().chain((&to.v - &from.v).iter()).copied().collect();
    DVector::from_vec(all)
}

/// Gradients in all parameters of surfaces beside central differences, and in the state beside A.
fn check_derivatives(simulator: &Simulator, least: usize) {
    let mut state = simulator.neutral_state();
    for (k, v) in state.v.iter_mut().enumerate() {
        *v = 0.02 * (k as f64 + 1.0).sin();
    }
    let weights = DVector::from_fn(2 * state.v.len(), |k, _| (k as f64 + 0.5).sin());
    let gradient = simulator.vjp(&state, &[], weights.as_slice());
    let a = simulator.linearize(&state, &[]).a;
    let error = (a.tr_mul(&weights) - &gradient.state).amax() / a.amax();
    assert!(error < 1e-9, "adjoint differs by {error:e}");
    let (layout, parameters) = (simulator.parameter_layout(), simulator.parameters());
    let mut checked = 0;
    for (group, range) in layout.groups() {
        let is_own = matches!(
            group,
            Group::PairLaw | Group::CollisionShape(_) | Group::PairMaterial(_)
        );
        // Numbers at the end of their range have no differences to both sides.
        for k in range.clone().filter(|k| is_own && parameters[*k] != 0.0) {
            let by = 1e-6 * parameters[k];
            let [after, before] = [by, -by].map(|by| {
                let mut moved = parameters.clone();
                moved[k] += by;
                let moved = simulator.with_parameters(moved.as_slice());
                difference(simulator, &state, &moved.step(&state, &[]))
            });
            let expected = (after - before).dot(&weights) / 2e-6;
            let own = gradient.parameters[k] * parameters[k];
            let size = expected.abs().max(1.0);
            assert!(
                (own - expected).abs() < 1e-6 * size,
                "{group:?} {k}: {own} {expected}"
            );
            checked += usize::from(expected.abs() > 1e-7);
        }
    }
    assert!(checked >= least, "only {checked} derivatives are not zero");
}

// Two balls with materials, one with that of its pair, one without any.
#[test]
fn derivatives_in_numbers_of_materials_equal_differences() {
    let own = SoftContact::estimate(1.0, 1, 2e-3);
    let (k, d) = (own.normal.stiffness, own.normal.damping);
    let relaxed = |time, ratio, largest| {
        let mut material = with(regularised(time, ratio, largest));
        if let Some(Compliance::Regularised { impedance, .. }) = &mut material.compliance {
            impedance.width = 4e-3;
        }
        material.turning.torsional = 0.25 * time;
        material
    };
    let cases = [
        (
            ContactLaw::RelaxedRigid(RelaxedRigid::default()),
            [
                relaxed(0.04, 0.8, 0.96),
                relaxed(0.03, 1.1, 0.94),
                relaxed(0.05, 1.0, 0.97),
            ],
            Integrator::SemiImplicitEuler,
        ),
        (
            ContactLaw::Soft(own),
            [
                with(soft(3.0 * k, d)),
                with(soft(k, 2.0 * d)),
                with(soft(2.0 * k, 3.0 * d)),
            ],
            Integrator::ImplicitVelocity,
        ),
        (
            ContactLaw::Soft(own),
            [
                with(soft(3.0 * k, d)),
                with(soft(k, 2.0 * d)),
                with(soft(2.0 * k, 3.0 * d)),
            ],
            Integrator::SemiImplicitEuler,
        ),
    ];
    for (law, [plate, ball, pair], integrator) in cases {
        let options = CollisionOptions::default()
            .with_material("plate", plate)
            .with_material("ball 0", ball)
            .with_pair("plate", "ball 1", pair);
        let simulator = on_a_plate(law, &[1e-3, 1.2e-3, 1.5e-3], &options);
        let simulator = simulator.with_integrator(integrator);
        let names = simulator.parameter_layout();
        for name in [
            "material of pair 0: friction",
            "shape 0 of ball 0: friction",
        ] {
            names.find(name).expect("a parameter");
        }
        check_derivatives(&simulator, 10);
    }
}

/// Heights of two balls that rest on each other.
fn heights(lower: &str, upper: &str, more: &str) -> [f64; 2] {
    let xml = format!(
        "<mujoco><option timestep='0.002' cone='elliptic'/><worldbody><geom name='floor' type='plane' size='1 1 1'/>
         <body pos='0 0 0.1'><freejoint/><geom name='lower' size='0.1' {lower}/></body>
         <body pos='0 0 0.3'><freejoint/><geom name='upper' size='0.1' {upper}/></body></worldbody>{more}</mujoco>"
    );
    let (scene, _) = ModelOptions::default()
        .load_mjcf_scene_str(&xml)
        .expect("a scene");
    let end = scene
        .simulator()
        .rollout(&scene.reference, 1500, |_, _, _| {});
    let q = &end.last().q;
    [q[2], q[9]]
}

// Heights by MuJoCo 4.0: numbers of both geoms, of that of priority, of pairs with each other and with the ground.
#[test]
fn balls_of_an_mjcf_file_rest_at_the_heights_of_mujoco() {
    let yields = "solref='0.06 0.8' solimp='0.7 0.8 0.004 0.4 3'";
    let heavier = format!("{yields} solmix='3'");
    let direct = "solref='-900 -40' priority='1'";
    let pair = "<contact><pair geom1='upper' geom2='lower' solref='0.1 1' solimp='0.5 0.6 0.01'/></contact>";
    let ground = "<contact><pair geom1='floor' geom2='lower' solref='0.1 1'/></contact>";
    for (lower, upper, more, expected) in [
        ("", "", "", [0.099436038, 0.298872077]),
        (yields, "", "", [0.096821560, 0.293643120]),
        (&heavier, "solref='0.03 1'", "", [0.094241223, 0.287892172]),
        (yields, direct, "", [0.096821560, 0.295731560]),
        ("solref='0.06 0.8'", "", pair, [0.098728624, 0.220248624]),
        ("", "", ground, [0.090190000, 0.289626038]),
    ] {
        let found = heights(lower, upper, more);
        for (found, expected) in found.iter().zip(expected) {
            assert!(
                (found - expected).abs() < 1e-7,
                "{lower} {upper} {more}: {found} {expected}"
            );
        }
    }
}

#[test]
fn numbers_of_a_pair_are_read_and_those_that_no_simulator_uses_are_reported() {
    let xml = "<mujoco><default><pair condim='4'/></default><worldbody><geom name='floor' type='plane' size='1 1 1'/>
         <body><freejoint/><geom name='a' size='0.1'/></body></worldbody>
         <contact><pair geom1='a' geom2='floor' friction='0.7 0.6 0.02' margin='0.1' solreffriction='0.02 1'/></contact></mujoco>";
    let (scene, report) = ModelOptions::default()
        .load_mjcf_scene_str(xml)
        .expect("a scene");
    let pair = &scene.contacts.pairs[0];
    assert_eq!(pair.friction, [0.7, 0.6, 0.02, 0.0001, 0.0001]);
    assert_eq!((pair.condim, pair.margin), (4, 0.1));
    let text = report.to_string();
    assert!(!text.contains("margin"), "{text}");
    for part in ["first coefficient acts along both", "solreffriction"] {
        assert!(text.contains(part), "{part}: {text}");
    }
    let simulator = scene.simulator();
    let contacts = simulator.contacts().expect("contacts");
    let ContactLaw::RelaxedRigid(law) = contacts.laws()[0] else {
        panic!("another contact model")
    };
    assert_eq!(law.friction, 0.7);
    let negative = xml.replace("0.7 0.6", "-1 0.6");
    let error = ModelOptions::default().load_mjcf_scene_str(&negative);
    assert!(
        error
            .map(|_| ())
            .expect_err("a file")
            .to_string()
            .contains("is negative")
    );
}

/// Width of a box of a column, m, and its mass, kg.
const WIDTH: f64 = 0.2;
const MASS: f64 = 1.0;

/// A column of boxes on regularised contact.
struct Column {
    boxes: usize,
    law: RelaxedRigid,
}

impl Column {
    /// Force of a corner at a depth at rest: f = k d² δ / ((1 − d) G), with G = 4 / m of a corner of a cube, and twice that between two.
    fn force(&self, joint: usize, depth: f64) -> f64 {
        let (d, largest): (f64, f64) = (self.law.impedance.at(depth), self.law.impedance.largest);
        let k = (largest * 0.02).powi(-2);
        let delassus = if joint == 0 { 4.0 } else { 8.0 } / MASS;
        k * d * d * depth / ((1.0 - d) * delassus)
    }

    /// Depth of the corners at each joint, by bisection.
    fn depths(&self) -> Vec<f64> {
        let depth = |joint: usize| {
            let wanted = (self.boxes - joint) as f64 * MASS * G / 4.0;
            let (mut low, mut high) = (0.0, 0.1);
            for _ in 0..100 {
                let middle = 0.5 * (low + high);
                match self.force(joint, middle) < wanted {
                    true => low = middle,
                    false => high = middle,
                }
            }
            low
        };
        (0..self.boxes).map(depth).collect()
    }

    /// The least stiffness of the column against tilts of its boxes, N·m: springs of its joints less the weights that lean.
    fn least_stiffness(&self) -> f64 {
        let n = self.boxes;
        let mut all = DMatrix::<f64>::zeros(n, n);
        for (i, depth) in self.depths().into_iter().enumerate() {
            let slope = (self.force(i, depth + 1e-8) - self.force(i, depth - 1e-8)) / 2e-8;
            let spring = slope * WIDTH * WIDTH;
            all[(i, i)] += spring - MASS * G * WIDTH * (n as f64 - i as f64 - 0.5);
            if i > 0 {
                all[(i - 1, i - 1)] += spring;
                all[(i, i - 1)] -= spring;
                all[(i - 1, i)] -= spring;
            }
        }
        all.symmetric_eigenvalues().min()
    }

    /// Rate of its fastest growing motion about rest, 1/s.
    fn growth(&self) -> f64 {
        const STEP: f64 = 5e-3;
        let (mut world, mut sunk) = (World::default(), 0.0);
        for (k, depth) in self.depths().into_iter().enumerate() {
            sunk += depth;
            let object = Object::free(Mass::Kilograms(MASS));
            let object = object.at(at(0.0, 0.0, WIDTH * (k as f64 + 0.5) - sunk));
            world
                .add_box(&format!("box {k:02}"), [WIDTH; 3], &object)
                .expect("a box");
        }
        let model = world.build().expect("a world");
        let law = ContactLaw::RelaxedRigid(self.law);
        let contacts = Contacts::new(&model, Terrain::flat(0.0), law)
            .with_collisions(&model, law, &CollisionOptions::default())
            .expect("links");
        let simulator = Simulator::new(model)
            .with_contacts(contacts)
            .with_time_step(STEP);
        let rest = speed(&simulator);
        assert!(rest < 1e-9, "not at rest: {rest:e}");
        let mut all: DMatrix<f64> = simulator.linearize(&simulator.neutral_state(), &[]).a;
        // The change over 2¹¹ steps, then that over twice as many.
        let mut before = 0.0;
        for _ in 0..12 {
            before = all.norm();
            all = &all * &all;
        }
        (all.norm() / before).ln() / (2048.0 * STEP)
    }
}

// A column of boxes on springs buckles under its own weight as an elastic column does; below that only creep is left, which is slow.
#[test]
fn a_stack_on_compliant_contact_buckles_where_its_springs_are_too_weak() {
    for (boxes, largest, stands) in [
        (7, 0.95, true),
        (10, 0.95, false),
        (12, 0.95, false),
        (12, 0.99, true),
    ] {
        let mut law = RelaxedRigid::default();
        law.impedance.largest = largest;
        let column = Column { boxes, law };
        let (stiffness, growth) = (column.least_stiffness(), column.growth());
        assert_eq!(stiffness > 0.0, stands, "{boxes}, {largest}: {stiffness}");
        assert_eq!(growth < 0.2, stands, "{boxes}, {largest}: {growth}");
    }
}
