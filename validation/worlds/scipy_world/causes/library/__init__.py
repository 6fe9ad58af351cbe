"""The effects of the contract, in forms that differ from the candidates'."""
