"""The work of `benchmarks.population` in numpy and JAX."""

from collections.abc import Callable, Iterator

import numpy as np

from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.population.columns import with_columns
from electrovib.solve.recursion import hold_weights


def _weights(fingers, factor) -> tuple:
    """Return decay, scale and direct share of each finger, with the factor of the square in them, (modes, fingers)."""
    decay, earlier, later = hold_weights(-fingers.rates * float(fingers.time[1]))
    earlier, later = earlier / fingers.rates, later / fingers.rates
    scale = fingers.residues * (decay * later + earlier)
    direct = fingers.direct + (fingers.residues * later).sum(axis=1)
    share = np.sqrt(factor)
    return decay, scale * share[:, np.newaxis], direct * share


def plain_numpy(fingers, factor) -> Callable[[], tuple]:
    """Return the work in numpy with a loop over samples; the weights are prepared."""
    decay, scale, direct = _weights(fingers, factor)
    decay, scale = np.ascontiguousarray(decay.T), np.ascontiguousarray(scale.T)

    def work() -> tuple:
        state, product = np.zeros_like(decay), np.empty_like(decay)
        mean, variance = np.empty((2, fingers.voltage.size))
        for sample, level in enumerate(fingers.voltage.tolist()):
            np.multiply(state, scale, out=product)
            response = product.sum(axis=0)
            response += direct * level
            response *= response
            mean[sample], variance[sample] = response.mean(), response.var()
            state *= decay
            state += level
        return mean, variance

    return work


def by_jax(fingers, factor) -> Iterator[tuple[str, Callable[[], tuple]]]:
    """Yield the work in JAX, in double precision and compiled, where JAX is installed; the weights are prepared."""
    try:
        import jax
    except ImportError:
        return
    jax.config.update("jax_enable_x64", True)
    import jax.numpy as jnp

    given = [jnp.asarray(each) for each in _weights(fingers, factor)]
    voltage = jnp.asarray(fingers.voltage)

    def scanned(unroll: int) -> Callable[[], tuple]:
        def one(decay, scale, direct):
            def advance(state, level):
                return decay * state + level, (direct * level + scale @ state) ** 2

            return jax.lax.scan(advance, jnp.zeros_like(decay), voltage, unroll=unroll)[1]

        def moments(*weights):
            values = jax.vmap(one)(*weights)
            return values.mean(axis=0), values.var(axis=0)

        compiled = jax.jit(moments)
        return lambda: tuple(np.asarray(each) for each in compiled(*given))

    yield "jax.vmap(lax.scan)", scanned(1)
    yield "jax.vmap(lax.scan), unroll=8", scanned(8)


def batched_eigenvalues(nodes, weights, constant) -> Callable[[], np.ndarray]:
    """Return the work by eigenvalues: zeros of sum w/(x - n) - c are those of diag(n) + sqrt(w) sqrt(w)^T/c."""
    root = np.sqrt(weights / constant[:, np.newaxis])
    matrices = root[:, :, np.newaxis] * root[:, np.newaxis, :]
    places = np.arange(nodes.shape[1])
    matrices[:, places, places] += nodes
    return lambda: np.linalg.eigvalsh(matrices)


def squares_in_numpy(many, draws) -> np.ndarray:
    """Return the attraction of fingers under a quadratic law, (times, fingers), by a loop over the times."""
    columns = {path: np.asarray(each, dtype=float)[:, None] for path, each in many.columns(draws).items()}
    member = with_columns(many.scenario, columns)
    ((name, transfer),) = many.asked(member).items()
    ((part,),) = many.drive.values()
    rates, residues, direct = transfer.rates, transfer.gains * transfer.rates, transfer.direct[:, 0]
    times = np.union1d(many.time, part.times[part.times < many.time[-1]])
    times = times[np.diff(times, prepend=-1.0) > 1e-12]  # an output beside a corner is at the corner
    voltage, steps = part.value(times), np.diff(times)
    _, first, kinds = np.unique(np.round(steps / steps.max(), 9), return_index=True, return_inverse=True)
    weights = [_of_duration(rates, residues, duration) for duration in steps[first].tolist()]
    rows, state = np.empty((voltage.size, len(rates))), np.zeros(rates.T.shape)
    rows[0] = direct * voltage[0]
    for place, kind in enumerate(kinds.tolist()):
        decay, earlier, later = weights[kind]
        state = decay * state + earlier * voltage[place] + later * voltage[place + 1]
        rows[place + 1] = direct * voltage[place + 1] + state.sum(axis=0)
    places = np.searchsorted(times, many.time - 1e-12)
    return attraction(member, total_pull(member, {name.name: rows[places].T})).T


def _of_duration(rates, residues, duration) -> tuple:
    """Return the weights of the states and of both ends of a step, (modes, fingers)."""
    decay, earlier, later = hold_weights(-np.ascontiguousarray(rates.T) * duration)
    with np.errstate(divide="ignore", invalid="ignore"):
        gain = np.where(rates > 0, residues / rates, 0.0).T
    return decay, earlier * gain, later * gain
