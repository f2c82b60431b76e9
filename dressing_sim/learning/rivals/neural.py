"""Conditional neural movement primitives: a path from any observed points of it.

    r = mean_i E(t_i, y_i, q),   (m, s) = D(r, t, q),   y(t) ~ N(m, diag s^2),

E and D networks of one hidden layer, q the task parameters. They are trained on random points of a
random demonstration, asked for others of it, by the likelihood (Adam: Kingma and Ba 2015). A new
path is asked with its start and its end.

Source: Seker, Imre, Piater and Ugur (2019), "Conditional neural movement primitives", Robotics:
Science and Systems.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import expit

from dressing_sim.learning.frame import FloatArray, Frame
from dressing_sim.learning.rivals.method import Method, Shown, Skill
from dressing_sim.learning.rivals.references import apart
from dressing_sim.learning.rivals.task_dmp import task_parameters

#: Least standard deviation, of the scale.
_SURE = 0.01

#: A path is so long in phase as the networks see it, which lets them bend along it.
_PHASE = 10.0

#: Adam's decay rates.
_FIRST, _SECOND = 0.9, 0.999

Layers = list[FloatArray]


@dataclass(frozen=True, slots=True)
class NeuralPrimitive(Method):
    """CNMP, see the module; in the coordinates of the last frame, the wrist's."""

    hidden: int = 48
    """Units of each layer, and of r."""
    steps: int = 2000
    """Of training."""
    rate: float = 5e-3
    """Of learning, at first; it falls to nothing linearly."""
    observed: int = 5
    """Most points that r is made of in training."""

    def learn(self, shown: Shown, rng: np.random.Generator) -> Skill:
        """The two networks."""
        scale, phase = shown.scale, shown.phase
        reach = float(np.mean([apart(frames) for frames in shown.situations]))
        centre = shown.local[:, -1].mean(axis=(0, 1))
        paths = (shown.local[:, -1] - centre) / scale
        known = np.stack([task_parameters(frames, reach) for frames in shown.situations])
        encoder, decoder = self._trained(phase, paths, known, rng)
        end = shown.place(-1)

        def skill(frames: Sequence[Frame], start: FloatArray) -> FloatArray:
            q = task_parameters(frames, reach)
            ends = np.stack([start, end.predict(frames)])
            seen = (frames[-1].to_local(ends) - centre) / scale
            given = _points(np.array([0.0, 1.0]), seen, q)
            r = _forward(encoder, given)[0].mean(axis=0)
            mean = _forward(decoder, _points(phase, np.tile(r, (len(phase), 1)), q))[0]
            return frames[-1].to_world(mean[:, : seen.shape[1]] * scale + centre)

        return skill

    def _trained(
        self, phase: FloatArray, paths: FloatArray, known: FloatArray, rng: np.random.Generator
    ) -> tuple[Layers, Layers]:
        count, rows, p = paths.shape
        width = 1 + known.shape[1]
        encoder = _layers(width + p, self.hidden, self.hidden, rng)
        decoder = _layers(width + self.hidden, self.hidden, 2 * p, rng)
        both = [*encoder, *decoder]
        moments = [(np.zeros_like(one), np.zeros_like(one)) for one in both]
        for step in range(1, self.steps + 1):
            one = int(rng.integers(count))
            seen = rng.integers(rows, size=int(rng.integers(1, self.observed + 1)))
            asked = rng.integers(rows, size=16)
            given = _points(phase[seen], paths[one, seen], known[one])
            slopes = loss(encoder, decoder, given, phase[asked], paths[one, asked], known[one])[1]
            rate = self.rate * (1.0 - (step - 1) / self.steps)
            for values, slope, (mean, square) in zip(both, slopes, moments, strict=True):
                mean += (1.0 - _FIRST) * (slope - mean)
                square += (1.0 - _SECOND) * (slope**2 - square)
                root = np.sqrt(square / (1.0 - _SECOND**step)) + 1e-8
                values -= rate * mean / (1.0 - _FIRST**step) / root
        return encoder, decoder


def loss(
    encoder: Layers,
    decoder: Layers,
    given: FloatArray,
    phase: FloatArray,
    path: FloatArray,
    q: FloatArray,
) -> tuple[float, Layers]:
    """Mean negative log-likelihood of points of a path, but for a constant, and its slopes.

    Args:
        encoder: Its layers.
        decoder: Its layers.
        given: Observed points, (n, 1 + p + d).
        phase: Of the points asked for, (B,).
        path: Those points, (B, p).
        q: Task parameters (d,).

    Returns:
        The loss, and its slope for each array of the encoder's and then the decoder's layers.
    """
    count, p = path.shape
    codes, before = _forward(encoder, given)
    r = np.tile(codes.mean(axis=0), (count, 1))
    asked = _points(phase, r, q)
    out, inside = _forward(decoder, asked)
    mean, raw = out[:, :p], out[:, p:]
    deviation = _SURE + np.logaddexp(0.0, raw)
    left = (path - mean) / deviation
    value = float(np.sum(np.log(deviation) + 0.5 * left**2) / count)
    up = np.hstack([-left / deviation, (1.0 - left**2) / deviation * expit(raw)]) / count
    slopes, down = _backward(decoder, asked, inside, up)
    pulled = down[:, 1 : 1 + codes.shape[1]].sum(axis=0) / len(codes)
    return value, [*_backward(encoder, given, before, np.tile(pulled, (len(codes), 1)))[0], *slopes]


def _points(phase: FloatArray, values: FloatArray, q: FloatArray) -> FloatArray:
    """Inputs of a network; phase is counted from the middle, as large as all else together."""
    time = _PHASE * (phase[:, None] - 0.5)
    return np.hstack([time, values, np.tile(q, (len(phase), 1))])


def _layers(inputs: int, hidden: int, outputs: int, rng: np.random.Generator) -> Layers:
    """Weights and offsets, drawn as by He et al. (2015)."""
    first = rng.standard_normal((inputs, hidden)) * np.sqrt(2.0 / inputs)
    second = rng.standard_normal((hidden, outputs)) * np.sqrt(1.0 / hidden)
    return [first, np.zeros(hidden), second, np.zeros(outputs)]


def _forward(layers: Layers, inputs: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Outputs, and what the hidden units say."""
    first, offset, second, last = layers
    hidden = np.maximum(inputs @ first + offset, 0.0)
    return hidden @ second + last, hidden


def _backward(
    layers: Layers, inputs: FloatArray, hidden: FloatArray, up: FloatArray
) -> tuple[Layers, FloatArray]:
    """Slopes of the layers and of the inputs, from those of the outputs."""
    first, _, second, _ = layers
    back = (up @ second.T) * (hidden > 0.0)
    return [inputs.T @ back, back.sum(axis=0), hidden.T @ up, up.sum(axis=0)], back @ first.T
