"""`python -m pymunk_dragon` is `pymunk-dragon`."""

from pymunk_dragon.cli import main

__all__: list[str] = []

if __name__ == "__main__":
    main()
