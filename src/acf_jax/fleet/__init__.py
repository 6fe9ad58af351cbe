"""Many rigs: their diagnoses, what changed since last time, and a page over all."""
