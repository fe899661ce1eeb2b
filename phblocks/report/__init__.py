"""A run as a film or as one page that explains it, for anyone with a browser; no network is needed.

The page is in :mod:`phblocks.report.page`, its sections in :mod:`phblocks.report.sections`, what moves in
:mod:`phblocks.report.scene`; style and scripts are files beside them.
"""

from phblocks.report.animation import write_animation
from phblocks.report.page import write_report

__all__ = ["write_animation", "write_report"]
