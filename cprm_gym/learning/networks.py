"""The networks of policies in NumPy: batches in, preferences and moments of the actions out. Equal to PyTorch's to 1e-5.

Arrays are named as they are stored: ``layer_0.weight`` (out, in), ``layer_0.bias`` (out,), ..., ``head.weight``; an LSTM's ``lstm.input``
(4 h, in), ``lstm.hidden`` (4 h, h), ``lstm.bias`` (4 h,), its gates in the order input, forget, cell, output (Hochreiter and Schmidhuber
1997, as `torch.nn.LSTM` has them).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

ACTIVATIONS: Mapping[str, Callable[[np.ndarray], np.ndarray]] = {"tanh": np.tanh, "relu": lambda x: np.maximum(x, 0.0)}
"""By name."""
LOWEST, HIGHEST = -20.0, 2.0
"""Bounds of the logarithm of a squashed Gaussian's deviation (Haarnoja et al. 2018)."""


def sigmoid(x: np.ndarray) -> np.ndarray:
    """The logistic function, without overflow."""
    return 0.5 * (1.0 + np.tanh(0.5 * x))


class Network:
    """Layers, perhaps behind an LSTM, and a linear head.

    Parameters
    ----------
    arrays : mapping of str to float32 array
    activation : str
        One of `ACTIVATIONS`.

    Attributes
    ----------
    inputs, outputs, hidden : int
        Sizes; `hidden` is that of the LSTM, 0 without one.
    """

    def __init__(self, arrays: Mapping[str, np.ndarray], activation: str) -> None:
        self.activation = ACTIVATIONS[activation]
        count = sum(name.endswith(".weight") and name.startswith("layer_") for name in arrays)
        self._layers = [(arrays[f"layer_{k}.weight"], arrays[f"layer_{k}.bias"]) for k in range(count)]
        self._head = arrays["head.weight"], arrays["head.bias"]
        self._deviation = (arrays["deviation.weight"], arrays["deviation.bias"]) if "deviation.weight" in arrays else None
        self._lstm = (arrays["lstm.input"], arrays["lstm.hidden"], arrays["lstm.bias"]) if "lstm.input" in arrays else None
        first = self._lstm[0] if self._lstm else self._layers[0][0] if self._layers else self._head[0]
        self.inputs, self.outputs = first.shape[1], self._head[0].shape[0]
        self.hidden = 0 if self._lstm is None else self._lstm[1].shape[1]

    def features(self, x: np.ndarray, state: np.ndarray | None) -> tuple[np.ndarray, np.ndarray | None]:
        """Last hidden layer of inputs (N, inputs), and the next state of the LSTM, (2, N, hidden)."""
        x = np.asarray(x, np.float32)
        if self._lstm is not None:
            if state is None:
                state = np.zeros((2, len(x), self.hidden), np.float32)
            weight, recurrent, bias = self._lstm
            i, f, g, o = np.split(x @ weight.T + state[0] @ recurrent.T + bias, 4, axis=1)
            cell = sigmoid(f) * state[1] + sigmoid(i) * np.tanh(g)
            x = sigmoid(o) * np.tanh(cell)
            state = np.stack([x, cell])
        for weight, bias in self._layers:
            x = self.activation(x @ weight.T + bias)
        return x, state

    def __call__(self, x: np.ndarray, state: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray | None]:
        """Outputs (N, outputs) and the next state."""
        features, state = self.features(x, state)
        return features @ self._head[0].T + self._head[1], state

    def gaussian(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and deviation of a Gaussian that is squashed afterwards, (N, outputs) each."""
        features, _ = self.features(x, None)
        mean = features @ self._head[0].T + self._head[1]
        assert self._deviation is not None
        return mean, np.exp(np.clip(features @ self._deviation[0].T + self._deviation[1], LOWEST, HIGHEST))


def choose(logits: np.ndarray, mask: np.ndarray | None, uniform: np.ndarray | None) -> np.ndarray:
    """One of the columns for each row of preferences, (N,) int.

    Parameters
    ----------
    logits : (N, choices) array
    mask : (N, choices) bool array, optional
        What may be chosen.
    uniform : (N,) array, optional
        Numbers in [0, 1) that draw in proportion to the exponentials; without them the likeliest is taken.
    """
    if mask is not None:
        logits = np.where(mask, logits, -np.inf)
    if uniform is None:
        return logits.argmax(axis=1)
    weights = np.exp(logits - logits.max(axis=1, keepdims=True)).astype(np.float64).cumsum(axis=1)
    chosen = (weights <= (uniform * weights[:, -1])[:, None]).sum(axis=1)
    # rounding at the upper end must not choose what is masked
    last = logits.shape[1] - 1 - np.isfinite(logits)[:, ::-1].argmax(axis=1)
    return np.minimum(chosen, last)
