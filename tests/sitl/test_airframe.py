import numpy as np
import pytest

from sitl.airframe import load_airframe
from sitl.params import Params

BUNDLED = ["7inch", "camera", "x500"]


@pytest.mark.parametrize("name", BUNDLED)
def test_an_airframe_hovers_at_its_hover_thrust(name):
    one = load_airframe(name)
    greatest = 4.0 * one.rotors.thrust_n_per_radps2 * one.rotors.speed_max_radps**2
    assert one.body.mass_kg * 9.80665 / greatest == pytest.approx(one.params["MPC_THR_HOVER"], abs=1e-3)
    Params(one.params)


@pytest.mark.parametrize("name", BUNDLED)
def test_an_airframe_stands_in_px4s_motor_order(name):
    rotors = load_airframe(name).rotors
    front, right = np.sign(rotors.position_frd_m[:, :2]).T
    assert front.tolist() == [1, -1, 1, -1] and right.tolist() == [1, -1, -1, 1]
    assert rotors.spin.tolist() == [1, 1, -1, -1]


@pytest.mark.parametrize("name", BUNDLED)
def test_a_full_unit_of_torque_turns_every_airframe_as_fast_by_its_gains(name, x500):
    """Gain times greatest torque by inertia: the bandwidth of the rate loop is the x500's, within 2 %."""

    def bandwidth(one):
        r, gains = one.rotors, Params(one.params)
        thrust = 4.0 * r.thrust_n_per_radps2 * r.speed_max_radps**2
        arms = (
            abs(r.position_frd_m[0, 1]) / 2**0.5,
            abs(r.position_frd_m[0, 0]) / 2**0.5,
            r.torque_per_thrust_m,
        )
        names = "MC_ROLLRATE_P", "MC_PITCHRATE_P", "MC_YAWRATE_P"
        return np.array([gains[name] for name in names]) * thrust * np.array(arms) / one.body.inertia_kgm2

    np.testing.assert_allclose(bandwidth(load_airframe(name)), bandwidth(x500), rtol=0.02)


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(ValueError, match="no airframe 'x501'; bundled: 7inch, camera, x500; or give"):
        load_airframe("x501")


@pytest.mark.parametrize(
    ("old", "new", "complaint"),
    [
        ("mass_kg", "mass_g", r"\[body\]: unknown key mass_g; known: .*mass_kg"),
        ("mass_kg = 2.0643", 'mass_kg = "two"', "mass_kg"),
        ("mass_kg = 2.0643", "mass_kg = inf", "mass_kg: wanted finite numbers"),
        ('"ccw", "ccw", "cw", "cw"', '"ccw", "up", "cw", "cw"', "turning"),
        ("schema = 1", "schema = 2", "schema must be 1"),
    ],
)
def test_a_bad_file_is_refused_by_its_key(tmp_path, old, new, complaint):
    from importlib import resources

    text = (resources.files("sitl") / "airframes" / "x500.toml").read_text(encoding="utf-8")
    assert old in text
    file = tmp_path / "mine.toml"
    file.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ValueError, match=complaint):
        load_airframe(file)
