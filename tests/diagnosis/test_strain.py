"""A rig that refitting has strained is a finding."""

from dataclasses import replace

import numpy as np
import pytest

from acf_jax.diagnosis import Diagnosis
from acf_jax.diagnosis.strain import doubt, statement, strains


def test_a_parameter_far_from_what_is_stated_is_named(diagnosed: Diagnosis) -> None:
    prior = diagnosed.observations.prior
    fitted = diagnosed.fits[0]
    theta = fitted.theta.copy()
    theta[:4] = prior.values + np.array([-11.0, 2.9, 0.0, 4.0]) * prior.stds
    moved = replace(fitted, u=fitted.coordinates.coordinate(theta))
    mass, stiffness = strains(moved, prior)
    assert (mass.parameter.name, stiffness.parameter.name) == ("moving_mass_kg", "contact_stiffness_n_per_m")
    assert mass.deviations == pytest.approx(-11) and mass.fitted == pytest.approx(theta[0])
    said = statement((mass, stiffness))
    assert (
        f"the moving mass m {theta[0]:.3g} kg, 11 standard deviations from the stated {prior.values[0]:.3g}"
        in said
    )
    assert "contact stiffness" in said
    assert doubt((mass,), "gravity").startswith("gravity fits only with the moving mass m ")


def test_a_rig_within_its_priors_is_none(diagnosed: Diagnosis) -> None:
    fitted = diagnosed.fits[0]
    at_prior = replace(fitted, u=np.zeros_like(fitted.u))
    assert (
        strains(at_prior, diagnosed.observations.prior) == () and statement(()) == doubt((), "gravity") == ""
    )
