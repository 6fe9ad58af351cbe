"""Causes of the MuJoCo world; a new file is a new cause."""
