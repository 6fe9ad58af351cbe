"""The diagnosis on data whose cause is withheld: draw, seal, diagnose, open, score."""
