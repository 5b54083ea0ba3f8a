"""The number of examples that property tests draw."""

from hypothesis import HealthCheck, settings

USUAL = 100  # examples of a test that asks for nothing, in the profile of every day


def thorough(examples: int, *suppressed: HealthCheck) -> settings:
    """So many examples, or as many times more as the profile draws."""
    times = max(1, settings().max_examples // USUAL)
    return settings(
        max_examples=times * examples,
        suppress_health_check=[*settings().suppress_health_check, *suppressed],
    )
