"""`acf-jax app`: the whole job in a browser, on one's own machine, over the commands and the library's functions."""
