"""Run every benchmark: ``python -m benchmarks``."""

from benchmarks import (
    door,
    fit,
    full_chain,
    imports,
    laws,
    leak_behind_amplifier,
    one_finger,
    population,
    rough_contact,
    rough_laws,
    start_up,
    texture_stream,
)

if __name__ == "__main__":
    one_finger.main()
    full_chain.main()
    start_up.main()
    door.main()
    fit.main()
    imports.main()
    laws.main()
    leak_behind_amplifier.main()
    population.main()
    rough_contact.main()
    rough_laws.main()
    texture_stream.main()
