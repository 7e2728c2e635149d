import numpy as np
import pytest

from sitl.physics.battery import drain, new_pack


def test_power_is_voltage_times_current_and_charge_is_counted(x500):
    pack = new_pack(x500).view(np.recarray)
    for _ in range(100):
        drain(pack[0], 240.0, 0.01)
    sheet = x500.battery
    power = 240.0 / sheet.motor_efficiency + sheet.avionics_w
    assert float((pack["voltage_v"] * pack["current_a"])[0]) == pytest.approx(power, rel=1e-12)
    assert float(pack["used_ah"][0]) == pytest.approx(float(pack["current_a"][0]) / 3600.0, rel=1e-3)
    assert float(pack["voltage_v"][0]) < sheet.cells * sheet.cell_full_v - 0.2  # it sags


def test_an_empty_pack_goes_on_without_nonsense(x500):
    pack = new_pack(x500).view(np.recarray)
    pack["used_ah"] = 2.0 * x500.battery.capacity_ah
    drain(pack[0], 1e6, 0.01)
    assert np.isfinite(pack["voltage_v"]) and float(pack["voltage_v"][0]) > 0.0
