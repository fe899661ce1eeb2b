"""Radau IIA collocation with two or three stages: damps what a step does not resolve, by an amount that is known."""

from __future__ import annotations

from dataclasses import dataclass, field

from phblocks.solvers.coefficients import Collocation
from phblocks.solvers.collocation_stepper import CollocationStepper, stepper_of
from phblocks.solvers.compiled import CompiledStepper
from phblocks.solvers.linear_stepper import LinearStepper
from phblocks.solvers.newton import ModifiedNewton, Newton
from phblocks.solvers.options import require_newton, require_quadratic, require_stages
from phblocks.system import System


@dataclass(frozen=True)
class RadauIIA:
    """Radau IIA collocation: order 3 with two stages, 5 with three; damps the modes that the step does not resolve.

    The equations of a step are those of ``GaussLegendre`` with other coefficients; the last stage is the end of the
    step. A step takes from a quadratic energy the energy of the leading coefficient of the polynomial through its start
    and its stages, times a number. With two stages that is ``H(x_n - 3/2 z_1 + 1/2 x_{n+1})``, so never negative,
    and ``H_{n+1} - H_n = supplied - dissipated - numerical loss`` exactly, whatever the step. The loss is a series
    of its own, ``solution.energy.numerical_loss``, and a column of ``solution.power``.

    A mode with ``h omega = w`` loses the share ``w^4 / (36 + 4 w^2 + w^4)`` of its energy in a step with two stages,
    ``w^6 / 3600`` to leading order with three: w = 0.05 loses 1.7e-7 and 4e-12 a step, w = 1 loses 2.4 % and 0.03 %,
    w = 1000 all but 4e-6 and 9e-6.

    Conserved: nothing, but all that is lost is told. Elongation and length of springs change alike to the order of the
    method only. Constraints of joints with multipliers hold at the end of every step, and multipliers do not
    alternate. Cost of a step: that of ``GaussLegendre``. With numba installed (``pip install "phblocks[fast]"``)
    steps run in compiled code: the same results to round-off.

    Parameters
    ----------
    stages : int, optional
        2 or 3.
    newton : Newton, optional
        The iteration: with one linearisation for all stages, so that convergence is linear with ``Newton`` too.

    Raises
    ------
    DataError
        If the number of stages is another one.
    ArgumentTypeError
        If an option is of the wrong kind.

    Notes
    -----
    E. Hairer, G. Wanner, Solving Ordinary Differential Equations II, 2nd ed., IV.5 and IV.12,
    doi:10.1007/978-3-642-05221-7. The loss is derived in ``docs/theory.md``.
    """

    stages: int = 2
    newton: Newton = field(default_factory=ModifiedNewton)

    def __post_init__(self) -> None:
        """Check the options."""
        require_stages("RadauIIA", self.stages, "Two stages have order 3, three have order 5.")
        require_newton("RadauIIA", self.newton)

    @property
    def order(self) -> int:
        """Order of convergence on smooth solutions."""
        return 2 * int(self.stages) - 1

    def prepare(self, system: System) -> LinearStepper | CollocationStepper | CompiledStepper:
        """Do once what does not change during a run.

        Parameters
        ----------
        system : System
            The system to integrate.

        Returns
        -------
        LinearStepper, CollocationStepper or CompiledStepper
            Ready for steps; the last where numba is installed.

        Raises
        ------
        MethodError
            If the energy is not quadratic.
        """
        require_quadratic("RadauIIA", system)
        return stepper_of(system, Collocation.radau(int(self.stages)), self.newton)
