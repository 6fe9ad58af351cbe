from acf_jax.cli.main import main

main()
