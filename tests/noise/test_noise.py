import math

import numpy as np
import pytest

from amorsim.contracts import Aim, Context, Draws
from amorsim.core.draws import stream_key
from amorsim.core.parameters import ParameterError
from amorsim.core.rows import stack
from amorsim.noise import AimGaussian, Bias, Diffusion, Gaussian, Quantize, Saturate, Scale

ROWS, K = 20_000, 4


class Chain:
    """One element over rows, taken through samples as the engine does."""

    def __init__(self, *elements, k=K, rows=None):
        rows = range(len(elements)) if rows is None else rows
        self.counter = np.zeros((len(elements), 3), dtype=np.uint32)
        self.counter[:, 0] = rows
        self.draws = Draws(np.full(len(elements), stream_key(11, "test"), dtype=np.uint64), self.counter)
        self.noise = stack(elements)
        context = Context(rows=len(elements), dt=0.1, robot=None, pose=np.zeros((len(elements), 3)), size=k)
        self.state = dict(self.noise.start(context))

    def sample(self, values):
        elapsed = np.where(self.counter[:, 2:] == 0, 0.0, 0.1)
        out = self.noise.corrupt(values, {}, elapsed, self.state, self.draws)
        self.tick()
        return out

    def aim(self, aim):
        out = self.noise.aim(aim, np.zeros((len(self.counter), 1)), self.state, self.draws)
        self.tick()
        return out

    def tick(self):
        self.counter[:, 2] += 1
        self.draws.rewind()


def many(noise):
    return Chain(*[noise] * ROWS)


def assert_normal(sample, std, mean=0.0):
    """Mean and spread of independent normal numbers, within five of their own standard deviations."""
    n = sample.size
    assert abs(sample.mean() - mean) < 5.0 * std / math.sqrt(n)
    assert abs(sample.std() / std - 1.0) < 5.0 / math.sqrt(2.0 * n)


def test_gaussian_noise_has_its_standard_deviation():
    values = np.full((ROWS, K), 3.0)
    assert_normal(many(Gaussian(std=0.2)).sample(values), 0.2, mean=3.0)


def test_noise_is_new_in_every_sample_and_value():
    chain, values = many(Gaussian(std=1.0)), np.zeros((ROWS, K))
    first, second = chain.sample(values), chain.sample(values)
    correlation = np.corrcoef(np.concatenate((first, second), axis=1).T)
    off = correlation[~np.eye(2 * K, dtype=bool)]
    assert np.abs(off).max() < 5.0 / math.sqrt(ROWS)


def test_proportional_noise_grows_with_the_size_of_the_value():
    values = np.tile([0.0, 1.0, -2.0, 4.0], (ROWS, 1))
    out = many(Gaussian(std=0.1, proportional=0.05)).sample(values)
    for j, std in enumerate((0.1, 0.15, 0.2, 0.3)):
        assert_normal(out[:, j] - values[:, j], std)


def test_noise_on_increments_is_a_random_walk():
    chain, n = many(Gaussian(std=0.3, per="increment")), 9
    values = np.full((ROWS, K), 100.0)
    assert chain.sample(values).tobytes() == values.tobytes()  # the first sample is not an increment
    for _ in range(n):
        last = chain.sample(values)
    assert_normal(last, 0.3 * math.sqrt(n), mean=100.0)


def test_proportional_noise_on_increments_takes_their_size():
    chain = many(Gaussian(proportional=0.1, per="increment"))
    chain.sample(np.zeros((ROWS, K)))
    chain.sample(np.full((ROWS, K), -5.0))
    out = chain.sample(np.full((ROWS, K), -3.0))
    assert_normal(out, 0.1 * math.hypot(5.0, 2.0), mean=-3.0)
    assert chain.sample(np.full((ROWS, K), -3.0)).tobytes() == out.tobytes()  # nothing turned, nothing slipped


def test_what_returned_nothing_goes_on_returning_nothing():
    values = np.full((1, K), math.inf)
    for noise in (
        Gaussian(std=1.0, proportional=1.0),
        Gaussian(std=1.0, proportional=1.0, per="increment"),
        Bias(value=2.0),
        Scale(factor=0.5),
        Quantize(step=0.1),
        Quantize(step=0.1, rounding="floor"),
        Saturate(minimum=0.0, maximum=1.0),
    ):
        chain = Chain(noise)
        for _ in range(3):
            assert chain.sample(values).tolist() == values.tolist()


def test_a_walk_goes_on_after_a_reading_of_nothing():
    chain = Chain(Gaussian(std=1.0, per="increment"), k=1)
    chain.sample(np.array([[2.0]]))
    assert chain.sample(np.array([[math.inf]])).tolist() == [[math.inf]]
    assert np.isfinite(chain.sample(np.array([[2.0]]))).all()


@pytest.mark.parametrize(
    "noise",
    [
        Gaussian(),
        Gaussian(per="increment"),
        Bias(value=0.0),
        Scale(factor=1.0),
        Saturate(),
        Diffusion(variance_per_length=0.0),
    ],
)
def test_noise_of_nothing_leaves_every_bit(noise):
    values = np.array([[0.0, -0.0, 1.0 / 3.0, -1e-300], [math.inf, 1e300, -2.5, 7.0]])
    chain = Chain(noise, noise)
    for _ in range(4):
        if type(noise) is Diffusion:
            values = np.where(np.isinf(values), 1.0, values)  # no wheel goes so far
        assert chain.sample(values).tobytes() == values.tobytes()


