"""Peak contact force of an active contact flange (ACF): model, surrogate and gap diagnosis."""

__version__ = "0.1.0"
