"""``python -m electrovib``."""

from electrovib.apps.start import main

if __name__ == "__main__":
    main()
