"""What a run leaves: the recording, positions rebuilt from strain, the power ledger, and the solution."""
