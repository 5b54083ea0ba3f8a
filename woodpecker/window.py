"""Where cycles of the toy are looked for, if nobody says another interval."""

WINDOW = (-2.5, -0.24)  # left of the band of centres [rad]
