"""Design of an impact: the pretension, speed and stiffness that meet a force limit and are best for a goal."""
