"""The true peak contact force of whichever model a user has, with its uncertainty and the body it meets."""
