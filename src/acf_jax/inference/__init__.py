"""Fitting explanations to measured impacts: observations, parameters, forward model, linear algebra, fits."""
