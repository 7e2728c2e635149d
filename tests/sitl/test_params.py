import pickle

import pytest

from sitl.params import DEFAULTS, Params


def test_a_replaced_value_leaves_the_old_parameters_alone():
    old = Params()
    new = old.replace(MPC_XY_P=1.5)
    assert (old["MPC_XY_P"], new["MPC_XY_P"]) == (0.95, 1.5)
    assert len(new) == len(DEFAULTS)


def test_an_unknown_name_gets_a_hint():
    with pytest.raises(KeyError, match="MPC_XY_P"):
        Params({"MPC_XYP": 1.0})
    with pytest.raises(KeyError, match="no parameter 'NOPE'"):
        Params()["NOPE"]


def test_an_int32_takes_no_fraction_and_a_real32_takes_an_int():
    assert Params({"MPC_XY_P": 1})["MPC_XY_P"] == 1.0
    assert isinstance(Params({"NAV_RCL_ACT": 3.0})["NAV_RCL_ACT"], int)
    with pytest.raises(TypeError, match="NAV_RCL_ACT is an INT32"):
        Params({"NAV_RCL_ACT": 1.5})
    with pytest.raises(TypeError):
        Params({"MPC_XY_P": True})


def test_they_survive_a_pickle():
    mine = Params({"MPC_XY_P": 1.25})
    assert dict(pickle.loads(pickle.dumps(mine))) == dict(mine)
