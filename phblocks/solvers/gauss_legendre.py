"""Gauss-Legendre collocation with two or three stages."""

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
class GaussLegendre:
    """Gauss-Legendre collocation: order 4 with two stages, 6 with three.

    With the coefficients A, b of the method it solves ``E (z_i - x_n) = dt sum_j A_ij f(z_j, theta_j)`` for all
    stages together, orientations eliminated, and sets ``x_{n+1} = x_n + sum_j d_j (z_j - x_n)`` with ``d = b^T A^-1``.

    Conserved: the balance of energies that are quadratic in the states, whatever the step; elongation and length of
    springs change alike. Cost of a step: a complex banded factorisation for each pair of stages and a real one for
    the odd stage, all of the band of the midpoint rule, and 6 to 11 residuals of all stages with their
    back-substitutions; three to four times a midpoint step. If the system is linear, back-substitutions only.
    With numba installed (``pip install "phblocks[fast]"``) steps run in compiled code: the same results to round-off.

    States without energy (multipliers, the states of stateless parts) have no rate: their value at the end of a step
    is that of the polynomial through the stages, of order ``stages`` at most. It does not act back on the run.

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
    E. Hairer, C. Lubich, G. Wanner, Geometric Numerical Integration, 2nd ed., II.1.3 and IV.2,
    doi:10.1007/3-540-30666-8.
    """

    stages: int = 2
    newton: Newton = field(default_factory=ModifiedNewton)

    def __post_init__(self) -> None:
        """Check the options."""
        require_stages("GaussLegendre", self.stages, "One stage is ph.Midpoint().")
        require_newton("GaussLegendre", self.newton)

    @property
    def order(self) -> int:
        """Order of convergence on smooth solutions."""
        return 2 * int(self.stages)

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
        require_quadratic("GaussLegendre", system)
        return stepper_of(system, Collocation.gauss(int(self.stages)), self.newton)
