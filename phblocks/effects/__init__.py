"""Which effects a compilation computes, and what became of the others."""
