"""``python -m pwmap``: the command ``pwmap`` without its script."""

from pwmap.cli.app import run

if __name__ == "__main__":  # not in the processes that a search starts
    run()
