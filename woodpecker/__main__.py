"""The command ``woodpecker``, as a script or as ``python -m woodpecker``."""

from pwmap.cli.interrupts import at_once, from_the_start


def run() -> None:
    """Run the command; SIGTERM ends it like Ctrl-C, even while it is being loaded."""
    with from_the_start():
        import logging

        from woodpecker.base import linking
        from woodpecker.cli.app import app

        logging.basicConfig(format="%(message)s")
        linking.around = at_once
        app()


if __name__ == "__main__":  # false in the worker processes of a search
    run()
