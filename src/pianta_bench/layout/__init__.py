"""Table 3.1a: layouts of schools."""
