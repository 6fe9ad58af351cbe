"""The diagnosis put to the test: simulated rigs with hidden causes, and blind runs on them."""
