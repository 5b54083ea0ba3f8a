"""The motion of the toy from event to event: the loop of [Leine2001, Fig. 1], which numba compiles.

Between two events the motion is known in closed form, so there is no time step.
"""
