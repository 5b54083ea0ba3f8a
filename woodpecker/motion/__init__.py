"""The motion of the toy from event to event, [Leine2001, Fig. 1], without time steps; compiled."""
