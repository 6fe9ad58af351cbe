"""The effects of the contract, as MuJoCo's own elements."""
