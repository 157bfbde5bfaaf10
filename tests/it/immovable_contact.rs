//! Contact without friction along which nothing can move: no force there is determined, and none acts.

use dualbody::contact::{ContactLaw, Contacts, RelaxedRigid, Rigid, Terrain};
use dualbody::sim::{BatchSimulator, RolloutStatus};
use dualbody::{Integrator, Simulator};

/// A puck on two sliders, pressed into the floor, and a ball that falls on the floor.
const PUCK: &str = r#"<mujoco model="puck">
  <option timestep="0.005"/>
  <worldbody>
    <geom type="plane" size="0 0 1"/>
    <body name="puck" pos="0 0 0.049">
      <joint name="x" type="slide" axis="1 0 0" damping="0.1"/>
      <joint name="y" type="slide" axis="0 1 0" damping="0.1"/>
      <geom type="cylinder" size="0.05 0.05" mass="0.2"/>
    </body>
    <body name="ball" pos="1 0 0.3">
      <joint name="z" type="slide" axis="0 0 1"/>
      <geom type="sphere" size="0.05" mass="0.1"/>
    </body>
  </worldbody>
  <actuator><motor joint="x"/></actuator>
</mujoco>"#;

/// The puck with and without contact, under each law that a solver finds, and the integrators that have one.
fn cases() -> Vec<[Simulator; 2]> {
    let scene = Simulator::from_mjcf_str(PUCK).expect("a scene");
    let without = Simulator::new(scene.model().clone())
        .with_time_step(scene.time_step())
        .with_actuated_joints(&["x"])
        .expect("a joint");
    let mut out = Vec::new();
    for law in [
        ContactLaw::RelaxedRigid(RelaxedRigid {
            friction: 0.0,
            ..RelaxedRigid::default()
        }),
        ContactLaw::Rigid(Rigid {
            friction: 0.0,
            ..Rigid::default()
        }),
    ] {
        let contacts = Contacts::new(scene.model(), Terrain::flat(0.0), law);
        for integrator in [Integrator::SemiImplicitEuler, Integrator::ImplicitVelocity] {
            let without = without.clone().with_integrator(integrator);
            out.push([without.clone().with_contacts(contacts.clone()), without]);
        }
    }
    out
}

#[test]
fn puck_on_sliders_moves_as_without_contact_while_a_ball_bounces() {
    for [with, without] in cases() {
        let start = with.neutral_state();
        let [rollout, free] = [&with, &without]
            .map(|own| own.rollout(&start, 100, |t, _, u| u[0] = 0.1 * (20.0 * t).sin()));
        assert_eq!(rollout.status, RolloutStatus::Completed);
        let (end, free) = (rollout.last(), free.last());
        assert!(free.q[0].abs() > 1e-3, "{}", free.q[0]);
        for k in 0..2 {
            assert!(
                (end.q[k] - free.q[k]).abs() < 1e-12,
                "{} {}",
                end.q[k],
                free.q[k]
            );
        }
        assert!(
            end.q[2] > -0.26 && free.q[2] < -1.0,
            "the ball at {}",
            end.q[2]
        );
    }
}

#[test]
fn its_step_has_the_jacobians_of_the_step_without_contact() {
    for [with, without] in cases() {
        let mut state = with.neutral_state();
        state.v[0] = 0.3;
        let [found, expected] = [&with, &without].map(|own| own.linearize(&state, &[0.2]));
        assert!((found.a - expected.a).amax() < 1e-12);
        assert!((found.b - expected.b).amax() < 1e-12);
    }
}

#[test]
fn lanes_have_the_bits_of_single_steps() {
    for [with, _] in cases() {
        let starts: Vec<_> = (0..9)
            .map(|k| {
                let mut state = with.neutral_state();
                state.q[2] = -0.03 * f64::from(k);
                state
            })
            .collect();
        let mut batch = BatchSimulator::new(with.clone(), starts.len());
        let mut states = batch.states(&starts);
        batch.step(&mut states, &[0.1; 9]);
        for (k, start) in starts.iter().enumerate() {
            assert_eq!(states.state(k), with.step(start, &[0.1]));
        }
    }
}
