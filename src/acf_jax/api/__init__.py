"""What `import acf_jax` offers: thin functions and classes over the library, each with checks, text and pictures."""
