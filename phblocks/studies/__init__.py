"""What accuracy costs in time: studies of convergence, work and precision, and the setting to use.

Results are tables of records, printed, written as CSV or Markdown, and drawn by ``ph.plots``.
"""

from phblocks.studies.choice import best_within, cheapest
from phblocks.studies.convergence import ConvergenceRun, ConvergenceStudy, convergence
from phblocks.studies.effects import EffectRun, EffectsStudy, effects
from phblocks.studies.execution import processes
from phblocks.studies.reference import Reference
from phblocks.studies.run import Run
from phblocks.studies.shares import EffectShares, Share, effect_shares
from phblocks.studies.table import Table
from phblocks.studies.work_precision import WorkPrecisionStudy, work_precision

__all__ = [
    "ConvergenceRun",
    "ConvergenceStudy",
    "EffectRun",
    "EffectShares",
    "EffectsStudy",
    "Reference",
    "Run",
    "Share",
    "Table",
    "WorkPrecisionStudy",
    "best_within",
    "cheapest",
    "convergence",
    "effect_shares",
    "effects",
    "processes",
    "work_precision",
]
