"""Its place puts this folder on the path, so that the tests find their helper modules.

Property tests draw the same examples each time, on every machine. The profile ``explore`` draws
others, and many more: ``--hypothesis-profile=explore``, or that name in HYPOTHESIS_PROFILE.
"""

import os

import rounding
from hypothesis import HealthCheck, settings

rounding.apply()

settings.register_profile("same", derandomize=True, database=None, deadline=None)
settings.register_profile(
    "explore",
    derandomize=False,
    deadline=None,
    max_examples=2000,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "same"))
