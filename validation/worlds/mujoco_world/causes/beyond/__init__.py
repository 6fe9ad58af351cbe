"""Causes that no candidate effect describes."""
