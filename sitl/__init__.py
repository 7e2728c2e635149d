"""A drone in software: a body that cannot see the code, and a brain that cannot see the truth.

NED and FRD axes, SI units, integer microseconds, quaternions wxyz. `python -m sitl` runs it over UDP as PX4's SITL;
`sitl.simulator.Simulator` is the same in one process, on a clock of the caller's.
"""
