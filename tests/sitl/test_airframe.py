import numpy as np
import pytest

from sitl.airframe import load_airframe


def test_the_x500_hovers_at_its_hover_thrust(x500):
    greatest = 4.0 * x500.rotors.thrust_n_per_radps2 * x500.rotors.speed_max_radps**2
    assert x500.body.mass_kg * 9.80665 / greatest == pytest.approx(x500.params["MPC_THR_HOVER"], abs=1e-3)


def test_the_x500_stands_in_px4s_motor_order(x500):
    front, right = np.sign(x500.rotors.position_frd_m[:, :2]).T
    assert front.tolist() == [1, -1, 1, -1] and right.tolist() == [1, -1, -1, 1]
    assert x500.rotors.spin.tolist() == [1, 1, -1, -1]


def test_an_unknown_name_lists_the_known_ones():
    with pytest.raises(ValueError, match="no airframe 'x501'; bundled: x500"):
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
