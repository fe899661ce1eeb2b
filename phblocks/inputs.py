"""Signals at the exposed ports: from what the user gives to one vector u(t)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from phblocks.errors import ArgumentTypeError, DataError, UnknownNameError
from phblocks.system import System
from phblocks.triplets import Floats, real_array

Signal = Callable[[float], ArrayLike] | ArrayLike


class NotFinite(Exception):
    """A signal gave a value that is not finite; ends the run with a status.

    Parameters
    ----------
    time : float
        When, s.
    name : str
        Which exposed port.
    """

    def __init__(self, time: float, name: str) -> None:
        super().__init__(f"{name} at {time}")
        self.time = time
        self.name = name


class InputFailed(Exception):
    """A signal raised an exception, or gave something else than before; ends the run with a status.

    Parameters
    ----------
    time : float
        When, s.
    name : str
        Which exposed port.
    error : Exception
        What the signal raised, or what is wrong with its value.
    """

    def __init__(self, time: float, name: str, error: Exception) -> None:
        super().__init__(f"{name} at {time}: {error}")
        self.time, self.name, self.error = time, name, error


class Drive:
    """Evaluates all inputs.

    Parameters
    ----------
    system : System
        With its exposed ports.
    signals : mapping
        For each exposed port a constant or a function of time.

    Raises
    ------
    UnknownNameError
        If there is no exposed port of that name.
    DataError
        If a value has the wrong shape, an imposed velocity is missing, or a function raises an exception at once.
    ArgumentTypeError
        If the signals are not a mapping, or a value is not numbers.
    PrunedError
        If an input is not zero that was taken to be.
    """

    def __init__(self, system: System, signals: Mapping[str, Any]) -> None:
        if not isinstance(signals, Mapping):
            raise ArgumentTypeError(
                "simulate inputs",
                expected="a mapping from names of exposed ports to signals",
                got=repr(signals),
                fix='Write for instance inputs={"tip": (0.0, -1.0)}.',
            )
        self._n, self._system = system.n_inputs, system
        self._quiet = bool(system.pruning.quiet.size)
        spans: dict[str, list[int]] = {}
        for i, entry in enumerate(system.inputs):
            spans.setdefault(entry.exposure, []).append(i)
        given = {name: system.inputs[span[0]].signal for name, span in spans.items()}
        given = {name: signal for name, signal in given.items() if signal is not None}
        for name in signals:
            if name not in spans:
                raise UnknownNameError(
                    "simulate inputs",
                    expected=f"one of the exposed ports {', '.join(spans) or '(there are none)'}",
                    got=repr(name),
                    fix="Use the names given in expose().",
                )
        signals = given | dict(signals)
        self._signals = [(name, signal, spans[name]) for name, signal in signals.items() if callable(signal)]
        self._constant = np.zeros(self._n)
        for name, span in spans.items():
            if name in signals:
                if not callable(signals[name]):
                    self._constant[span] = value = self._value(name, signals[name], len(span), 0.0)
                    if not np.isfinite(value).all():
                        raise DataError(
                            f"simulate inputs[{name!r}]",
                            expected="finite numbers",
                            got=repr(signals[name]),
                            fix="Correct it.",
                        )
            elif system.inputs[span[0]].common:
                raise DataError(
                    f"simulate inputs[{name!r}]",
                    expected=f"a signal: the outside imposes the {system.inputs[span[0]].imposed.name}",
                    got="none",
                    fix="Give a constant or a function of time; 0.0 holds it.",
                )
        system.pruning.require_quiet(system, self._constant, "simulate inputs")
        for name, signal, span in self._signals:
            try:
                value = signal(0.0)
            except Exception as error:
                raise DataError(
                    f"simulate inputs[{name!r}] at t = 0 s",
                    expected="a value",
                    got=f"{type(error).__name__}: {error}",
                    fix="Correct the function of time.",
                ) from error
            self._value(name, value, len(span), 0.0)  # may be infinite where no step looks

    def at(self, times: Sequence[float]) -> Floats:
        """Evaluate all inputs.

        Parameters
        ----------
        times : sequence of float
            s.

        Returns
        -------
        numpy.ndarray
            Shape (times, n_inputs).

        Raises
        ------
        PrunedError
            If it is not zero where that was taken for granted.
        NotFinite
            If a signal gives a value that is not finite.
        InputFailed
            If a signal raises an exception, or gives a value of another shape or kind.
        """
        u, error = self.ahead(times)
        if error is not None:
            raise error
        return u

    def ahead(self, times: Sequence[float] | Floats) -> tuple[Floats, InputFailed | NotFinite | None]:
        """Evaluate all inputs as far as they can be; each signal is asked once for each time, in their order.

        Parameters
        ----------
        times : sequence of float or numpy.ndarray
            s, increasing.

        Returns
        -------
        u : numpy.ndarray
            Shape (times up to the first that fails, n_inputs).
        error : InputFailed or NotFinite or None
            What is wrong at the next one.

        Raises
        ------
        PrunedError
            If it is not zero where that was taken for granted.
        """
        u, good = self._constant[None].repeat(len(times), axis=0), len(times)
        if not self._signals:
            return u, None
        times = times.tolist() if isinstance(times, np.ndarray) else times
        wrong: InputFailed | NotFinite | None = None
        for name, signal, span in self._signals:
            for i, t in enumerate(times[:good]):
                try:
                    u[i, span] = self._value(name, signal(t), len(span), t)
                except Exception as error:
                    good, wrong = i, InputFailed(t, name, error)
                    wrong.__cause__ = error
                    break
                if self._quiet:
                    self._system.pruning.require_quiet(self._system, u[i], f"simulate inputs at t = {t:g} s")
                if not np.isfinite(u[i, span]).all():
                    good, wrong = i, NotFinite(t, name)
                    break
        return u[:good], wrong

    @staticmethod
    def _value(name: str, value: object, size: int, t: float) -> Floats:
        array = real_array(value)
        where, fix = f"simulate inputs[{name!r}] at t = {t:g} s", "Correct the constant or the function of time."
        expected = "a number" if size == 1 else f"numbers of shape ({size},)"
        if array is None:
            raise ArgumentTypeError(where, expected=expected, got=repr(value), fix=fix)
        if array.size != size or array.ndim > 1:
            raise DataError(where, expected=expected, got=f"shape {array.shape}", fix=fix)
        return np.atleast_1d(array)