def test_aim_of_nothing_leaves_the_beams():
    bearing = np.array([[0.1, -0.2, 1e-300, 3.0]])
    assert Chain(AimGaussian(std=0.0)).aim(Aim(bearing=bearing)).bearing.tobytes() == bearing.tobytes()


def test_beams_are_bent_by_the_standard_deviation_and_bends_add_up():
    assert_normal(many(AimGaussian(std=0.01)).aim(Aim()).bearing, 0.01)
    before = np.full((ROWS, K), 0.5)
    assert_normal(many(AimGaussian(std=0.01)).aim(Aim(bearing=before)).bearing, 0.01, mean=0.5)


def test_bias_scale_quantize_and_saturate_do_what_they_say():
    values = np.array([[-1.26, 0.0, 0.74, 2.0]])
    assert Chain(Bias(value=0.5)).sample(values).tolist() == [[-0.76, 0.5, 1.24, 2.5]]
    assert Chain(Scale(factor=2.0)).sample(values).tolist() == [[-2.52, 0.0, 1.48, 4.0]]
    assert Chain(Quantize(step=0.5)).sample(values).tolist() == [[-1.5, 0.0, 0.5, 2.0]]
    assert Chain(Quantize(step=0.5, rounding="floor")).sample(values).tolist() == [[-1.5, 0.0, 0.5, 2.0]]
    assert Chain(Quantize(step=0.5, rounding="floor")).sample(-values).tolist() == [[1.0, 0.0, -1.0, -2.0]]
    assert Chain(Saturate(minimum=-1.0, maximum=1.5)).sample(values).tolist() == [[-1.0, 0.0, 0.74, 1.5]]
    assert Chain(Saturate(minimum=-1.0)).sample(values).tolist() == [[-1.0, 0.0, 0.74, 2.0]]


def test_the_error_of_quantisation_is_uniform():
    step = 0.02
    values = np.random.default_rng(3).uniform(0.0, 5.0, size=(1, 100_000))
    error = Chain(Quantize(step=step), k=100_000).sample(values) - values
    assert np.abs(error).max() <= 0.5 * step * (1.0 + 1e-9)
    # The variance of a square of a uniform error is (4/45) (step/2)^4.
    bound = 5.0 * math.sqrt(4.0 / 45.0 / error.size) * (step / 2.0) ** 2
    assert abs((error**2).mean() - step**2 / 12.0) < bound


def test_diffusion_has_a_variance_in_proportion_to_the_way():
    values = np.tile([0.0, 0.25, -1.0, 4.0], (ROWS, 1))
    out = many(Diffusion(variance_per_length=1e-4)).sample(values)
    assert out[:, 0].tolist() == [0.0] * ROWS
    for j in (1, 2, 3):
        assert_normal(out[:, j] - values[:, j], math.sqrt(1e-4 * abs(values[0, j])))


def test_the_same_draws_are_taken_whatever_the_parameters():
    values = np.ones((50, K))
    small, large = Chain(*[Gaussian(std=0.001)] * 50), Chain(*[Gaussian(std=1.0)] * 50)
    np.testing.assert_allclose((small.sample(values) - 1.0) / 0.001, large.sample(values) - 1.0, atol=1e-12)
    assert small.draws._block == large.draws._block
    none, some = Chain(Diffusion(variance_per_length=0.0)), Chain(Diffusion(variance_per_length=1.0))
    for chain in (none, some):
        chain.draws.rewind()
        chain.noise.corrupt(np.zeros((1, K)), {}, np.zeros((1, 1)), chain.state, chain.draws)
    assert none.draws._block == some.draws._block > 0


@pytest.mark.parametrize(
    "make",
    [
        lambda i: Gaussian(std=0.1 * i, proportional=0.01 * i),
        lambda i: Gaussian(std=0.1 * i, proportional=0.01 * i, per="increment"),
        lambda i: Bias(value=0.1 * i),
        lambda i: Scale(factor=1.0 + 0.1 * i),
        lambda i: Quantize(step=0.1 + 0.01 * i),
        lambda i: Saturate(minimum=-0.1 * i, maximum=0.1 * i),
        lambda i: Diffusion(variance_per_length=0.1 * i),
    ],
)
def test_rows_do_not_touch_one_another(make):
    values = np.random.default_rng(4).normal(size=(3, 64, 7))
    together = Chain(*[make(i) for i in range(64)], k=7)
    outs = [together.sample(sample) for sample in values]
    for i in range(64):
        alone = Chain(make(i), k=7, rows=[i])
        for sample, out in zip(values, outs, strict=True):
            given = sample[i : i + 1].copy()
            assert alone.sample(given).tobytes() == out[i : i + 1].tobytes()
            assert given.tobytes() == sample[i : i + 1].tobytes()  # values are shared with others


@pytest.mark.parametrize(
    ("make", "name"),
    [
        (lambda: Gaussian(std=-1.0), "std"),
        (lambda: Gaussian(std=1.0, per="second"), "per"),
        (lambda: AimGaussian(std=math.nan), "std"),
        (lambda: Bias(value=math.inf), "value"),
        (lambda: Scale(factor=0.0), "factor"),
        (lambda: Quantize(step=0.0), "step"),
        (lambda: Quantize(step=1.0, rounding="up"), "rounding"),
        (lambda: Saturate(minimum=1.0, maximum=0.0), "minimum"),
        (lambda: Diffusion(variance_per_length=-1e-9), "variance_per_length"),
    ],
)
def test_a_value_that_makes_no_sense_is_refused_by_name(make, name):
    with pytest.raises(ParameterError, match=name):
        make()
