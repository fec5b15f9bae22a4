"""``python -m electrovib``."""

from electrovib.apps.cli import main

if __name__ == "__main__":
    main()
