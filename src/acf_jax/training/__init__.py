"""Training a surrogate of the peak force: of the paper's model, or of the one that a diagnosis leaves."""
