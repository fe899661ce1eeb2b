"""The midpoint rule with discrete gradients: exact balance of any energy."""

from __future__ import annotations

from dataclasses import dataclass, field

from phblocks.solvers.coefficients import Collocation
from phblocks.solvers.linear_stepper import LinearStepper
from phblocks.solvers.midpoint import MidpointStepper
from phblocks.solvers.newton import Newton
from phblocks.solvers.options import require_newton
from phblocks.system import System


@dataclass(frozen=True)
class DiscreteGradient:
    """Midpoint rule with Gonzalez' discrete gradient: second order, keeps the balance of any energy exactly.

    Where the energy is quadratic it is the implicit midpoint rule, ``Midpoint``. Elsewhere the co-energy variables
    over a step are not the gradient at the midpoint m but, with ``d = x_{n+1} - x_n``::

        z = grad H(m) + (H(x_{n+1}) - H(x_n) - grad H(m)^T d) / |d|^2 d,

    so that ``z^T d = H(x_{n+1}) - H(x_n)`` whatever the step. ``|d|`` is measured in units in which the Hessian at the
    start has a diagonal of ones. Newton's method uses the exact derivative, from gradient and Hessian.

    Conserved: the balance of any energy. Cost of a step: 3 to 5 iterations, each with a Jacobian, the Hessians and a
    banded factorisation.

    Parameters
    ----------
    newton : Newton, optional
        Tolerance and limit of the iteration.

    Raises
    ------
    ArgumentTypeError
        If the options are not those of Newton's method.

    Notes
    -----
    O. Gonzalez, Time integration and discrete Hamiltonian systems, J. Nonlinear Sci. 6 (1996) 449-467,
    doi:10.1007/BF02440162.
    """

    newton: Newton = field(default_factory=Newton)

    def __post_init__(self) -> None:
        """Check the options."""
        require_newton("DiscreteGradient", self.newton)

    #: Order of convergence on smooth solutions.
    order = 2

    def prepare(self, system: System) -> LinearStepper | MidpointStepper:
        """Do once what does not change during a run.

        Parameters
        ----------
        system : System
            The system to integrate.

        Returns
        -------
        LinearStepper or MidpointStepper
            Ready for steps.
        """
        if system.linear:
            return LinearStepper(system, Collocation.gauss(1))
        return MidpointStepper(system, self.newton, discrete=True)
