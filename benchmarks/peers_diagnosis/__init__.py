"""Other methods that name a cause, on the sets of blind runs: information criteria, SINDy, a trained classifier."""
