"""The command ``pwmap``, as a script or as ``python -m pwmap``."""

from pwmap.cli.interrupts import from_the_start


def run() -> None:
    """Run the command, which SIGTERM ends as Ctrl-C does, also while it is loaded."""
    with from_the_start():
        from pwmap.cli.app import app

        app()


if __name__ == "__main__":  # not in the processes that a search starts
    run()
