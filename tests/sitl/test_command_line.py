"""`python -m sitl`'s options: what is wrong is said in one line; nobody is on the air before it is warm."""

from pathlib import Path

import pytest

from sitl import __main__ as command_line
from sitl.arguments import joined, parser_of_options
from sitl.link.endpoint import PortTakenError
from sitl.simulator import Simulator


@pytest.mark.parametrize(
    ("option", "value"),
    [
        ("--seed", "-1"),
        ("--seed", "1.5"),
        ("--seed", "9" * 5000),
        ("--home", "0,0,1e300,0"),
        ("--home", "0,0,-2000,0"),
        ("--home", "0,0,nan,0"),
        ("--home", "90,0,0,0"),
        ("--home", "here"),
        ("--wind", "nan"),
        ("--wind", "1e9"),
        ("--wind", "5,inf"),
        ("--speedup", "0"),
        ("--speedup", "inf"),
        ("--instance", "-1"),
        ("--instance", "9" * 5000),
        ("--fault", "gps_loss@" + "9" * 400 + "s"),
        ("--fault", "nothing@1s"),
        ("--gps", "none"),
    ],
)
def test_a_wrong_value_is_said_in_one_line(option, value, capsys):
    with pytest.raises(SystemExit) as stop:
        command_line.main([f"{option}={value}"])
    assert stop.value.code == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("sitl: ")
    assert option in line


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (None, "cannot be read"),
        ("schema = 1", "missing key"),
        ("schema = ", "Invalid value"),
        ('"rotors" = 3\n', "schema must be 1"),
        ("MPC_XY_P = 1", "no parameter 'MPC_XY_PP'"),
        ("body", "[body]: wanted a table"),
    ],
)
def test_a_wrong_airframe_is_said_in_one_line(text, said, tmp_path, capsys):
    path = tmp_path / "mine.toml"
    x500 = (Path(command_line.__file__).parent / "airframes/x500.toml").read_text(encoding="utf-8")
    if text == "MPC_XY_P = 1":
        text = x500 + "MPC_XY_PP = 1.0\n"
    elif text == "body":
        begin, end = x500.index("[body]"), x500.index("[rotors]")
        text = "body = 3\n" + x500[:begin] + x500[end:]
    if text is not None:
        path.write_text(text, encoding="utf-8")
    assert command_line.main([f"--airframe={path}"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("sitl: ") and said in line


@pytest.mark.parametrize(
    "options", [["--home=89,180,20000,1e300"], ["--wind=100,1e300"], ["--seed=" + "9" * 18]]
)
def test_the_widest_values_fly_and_the_vehicle_is_warm_before_its_ports_are_opened(
    options, monkeypatch, capsys
):
    """They are only tried before, so that a taken one is said at once."""
    lived_us, tried = [], []
    exchange = Simulator.exchange

    def noted(simulator, now_us, received):
        lived_us.append(now_us)
        return exchange(simulator, now_us, received)

    def taken(address, instance):
        tried.append(list(lived_us))
        if len(tried) == 1:
            return ()
        raise PortTakenError(address, 14580 + instance)

    monkeypatch.setattr(Simulator, "exchange", noted)
    monkeypatch.setattr(command_line, "px4_links", taken)
    assert command_line.main(options) == 2
    assert tried == [[], [3_000_000]]
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_a_home_south_of_the_equator_needs_no_equals_sign():
    home = joined(["--gust", "--home", "-35.363937,149.164790,584,10", "--wind", "-3", "--seed", "2"])
    options = parser_of_options("").parse_args(home)
    assert options.home[0].lat_deg == -35.363937 and options.seed == 2 and options.gust
    assert options.wind[1] == pytest.approx(-3.0)
