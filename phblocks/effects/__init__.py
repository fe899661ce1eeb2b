"""Which effects a scene calls for: what is reached by what moves it, and the report of what was kept and left out."""

from phblocks.effects.reachability import Pattern, PatternBuilder, Reached, reach
from phblocks.effects.record import Effect
from phblocks.effects.report import EffectsReport

__all__ = ["Effect", "EffectsReport", "Pattern", "PatternBuilder", "Reached", "reach"]
