"""What plots ask of their arguments."""

from __future__ import annotations

from phblocks.errors import ArgumentTypeError
from phblocks.results.solution import Solution


def require_solution(where: str, solution: object) -> Solution:
    """Check that something is a solution.

    Parameters
    ----------
    where : str
        Who asks, for the message.
    solution : object
        The candidate.

    Returns
    -------
    Solution
        The same.

    Raises
    ------
    ArgumentTypeError
        If it is not one.
    """
    if not isinstance(solution, Solution):
        raise ArgumentTypeError(
            where, expected="a Solution", got=type(solution).__name__, fix="Call ph.simulate() first."
        )
    return solution
