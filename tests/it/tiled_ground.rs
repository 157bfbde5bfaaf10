//! Height fields side by side.

use dualbody::contact::{ContactLaw, Contacts, HeightField, RelaxedRigid, Terrain};
use dualbody::sim::BatchSimulator;
use dualbody::{Model, Simulator, State};

/// A grid of 5 × 4 nodes with bumps of its own.
fn bumps(seed: f64) -> HeightField {
    let heights: Vec<f64> = (0..20)
        .map(|k| 0.1 * (seed + 1.7 * f64::from(k)).sin())
        .collect();
    HeightField::new([-1.0, seed], [0.5, 0.25], [5, 4], &heights)
}

#[test]
fn nodes_of_each_tile_keep_their_heights_at_their_shift() {
    let tiles: Vec<HeightField> = (0..5).map(|k| bumps(f64::from(k))).collect();
    for columns in [1, 2, 3, 5, 7] {
        let (field, shifts) = HeightField::tiled(&tiles, columns);
        let rows = tiles.len().div_ceil(columns);
        assert_eq!((field.size(), shifts.len()), ([5 * columns, 4 * rows], 5));
        let whole = Terrain::HeightField(field);
        for (k, (tile, shift)) in tiles.iter().zip(&shifts).enumerate() {
            let own = Terrain::HeightField(tile.clone());
            for node in 0..20 {
                let x = -1.0 + 0.5 * f64::from(node % 5);
                let y = k as f64 + 0.25 * f64::from(node / 5);
                let expected = own.surface(&x, &y).height;
                let found = whole.surface(&(x + shift[0]), &(y + shift[1])).height;
                assert!(
                    (found - expected).abs() < 1e-12,
                    "{columns} columns, tile {k}: {found} {expected}"
                );
            }
        }
    }
}

// Where tiles are level about their middle, a ball does not see what is beside them.
#[test]
fn balls_rest_each_on_their_own_tile() {
    let level = |height: f64| HeightField::new([-2.0; 2], [0.25; 2], [17, 17], &[height; 289]);
    let tiles: Vec<HeightField> = (0..6).map(|k| level(0.2 * f64::from(k))).collect();
    let (field, shifts) = HeightField::tiled(&tiles, 3);
    let ball = r#"<robot name="ball"><link name="ball"><inertial><mass value="1"/><inertia ixx="0.01" ixy="0" ixz="0" iyy="0.01" iyz="0" izz="0.01"/></inertial>
      <collision><geometry><sphere radius="0.1"/></geometry></collision></link></robot>"#;
    let model = Model::from_urdf_str(ball).expect("a ball");
    let radius = {
        let flat = Contacts::new(
            &model,
            Terrain::flat(0.0),
            ContactLaw::RelaxedRigid(RelaxedRigid::default()),
        );
        rest(
            &Simulator::new(model.clone()).with_contacts(flat),
            &[[0.0; 2]],
            &[0.0],
        )[0]
    };
    let law = ContactLaw::RelaxedRigid(RelaxedRigid::default());
    let contacts = Contacts::new(&model, Terrain::HeightField(field), law);
    let ground: Vec<f64> = (0..6).map(|k| 0.2 * f64::from(k)).collect();
    let simulator = Simulator::new(model).with_contacts(contacts);
    for (k, z) in rest(&simulator, &shifts, &ground).iter().enumerate() {
        assert!((z - radius - ground[k]).abs() < 1e-6, "tile {k}: {z}");
    }
}

/// Heights of balls two seconds after they were put down over these places.
fn rest(simulator: &Simulator, places: &[[f64; 2]], ground: &[f64]) -> Vec<f64> {
    let simulator = simulator.clone().with_time_step(0.005);
    let start = |(place, ground): (&[f64; 2], &f64)| {
        let mut state: State = simulator.neutral_state();
        let q = [place[0], place[1], ground + 1.0];
        state.q.rows_mut(0, 3).copy_from_slice(&q);
        state
    };
    let starts: Vec<State> = places.iter().zip(ground).map(start).collect();
    let mut batch = BatchSimulator::new(simulator.clone(), starts.len());
    let ends = batch.rollout(&starts, 400, |_, _, _| {});
    (0..starts.len()).map(|k| ends.last(k).q[2]).collect()
}

#[test]
#[should_panic(expected = "tile 1 has size and spacing")]
fn tiles_of_another_size_are_refused() {
    let other = HeightField::new([0.0; 2], [0.5, 0.25], [4, 5], &[0.0; 20]);
    HeightField::tiled(&[bumps(0.0), other], 2);
}

#[test]
#[should_panic(expected = "one tile or more")]
fn no_tiles_are_refused() {
    HeightField::tiled(&[], 2);
}
