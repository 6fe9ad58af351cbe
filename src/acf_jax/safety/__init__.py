"""Contact with people: limits per body area, and whether an impact stays below them."""
