"""Run every benchmark: ``python -m benchmarks``."""

from benchmarks import one_finger, start_up

if __name__ == "__main__":
    one_finger.main()
    start_up.main()
