"""Causes of the scipy world; a new file is a new cause."""
