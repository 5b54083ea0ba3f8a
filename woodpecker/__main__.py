"""``python -m woodpecker``: the command ``woodpecker`` without its script."""

from woodpecker.cli.app import run

if __name__ == "__main__":  # not in the processes that a search starts
    run()
