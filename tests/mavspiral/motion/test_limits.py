import dataclasses
import math

import pytest

from mavspiral.motion.limits import Limits


@pytest.mark.parametrize("name", [field.name for field in dataclasses.fields(Limits)])
@pytest.mark.parametrize("bound", [0.0, -1.0, math.nan, math.inf])
def test_a_bound_that_is_no_bound_is_named(limits, name, bound):
    with pytest.raises(ValueError, match=name):
        dataclasses.replace(limits, **{name: bound})
