"""PX4's parameter protocol, as a real PX4 v1.17 was seen to speak it."""

import math
from struct import pack, unpack


def test_the_parameter_list_begins_with_the_hash_and_is_complete(client, pick):
    client.quiet()
    client.say("PARAM_REQUEST_LIST", target_system=1, target_component=1)
    values = pick(client.live(1.0), "PARAM_VALUE")
    assert (values[0].param_id, values[0].param_index, values[0].param_type) == (b"_HASH_CHECK", 65535, 5)
    assert [value.param_index for value in values[1:]] == list(range(values[0].param_count))
    names = [value.param_id for value in values[1:]]
    assert names == sorted(names)
    assert {b"MPC_XY_P", b"COM_OF_LOSS_T", b"MIS_TAKEOFF_ALT", b"RTL_RETURN_ALT", b"SYS_AUTOSTART"} <= set(
        names
    )


def read(client, pick, name):
    client.say("PARAM_REQUEST_READ", param_index=-1, target_system=1, target_component=1, param_id=name)
    return pick(client.live(0.05), "PARAM_VALUE")


def test_integers_travel_byte_wise_in_the_float(client, pick):
    (value,) = read(client, pick, b"SYS_AUTOSTART")
    assert value.param_type == 6
    assert unpack("<i", pack("<f", value.param_value))[0] == 10040
    client.say(
        "PARAM_SET",
        param_value=unpack("<f", pack("<i", 3))[0],
        target_system=1,
        target_component=1,
        param_id=b"NAV_RCL_ACT",
        param_type=6,
    )
    client.live(0.1)
    assert client.simulator.parameters["NAV_RCL_ACT"] == 3


def test_a_changed_value_is_echoed_twice_and_an_unchanged_one_once(client, pick):
    client.quiet()

    def set_height(value):
        client.say(
            "PARAM_SET",
            param_value=value,
            target_system=1,
            target_component=1,
            param_id=b"MIS_TAKEOFF_ALT",
            param_type=9,
        )
        return [v.param_value for v in pick(client.live(0.1), "PARAM_VALUE")]

    assert set_height(7.5) == [7.5, 7.5]
    assert set_height(7.5) == [7.5]


def test_unknown_names_and_wrong_types_are_met_with_silence(client, pick):
    assert read(client, pick, b"NO_SUCH_THING") == []
    client.say(
        "PARAM_SET",
        param_value=1.0,
        target_system=1,
        target_component=1,
        param_id=b"MIS_TAKEOFF_ALT",
        param_type=6,
    )
    client.say(
        "PARAM_SET", param_value=1.0, target_system=1, target_component=1, param_id=b"FOO", param_type=9
    )
    assert pick(client.live(0.1), "PARAM_VALUE") == []
    assert client.simulator.parameters["MIS_TAKEOFF_ALT"] == 2.5


def test_out_of_range_values_are_accepted_but_not_what_is_no_number(client, pick):
    for value in (math.nan, math.inf, 1e9):
        client.say(
            "PARAM_SET",
            param_value=value,
            target_system=1,
            target_component=1,
            param_id=b"RTL_RETURN_ALT",
            param_type=9,
        )
    client.live(0.1)
    assert client.simulator.parameters["RTL_RETURN_ALT"] == 1e9
