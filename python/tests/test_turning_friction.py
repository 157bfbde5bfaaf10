"""Torsional and rolling friction: of links on the ground, of materials, and of all pairs."""

import dualbody as db
import pytest
from dualbody.contact import Collisions, Contacts, Material, Rigid, Terrain


def ball(contacts: Contacts) -> db.Simulator:
    world = db.World()
    world.add_sphere("ball", 0.1, mass=2.0)
    world.add_box("table", (1.0, 1.0, 0.2), fixed=True, position=(0.0, 0.0, -0.1))
    return db.Simulator(world.build(), time_step=1e-3, contacts=contacts)


def rate_after(simulator: db.Simulator, steps: int) -> float:
    """The rate about the vertical of a ball that spins at 3 rad/s."""
    q, v = [0.0, 0.0, 0.1, 1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 0.0, 0.0, 3.0]
    return float(simulator.rollout(q, v, steps).v[-1][5])


# I = 0.008 kg m²: ω = Ω − c m g t / I, by whichever way c is given; between two materials the larger one counts.
@pytest.mark.parametrize(
    "contacts",
    [
        Contacts(Terrain.flat(), Rigid(), links=["ball"], turning={"ball": (0.004, 0.0)}),
        Contacts(Terrain.flat(-5.0), Rigid(), collisions=Collisions(torsional_friction=0.004)),
        Contacts(
            Terrain.flat(-5.0),
            Rigid(),
            collisions=Collisions(
                materials={
                    "ball": Material(torsional_friction=0.004),
                    "table": Material(torsional_friction=0.001),
                }
            ),
        ),
    ],
)
def test_a_spinning_ball_stops_by_the_closed_form(contacts: Contacts) -> None:
    simulator = ball(contacts)
    expected = 3.0 - 0.1 * 0.004 * 2.0 * 9.81 / 0.008
    assert abs(rate_after(simulator, 100) - expected) < 1e-6
    assert abs(rate_after(simulator, 500)) < 1e-9


def test_without_coefficients_a_ball_spins_on() -> None:
    assert rate_after(ball(Contacts(Terrain.flat(), Rigid())), 100) == pytest.approx(3.0, abs=1e-12)


def test_a_negative_coefficient_is_refused() -> None:
    with pytest.raises(ValueError, match="rolling friction is -0.1: negative or not finite"):
        ball(Contacts(Terrain.flat(), Rigid(), turning={"ball": (0.0, -0.1)}))
